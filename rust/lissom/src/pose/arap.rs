//! As-rigid-as-possible surface modelling (Sorkine & Alexa 2007).
//!
//! ```text
//!     E(R) = min_x  sum_i  sum_{e in cell i}  w_te | e(x) - R_i e(v) |^2
//! ```
//!
//! A cell is all edges of the triangles at `i`, [`Cells::SpokesAndRims`] (Chao, Pinkall, Sanan & Schröder
//! 2010), or only those that end in `i`, [`Cells::Spokes`]. With spokes and rims the sum over a triangle is never
//! negative, whatever the sign of single cotangents; spokes alone need negative edge weights cut off.
//!
//! As published, rotations and positions are found in turn. Here the rotations are the unknowns ([`crate::stitch`],
//! turns): every shape is the one that matches its rotations best, and the rotations descend (`arap_descent`).
//!
//! This energy stretches, but does not bend: its minimum folds a tube's elbow flat, the sharper the finer the mesh.
//! Two terms bend, each with a length of its own that no refinement changes. `rotation_smoothing` adds
//! `a area sum_ij w_ij |R_i - R_j|^2` (Levi & Gotsman 2015, Smooth Rotation Enhanced As-Rigid-As-Possible Mesh
//! Animation): the Dirichlet energy of the rotations, which makes a surface bend like a solid of the thickness
//! `sqrt(a area)`. `smoothness` blends to `(1 - l) E + l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i` (Oehri, Herholz &
//! Sorkine-Hornung 2025, Higher Order Continuity for Smooth As-Rigid-As-Possible Shape Modeling), so that a single
//! moved vertex pulls without a spike. They leave the unit of length open; the factor `BENDING` times the region's
//! area makes `l` mean the same for every mesh.
//!
//! The metric of the descent is the rotations' own part of the second derivative. Without `rotation_smoothing` every
//! rotation is in it by itself, and the step to the one that fits best is known exactly: the local step as published.
//! With it the metric is that about the rest pose, the mean `2/3 tr S_i` of the eigenvalues of `tr(S_i) I - S_i` of each
//! cell's covariance `S_i`, and `4 a area L`; then the number of iterations does not grow with the mesh.

use std::f64::consts::PI;

use super::arap_descent::{Energy, Posing, Turned};
use super::field;
use super::flat::Turns;
use super::following::{Following, Reached};
use super::goal::Goal;
use super::lever::Lever;
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use super::rods::differences;
use super::smoothing::{LEAST_MASS, metric, smoothness};
use crate::geometry::rigid::centroid;
use crate::linear::ConstrainedSystem;
use crate::matrix::trace;
use crate::options::{choices, options};
use crate::stitch::{Descent, Differences, Owners, Reference, Stitcher, Stop, Weights, edge_weights, refine};
use crate::symmetry::Symmetry;
use crate::{Job, Mat3, Quat, Result, Vec3};

/// Extended rotations are a start where they bring the energy below this fraction of that without.
const CLEARLY: f64 = 0.8;

/// The turn, in radians, by which a handle's stiffness is told.
const LITTLE: f64 = 1e-4;

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
        /// How much neighbours must turn alike: more spreads a bend further along, 0 creases.
        pub rotation_smoothing: f64 = 0.001 => at_least(0.0),
        /// How much curvature counts against lengths: 0.1 takes the spike off a single moved vertex.
        pub smoothness: f64 = 0.0 => at_least(0.0) below(1.0),
        /// Closed parts keep their thickness when they bend and twist, as a body does and a hollow shell does not.
        pub solid: bool = false,
    }
}

/// Binds the method to a region.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Arap::new(region, options, job)?))
}

/// ARAP bound to a region.
#[derive(Debug)]
pub struct Arap {
    energy: Energy,
    /// The last pose: rotations, and the shape.
    previous: Option<(Vec<Quat>, Reached)>,
    /// That of a solve that has not been kept yet.
    found: (Vec<Quat>, Reached),
    following: Following,
    /// Of each handle that has turned by itself: how much vertices turn along, and its compliance.
    levers: Vec<Option<(Vec<f64>, Mat3)>>,
}

impl Arap {
    /// Factors the system of the positions, and that of the rotations where they are smoothed.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where a system cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let share = 1.0 - options.smoothness;
        let smooth = (options.smoothness > 0.0).then(|| smoothness(mesh, options.smoothness));
        let solid = (!region.rods().is_empty()).then(|| differences(region.rods(), mesh.rest(), share));
        let differences: Vec<Differences> = smooth.into_iter().chain(solid).collect();
        let more = differences.iter().map(Differences::matrix).collect::<Result<Vec<_>>>()?;
        let more = more.into_iter().reduce(|a, b| a.combine(1.0, &b, 1.0));
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
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, more.as_ref(), constraints, job)?;
        let mut rest = stitcher.covariances(Reference::Rest, mesh.rest());
        for (i, covariance) in rest.iter_mut().enumerate() {
            differences.iter().for_each(|differences| *covariance += differences.rest_covariance(i));
            // But for rounding they are symmetric; exactly so, the rest pose has no torques.
            *covariance = (*covariance + covariance.transpose()) * 0.5;
        }
        let area = mesh.area();
        let rotation_smoothing = options.rotation_smoothing * area / (share * owners.per_edge());
        let metric = (rotation_smoothing > 0.0)
            .then(|| metric(&stitcher, &rest, rotation_smoothing, job))
            .transpose()?;
        Ok(Self {
            energy: Energy { stitcher, rest, rotation_smoothing, differences, metric },
            previous: None,
            found: Default::default(),
            following: Following::default(),
            levers: Vec::new(),
        })
    }

    /// The better of two shapes to start from: stitched to the handles' rotations, extended as harmonic rotation
    /// vectors, which is exact where all given vertices move by one rigid motion; or to the rotations that
    /// fit where only the handles move, which bends nothing that may stay straight. Which of them leads to
    /// the lower minimum shows only at the end. Where both are about equal, rotations are not what the pose is
    /// about, and the second leads lower.
    fn start(&self, region: &Region, goal: &Goal) -> Turned {
        let posing = Posing::of(&self.energy, &self.levers, region, goal);
        let quaternions = |rotations: Vec<Mat3>| {
            rotations.iter().map(|r| Quat::from_mat3(r).normalize()).collect::<Vec<_>>()
        };
        let unturned = || vec![Quat::IDENTITY; goal.pivots.len()];
        let mut extended = quaternions(field::rotations(self.energy.stitcher.system(), region, goal));
        posing.turns.keep(&mut extended);
        let extended = posing.stitched(extended, unturned());
        // More than half a turn is in the extended rotations alone.
        if goal.handles.iter().any(|m| m.whole_turns != Vec3::ZERO || m.rotation.length() > PI) {
            return extended;
        }
        let x: Vec<Vec3> =
            region.mesh().rest().iter().zip(&goal.displacements).map(|(&v, &d)| v + d).collect();
        let covariances = self.energy.stitcher.covariances(Reference::Rest, &x);
        let rest = quaternions(covariances.into_iter().map(|m| posing.turns.nearest(m)).collect());
        let rest = posing.stitched(rest, unturned());
        let start = if extended.energy <= CLEARLY * rest.energy { extended } else { rest };
        // So long a step would teach the descent a wrong curvature.
        if self.energy.metric.is_none() { posing.moved(&start, &start.misfits, 1.0) } else { start }
    }

    /// The lever of a handle: from the rest pose, turned a little, its stiffness is what resists.
    fn add_lever(&mut self, region: &Region, handle: usize) {
        let axis = |h: usize| if h == handle { Vec3::X } else { Vec3::ZERO };
        let mut weights = [region.at_handles(axis)];
        self.energy.stitcher.system().extend(&mut weights);
        let weights: Vec<f64> = weights[0].iter().map(|w| w.x).collect();
        let rest = vec![Vec3::ZERO; weights.len()];
        let goal = Goal { displacements: rest, handles: Vec::new(), affine: true, pivots: Vec::new() };
        let n = weights.len();
        let members = (0..n).filter(|&v| region.handle_of(v) == Some(handle));
        let centre = centroid(members.map(|v| region.mesh().rest()[v]));
        let lever = Lever::of(region, &goal, (handle, centre), &weights, Mat3::IDENTITY);
        let symmetry = &Symmetry::default();
        let turns = Turns::free();
        let posing = Posing { energy: &self.energy, symmetry, goal: &goal, levers: vec![lever], turns };
        let still = posing.stitched(vec![Quat::IDENTITY; n], vec![Quat::IDENTITY]);
        let stiffness = Vec3::AXES.map(|axis| {
            let mut direction = vec![Vec3::ZERO; n + 1];
            direction[n] = axis * LITTLE;
            posing.moved(&still, &direction, 1.0).torques[n] / LITTLE
        });
        let stiffness = Mat3::from_cols(stiffness[0], stiffness[1], stiffness[2]);
        let size: f64 = self.energy.rest.iter().map(|s| trace(*s)).sum();
        let least = Mat3::IDENTITY * (LEAST_MASS * size).max(f64::MIN_POSITIVE);
        let compliance = ((stiffness + stiffness.transpose()) * 0.5 + least).inverse();
        self.levers.resize(self.levers.len().max(handle + 1), None);
        self.levers[handle] = Some((weights, compliance));
    }
}

impl Method for Arap {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        std::iter::once(self.energy.stitcher.system()).chain(&self.energy.metric).collect()
    }

    fn turns_handles(&self) -> bool {
        true
    }

    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        for &(handle, _) in &goal.pivots {
            if self.levers.get(handle).is_none_or(Option::is_none) {
                self.add_lever(region, handle);
            }
        }
        let followed = self.previous.as_ref().filter(|_| options.warm_start).and_then(|(_, reached)| {
            self.following.moved(self.energy.stitcher.system(), region, reached, goal)
        });
        let posing = Posing::of(&self.energy, &self.levers, region, goal);
        let start = match (&self.previous, followed) {
            (Some((rotations, _)), Some(shape)) if !posing.turns.are_flat() => {
                posing.at(rotations.clone(), Vec::new(), shape, &[])
            }
            (Some((rotations, _)), _) if options.warm_start => {
                let mut rotations = rotations.clone();
                posing.turns.keep(&mut rotations);
                posing.stitched(rotations, vec![Quat::IDENTITY; goal.pivots.len()])
            }
            _ => self.start(region, goal),
        };
        let stop = Stop { max_iterations: options.max_iterations, tolerance: options.tolerance };
        let refined = refine(&posing, start, stop, |iteration| {
            job.report(iteration as f64 / stop.max_iterations as f64, "posing");
            job.check()
        })?;
        let cells = self.energy.stitcher.owners().per_edge();
        let Turned { rotations, turns, displacements, energy, .. } = refined.point;
        self.found = (rotations, Reached { goal: Some(goal.clone()), displacements: displacements.clone() });
        Ok(Solution {
            displacements,
            iterations: refined.iterations,
            energy: Some((cells * energy).max(0.0)),
            converged: refined.converged,
            residual: refined.residual,
            turns,
        })
    }

    fn keep(&mut self) {
        self.previous = Some(std::mem::take(&mut self.found));
    }
}
