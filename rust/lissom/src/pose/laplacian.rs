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
use super::goal::Goal;
use super::method::Method;
use super::region::Region;
use super::responses::{Linear, Response, minima};
use crate::linear::{ConstrainedSystem, SplitMatrix, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::graph::graph_laplacian;
use crate::options::{choices, options};
use crate::{Job, Mesh, Result, Vec3};

choices! {
    /// How neighbours are weighed.
    pub enum LaplacianWeights {
        /// By the shape of the triangles: fine and coarse parts act alike.
        Cotangent = "cotangent",
        /// All the same: for even meshes, and where triangles are very thin.
        Uniform = "uniform",
    }
}

options! {
    /// Options of Laplacian editing.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// How much each neighbour of a vertex counts.
        pub weights: LaplacianWeights = LaplacianWeights::Cotangent,
    }
}

/// Binds the method to a region, with precomputed responses.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Linear::new(Laplacian::new(region, options, job)?)))
}

/// Laplacian editing bound to a region.
#[derive(Debug)]
pub struct Laplacian {
    system: ConstrainedSystem,
    laplacian: SymmetricMatrix,
    squares: Vec<f64>,
}

impl Laplacian {
    /// Assembles and factors the normal matrix `A^T A`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where it cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let (laplacian, squares) = operator(region.mesh(), options.weights);
        let matrix = SplitMatrix::sandwich(&laplacian, &squares)?;
        let system = ConstrainedSystem::of_split(&matrix, region.constraints().clone(), job)?;
        Ok(Self { system, laplacian, squares })
    }
}

/// `L` and the squares of `D` of the operator `A = D L`.
pub(super) fn operator(mesh: &Mesh, weights: LaplacianWeights) -> (SymmetricMatrix, Vec<f64>) {
    match weights {
        LaplacianWeights::Cotangent => (cotangent_laplacian(mesh), inverse_mass(mesh)),
        LaplacianWeights::Uniform => {
            let laplacian = graph_laplacian(mesh);
            let degree = laplacian.entries().filter(|(i, j, _)| i == j).map(|(_, _, d)| d);
            let squares = degree.map(|d| if d > 0.0 { 1.0 / (d * d) } else { 0.0 }).collect();
            (laplacian, squares)
        }
    }
}

impl Response for Laplacian {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![&self.system]
    }

    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3> {
        self.displacements_of(region, std::slice::from_ref(goal)).swap_remove(0)
    }

    fn displacements_of(&self, _region: &Region, goals: &[Goal]) -> Vec<Vec<Vec3>> {
        minima(&self.system, goals, |x| self.laplacian.sandwich_times(&self.squares, x))
    }
}
