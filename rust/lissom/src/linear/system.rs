//! `min_x  x^T A x - 2 b^T x  +  sum_soft w |x_v - c_v|^2` with the fixed rows of `x` given.
//!
//! Fixed unknowns are eliminated exactly: `A_ff x_f = b_f - A_fc x_c`.

use super::{Columns, Constraints, Factor, Symbolic, SymmetricMatrix};
use crate::Result;

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
    /// [`crate::Error::SolveFailed`], see [`Symbolic::factor`].
    pub fn new(matrix: &SymmetricMatrix, constraints: Constraints) -> Result<Self> {
        Self::with_symbolic(matrix, constraints, None)
    }

    /// The same, with the symbolic part of a system of the same pattern and the same free vertices.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], see [`Symbolic::factor`].
    pub fn with_symbolic(
        matrix: &SymmetricMatrix,
        constraints: Constraints,
        symbolic: Option<&Symbolic>,
    ) -> Result<Self> {
        assert_eq!(matrix.size(), constraints.vertex_count(), "one row per vertex");
        let mut coupling = Vec::new();
        let mut kept = Vec::new();
        for (i, j, value) in matrix.entries() {
            match (constraints.slot(i), constraints.slot(j)) {
                (Some(a), Some(b)) => kept.push((a, b, value)),
                (Some(a), None) => coupling.push((a, j, value)),
                (None, Some(b)) => coupling.push((b, i, value)),
                (None, None) => {}
            }
        }
        coupling.sort_unstable_by_key(|&(slot, vertex, _)| (slot, vertex));
        let mut reduced = SymmetricMatrix::from_entries(constraints.free().len(), kept);
        for &(vertex, weight) in constraints.soft() {
            if let Some(slot) = constraints.slot(vertex) {
                reduced.add_to_diagonal(slot as usize, weight);
            }
        }
        let symbolic = match symbolic {
            Some(symbolic) => symbolic.clone(),
            None => Symbolic::analyse(&reduced)?,
        };
        let factor = symbolic.factor(&reduced)?;
        Ok(Self { constraints, symbolic, factor, coupling })
    }

    /// The constraints.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// The symbolic part, for another system of the same pattern.
    pub fn symbolic(&self) -> &Symbolic {
        &self.symbolic
    }

    /// Solves for the free rows of `x`, whose fixed rows are given; `rhs` and `x` have one row per
    /// vertex. Soft targets enter through `rhs`: add `weight * target` to their rows.
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
        }
        self.factor.solve(&mut reduced);
        for c in 0..rhs.count() {
            let column = x.column_mut(c);
            for (&v, &value) in free.iter().zip(reduced.column(c)) {
                column[v as usize] = value;
            }
        }
    }
}
