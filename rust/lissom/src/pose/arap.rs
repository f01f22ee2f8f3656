//! As-rigid-as-possible surface modelling (Sorkine & Alexa 2007).
//!
//! ```text
//!     E(x) = min_R  sum_i  sum_{e in cell i}  w_te | e(x) - R_i e(v) |^2
//! ```
//!
//! A cell is all edges of the triangles at `i`, [`Cells::SpokesAndRims`] (Chao, Pinkall, Sanan & Schröder
//! 2010), or only those that end in `i`, [`Cells::Spokes`]. The *local* step takes for `R_i` the rotation
//! nearest to the cell's covariance `sum w e(x) e(v)^T`. The *global* step stitches ([`crate::stitch`]): for fixed
//! rotations every edge of every triangle has as its target the mean over the cells it is in,
//!
//! ```text
//!     C_te = (R_i + R_j + R_k) / 3    or, for spokes,    (R_j + R_k) / 2      for the edge from j to k
//! ```
//!
//! With spokes and rims the sum over a triangle is never negative, whatever the sign of single
//! cotangents; spokes alone need negative edge weights cut off.
//!
//! Two terms may join. `rotation_smoothing` adds `a area sum_ij w_ij |R_i - R_j|^2` (Levi & Gotsman 2015,
//! Smooth Rotation Enhanced As-Rigid-As-Possible Mesh Animation), which makes a surface bend like a solid.
//! `smoothness` blends to `(1 - l) E + l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i` (Oehri, Herholz &
//! Sorkine-Hornung 2025, Higher Order Continuity for Smooth As-Rigid-As-Possible Shape Modeling), with
//! the rotations still fitted to edges, so that a single moved vertex pulls without a spike. They leave the
//! unit of length open; the factor [`BENDING`] times the region's area makes `l` mean the same for every mesh.

use std::f64::consts::PI;

use super::field::{self, inverse_mass};
use super::goal::Goal;
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use crate::geometry::rows::Rows;
use crate::linear::{ConstrainedSystem, SymmetricMatrix};
use crate::matrix::norm_squared;
use crate::operators::cotangent::cotangent_laplacian;
use crate::options::{choices, options};
use crate::rotation::nearest_rotation;
use crate::stitch::{Chooser, Iterate, Owners, Reference, Stitcher, Stop, Weights, edge_weights};
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// Extended rotations are a start where they bring the energy below this fraction of that without.
const CLEARLY: f64 = 0.8;

/// What the bending term of `smoothness` is worth, relative to the area of the region: at `l = 1/2` it
/// rules over distances below a tenth of the region's size.
const BENDING: f64 = 0.01;

choices! {
    /// Which edges a vertex's rotation is fitted to.
    pub enum Cells {
        /// All edges of the triangles around it.
        SpokesAndRims = "spokes_and_rims",
        /// Only the edges that end in it, as first published.
        Spokes = "spokes",
    }
}

options! {
    /// Options of ARAP: the cells, `a` and `l`.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// The edges around a vertex that are kept rigid together.
        pub cells: Cells = Cells::SpokesAndRims,
        /// How much neighbours must turn alike: more spreads a bend over a longer stretch.
        pub rotation_smoothing: f64 = 0.0 => at_least(0.0),
        /// How much curvature counts against lengths: 0.1 takes the spike off a single moved vertex.
        pub smoothness: f64 = 0.0 => at_least(0.0) below(1.0),
    }
}

/// Binds the method to a region.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Arap::new(region, options, job)?))
}

/// ARAP bound to a region.
#[derive(Debug)]
pub struct Arap {
    /// Of weights times `1 - l`.
    stitcher: Stitcher,
    /// `a` times the region's area, against weights times `1 - l`.
    rotation_smoothing: f64,
    smoothness: Option<Smoothness>,
    /// The rotations of the last pose, less the identity.
    previous: Option<Vec<Mat3>>,
}

/// The Laplacian's rows, how much each counts, and what they make of the rest pose.
#[derive(Debug)]
struct Smoothness {
    rows: Rows<(u32, f64)>,
    /// `l h^2 / m_i`.
    factor: Vec<f64>,
    rest: Vec<Vec3>,
}

/// A region on its way to a goal.
struct Posing<'a> {
    arap: &'a Arap,
    goal: &'a Goal,
}

impl Arap {
    /// Factors the system of the global step.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where the system cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let share = 1.0 - options.smoothness;
        let smoothness = (options.smoothness > 0.0).then(|| Smoothness::of(mesh, options.smoothness));
        let bending = smoothness.as_ref().map(|smoothness| {
            let rows = smoothness.factor.iter().copied().zip(smoothness.rows.iter());
            SymmetricMatrix::normal(mesh.rest().len(), rows)
        });
        let (of_triangles, of_edges);
        let (owners, weights) = match options.cells {
            Cells::SpokesAndRims => {
                of_triangles = vec![share; mesh.triangles().len()];
                (Owners::Corners, Weights::Scaled(&of_triangles))
            }
            Cells::Spokes => {
                let weights = edge_weights(mesh, mesh.half_cotangents());
                of_edges = weights.into_iter().map(|w| share * w.max(0.0)).collect::<Vec<_>>();
                (Owners::Edges, Weights::Edges(&of_edges))
            }
        };
        let constraints = region.constraints().clone();
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, bending.as_ref(), constraints, job)?;
        let rotation_smoothing = options.rotation_smoothing * mesh.areas().iter().sum::<f64>() / share;
        Ok(Self { stitcher, rotation_smoothing, smoothness, previous: None })
    }

    /// The better of two shapes to start from: stitched to the handles' rotations, extended as harmonic rotation
    /// vectors, which is exact where all given vertices move by one rigid motion; or to the rotations that
    /// fit where only the handles move, which bends nothing that may stay straight. Which of them leads to
    /// the lower minimum shows only at the end. Where both are about equal, rotations are not what the pose is
    /// about, and the second leads lower.
    fn start(&self, region: &Region, goal: &Goal) -> Iterate {
        let posing = Posing { arap: self, goal };
        let rotations = field::rotations(self.stitcher.system(), region, goal);
        let extended = posing.stitched(rotations.into_iter().map(|r| r - Mat3::IDENTITY).collect());
        // More than half a turn is in the extended rotations alone.
        if goal.handles.iter().any(|m| m.whole_turns != Vec3::ZERO || m.rotation.length() > PI) {
            return extended;
        }
        let unturned = vec![Mat3::ZERO; goal.displacements.len()];
        let rest = posing.stitched(posing.fit(goal.displacements.clone(), &unturned).changes);
        if extended.energy <= CLEARLY * rest.energy { extended } else { rest }
    }
}

impl Posing<'_> {
    /// The shape for given rotations, and those that fit it best.
    fn stitched(&self, changes: Vec<Mat3>) -> Iterate {
        let from =
            Iterate { displacements: self.goal.displacements.clone(), changes, energy: 0.0, size: 0.0 };
        self.fit(self.arap.stitcher.global_step(self, &from), &from.changes)
    }
}

impl Chooser for Posing<'_> {
    /// Energies are over the number of cells that an edge is in.
    fn fit(&self, displacements: Vec<Vec3>, last: &[Mat3]) -> Iterate {
        let Arap { stitcher, smoothness, .. } = self.arap;
        let smoothing = self.arap.rotation_smoothing / stitcher.owners().per_edge();
        let local = stitcher.local_step(Reference::Rest, &displacements, |i, mut covariance| {
            if smoothing > 0.0 {
                for (j, weight) in stitcher.neighbours(i) {
                    covariance += (Mat3::IDENTITY + last[j]) * (2.0 * smoothing * weight.max(0.0));
                }
            }
            nearest_rotation(covariance)
        });
        let missed = |&(v, weight): &(u32, f64)| {
            weight * displacements[v as usize].distance_squared(self.goal.displacements[v as usize])
        };
        let pulls: f64 = stitcher.system().constraints().soft().iter().map(missed).sum();
        let bending = smoothness.as_ref().map_or(0.0, |s| s.energy(&displacements, &local.changes));
        let apart = if smoothing > 0.0 { smoothing * disagreement(stitcher, &local.changes) } else { 0.0 };
        let energy = local.energy + bending + pulls + apart;
        Iterate { displacements, changes: local.changes, energy, size: local.size }
    }

    fn gradient(&self, fit: &Iterate) -> Vec<Vec3> {
        let Iterate { displacements, changes, .. } = fit;
        let Arap { stitcher, smoothness, .. } = self.arap;
        let mut gradient =
            stitcher.gradient(Reference::Rest, changes, displacements, &self.goal.displacements);
        if let Some(smoothness) = smoothness {
            smoothness.add_gradient(displacements, changes, &mut gradient);
        }
        gradient
    }
}

impl Method for Arap {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![self.stitcher.system()]
    }

    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        // What is cancelled leaves the last pose as it was.
        let previous = self.previous.clone().filter(|_| options.warm_start);
        let posing = Posing { arap: self, goal };
        let start = match previous {
            Some(changes) => posing.stitched(changes),
            None => self.start(region, goal),
        };
        let stop = Stop { max_iterations: options.max_iterations, tolerance: options.tolerance };
        let refined = self.stitcher.refine(&posing, start, stop, |iteration| {
            job.report(iteration as f64 / stop.max_iterations as f64, "posing");
            job.check()
        })?;
        let cells = self.stitcher.owners().per_edge();
        let Iterate { displacements, changes, energy, .. } = refined.fit;
        self.previous = Some(changes);
        Ok(Solution {
            displacements,
            iterations: refined.iterations,
            energy: Some((cells * energy).max(0.0)),
            converged: refined.converged,
            residual: refined.residual,
        })
    }
}

/// `sum_ij w_ij |R_i - R_j|^2`, each edge from both ends.
fn disagreement(stitcher: &Stitcher, changes: &[Mat3]) -> f64 {
    let apart = |i: usize| {
        let neighbours = stitcher.neighbours(i).filter(move |(j, _)| i < *j);
        neighbours.map(move |(j, w)| w.max(0.0) * norm_squared(changes[i] - changes[j])).sum::<f64>()
    };
    2.0 * (0..changes.len()).map(apart).sum::<f64>()
}

impl Smoothness {
    fn of(mesh: &Mesh, amount: f64) -> Self {
        let inverse = inverse_mass(mesh);
        let unit = amount * BENDING * mesh.areas().iter().sum::<f64>();
        let rows = cotangent_laplacian(mesh).rows();
        let rest = rows.iter().map(|row| combination(row, mesh.rest())).collect();
        Self { rows, factor: inverse.into_iter().map(|m| m * unit).collect(), rest }
    }

    /// Adds half the gradient of `sum_i f_i |(L d)_i - (R_i - I) (L v)_i|^2`.
    fn add_gradient(&self, displacements: &[Vec3], changes: &[Mat3], gradient: &mut [Vec3]) {
        for (i, row) in self.rows.iter().enumerate() {
            let bend = self.bend(i, displacements, changes) * self.factor[i];
            for &(j, value) in row {
                gradient[j as usize] += bend * value;
            }
        }
    }

    fn energy(&self, displacements: &[Vec3], changes: &[Mat3]) -> f64 {
        let part = |i: usize| self.factor[i] * self.bend(i, displacements, changes).length_squared();
        (0..self.rows.count()).map(part).sum()
    }

    fn bend(&self, i: usize, displacements: &[Vec3], changes: &[Mat3]) -> Vec3 {
        combination(self.rows.of(i), displacements) - changes[i] * self.rest[i]
    }
}

fn combination(row: &[(u32, f64)], vectors: &[Vec3]) -> Vec3 {
    row.iter().fold(Vec3::ZERO, |sum, &(j, value)| sum + vectors[j as usize] * value)
}
