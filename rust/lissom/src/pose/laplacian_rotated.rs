//! Laplacian editing in two passes, with estimated rotations (Lipman, Sorkine, Cohen-Or, Levin, Rössl & Seidel 2004,
//! Differential Coordinates for Interactive Mesh Editing; references 5 and 6 of the thesis of S. Zhou 2008).
//!
//! ```text
//!     min_x'  sum_i | (A x')_i - delta_i |^2          delta = A v, the pose of `laplacian`
//!     R_i     the rotation nearest to the mean over about l of the gradients from v to x'
//!     min_x   sum_i | (A x)_i - R_i delta_i |^2
//! ```
//!
//! Without turns of their own, details of the first pass are sheared; it still tells how the surface as a whole
//! turns. The mean is `(M + l^2 L) g = M q`, with the gradients `q` at the vertices, and given in handles and where the
//! surface stays, whose turns are known. The unknown of the second pass is what it adds to the first.

use super::field::inverse_mass;
use super::goal::Goal;
use super::laplacian::{LaplacianWeights, operator};
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use super::responses::minima;
use crate::linear::{ConstrainedSystem, Constraints, SplitMatrix, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::gradient::deformation_gradients;
use crate::options::options;
use crate::rotation::{exp, nearest_rotation};
use crate::{Job, Mat3, Result, Vec3};

options! {
    /// Options of Laplacian editing with estimated rotations.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// How much each neighbour of a vertex counts.
        pub weights: LaplacianWeights = LaplacianWeights::Cotangent,
        /// Bumps narrower than this turn as the surface around them does.
        pub estimate: f64 = 0.05 => at_least(0.0) unit("of the mesh's diagonal"),
    }
}

/// Binds the method to a region.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(LaplacianRotated::new(region, options, job)?))
}

/// Laplacian editing with estimated rotations, bound to a region.
#[derive(Debug)]
pub struct LaplacianRotated {
    system: ConstrainedSystem,
    laplacian: SymmetricMatrix,
    squares: Vec<f64>,
    /// `L v`.
    delta: Vec<Vec3>,
    /// `M + l^2 L`, where there is an `l`.
    mean: Option<ConstrainedSystem>,
    /// `M`.
    mass: Vec<f64>,
}

impl LaplacianRotated {
    fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let (laplacian, squares) = operator(mesh, options.weights);
        let matrix = SplitMatrix::sandwich(&laplacian, &squares)?;
        let system = ConstrainedSystem::of_split(&matrix, region.constraints().clone(), job)?;
        let mass: Vec<f64> = inverse_mass(mesh).into_iter().map(|inverse| 1.0 / inverse).collect();
        let mean = if options.estimate > 0.0 {
            let diagonal = (0u32..).zip(&mass).map(|(v, &m)| (v, v, m));
            let matrix = SymmetricMatrix::from_entries(mass.len(), diagonal).combine(
                1.0,
                &cotangent_laplacian(mesh),
                options.estimate * options.estimate,
            );
            Some(ConstrainedSystem::new(
                &matrix,
                Constraints::hard(mass.len(), |v| is_known(region, v)),
                job,
            )?)
        } else {
            None
        };
        let delta = laplacian.times_vectors(mesh.rest());
        Ok(Self { system, laplacian, squares, delta, mean, mass })
    }

    /// `R_i - I` of every vertex, where the first pass has moved them by `displacements`.
    fn turns(&self, region: &Region, goal: &Goal, displacements: &[Vec3]) -> Vec<Mat3> {
        let mesh = region.mesh();
        let moved: Vec<Vec3> = mesh.rest().iter().zip(displacements).map(|(&v, &d)| v + d).collect();
        let gradients = deformation_gradients(mesh, &moved);
        let at = |v: usize| {
            if is_known(region, v) {
                return region.handle_of(v).map_or(Mat3::IDENTITY, |h| exp(goal.handles[h].rotation));
            }
            let around = mesh.adjacency().corners_of(v).iter().map(|corner| corner.triangle as usize);
            let (sum, area) = around.fold((Mat3::ZERO, f64::MIN_POSITIVE), |(sum, area), t| {
                (sum + gradients[t] * mesh.areas()[t], area + mesh.areas()[t])
            });
            sum * (1.0 / area)
        };
        let changes: Vec<Mat3> = (0..moved.len()).map(|v| at(v) - Mat3::IDENTITY).collect();
        let mut columns =
            [0, 1, 2].map(|axis| changes.iter().map(|change| change.col(axis)).collect::<Vec<_>>());
        if let Some(mean) = &self.mean {
            let weigh = |column: &Vec<Vec3>| column.iter().zip(&self.mass).map(|(&g, &m)| g * m).collect();
            let weighed: Vec<Vec<Vec3>> = columns.iter().map(weigh).collect();
            mean.solve(&weighed, &mut columns);
        }
        let change = |v: usize| Mat3::from_cols(columns[0][v], columns[1][v], columns[2][v]);
        (0..moved.len()).map(|v| nearest_rotation(Mat3::IDENTITY + change(v)) - Mat3::IDENTITY).collect()
    }
}

/// Whether a vertex turns as its handle does, or stays.
fn is_known(region: &Region, vertex: usize) -> bool {
    region.handle_of(vertex).is_some() || region.constraints().slot(vertex as u32).is_none()
}

impl Method for LaplacianRotated {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        self.mean.iter().chain([&self.system]).collect()
    }

    fn solve(&mut self, region: &Region, goal: &Goal, _: &SolveOptions, job: &Job) -> Result<Solution> {
        job.check()?;
        let product = |x: &[f64]| self.laplacian.sandwich_times(&self.squares, x);
        let mut displacements = minima(&self.system, std::slice::from_ref(goal), product).swap_remove(0);
        job.check()?;
        let turned = self.turns(region, goal, &displacements).into_iter().zip(&self.delta).zip(&self.squares);
        let asked: Vec<Vec3> = turned.map(|((turn, &delta), &square)| turn * delta * square).collect();
        let mut added = [vec![Vec3::ZERO; asked.len()]];
        self.system.solve(&[self.laplacian.times_vectors(&asked)], &mut added);
        displacements.iter_mut().zip(&added[0]).for_each(|(d, &added)| *d += added);
        Ok(Solution::direct(displacements))
    }
}
