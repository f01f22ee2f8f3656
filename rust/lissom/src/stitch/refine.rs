//! Descent to the minimum of an energy: [`Lbfgs`] in the metric of a matrix that is factored once.
//!
//! A global step after a local one is descent along `-K^-1` times the gradient, `K` being the matrix of the global
//! step, and converges slowly. The last steps tell more of the curvature. A step that does not lower the energy well
//! enough is shortened, and where that does not help the last steps are forgotten.

use super::lbfgs::{Heading, Lbfgs};
use super::vectors::dot;
use crate::{Result, Vec3};

/// An energy below this fraction of that of the edges themselves is zero but for rounding.
const NOTHING: f64 = 1e-14;

/// Lengths tried along a direction before the last steps are forgotten.
const TRIALS: usize = 4;

/// The part of the decrease that the slope promises which a step must bring (Armijo 1966).
const ENOUGH: f64 = 1e-4;

/// An energy of points on which one may move along directions of a vector per vertex.
pub trait Descent {
    /// A point, with what its energy and gradient need.
    type Point;

    /// The energy at a point, and the size of what it was summed from, which its rounding is relative to.
    fn energy(&self, at: &Self::Point) -> (f64, f64);

    /// Half the gradient, and that multiplied by the inverse of the metric.
    fn gradient(&self, at: &Self::Point) -> [Vec<Vec3>; 2];

    /// The point so far along a direction.
    fn moved(&self, from: &Self::Point, direction: &[Vec3], length: f64) -> Self::Point;
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Stop {
    /// Most iterations.
    pub max_iterations: usize,
    /// Two iterations that lower the energy by less than this fraction of it are the last.
    pub tolerance: f64,
}

/// Where it has stopped.
#[derive(Debug)]
pub struct Refined<P> {
    /// The point.
    pub point: P,
    /// Iterations done.
    pub iterations: usize,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// The fraction of the energy by which the last iteration lowered it.
    pub residual: f64,
}

/// Lowers the energy from a point on. `watch` is told the number of each iteration.
///
/// # Errors
///
/// Those of `watch`.
pub fn refine<D: Descent>(
    problem: &D,
    mut point: D::Point,
    stop: Stop,
    mut watch: impl FnMut(usize) -> Result<()>,
) -> Result<Refined<D::Point>> {
    let mut memory = Lbfgs::default();
    let (mut iterations, mut quiet, mut residual, mut length) = (0, 0, f64::INFINITY, 1.0);
    // What is out of range is told by whoever sees the result.
    while iterations < stop.max_iterations && quiet < 2 && problem.energy(&point).0.is_finite() {
        watch(iterations)?;
        let mut found = search(problem, &point, memory.direction(problem.gradient(&point), length));
        if found.is_none() {
            found = memory.steepest().and_then(|heading| search(problem, &point, heading));
        }
        iterations += 1;
        let before = problem.energy(&point).0;
        // Where the steepest way down leads nowhere, rounding is all that is left.
        let Some((next, taken)) = found else {
            (quiet, residual) = (2, 0.0);
            break;
        };
        (point, length) = (next, taken);
        let (energy, size) = problem.energy(&point);
        let gain = before - energy;
        // One small step may be an accident of the model, two are not.
        quiet = if gain <= stop.tolerance * energy + NOTHING * size { quiet + 1 } else { 0 };
        residual = gain / energy;
    }
    Ok(Refined { point, iterations, converged: quiet == 2, residual })
}

/// The first of some lengths of a step along `direction` that lowers the energy well enough; each is where
/// the parabola through what is known has its minimum.
fn search<D: Descent>(
    problem: &D,
    from: &D::Point,
    Heading { gradient, direction, .. }: &Heading,
) -> Option<(D::Point, f64)> {
    let slope = 2.0 * dot(gradient, direction);
    let start = problem.energy(from).0;
    let mut length = 1.0;
    for _ in 0..TRIALS {
        let next = problem.moved(from, direction, length);
        let (energy, size) = problem.energy(&next);
        let change = energy - start;
        if change <= ENOUGH * length * slope.min(0.0) + NOTHING * size {
            return Some((next, length));
        }
        if !change.is_finite() {
            return None;
        }
        let lowest = -slope * length * length / (2.0 * (change - slope * length));
        length = lowest.clamp(0.1 * length, 0.5 * length);
    }
    None
}
