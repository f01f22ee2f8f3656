//! Sparse Cholesky factorization behind one small type; the only file that knows faer's solver.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side, Spec};
use rayon::prelude::*;

use super::{Columns, SymmetricMatrix};
use crate::{Error, Result};

/// Added to the diagonal, relative to its largest entry, when a factorization fails the first time.
const REGULARIZATION: f64 = 1e-11;

/// Columns solved together by one thread; more share each pass over the factor.
const COLUMNS_AT_ONCE: usize = 8;

/// The order of elimination and the pattern of the factor: the part of the work that depends on the
/// pattern of the matrix alone. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Symbolic(Arc<SymbolicCholesky<u32>>);

/// A Cholesky factor `L L^T = P A P^T`.
#[derive(Debug)]
pub struct Factor {
    symbolic: Symbolic,
    values: Vec<f64>,
}

impl Symbolic {
    /// Orders `matrix` by approximate minimum degree.
    ///
    /// # Errors
    ///
    /// [`Error::SolveFailed`] where the factor is too large.
    pub fn analyse(matrix: &SymmetricMatrix) -> Result<Self> {
        Self::in_order(matrix, SymmetricOrdering::Amd)
    }

    /// Orders a matrix of 3 x 3 blocks by the pattern of its blocks, nine times smaller.
    ///
    /// # Errors
    ///
    /// [`Error::SolveFailed`] where the factor is too large.
    pub fn analyse_blocks(matrix: &SymmetricMatrix) -> Result<Self> {
        let failed = |problem: String| Error::SolveFailed(format!("no order of elimination: {problem}"));
        let blocks = matrix.size() / 3;
        let (mut starts, mut rows) = (vec![0u32], Vec::new());
        for k in 0..blocks {
            // Blocks are full, so the first row of each stands for it; the diagonal one comes whole.
            let column = matrix.0.symbolic().row_idx_of_col_raw(3 * k);
            rows.extend(column.iter().filter(|i| *i % 3 == 0).map(|i| i / 3));
            starts.push(rows.len() as u32);
        }
        let pattern = SymbolicSparseColMat::new_checked(blocks, blocks, starts, None, rows);
        let scratch = amd::order_maybe_unsorted_scratch::<u32>(blocks, pattern.row_idx().len());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| failed("no memory to order in".into()))?;
        let (mut forward, mut inverse) = (vec![0u32; blocks], vec![0u32; blocks]);
        let control = amd::Control::default();
        let stack = MemStack::new(&mut memory);
        amd::order_maybe_unsorted(&mut forward, &mut inverse, pattern.as_ref(), control, stack)
            .map_err(|problem| failed(problem.to_string()))?;
        let of_axes = |order: Vec<u32>| -> Vec<u32> {
            order.into_iter().flat_map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect()
        };
        let (forward, inverse) = (of_axes(forward), of_axes(inverse));
        let order = PermRef::new_checked(&forward, &inverse, matrix.size());
        Self::in_order(matrix, SymmetricOrdering::Custom(order))
    }

    fn in_order(matrix: &SymmetricMatrix, order: SymmetricOrdering<'_, u32>) -> Result<Self> {
        let pattern = matrix.0.symbolic();
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, order, CholeskySymbolicParams::default());
        match symbolic {
            Ok(symbolic) => Ok(Self(Arc::new(symbolic))),
            Err(problem) => Err(Error::SolveFailed(format!(
                "no order of elimination for {} unknowns: {problem}",
                matrix.size()
            ))),
        }
    }

    /// Factors a matrix of the same pattern.
    ///
    /// # Errors
    ///
    /// [`Error::SolveFailed`] where the matrix is not positive definite even after one retry with a
    /// little added to its diagonal, or where memory does not suffice.
    pub fn factor(&self, matrix: &SymmetricMatrix) -> Result<Factor> {
        if let Some(values) = self.attempt(matrix)? {
            return Ok(Factor { symbolic: self.clone(), values });
        }
        let mut lifted = matrix.clone();
        let largest = matrix.entries().filter(|(i, j, _)| i == j).fold(0.0, |m: f64, e| m.max(e.2));
        for row in 0..matrix.size() {
            lifted.add_to_diagonal(row, largest * REGULARIZATION);
        }
        match self.attempt(&lifted)? {
            Some(values) => Ok(Factor { symbolic: self.clone(), values }),
            None => Err(Error::SolveFailed(format!(
                "the system of {} unknowns is not positive definite: too few constraints?",
                matrix.size()
            ))),
        }
    }

    /// The values of the factor; `None` where a pivot is not positive.
    fn attempt(&self, matrix: &SymmetricMatrix) -> Result<Option<Vec<f64>>> {
        let length = self.0.len_val();
        let too_large = |_| {
            let gigabytes = length as f64 * 8e-9;
            Error::SolveFailed(format!("the factor needs {gigabytes:.1} GB of memory"))
        };
        let mut values = Vec::new();
        values.try_reserve_exact(length).map_err(too_large)?;
        values.resize(length, 0.0);
        // faer's own threads cost more than they give on matrices of surfaces.
        let scratch = self.0.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let mut memory =
            MemBuffer::try_new(scratch).map_err(|_| Error::SolveFailed("no memory to factor in".into()))?;
        let outcome = self.0.factorize_numeric_llt(
            &mut values,
            matrix.0.as_ref(),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Spec::default(),
        );
        let positive = outcome.is_ok() && values.iter().all(|v| v.is_finite());
        Ok(positive.then_some(values))
    }

    /// Number of values in the factor.
    pub fn factor_size(&self) -> usize {
        self.0.len_val()
    }
}

impl Factor {
    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.symbolic.0.nrows()
    }

    /// Replaces each column `b` by the solution `x` of `A x = b`.
    ///
    /// Columns are spread over threads: one back-substitution by itself is bound by memory and
    /// slower on several.
    pub fn solve(&self, columns: &mut Columns) {
        assert_eq!(columns.rows(), self.size(), "one row per unknown");
        if self.size() == 0 {
            return;
        }
        let threads = rayon::current_num_threads().max(1);
        let at_once = columns.count().div_ceil(threads).clamp(1, COLUMNS_AT_ONCE);
        let llt = LltRef::new(&self.symbolic.0, &self.values);
        columns.data_mut().par_chunks_mut(at_once * self.size()).for_each(|chunk| {
            let count = chunk.len() / self.size();
            let scratch = self.symbolic.0.solve_in_place_scratch::<f64>(count, Par::Seq);
            let mut memory = MemBuffer::new(scratch);
            let block = MatMut::from_column_major_slice_mut(chunk, self.size(), count);
            llt.solve_in_place_with_conj(Conj::No, block, Par::Seq, MemStack::new(&mut memory));
        });
    }
}
