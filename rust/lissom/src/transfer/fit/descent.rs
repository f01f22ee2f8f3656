//! Descent: conjugate gradients in the metric of a factor that the three axes share.
//!
//! Planes couple the axes: the system with them is three times as large, and its factor ten times as costly. The
//! uncoupled one with the mean of each plane's weights is near enough to it for one step a look-up, and the direction
//! carries over from one to the next (Polak & Ribière 1969, with the restart of Powell 1977): the pulls change less
//! than they would be met.

use super::energy::Energy;
use super::pulls::{self, Pull};
use crate::Vec3;
use crate::linear::Factor;

/// The way down so far.
pub struct Descent<'a> {
    energy: &'a Energy<'a>,
    factor: Factor,
    last: Option<Step>,
}

struct Step {
    direction: Vec<Vec3>,
    residual: Vec<Vec3>,
    /// Of the residual, in the metric.
    square: f64,
}

impl<'a> Descent<'a> {
    /// From anywhere, in the metric of `factor`.
    pub fn new(energy: &'a Energy, factor: Factor) -> Self {
        Self { energy, factor, last: None }
    }

    /// So many steps towards the least of the energy with these pulls.
    pub fn go(&mut self, pulls: &[Pull], u: &mut [Vec3], steps: usize) {
        let mut residual = self.energy.gradient(u);
        pulls::add_gradient(pulls, u, &mut residual);
        residual.iter_mut().for_each(|r| *r = -*r);
        for _ in 0..steps {
            let preconditioned = self.energy.solve(&self.factor, &residual);
            let square = dot(&residual, &preconditioned);
            let direction = match self.last.take() {
                Some(Step { mut direction, residual: before, square: last }) => {
                    let share = ((square - dot(&before, &preconditioned)) / last).max(0.0);
                    direction.iter_mut().zip(&preconditioned).for_each(|(d, &z)| *d = z + *d * share);
                    direction
                }
                None => preconditioned,
            };
            let mut image = self.energy.curvature(&direction);
            pulls::add_curvature(pulls, &direction, &mut image);
            let step = dot(&residual, &direction) / dot(&direction, &image);
            // Already there, to rounding.
            if !(step.is_finite() && square > 0.0) {
                return;
            }
            u.iter_mut().zip(&direction).for_each(|(u, &d)| *u += d * step);
            let before = residual.clone();
            residual.iter_mut().zip(&image).for_each(|(r, &q)| *r -= q * step);
            self.last = Some(Step { direction, residual: before, square });
        }
    }
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
