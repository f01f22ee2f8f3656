//! Rotation-invariant coordinates (thesis of S. Zhou 2008, chapters 3 and 4; Lipman, Sorkine, Levin &
//! Cohen-Or 2005, Linear Rotation-Invariant Coordinates for Meshes).
//!
//! First frames, then positions. A frame `F_i = R_i G_i` is the rest frame `G_i` turned by `R_i`, so the
//! frame equations (3-17), `F_j = F_i G_i^T G_j`, say `R_j = R_i`, whichever tangent direction builds
//! `G_i`: their least squares is a harmonic field of matrices, n x n with nine right-hand sides.
//!
//! ```text
//!     min_R  sum over edges ij  w_ij | R_j - R_i |^2                                  R given at handles
//!     min_x  1/2 sum_i sum_{j at i}  w_ij | x_j - x_i - R_i (v_j - v_i) |^2     (3-18)    x given at handles
//! ```
//!
//! Both have one Laplacian for a matrix and share its factor. The thesis has `w = 1`; cotangents keep the
//! triangles' shapes out of the result, which on irregular meshes is far smoother. The thesis builds frames on principal directions (chapter 4), which by the above cannot change the solution; what can
//! is to weigh the equations by them, and that is what [`Frames::Principal`] does.
//!
//! Means of rotation matrices vanish half way to a handle that is turned by 180 degrees, and know no
//! whole turns. [`Interpolation::RotationVector`] solves the same harmonic system for rotation vectors.

use rayon::prelude::*;

use super::field;
use super::goal::Goal;
pub use super::laplacian::LaplacianWeights;
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use super::responses::{Linear, Response};
use crate::linear::{ConstrainedSystem, SymmetricMatrix};
use crate::operators::principal::{Principal, principal_directions};
use crate::options::{choices, options};
use crate::rotation::{exp, nearest_rotation};
use crate::stitch::{self, Owners, Reference, Stitcher, edge_weights};
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// Curvature, in one over the diagonal, that counts as flat: no direction is principal there.
const NEGLIGIBLE_CURVATURE: f64 = 1e-3;

/// Least weight of an edge: it keeps frames together across the principal direction.
const LEAST_WEIGHT: f64 = 0.05;

choices! {
    /// How frame equations are weighed.
    pub enum Frames {
        /// Along all edges alike.
        Uniform = "uniform",
        /// Rather along the directions in which the surface curves most.
        Principal = "principal",
    }
}

choices! {
    /// What is spread over the free vertices.
    pub enum Interpolation {
        /// Axis and angle: also half a turn and more, whole turns counted.
        RotationVector = "rotation_vector",
        /// The nine entries, as in the thesis: for turns well below half a turn.
        Matrix = "matrix",
    }
}

options! {
    /// Options of rotation-invariant coordinates. Matrices that are not projected make the whole method linear,
    /// and the handles' linear parts are spread as they are, stretches and all.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// How much each neighbour of a vertex counts.
        pub weights: LaplacianWeights = LaplacianWeights::Cotangent,
        /// Along which edges turns are spread.
        pub frames: Frames = Frames::Uniform,
        /// What is spread between the handles.
        pub interpolation: Interpolation = Interpolation::RotationVector,
        /// Make every spread matrix a rotation; without, stretches of the handles are spread as well.
        pub project: bool = true => when("interpolation", "matrix"),
    }
}

/// Rotation-invariant coordinates bound to a region.
#[derive(Debug)]
pub struct RotationInvariant {
    options: Options,
    stitcher: Stitcher,
    /// The system of the frames, where it is another one.
    frames: Option<ConstrainedSystem>,
}

/// Factors both systems; what is linear in the handles' motion comes with precomputed responses.
///
/// # Errors
///
/// [`crate::Error::SolveFailed`] where a system cannot be factored.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    let linear = options.interpolation == Interpolation::Matrix && !options.project;
    let method = RotationInvariant::new(region, options, job)?;
    Ok(if linear { Box::new(Linear::new(method)) } else { Box::new(method) })
}

impl RotationInvariant {
    fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let (mesh, constraints) = (region.mesh(), region.constraints());
        let weights = match options.weights {
            LaplacianWeights::Uniform => vec![1.0; mesh.adjacency().edges().len()],
            LaplacianWeights::Cotangent => edge_weights(mesh, mesh.half_cotangents()),
        };
        let (owners, of_edges) = (Owners::Edges, stitch::Weights::Edges(&weights));
        let stitcher = Stitcher::new(mesh.clone(), owners, of_edges, None, constraints.clone(), job)?;
        let frames = match options.frames {
            Frames::Uniform => None,
            Frames::Principal => {
                let weights = principal_weights(mesh, &weights);
                let edges = mesh.adjacency().edges().iter().zip(&weights).map(|(&[i, j], &w)| (i, j, w));
                let matrix = SymmetricMatrix::laplacian(mesh.rest().len(), edges);
                let symbolic = Some(stitcher.system().symbolic());
                Some(ConstrainedSystem::with_symbolic(&matrix, constraints.clone(), symbolic, job)?)
            }
        };
        Ok(Self { options: options.clone(), stitcher, frames })
    }

    /// `R_i - I` of every vertex.
    fn changes(&self, region: &Region, goal: &Goal) -> Vec<Mat3> {
        let system = self.frames.as_ref().unwrap_or(self.stitcher.system());
        if self.options.interpolation == Interpolation::RotationVector {
            return field::rotations(system, region, goal).into_iter().map(|r| r - Mat3::IDENTITY).collect();
        }
        let matrix = |h: usize| {
            let motion = &goal.handles[h];
            if self.options.project { exp(motion.rotation) } else { motion.linear }
        };
        // The unknown is `R - I`, which is zero where the surface stays.
        let mut columns =
            [0, 1, 2].map(|column| region.at_handles(|h| (matrix(h) - Mat3::IDENTITY).col(column)));
        system.extend(&mut columns);
        let change = |v: usize| Mat3::from_cols(columns[0][v], columns[1][v], columns[2][v]);
        let projected = |v| nearest_rotation(Mat3::IDENTITY + change(v)) - Mat3::IDENTITY;
        let change = |v| if self.options.project { projected(v) } else { change(v) };
        (0..columns[0].len()).into_par_iter().map(change).collect()
    }
}

impl Response for RotationInvariant {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        self.frames.iter().chain([self.stitcher.system()]).collect()
    }

    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3> {
        let mut displacements = goal.displacements.clone();
        self.stitcher.stitch(Reference::Rest, &self.changes(region, goal), &mut displacements);
        displacements
    }
}

impl Method for RotationInvariant {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        Response::systems(self)
    }

    fn solve(&mut self, region: &Region, goal: &Goal, _: &SolveOptions, job: &Job) -> Result<Solution> {
        job.check()?;
        Ok(Solution::direct(self.displacements(region, goal)))
    }
}

/// The weights times the edges' alignment with the direction of largest curvature, `1 + a cos 2 psi` at
/// either end, where `psi` is the angle between edge and direction and the anisotropy `a` is 1 where the
/// surface curves in one direction only, 0 where in all alike.
fn principal_weights(mesh: &Mesh, weights: &[f64]) -> Vec<f64> {
    let principal = principal_directions(mesh);
    let rest = mesh.rest();
    let negligible = NEGLIGIBLE_CURVATURE / mesh.diagonal();
    let at = |p: &Principal, edge: Vec3| {
        let [most, least] = p.curvatures.map(f64::abs);
        let anisotropy = (most - least) / (most + least + negligible);
        let (along, across) = (edge.dot(p.direction), edge.dot(p.normal.cross(p.direction)));
        let length_squared = (along * along + across * across).max(f64::MIN_POSITIVE);
        1.0 + anisotropy * (along * along - across * across) / length_squared
    };
    let edges = mesh.adjacency().edges().iter().zip(weights);
    edges
        .map(|(&[i, j], &weight)| {
            let (a, b) = (i as usize, j as usize);
            let edge = rest[b] - rest[a];
            let alignment = 0.5 * (at(&principal[a], edge) + at(&principal[b], edge));
            // Negative cotangents are harmless together, but not weighed one by one.
            weight.max(LEAST_WEIGHT) * alignment.max(LEAST_WEIGHT)
        })
        .collect()
}
