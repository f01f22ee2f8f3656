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

use super::{Goal, Method, Motion, Region, Solution, SolveOptions};
use crate::{Job, Mat3, Result, Vec3};

/// Most handles whose responses are kept; beyond, a solve is the lesser cost.
const MOST_HANDLES: usize = 16;

/// A method whose displacements are a linear function of the goal.
pub trait Response: Send + std::fmt::Debug {
    /// Displacements of every vertex of the region's mesh.
    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3>;

    /// Whether a motion along one axis moves anything along another.
    fn axes_couple(&self) -> bool {
        false
    }
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
        let axes = if self.method.axes_couple() { 3 } else { 1 };
        let entries = handles * 4 * axes;
        let vertices = region.mesh().vertices().len();
        let mut responses = vec![Vec3::ZERO; vertices * entries];
        for entry in 0..entries {
            job.report(entry as f64 / entries as f64, "responses");
            job.check()?;
            let (handle, column, axis) = (entry / (4 * axes), entry / axes % 4, entry % axes);
            let goal = unit_goal(region, handles, handle, column, axis);
            for (v, d) in self.method.displacements(region, &goal).into_iter().enumerate() {
                responses[v * entries + entry] = d;
            }
        }
        Ok(if axes == 3 {
            Responses::Vector(responses)
        } else {
            Responses::Scalar(responses.into_iter().map(|d| d.x).collect())
        })
    }
}

/// One entry of one handle's `[A - I | b]` is 1, all others 0.
fn unit_goal(region: &Region, handles: usize, handle: usize, column: usize, axis: usize) -> Goal {
    let (zero, linear) = (Vec3::ZERO, Mat3::IDENTITY);
    let still = Motion { rotation: zero, whole_turns: zero, linear, offset: zero };
    let mut motions = vec![still; handles];
    let mut change = Mat3::ZERO;
    if column < 3 {
        change.col_mut(column)[axis] = 1.0;
    } else {
        motions[handle].offset[axis] = 1.0;
    }
    motions[handle].linear += change;
    let (rest, offset) = (region.mesh().rest(), motions[handle].offset);
    let moved = (0..rest.len()).map(|v| match region.handle_of(v) {
        Some(h) if h == handle => change * rest[v] + offset,
        _ => Vec3::ZERO,
    });
    Goal { displacements: moved.collect(), handles: motions, affine: true }
}

impl Responses {
    fn displacements(&self, motions: &[Motion], vertices: usize) -> Vec<Vec3> {
        let columns: Vec<Vec3> = motions
            .iter()
            .flat_map(|m| {
                let change = m.linear - Mat3::IDENTITY;
                [change.x_axis, change.y_axis, change.z_axis, m.offset]
            })
            .collect();
        match self {
            Self::Scalar(responses) => (responses.par_chunks(columns.len()))
                .with_min_len(1024)
                .map(|row| row.iter().zip(&columns).fold(Vec3::ZERO, |sum, (&b, &column)| sum + column * b))
                .collect(),
            Self::Vector(responses) => {
                let entries: Vec<f64> = columns.iter().flat_map(Vec3::to_array).collect();
                (responses.par_chunks(responses.len() / vertices))
                    .with_min_len(1024)
                    .map(|row| row.iter().zip(&entries).fold(Vec3::ZERO, |sum, (&b, &m)| sum + b * m))
                    .collect()
            }
        }
    }
}

impl<M: Response> Method for Linear<M> {
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
