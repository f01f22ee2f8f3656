//! `min_x  x^T A x - 2 b^T x  +  sum_soft w |x_v - c_v|^2` with the fixed rows of `x` given.
//!
//! Fixed unknowns are eliminated exactly: `A_ff x_f = b_f - A_fc x_c`.

use rayon::prelude::*;

use super::{Columns, Constraints, Factor, Symbolic, SymmetricMatrix};
use crate::{Job, Result};

/// A symmetric system with constraints, factored.
#[derive(Debug)]
pub struct ConstrainedSystem {
    constraints: Constraints,
    symbolic: Symbolic,
    factor: Factor,
    /// Entries that couple a free row to a fixed vertex: (slot, vertex, value).
    coupling: Vec<(u32, u32, f64)>,
}

impl ConstrainedSystem {
    /// Eliminates the constraints from `matrix` and factors the rest.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], [`crate::Error::OutOfMemory`], see [`Symbolic::factor`];
    /// [`crate::Error::Cancelled`].
    pub fn new(matrix: &SymmetricMatrix, constraints: Constraints, job: &Job) -> Result<Self> {
        Self::with_symbolic(matrix, constraints, None, job)
    }

    /// The same, with the symbolic part of a system of the same pattern and the same free vertices.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn with_symbolic(
        matrix: &SymmetricMatrix,
        constraints: Constraints,
        symbolic: Option<&Symbolic>,
        job: &Job,
    ) -> Result<Self> {
        job.part("order of elimination")?;
        let (reduced, coupling) = eliminate(matrix, &constraints);
        let symbolic = match symbolic {
            Some(symbolic) => symbolic.clone(),
            None => Symbolic::analyse(&reduced)?,
        };
        job.part("factorization")?;
        let factor = symbolic.factor(&reduced)?;
        Ok(Self { constraints, symbolic, factor, coupling })
    }

    /// The same for a matrix of 3 x 3 blocks, one block row per vertex, where the axes couple: unknown
    /// `3 v + a` is axis `a` of vertex `v`, and is constrained as `v` is.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn of_blocks(matrix: SymmetricMatrix, constraints: &Constraints, job: &Job) -> Result<Self> {
        job.part("order of elimination")?;
        let constraints = constraints.of_axes();
        let (reduced, coupling) = eliminate(&matrix, &constraints);
        // The factor is about to need the room.
        drop(matrix);
        let symbolic = Symbolic::analyse_blocks(&reduced)?;
        job.part("factorization")?;
        let factor = symbolic.factor(&reduced)?;
        Ok(Self { constraints, symbolic, factor, coupling })
    }

    /// The constraints.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// The factor.
    pub fn factor(&self) -> &Factor {
        &self.factor
    }

    /// The symbolic part, for another system of the same pattern.
    pub fn symbolic(&self) -> &Symbolic {
        &self.symbolic
    }

    /// Solves for the free rows of `x`, one row per vertex, as in `rhs`. On entry the fixed rows of `x`
    /// hold what is given, and the rows of soft constraints their targets.
    pub fn solve(&self, rhs: &Columns, x: &mut Columns) {
        assert_eq!(rhs.rows(), self.constraints.vertex_count(), "one row per vertex");
        assert_eq!((x.rows(), x.count()), (rhs.rows(), rhs.count()), "unknowns match right-hand sides");
        let free = self.constraints.free();
        let mut reduced = Columns::zeros(free.len(), rhs.count());
        for c in 0..rhs.count() {
            let (full, given, column) = (rhs.column(c), x.column(c), reduced.column_mut(c));
            for (target, &v) in column.iter_mut().zip(free) {
                *target = full[v as usize];
            }
            for &(slot, vertex, value) in &self.coupling {
                column[slot as usize] -= value * given[vertex as usize];
            }
            for &(vertex, weight) in self.constraints.soft() {
                if let Some(slot) = self.constraints.slot(vertex) {
                    column[slot as usize] += weight * given[vertex as usize];
                }
            }
        }
        self.factor.solve(&mut reduced);
        for c in 0..rhs.count() {
            let column = x.column_mut(c);
            for (&v, &value) in free.iter().zip(reduced.column(c)) {
                column[v as usize] = value;
            }
        }
    }

    /// Solves without right-hand side, then again for what is left of it. `product` multiplies one column by
    /// the matrix, not with its entries but as `B^T (B x)` from the factors that it was assembled from.
    ///
    /// Rounding its entries alone costs a normal matrix the square of the digits that `B` costs (Björck 1987,
    /// Stability Analysis of the Method of Seminormal Equations): 1e-7 of the diagonal on 100,000 vertices,
    /// where after one correction 1e-11 is left.
    pub fn minimise(&self, x: &mut Columns, product: impl Fn(&[f64]) -> Vec<f64> + Sync) {
        let targets = x.clone();
        let mut rest = Columns::zeros(x.rows(), x.count());
        self.solve(&rest, x);
        rest.data_mut().par_chunks_mut(x.rows().max(1)).enumerate().for_each(|(c, rest)| {
            let (x, target) = (x.column(c), targets.column(c));
            for (rest, product) in rest.iter_mut().zip(product(x)) {
                *rest = -product;
            }
            for &(v, weight) in self.constraints.soft() {
                rest[v as usize] += weight * (target[v as usize] - x[v as usize]);
            }
        });
        let mut correction = Columns::zeros(x.rows(), x.count());
        self.solve(&rest, &mut correction);
        for (x, correction) in x.data_mut().iter_mut().zip(correction.data_mut()) {
            *x += *correction;
        }
    }
}

/// The rows and columns of the free unknowns, soft constraints added, and what couples them to the fixed.
fn eliminate(matrix: &SymmetricMatrix, constraints: &Constraints) -> (SymmetricMatrix, Vec<(u32, u32, f64)>) {
    assert_eq!(matrix.size(), constraints.vertex_count(), "one row per vertex");
    let mut coupling = Vec::new();
    for (i, j, value) in matrix.entries() {
        match (constraints.slot(i), constraints.slot(j)) {
            (Some(a), None) => coupling.push((a, j, value)),
            (None, Some(b)) => coupling.push((b, i, value)),
            _ => {}
        }
    }
    coupling.sort_unstable_by_key(|&(slot, vertex, _)| (slot, vertex));
    let mut reduced = matrix.select(|v| constraints.slot(v));
    for &(vertex, weight) in constraints.soft() {
        if let Some(slot) = constraints.slot(vertex) {
            reduced.add_to_diagonal(slot as usize, weight);
        }
    }
    (reduced, coupling)
}
