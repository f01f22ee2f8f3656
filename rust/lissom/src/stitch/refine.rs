//! Local and global steps in turn, until the energy falls no more.
//!
//! By themselves they are descent along `-K^-1` times the gradient, `K` being the matrix of the global step, and
//! converge slowly. The last steps tell more of the curvature: [`Lbfgs`] in that metric (Liu, Bouaziz & Kavan 2017,
//! Quasi-Newton Methods for Real-Time Simulation of Hyperelastic Materials). A step that does not lower the energy
//! well enough is shortened, and where that does not help the plain global step is taken, which always does.

use super::lbfgs::Lbfgs;
use super::stitcher::Stitcher;
use super::vectors::{dot, moved};
use crate::{Mat3, Result, Vec3};

/// An energy below this fraction of that of the edges themselves is zero but for rounding.
const NOTHING: f64 = 1e-14;

/// Lengths tried along a direction before the plain step is taken instead.
const TRIALS: usize = 4;

/// The part of the decrease that the slope promises which a step must bring (Armijo 1966).
const ENOUGH: f64 = 1e-4;

/// A shape and the outcome of its local step.
#[derive(Debug)]
pub struct Iterate {
    /// Displacement of every vertex, in unit coordinates.
    pub displacements: Vec<Vec3>,
    /// `C - I` of every owner.
    pub changes: Vec<Mat3>,
    /// The energy.
    pub energy: f64,
    /// The weighted size of all edges, which rounding of the energy is relative to.
    pub size: f64,
}

/// Chooses targets again for every shape.
pub trait Chooser {
    /// The local step; `last` are the targets of the shape before.
    fn fit(&self, displacements: Vec<Vec3>, last: &[Mat3]) -> Iterate;

    /// Half the gradient of the energy by the displacements, for fixed targets; zero at fixed vertices.
    fn gradient(&self, fit: &Iterate) -> Vec<Vec3>;
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
pub struct Refined {
    /// The shape.
    pub fit: Iterate,
    /// Iterations done.
    pub iterations: usize,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// The fraction of the energy by which the last iteration lowered it.
    pub residual: f64,
}

impl Stitcher {
    /// The global step: the shape of least energy for fixed targets.
    pub fn global_step(&self, chooser: &impl Chooser, fit: &Iterate) -> Vec<Vec3> {
        moved(&fit.displacements, &self.precondition(&chooser.gradient(fit)), -1.0)
    }

    /// Lowers the energy of `chooser` from a shape on. `watch` is told the number of each iteration.
    ///
    /// # Errors
    ///
    /// Those of `watch`.
    pub fn refine(
        &self,
        chooser: &impl Chooser,
        mut fit: Iterate,
        stop: Stop,
        mut watch: impl FnMut(usize) -> Result<()>,
    ) -> Result<Refined> {
        let mut memory = Lbfgs::default();
        let (mut iterations, mut quiet, mut residual, mut length) = (0, 0, f64::INFINITY, 1.0);
        // Targets out of range are told by whoever sees the result.
        while iterations < stop.max_iterations && quiet < 2 && fit.energy.is_finite() {
            watch(iterations)?;
            let gradient = chooser.gradient(&fit);
            let preconditioned = self.precondition(&gradient);
            let direction = memory.direction(&gradient, &preconditioned, length);
            let slope = 2.0 * dot(&gradient, &direction);
            let next = match search(chooser, &fit, &direction, slope) {
                Some((next, found)) => {
                    length = found;
                    next
                }
                None => {
                    memory = Lbfgs::default();
                    chooser.fit(moved(&fit.displacements, &preconditioned, -1.0), &fit.changes)
                }
            };
            iterations += 1;
            // One small step may be an accident of the model, two are not.
            let gain = fit.energy - next.energy;
            let small = gain <= stop.tolerance * next.energy + NOTHING * next.size;
            quiet = if small { quiet + 1 } else { 0 };
            residual = gain / next.energy;
            fit = next;
        }
        Ok(Refined { fit, iterations, converged: quiet == 2, residual })
    }
}

/// The first of some lengths of a step along `direction` that lowers the energy well enough; each is where
/// the parabola through what is known has its minimum.
fn search(chooser: &impl Chooser, from: &Iterate, direction: &[Vec3], slope: f64) -> Option<(Iterate, f64)> {
    let mut length = 1.0;
    for _ in 0..TRIALS {
        let next = chooser.fit(moved(&from.displacements, direction, length), &from.changes);
        let change = next.energy - from.energy;
        if change <= ENOUGH * length * slope.min(0.0) + NOTHING * next.size {
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
