//! What a pose method is.

use super::goal::Goal;
use super::region::Region;
use crate::linear::ConstrainedSystem;
use crate::{Job, Result, Vec3};

/// How long an iterative method goes on, and from where.
#[derive(Debug, Clone, Copy)]
pub struct SolveOptions {
    /// Most iterations.
    pub max_iterations: usize,
    /// Stop when an iteration lowers the energy by less than this fraction of it.
    pub tolerance: f64,
    /// Start from the previous pose, where there is one, instead of the linear guess.
    pub warm_start: bool,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { max_iterations: 200, tolerance: 1e-6, warm_start: true }
    }
}

/// What a method makes of a goal.
#[derive(Debug)]
pub struct Solution {
    /// Displacement of every vertex of the region's mesh, in unit coordinates.
    pub displacements: Vec<Vec3>,
    /// Iterations done.
    pub iterations: usize,
    /// Energy at the end, of iterative methods.
    pub energy: Option<f64>,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// The fraction of the energy by which the last iteration lowered it.
    pub residual: f64,
}

impl Solution {
    /// What a method that does not iterate found.
    pub(crate) fn direct(displacements: Vec<Vec3>) -> Self {
        Self { displacements, iterations: 1, energy: None, converged: true, residual: 0.0 }
    }
}

/// A way to pose a region. An instance is bound to one region, and keeps what it factored.
pub trait Method: Send + std::fmt::Debug {
    /// Moves the free vertices of `region` so that they follow `goal`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], and [`Error::SolveFailed`] where the linear algebra gives up.
    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution>;

    /// What it factored, to solve by.
    fn systems(&self) -> Vec<&ConstrainedSystem>;
}
