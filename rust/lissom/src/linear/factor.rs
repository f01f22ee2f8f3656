//! Sparse Cholesky factorization behind one small type; beside [`super::schedule`] the only file that knows faer's
//! solver.

use std::sync::{Arc, OnceLock};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side, Spec};
use rayon::prelude::*;

use super::columns::Columns;
use super::lanes::{LANES, Lanes};
use super::matrix::SymmetricMatrix;
use super::schedule::Schedule;
use super::substitution::substitute;
use crate::{Error, Result, Vec3, memory};

/// Added to each entry of the diagonal, relative to itself, when a factorization fails the first time. Rounding
/// alone makes a pivot negative by some 1e-14 of it; small entries beside large ones keep their worth.
const REGULARIZATION: f64 = 1e-11;

/// A pivot below this fraction of the entry of the diagonal that it started from is rounding: some ten times what
/// a sum of as many terms as a vertex of a surface has neighbours is off by.
const ROUNDING: f64 = 1e-14;

/// What to say where that happened.
pub const REGULARIZED: &str = "the system is singular to rounding, and a little was added to its diagonal: parts of \
                               the mesh hang together by next to nothing, or are held by too few vertices";

/// Up to so many columns are solved by [`substitute`]; beyond, products of matrices are worth being set up.
const FEW: usize = 2 * LANES;

/// Columns solved together by one thread; more share each pass over the factor.
const COLUMNS_AT_ONCE: usize = 8;

/// Into how many shares columns fall where there are not enough for more. How many columns are solved together shows in
/// the last bits of each, so it must not depend on the threads that there are.
const SHARES: usize = 2;

/// The order of elimination and the pattern of the factor: the part of the work that depends on the
/// pattern of the matrix alone. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Symbolic(Arc<Order>);

#[derive(Debug)]
struct Order {
    cholesky: SymbolicCholesky<u32>,
    /// Made for the first few columns; none where blocks are single columns.
    schedule: OnceLock<Option<Schedule>>,
}

/// A Cholesky factor `L L^T = P A P^T`.
#[derive(Debug)]
pub struct Factor {
    symbolic: Symbolic,
    values: Values,
    regularized: bool,
}

#[derive(Debug)]
enum Values {
    Double(Vec<f64>),
    Single(Vec<f32>),
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
        let mut memory = MemBuffer::new(scratch);
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
            Ok(cholesky) => {
                let schedule = OnceLock::new();
                Ok(Self(Arc::new(Order { cholesky, schedule })))
            }
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
    /// little added to its diagonal, [`Error::OutOfMemory`] where the factor does not fit.
    pub fn factor(&self, matrix: &SymmetricMatrix) -> Result<Factor> {
        if let Some(values) = self.attempt(matrix)? {
            return Ok(Factor { symbolic: self.clone(), values: Values::Double(values), regularized: false });
        }
        let mut regularized = matrix.clone();
        let least = matrix.largest() * f64::EPSILON;
        for row in 0..matrix.size() {
            regularized.add_to_diagonal(row, REGULARIZATION * matrix.diagonal(row).max(least));
        }
        match self.attempt(&regularized)? {
            Some(values) => {
                Ok(Factor { symbolic: self.clone(), values: Values::Double(values), regularized: true })
            }
            None => Err(Error::SolveFailed(format!(
                "the system of {} unknowns is not positive definite: too few constraints?",
                matrix.size()
            ))),
        }
    }

    /// How a few columns are solved; `None` where blocks are single columns.
    fn schedule(&self) -> Option<&Schedule> {
        let make = || match self.0.cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => None,
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                let order = self.0.cholesky.perm().map(|order| order.arrays().0);
                Some(Schedule::of(symbolic, |k| order.map_or(k as u32, |order| order[k])))
            }
        };
        self.0.schedule.get_or_init(make).as_ref()
    }

    /// The values of the factor; `None` where a pivot is not positive.
    fn attempt(&self, matrix: &SymmetricMatrix) -> Result<Option<Vec<f64>>> {
        // faer's own threads cost more than they give on matrices of surfaces.
        let scratch = self.0.cholesky.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        memory::check(
            "the factor",
            8 * self.0.cholesky.len_val() as u128 + scratch.unaligned_bytes_required() as u128,
        )?;
        let mut values = vec![0.0; self.0.cholesky.len_val()];
        let mut memory = MemBuffer::new(scratch);
        let outcome = self.0.cholesky.factorize_numeric_llt(
            &mut values,
            matrix.0.as_ref(),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Spec::default(),
        );
        let definite = outcome.is_ok() && values.iter().all(|v| v.is_finite());
        Ok((definite && self.stands(matrix, &values)).then_some(values))
    }

    /// Whether every pivot is more than what rounding leaves of the entry that it started from. Where one is
    /// not, the matrix is singular as far as can be told, and the factor is noise.
    fn stands(&self, matrix: &SymmetricMatrix, values: &[f64]) -> bool {
        let row = |k: usize| self.0.cholesky.perm().map_or(k, |order| order.arrays().0[k] as usize);
        let pivots = self.pivots(values);
        (pivots.iter().enumerate()).all(|(k, pivot)| pivot * pivot > ROUNDING * matrix.diagonal(row(k)))
    }

    /// The diagonal of a factor.
    fn pivots(&self, values: &[f64]) -> Vec<f64> {
        match self.0.cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let firsts = &symbolic.col_ptr()[..self.0.cholesky.nrows()];
                firsts.iter().map(|&first| values[first as usize]).collect()
            }
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                let factor = SupernodalLltRef::new(symbolic, values);
                let blocks = (0..symbolic.n_supernodes()).map(|s| factor.supernode(s).val());
                blocks.flat_map(|block| (0..block.ncols()).map(move |k| block[(k, k)])).collect()
            }
        }
    }
}

impl Factor {
    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.symbolic.0.cholesky.nrows()
    }

    /// Whether the matrix was singular to rounding, and a little was added to its diagonal.
    pub fn is_regularized(&self) -> bool {
        self.regularized
    }

    /// The same with values rounded to single precision, where they suit that: the factor of a matrix that is still
    /// symmetric and positive definite, and about as near. A pass over it reads half.
    pub fn rounded(mut self) -> Self {
        if let Values::Double(values) = &self.values
            && self.symbolic.schedule().is_some()
            && self.symbolic.pivots(values).iter().all(|pivot| (*pivot as f32).is_normal())
            && values.iter().all(|value| (*value as f32).is_finite())
        {
            self.values = Values::Single(values.iter().map(|&value| value as f32).collect());
        }
        self
    }

    /// Number of values, zeros that fill up blocks included.
    pub fn nonzeros(&self) -> usize {
        match &self.values {
            Values::Double(values) => values.len(),
            Values::Single(values) => values.len(),
        }
    }

    /// Bytes of values and indices: what one solve reads twice.
    pub fn bytes(&self) -> usize {
        let indices = match self.symbolic.0.cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(symbolic) => symbolic.row_idx().len() + symbolic.col_ptr().len(),
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic.row_idx().len(),
        };
        let each = if matches!(self.values, Values::Double(_)) { size_of::<f64>() } else { size_of::<f32>() };
        each * self.nonzeros() + size_of::<u32>() * indices
    }

    /// Replaces every set of vectors `b`, one per unknown, by the solution `x` of `A x = b`.
    pub fn solve(&self, sets: &mut [Vec<Vec3>]) {
        let mut columns = Columns::side_by_side(self.size(), sets.iter().map(Vec::as_slice));
        self.solve_columns(&mut columns);
        sets.iter_mut().enumerate().for_each(|(k, set)| *set = columns.vectors(k));
    }

    /// Replaces each column `b` by the solution `x` of `A x = b`.
    ///
    /// Columns are spread over threads: one back-substitution by itself is bound by memory and
    /// slower on several.
    pub(super) fn solve_columns(&self, columns: &mut Columns) {
        assert_eq!(columns.rows(), self.size(), "one row per unknown");
        if self.size() == 0 {
            return;
        }
        let few = (2..=FEW).contains(&columns.count());
        let values = match &self.values {
            Values::Double(values) if !(few && self.symbolic.schedule().is_some()) => values,
            _ => return self.solve_few(columns),
        };
        let at_once = columns.count().div_ceil(SHARES).clamp(1, COLUMNS_AT_ONCE);
        let llt = LltRef::new(&self.symbolic.0.cholesky, values);
        columns.data_mut().par_chunks_mut(at_once * self.size()).for_each(|chunk| {
            let count = chunk.len() / self.size();
            let scratch = self.symbolic.0.cholesky.solve_in_place_scratch::<f64>(count, Par::Seq);
            let mut memory = MemBuffer::new(scratch);
            let block = MatMut::from_column_major_slice_mut(chunk, self.size(), count);
            llt.solve_in_place_with_conj(Conj::No, block, Par::Seq, MemStack::new(&mut memory));
        });
    }

    fn substitute(&self, schedule: &Schedule, b: &mut [Lanes]) {
        match &self.values {
            Values::Double(values) => substitute(schedule, values, b),
            Values::Single(values) => substitute(schedule, values, b),
        }
    }

    fn solve_few(&self, columns: &mut Columns) {
        let Some(schedule) = self.symbolic.schedule() else { return };
        let size = self.size();
        let at_once = columns.count().div_ceil(columns.count().div_ceil(LANES));
        columns.data_mut().par_chunks_mut(at_once * size).for_each(|chunk| {
            let count = chunk.len() / size;
            let at = |i: usize, lane: usize| if lane < count { chunk[lane * size + i] } else { 0.0 };
            let lanes = |unknown: u32| -> Lanes { std::array::from_fn(|lane| at(unknown as usize, lane)) };
            let mut b = schedule.vector(lanes);
            self.substitute(schedule, &mut b);
            for (lane, column) in chunk.chunks_mut(size).enumerate() {
                let places = column.iter_mut().zip(schedule.places());
                places.for_each(|(x, &place)| *x = b[place as usize][lane]);
            }
        });
    }

    /// Solves for a few columns side by side, of which `of` tells the right-hand side of each unknown, and `add` adds
    /// to it at the unknowns' places. The solution, and where in it each unknown is; `None` where the factor has no
    /// blocks.
    pub(super) fn solve_lanes(
        &self,
        of: impl Fn(u32) -> Lanes + Sync,
        add: impl FnOnce(&mut [Lanes], &[u32]),
    ) -> Option<(Vec<Lanes>, &[u32])> {
        let schedule = self.symbolic.schedule()?;
        let mut b = schedule.vector(of);
        add(&mut b, schedule.places());
        self.substitute(schedule, &mut b);
        Some((b, schedule.places()))
    }
}
