//! Normal matrices whose long rows are kept apart.
//!
//! ```text
//!     M = S + sum_k w_k a_k a_k^T = S + U C U^T          C = diag(+-1)
//!     M^-1 = S^-1 - Z (C + U^T Z)^-1 Z^T,                Z = S^-1 U
//! ```
//!
//! (Woodbury; Hager 1989, Updating the Inverse of a Matrix). A vertex with `d` neighbours has a row of `d` values, whose
//! product with itself is a full block: `d^2` entries, and `d^3` operations to factor them. Apart it costs one column of
//! `Z`.

use rayon::prelude::*;

use super::columns::Columns;
use super::constraints::Constraints;
use super::dense;
use super::factor::Factor;
use super::matrix::SymmetricMatrix;
use crate::{Result, memory};

/// Rows up to this length are never kept apart: their blocks are factored in no time.
const SHORT: usize = 256;

/// Beyond this share of all rows, what is left is singular.
const MOST: f64 = 0.1;

/// Entries of a row, as column and value.
type Row = Vec<(u32, f64)>;

/// A symmetric matrix, and what is added to it in products that are not formed.
#[derive(Debug, Clone)]
pub struct SplitMatrix {
    /// `S`.
    pub sparse: SymmetricMatrix,
    /// `w` and `a`.
    apart: Vec<(f64, Row)>,
}

/// Which of so many rows, of such lengths, are to be kept apart: those whose product is larger than a column.
pub fn long_rows(lengths: &[usize]) -> Vec<bool> {
    let n = lengths.len();
    let long: Vec<bool> = lengths.iter().map(|&length| length > SHORT && length * length > 2 * n).collect();
    let many = long.iter().filter(|long| **long).count() as f64 > MOST * n as f64;
    if many { vec![false; n] } else { long }
}

impl From<SymmetricMatrix> for SplitMatrix {
    fn from(sparse: SymmetricMatrix) -> Self {
        Self { sparse, apart: Vec::new() }
    }
}

impl SplitMatrix {
    /// `S` with `w a a^T` of every row apart, each of weight `w`, of either sign, and no column twice.
    pub fn new(sparse: SymmetricMatrix, apart: Vec<(f64, Row)>) -> Self {
        Self { sparse, apart: apart.into_iter().filter(|(w, _)| *w != 0.0).collect() }
    }

    /// `A D A` with a diagonal `D`, long rows of `A` apart.
    ///
    /// # Errors
    ///
    /// As [`SymmetricMatrix::normal`].
    pub fn sandwich(a: &SymmetricMatrix, diagonal: &[f64]) -> Result<Self> {
        let rows = a.rows();
        let long = long_rows(&rows.iter().map(<[_]>::len).collect::<Vec<_>>());
        // A vertex with a row apart keeps its place on the diagonal.
        let places: Vec<[(u32, f64); 1]> = (0..a.size() as u32).map(|i| [(i, 0.0)]).collect();
        let own = |i: usize| if long[i] { &places[i][..] } else { rows.of(i) };
        let sparse = SymmetricMatrix::normal(a.size(), (0..a.size()).map(|i| (diagonal[i], own(i))))?;
        let apart = (0..a.size()).filter(|&i| long[i]).map(|i| (diagonal[i], rows.of(i).to_vec()));
        Ok(Self::new(sparse, apart.collect()))
    }

    /// `a M + b N` with another matrix `N` of the same size.
    pub fn combine(&self, a: f64, other: &Self, b: f64) -> Self {
        let scaled = |m: &Self, by: f64| m.apart.iter().map(|(w, row)| (by * w, row.clone())).collect();
        let (mut apart, more): (Vec<_>, Vec<_>) = (scaled(self, a), scaled(other, b));
        apart.extend(more);
        Self::new(self.sparse.combine(a, &other.sparse, b), apart)
    }

    /// The matrix with all products formed.
    ///
    /// # Errors
    ///
    /// [`crate::Error::OutOfMemory`].
    pub fn whole(&self) -> Result<SymmetricMatrix> {
        let n = self.sparse.size();
        let listed: usize = self.apart.iter().map(|(_, row)| row.len() * row.len()).sum();
        SymmetricMatrix::weigh(1, |_| listed)?;
        let products = self.apart.iter().flat_map(|(w, row)| {
            row.iter()
                .enumerate()
                .flat_map(move |(k, &(i, a))| row[k..].iter().map(move |&(j, b)| (i, j, w * a * b)))
        });
        Ok(SymmetricMatrix::from_entries(n, self.sparse.entries().chain(products)))
    }

    /// Whether all products are formed.
    pub(super) fn is_whole(&self) -> bool {
        self.apart.is_empty()
    }
}

/// What turns solutions of `S` into those of `M`, in the free unknowns.
#[derive(Debug)]
pub(super) struct Correction {
    /// The columns of `U`: those of free unknowns by their place among these, those of fixed ones by their own.
    free: Vec<Row>,
    given: Vec<Row>,
    signs: Vec<f64>,
    /// `Z`.
    solved: Columns,
    /// `(C + U^T Z)^-1`, row by row.
    inverse: Vec<f64>,
}

impl Correction {
    /// For the factor of `S`; `None` where too little is left of that to correct.
    ///
    /// # Errors
    ///
    /// [`crate::Error::OutOfMemory`].
    pub fn new(matrix: &SplitMatrix, constraints: &Constraints, factor: &Factor) -> Result<Option<Self>> {
        let (size, count) = (factor.size(), matrix.apart.len());
        memory::check("long rows", 8 * count as u128 * (size + 2 * count) as u128)?;
        let part = |free: bool| -> Vec<Row> {
            let own = |v: u32| {
                constraints.slot(v).filter(|_| free).or((!free && constraints.slot(v).is_none()).then_some(v))
            };
            let scaled = |(w, row): &(f64, Row)| {
                row.iter().filter_map(|&(v, a)| Some((own(v)?, a * w.abs().sqrt()))).collect()
            };
            matrix.apart.iter().map(scaled).collect()
        };
        let (free, given) = (part(true), part(false));
        let signs: Vec<f64> = matrix.apart.iter().map(|(w, _)| w.signum()).collect();
        let mut solved = Columns::zeros(size, count);
        for (k, row) in free.iter().enumerate() {
            let column = solved.column_mut(k);
            row.iter().for_each(|&(slot, a)| column[slot as usize] = a);
        }
        factor.solve_columns(&mut solved);
        let at = |i: usize, j: usize| dot(&free[i], solved.column(j)) + if i == j { signs[i] } else { 0.0 };
        let inverse = dense::inverse(count, at);
        let found = Self { free, given, signs, solved, inverse };
        Ok(found.inverse.iter().all(|x| x.is_finite()).then_some(found))
    }

    /// Moves to the right-hand side what fixed unknowns have in `U C U^T`.
    pub fn reduce(&self, column: &mut [f64], given: impl Fn(usize) -> f64) {
        for ((free, fixed), sign) in self.free.iter().zip(&self.given).zip(&self.signs) {
            let known: f64 = fixed.iter().map(|&(v, a)| a * given(v as usize)).sum();
            free.iter().for_each(|&(slot, a)| column[slot as usize] -= sign * known * a);
        }
    }

    /// Turns solutions of `S` into those of `M`.
    pub fn correct(&self, columns: &mut Columns) {
        let (size, count) = (columns.rows(), self.free.len());
        columns.data_mut().par_chunks_mut(size.max(1)).for_each(|x| {
            let seen: Vec<f64> = self.free.iter().map(|row| dot(row, x)).collect();
            for (k, inverse) in self.inverse.chunks(count).enumerate() {
                let share: f64 = inverse.iter().zip(&seen).map(|(a, b)| a * b).sum();
                x.iter_mut().zip(self.solved.column(k)).for_each(|(x, z)| *x -= share * z);
            }
        });
    }
}

fn dot(row: &[(u32, f64)], column: &[f64]) -> f64 {
    row.iter().map(|&(i, a)| a * column[i as usize]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::ConstrainedSystem;
    use crate::{Job, Vec3};

    #[test]
    fn rows_apart_act_as_their_products() {
        let n = 40;
        let chain = (1..n).map(|i| (i - 1, i, 1.0 + 0.1 * f64::from(i)));
        let sparse = SymmetricMatrix::laplacian(n as usize, chain);
        let row = |k: u32| {
            (0..n).filter(|i| i % (k + 2) != 1).map(|i| (i, f64::from((i * 7 + k) % 5) - 1.7)).collect()
        };
        let apart = vec![(2.0, row(0)), (0.0, row(1)), (0.3, row(2)), (-1e-5, row(3))];
        let split = SplitMatrix::new(sparse, apart);
        let constraints = || Constraints::hard(n as usize, |v| v % 13 == 2).with_soft([(5, 0.7)]);
        let given: Vec<Vec3> = (0..n).map(|i| Vec3::new(f64::from(i % 3), f64::from(i % 4), -1.0)).collect();
        let job = Job::default();
        let systems = [
            ConstrainedSystem::of_split(&split, constraints(), &job).unwrap(),
            ConstrainedSystem::new(&split.whole().unwrap(), constraints(), &job).unwrap(),
        ];
        let [a, b] = systems.map(|system| {
            let mut x = [given.clone()];
            system.solve(std::slice::from_ref(&given), &mut x);
            x
        });
        assert!(a[0].iter().zip(&b[0]).all(|(a, b)| a.distance(*b) < 1e-9), "{a:?} {b:?}");
    }

    #[test]
    fn few_rows_are_long() {
        let mut lengths = vec![7; 9000];
        (lengths[3], lengths[4], lengths[5]) = (200, 300, 130);
        assert_eq!(long_rows(&lengths).iter().filter(|long| **long).count(), 1);
        assert!(!long_rows(&vec![299; 300]).contains(&true));
    }
}
