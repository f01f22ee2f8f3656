//! Linear methods: precomputed responses, so that a frame is a product and not a solve.
//!
//! A handle's motion is a 3 x 4 matrix `[A - I | b]`. Where displacements depend linearly on it,
//!
//! ```text
//!     d_v = sum over handles h, entries (a, k)   (A_h - I | b_h)_ak  B_hak(v)
//! ```
//!
//! the response `B` to each entry is solved for once, and moving handles as wholes costs one pass over the
//! responses. Where the axes do not couple, `B_hak(v) = b_hk(v) e_a`: 4 numbers a handle instead of 36.

use rayon::prelude::*;

use super::goal::{Goal, HandleMotion};
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use crate::linear::ConstrainedSystem;
use crate::matrix::outer;
use crate::{Job, Mat3, Result, Vec3, memory};

/// Most handles whose responses are kept; beyond, a solve is the lesser cost.
const MOST_HANDLES: usize = 16;

/// A method whose displacements are a linear function of the goal.
pub trait Response: Send + std::fmt::Debug {
    /// Displacements of every vertex of the region's mesh.
    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3>;

    /// The same for several goals, which may share passes over a factor.
    fn displacements_of(&self, region: &Region, goals: &[Goal]) -> Vec<Vec<Vec3>> {
        goals.iter().map(|goal| self.displacements(region, goal)).collect()
    }

    /// What it factored.
    fn systems(&self) -> Vec<&ConstrainedSystem>;

    /// Whether a motion along one axis moves anything along another.
    fn axes_couple(&self) -> bool {
        false
    }
}

/// Displacements of a method that is the minimum of one system. `product` multiplies a column by its matrix, see [`ConstrainedSystem::minimise`].
pub(super) fn minima(
    system: &ConstrainedSystem,
    goals: &[Goal],
    product: impl Fn(&[f64]) -> Vec<f64> + Sync,
) -> Vec<Vec<Vec3>> {
    let mut x: Vec<Vec<Vec3>> = goals.iter().map(|goal| goal.displacements.clone()).collect();
    system.minimise(&mut x, product);
    x
}

/// A linear method with its responses, which are made when handles first move as wholes.
#[derive(Debug)]
pub struct Linear<M> {
    method: M,
    responses: Option<Responses>,
}

/// Responses, vertex by vertex; within a vertex handle by handle, entry by entry, column first.
#[derive(Debug)]
enum Responses {
    Scalar(Vec<f64>),
    Vector(Vec<Vec3>),
}

impl<M: Response> Linear<M> {
    /// Wraps a bound method.
    pub fn new(method: M) -> Self {
        Self { method, responses: None }
    }

    fn respond(&self, region: &Region, handles: usize, job: &Job) -> Result<Responses> {
        let couple = self.method.axes_couple();
        let entries = handles * if couple { 12 } else { 4 };
        let vertices = region.mesh().vertices().len();
        let bytes = if couple { size_of::<Vec3>() } else { size_of::<f64>() };
        memory::check("the responses", vertices as u128 * entries as u128 * bytes as u128)?;
        let mut vector = vec![Vec3::ZERO; if couple { vertices * entries } else { 0 }];
        let mut scalar = vec![0.0; if couple { 0 } else { vertices * entries }];
        for handle in 0..handles {
            job.report(handle as f64 / handles as f64, "responses");
            job.check()?;
            let units: Vec<(Mat3, Vec3)> = if couple {
                let axes = [Vec3::X, Vec3::Y, Vec3::Z];
                let linear = axes.iter().flat_map(|&k| axes.map(|a| (outer(a, k), Vec3::ZERO)));
                linear.chain(axes.map(|a| (Mat3::ZERO, a))).collect()
            } else {
                // Each axis of the displacements answers to its own row alone: three entries at once.
                vec![(Mat3::IDENTITY, Vec3::ZERO), (Mat3::ZERO, Vec3::X)]
            };
            let goals: Vec<Goal> =
                units.into_iter().map(|(change, offset)| unit_goal(region, handle, change, offset)).collect();
            let first = handle * entries / handles;
            for (unit, moved) in self.method.displacements_of(region, &goals).into_iter().enumerate() {
                for (v, d) in moved.into_iter().enumerate() {
                    let at = v * entries + first + if couple { unit } else { 3 * unit };
                    match (couple, unit) {
                        (true, _) => vector[at] = d,
                        (false, 0) => scalar[at..at + 3].copy_from_slice(&d.to_array()),
                        (false, _) => scalar[at] = d.x,
                    }
                }
            }
        }
        Ok(if couple { Responses::Vector(vector) } else { Responses::Scalar(scalar) })
    }
}

/// One handle's `[A - I | b]` is `[change | offset]`, all others stay.
fn unit_goal(region: &Region, handle: usize, change: Mat3, offset: Vec3) -> Goal {
    let zero = Vec3::ZERO;
    let still = HandleMotion { rotation: zero, whole_turns: zero, linear: Mat3::IDENTITY, offset: zero };
    let mut motions = vec![still; region.handles().len()];
    motions[handle] = HandleMotion { linear: Mat3::IDENTITY + change, offset, ..still };
    let rest = region.mesh().rest();
    let moved = (0..rest.len()).map(|v| match region.handle_of(v) {
        Some(h) if h == handle => change * rest[v] + offset,
        _ => Vec3::ZERO,
    });
    Goal { displacements: moved.collect(), handles: motions, affine: true, pivots: Vec::new() }
}

impl Responses {
    fn displacements(&self, motions: &[HandleMotion], vertices: usize) -> Vec<Vec3> {
        let columns: Vec<Vec3> = motions
            .iter()
            .flat_map(|m| {
                let change = m.linear - Mat3::IDENTITY;
                [change.x_axis, change.y_axis, change.z_axis, m.offset]
            })
            .collect();
        // Reading the responses is what a frame costs, so those to entries of 0 are not.
        match self {
            Self::Scalar(responses) => {
                let moving: Vec<(usize, Vec3)> =
                    columns.iter().copied().enumerate().filter(|(_, column)| *column != Vec3::ZERO).collect();
                (responses.par_chunks(columns.len()))
                    .with_min_len(1024)
                    .map(|row| moving.iter().fold(Vec3::ZERO, |sum, &(k, column)| sum + column * row[k]))
                    .collect()
            }
            Self::Vector(responses) => {
                let entries = columns.iter().flat_map(Vec3::to_array).enumerate();
                let moving: Vec<(usize, f64)> = entries.filter(|(_, m)| *m != 0.0).collect();
                (responses.par_chunks(responses.len() / vertices))
                    .with_min_len(1024)
                    .map(|row| moving.iter().fold(Vec3::ZERO, |sum, &(k, m)| sum + row[k] * m))
                    .collect()
            }
        }
    }
}

impl<M: Response> Method for Linear<M> {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        self.method.systems()
    }

    fn solve(&mut self, region: &Region, goal: &Goal, _: &SolveOptions, job: &Job) -> Result<Solution> {
        job.check()?;
        let displacements = if goal.affine && goal.handles.len() <= MOST_HANDLES {
            let responses = match self.responses.take() {
                Some(responses) => responses,
                None => self.respond(region, goal.handles.len(), job)?,
            };
            self.responses.insert(responses).displacements(&goal.handles, goal.displacements.len())
        } else {
            self.method.displacements(region, goal)
        };
        Ok(Solution::direct(displacements))
    }
}
