//! Laplacian editing (thesis of S. Zhou 2008, 2.1-2.2; Sorkine, Cohen-Or, Lipman, Alexa, Rössl & Seidel
//! 2004, Laplacian Surface Editing).
//!
//! ```text
//!     min_x  sum_i  | (A x)_i - delta_i |^2  +  w^2 sum_{i in H} | x_i - u_i |^2        delta = A v
//! ```
//!
//! with the uniform `(A x)_i = x_i - mean of neighbours` (equation 2-1) or the cotangent Laplacian,
//! divided by the square root of the cell's area so that the sum is an integral over the surface. It
//! keeps details, but not their orientation: they do not turn with the handles. The unknown is the
//! displacement `d = x - v`, for which `delta` vanishes.

use super::field::inverse_mass;
use super::responses::Response;
use super::{Goal, Region};
use crate::linear::{Columns, ConstrainedSystem, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::graph::graph_laplacian;
use crate::{Mesh, Result, Vec3};

/// How neighbours are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weights {
    /// Each the same, whatever the triangles' shapes.
    Uniform,
    /// By cotangents, which follow the surface and not its triangles.
    #[default]
    Cotangent,
}

/// Options of Laplacian editing.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How neighbours are weighed.
    pub weights: Weights,
}

/// Laplacian editing bound to a region.
#[derive(Debug)]
pub struct Laplacian {
    system: ConstrainedSystem,
}

impl Laplacian {
    /// Assembles and factors the normal matrix `A^T A`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where it cannot be factored.
    pub fn new(region: &Region, options: &Options) -> Result<Self> {
        let matrix = normal_matrix(region.mesh(), options.weights);
        Ok(Self { system: ConstrainedSystem::new(&matrix, region.constraints().clone())? })
    }
}

/// `A^T A`.
fn normal_matrix(mesh: &Mesh, weights: Weights) -> SymmetricMatrix {
    match weights {
        Weights::Cotangent => cotangent_laplacian(mesh).sandwich(&inverse_mass(mesh)),
        Weights::Uniform => {
            let laplacian = graph_laplacian(mesh);
            let degree = laplacian.entries().filter(|(i, j, _)| i == j).map(|(_, _, d)| d);
            let inverse: Vec<f64> = degree.map(|d| if d > 0.0 { 1.0 / (d * d) } else { 0.0 }).collect();
            laplacian.sandwich(&inverse)
        }
    }
}

impl Response for Laplacian {
    fn displacements(&self, _region: &Region, goal: &Goal) -> Vec<Vec3> {
        let mut x = Columns::from_vectors(&goal.displacements);
        self.system.solve(&Columns::zeros(x.rows(), x.count()), &mut x);
        x.vectors(0)
    }
}
