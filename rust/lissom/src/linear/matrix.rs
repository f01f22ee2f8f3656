//! Sparse symmetric matrices, stored as their lower triangle.

use faer::sparse::{SparseColMat, SymbolicSparseColMat, Triplet};

use crate::Mat3;

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
        let triplets: Vec<Triplet<u32, u32, f64>> =
            entries.into_iter().map(|(i, j, value)| Triplet::new(i.max(j), i.min(j), value)).collect();
        Self(SparseColMat::try_new_from_triplets(n, n, &triplets).expect("indices are within the matrix"))
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
    pub fn normal<'a>(n: usize, rows: impl IntoIterator<Item = (f64, &'a [(u32, f64)])>) -> Self {
        let mut entries = Vec::new();
        for (w, row) in rows {
            for (k, &(i, a)) in row.iter().enumerate() {
                entries.extend(row[..=k].iter().map(|&(j, b)| (i, j, w * a * b)));
            }
        }
        Self::from_entries(n, entries)
    }

    /// The rows in full, as lists of `(column, value)`.
    pub fn rows(&self) -> Vec<Vec<(u32, f64)>> {
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); self.size()];
        for (i, j, value) in self.entries() {
            rows[i as usize].push((j, value));
            if i != j {
                rows[j as usize].push((i, value));
            }
        }
        rows
    }

    /// `A D A` with a diagonal `D`.
    pub fn sandwich(&self, diagonal: &[f64]) -> Self {
        let rows = self.rows();
        Self::normal(self.size(), diagonal.iter().copied().zip(rows.iter().map(Vec::as_slice)))
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
