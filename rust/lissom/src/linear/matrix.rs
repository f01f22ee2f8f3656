//! Sparse symmetric matrices, stored as their lower triangle.

use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use rayon::prelude::*;

use crate::geometry::rows::Rows;
use crate::{Mat3, Result, Vec3, memory};

/// Columns that a thread takes at once.
const GRAIN: usize = 4096;

/// What an entry of a product takes while it is assembled, summed with others and constrained: up to four copies, of a
/// value and one or two indices.
const BYTES_PER_ENTRY: u128 = 64;

/// A sparse symmetric matrix; only the lower triangle is stored.
#[derive(Debug, Clone)]
pub struct SymmetricMatrix(pub(super) SparseColMat<u32, f64>);

impl SymmetricMatrix {
    /// The n x n matrix with `entries` `(row, column, value)`; those of the same place add up, and an
    /// entry off the diagonal stands for itself and its mirror image, so give it once.
    ///
    /// # Panics
    ///
    /// Where an index is not below `n`: the caller has validated the mesh.
    pub fn from_entries(n: usize, entries: impl IntoIterator<Item = (u32, u32, f64)>) -> Self {
        // By column, then each column by row: entries are many, columns short.
        let entries: Vec<(u32, (u32, f64))> =
            entries.into_iter().map(|(i, j, value)| (i.min(j), (i.max(j), value))).collect();
        let mut sorted = Rows::sort(n, entries.iter().copied());
        drop(entries);
        let (mut starts, mut rows, mut values) = (vec![0u32], Vec::<u32>::new(), Vec::<f64>::new());
        for j in 0..n {
            let column = sorted.of_mut(j);
            column.sort_by_key(|&(i, _)| i);
            for same in column.chunk_by(|a, b| a.0 == b.0) {
                rows.push(same[0].0);
                values.push(same.iter().map(|&(_, value)| value).sum());
            }
            starts.push(rows.len() as u32);
        }
        Self::from_parts(starts, rows, values)
    }

    /// Refuses products that do not fit, before any is formed; `listed` says how many, of the same place or not, meet in
    /// each of `n` columns.
    ///
    /// # Errors
    ///
    /// [`crate::Error::OutOfMemory`].
    pub fn weigh(n: usize, listed: impl Fn(usize) -> usize) -> Result<()> {
        // Only the lower half is kept.
        let entries: u128 = (0..n).map(|j| (listed(j).min(n) / 2 + 1) as u128).sum();
        memory::check("the matrix", BYTES_PER_ENTRY * entries)
    }

    /// The 3n x 3n matrix of 3 x 3 blocks. `fill(k, list)` lists the block column `k` from its diagonal
    /// block down, as `(block row, block)` in ascending order; it starts from an empty list.
    pub fn from_blocks(n: usize, mut fill: impl FnMut(u32, &mut Vec<(u32, Mat3)>)) -> Self {
        let (mut starts, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
        let mut column = Vec::new();
        for k in 0..n as u32 {
            column.clear();
            fill(k, &mut column);
            for b in 0..3 {
                for &(j, block) in &column {
                    let first = if j == k { b } else { 0 };
                    rows.extend((first..3).map(|a| 3 * j + a as u32));
                    values.extend((first..3).map(|a| block.col(b)[a]));
                }
                starts.push(rows.len() as u32);
            }
        }
        Self::from_parts(starts, rows, values)
    }

    /// The rows and columns with a `slot`, which must ascend, moved to it.
    pub fn select(&self, slot: impl Fn(u32) -> Option<u32>) -> Self {
        let (mut starts, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
        for j in (0..self.size()).filter(|&j| slot(j as u32).is_some()) {
            let entries = self.0.symbolic().row_idx_of_col_raw(j).iter().zip(self.0.val_of_col(j));
            for (row, &value) in entries.filter_map(|(&i, value)| Some((slot(i)?, value))) {
                rows.push(row);
                values.push(value);
            }
            starts.push(rows.len() as u32);
        }
        Self::from_parts(starts, rows, values)
    }

    fn from_parts(starts: Vec<u32>, rows: Vec<u32>, values: Vec<f64>) -> Self {
        let n = starts.len() - 1;
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        Self(SparseColMat::new(pattern, values))
    }

    /// `sum over (i, j, w) of w (e_i - e_j) (e_i - e_j)^T`.
    pub fn laplacian(n: usize, edges: impl Iterator<Item = (u32, u32, f64)>) -> Self {
        // The diagonal is listed first, so that every vertex has its place, also one without edges.
        let mut diagonal = vec![0.0; n];
        let mut entries = Vec::new();
        for (i, j, w) in edges {
            diagonal[i as usize] += w;
            diagonal[j as usize] += w;
            entries.push((i, j, -w));
        }
        let diagonal = (0u32..).zip(diagonal).map(|(i, w)| (i, i, w));
        Self::from_entries(n, diagonal.chain(entries))
    }

    /// `sum over rows (w, a) of w a a^T`, where a row is a list of `(column, value)` that names no column
    /// twice.
    ///
    /// # Errors
    ///
    /// [`crate::Error::OutOfMemory`]: a row of `k` values makes `k^2 / 2` entries.
    pub fn normal<'a>(n: usize, rows: impl IntoIterator<Item = (f64, &'a [(u32, f64)])>) -> Result<Self> {
        let rows: Vec<(f64, &[(u32, f64)])> = rows.into_iter().collect();
        let named = (0u32..).zip(&rows).flat_map(|(r, (_, row))| row.iter().map(move |&(j, _)| (j, r)));
        let namers = Rows::sort(n, named);
        Self::weigh(n, |j| namers.of(j).iter().map(|&r| rows[r as usize].1.len()).sum())?;
        // Column by column, from the rows that name it: each sum in the order of the rows, whoever adds it up.
        let columns: Vec<Vec<(u32, f64)>> = (0..n)
            .into_par_iter()
            .with_min_len(GRAIN)
            .map_init(
                || (vec![0.0; n], vec![false; n]),
                |(sum, touched), j| {
                    let mut column = Vec::new();
                    for &r in namers.of(j) {
                        let (w, row) = rows[r as usize];
                        let own = row.iter().find(|(i, _)| *i as usize == j).map_or(0.0, |(_, a)| *a);
                        for &(i, a) in row.iter().filter(|(i, _)| *i as usize >= j) {
                            if !touched[i as usize] {
                                touched[i as usize] = true;
                                column.push((i, 0.0));
                            }
                            sum[i as usize] += w * own * a;
                        }
                    }
                    column.sort_unstable_by_key(|&(i, _)| i);
                    for (i, value) in &mut column {
                        *value = std::mem::take(&mut sum[*i as usize]);
                        touched[*i as usize] = false;
                    }
                    column
                },
            )
            .collect();
        let mut starts = vec![0u32];
        starts.extend(columns.iter().scan(0, |sum, column| {
            *sum += column.len() as u32;
            Some(*sum)
        }));
        let (rows, values) = columns.into_iter().flatten().unzip();
        Ok(Self::from_parts(starts, rows, values))
    }

    /// The rows in full, of `(column, value)`.
    pub fn rows(&self) -> Rows<(u32, f64)> {
        let both = self.entries().flat_map(|(i, j, value)| {
            [Some((i, (j, value))), (i != j).then_some((j, (i, value)))].into_iter().flatten()
        });
        Rows::sort(self.size(), both.collect::<Vec<_>>().into_iter())
    }

    /// `a A + b B` with another matrix `B` of the same size.
    pub fn combine(&self, a: f64, other: &Self, b: f64) -> Self {
        let scaled = |m: &Self, factor: f64| m.entries().map(move |(i, j, v)| (i, j, factor * v)).collect();
        let (mut entries, more): (Vec<_>, Vec<_>) = (scaled(self, a), scaled(other, b));
        entries.extend(more);
        Self::from_entries(self.size(), entries)
    }

    /// The 3n x 3n matrix that does the same to three interleaved axes, with full 3 x 3 blocks.
    pub fn of_axes(&self) -> Self {
        Self::from_blocks(self.size(), |k, column| {
            let rows = self.0.symbolic().row_idx_of_col_raw(k as usize).iter();
            let values = self.0.val_of_col(k as usize);
            column.extend(rows.zip(values).map(|(&j, &value)| (j, Mat3::IDENTITY * value)));
        })
    }

    /// An entry of the diagonal.
    pub fn diagonal(&self, row: usize) -> f64 {
        let first = self.0.symbolic().row_idx_of_col_raw(row).first().copied();
        if first == Some(row as u32) { self.0.val_of_col(row)[0] } else { 0.0 }
    }

    /// The largest entry of the diagonal.
    pub fn largest(&self) -> f64 {
        (0..self.size()).map(|row| self.diagonal(row)).fold(0.0, f64::max)
    }

    /// Number of rows and columns.
    pub fn size(&self) -> usize {
        self.0.nrows()
    }

    /// The stored entries `(row, column, value)`, row >= column.
    pub fn entries(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        (0..self.size()).flat_map(move |j| {
            let rows = self.0.symbolic().row_idx_of_col_raw(j);
            rows.iter().zip(self.0.val_of_col(j)).map(move |(&i, &value)| (i, j as u32, value))
        })
    }

    /// The product with one column.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size()];
        for (i, j, value) in self.entries() {
            y[i as usize] += value * x[j as usize];
            if i != j {
                y[j as usize] += value * x[i as usize];
            }
        }
        y
    }

    /// The product with one vector per row, axis by axis.
    pub fn times_vectors(&self, x: &[Vec3]) -> Vec<Vec3> {
        let axis = |axis: usize| self.times(&x.iter().map(|x| x[axis]).collect::<Vec<_>>());
        let [x, y, z]: [Vec<f64>; 3] =
            (0..3).into_par_iter().map(axis).collect::<Vec<_>>().try_into().unwrap_or_default();
        (0..self.size()).map(|row| Vec3::new(x[row], y[row], z[row])).collect()
    }

    /// `A D A x` with a diagonal `D`.
    pub fn sandwich_times(&self, diagonal: &[f64], x: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = self.times(x).iter().zip(diagonal).map(|(y, d)| d * y).collect();
        self.times(&scaled)
    }

    /// Adds to the diagonal, which every row must have.
    pub fn add_to_diagonal(&mut self, row: usize, value: f64) {
        let first = self.0.symbolic().row_idx_of_col_raw(row).first().copied();
        assert_eq!(first, Some(row as u32), "row {row} has no diagonal entry");
        self.0.val_of_col_mut(row)[0] += value;
    }
}
