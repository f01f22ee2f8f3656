//! Stitch: from one target matrix per triangle to positions.
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - C_t e(v) |^2      x given at fixed vertices
//! ```
//!
//! With `w_te` half the cotangent opposite the edge this *is* `sum_t area_t |grad_t x - C_t (I - n n^T)|^2`
//! (Botsch, Sumner, Pauly & Gross 2006, Deformation Transfer for Detail-Preserving Surface Editing): the
//! fourth vertices of Sumner & Popović (2004) drop out exactly. Its normal equations are
//! `L x = div C` with the cotangent Laplacian `L`.
//!
//! The unknown is the displacement, `L d = div (C - I)`: where nothing is asked for, nothing moves,
//! to the last bit.

pub mod lbfgs;

use rayon::prelude::*;

use crate::linear::{Columns, ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::divergence::divergence;
use crate::operators::hat_gradients;
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// The factored stitching system of one mesh and one set of constraints.
#[derive(Debug)]
pub struct Stitcher {
    system: ConstrainedSystem,
    hats: Vec<[Vec3; 3]>,
}

impl Stitcher {
    /// Prepares to stitch `mesh` under `constraints`. Every connected component needs a fixed or soft
    /// vertex.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where a component has none, [`crate::Error::OutOfMemory`] and
    /// [`crate::Error::Cancelled`].
    pub fn new(mesh: &Mesh, constraints: Constraints, job: &Job) -> Result<Self> {
        Self::with_matrix(mesh, &cotangent_laplacian(mesh), constraints, job)
    }

    /// The same, with a matrix of one's own: the Laplacian plus further quadratic terms.
    ///
    /// # Errors
    ///
    /// As [`Stitcher::new`].
    pub fn with_matrix(
        mesh: &Mesh,
        matrix: &SymmetricMatrix,
        constraints: Constraints,
        job: &Job,
    ) -> Result<Self> {
        let system = ConstrainedSystem::new(matrix, constraints, job)?;
        Ok(Self { system, hats: hat_gradients(mesh) })
    }

    /// The system behind it.
    pub fn system(&self) -> &ConstrainedSystem {
        &self.system
    }

    /// `area_t grad phi_c` of every corner.
    pub fn hats(&self) -> &[[Vec3; 3]] {
        &self.hats
    }

    /// Displacements, in unit coordinates, that match `targets` (one matrix per triangle) best.
    ///
    /// `displacements` holds those of the fixed vertices and receives the others.
    pub fn solve(&self, mesh: &Mesh, targets: &[Mat3], displacements: &mut [Vec3]) {
        let changes: Vec<Mat3> = targets.par_iter().map(|&c| c - Mat3::IDENTITY).collect();
        let mut block = Columns::from_vectors(displacements);
        let mut rhs = Columns::zeros(block.rows(), 3);
        self.ask(mesh, &changes, rhs.data_mut());
        self.system.solve(&rhs, &mut block);
        displacements.copy_from_slice(&block.vectors(0));
    }

    /// Writes the right-hand side `div (C - I)` for `changes`, one `C_t - I` per triangle, into three columns.
    pub fn ask(&self, mesh: &Mesh, changes: &[Mat3], columns: &mut [f64]) {
        let rows = divergence(mesh.triangles(), &self.hats, changes, mesh.rest().len());
        for (axis, column) in columns.chunks_exact_mut(rows.len()).enumerate() {
            for (value, row) in column.iter_mut().zip(&rows) {
                *value = row[axis];
            }
        }
    }
}
