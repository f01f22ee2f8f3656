//! Descent: conjugate gradients in the metric of a factor that the three axes share.
//!
//! Planes couple the axes: the system with them is three times as large, and its factor ten times as costly. The
//! uncoupled one with the mean of each plane's weights is near enough to it for a few steps a look-up, and the direction
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
    /// Half the gradient of `E` where the last step ended: it is linear, and pulls are what changes.
    slope: Option<Vec<Vec3>>,
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
        Self { energy, factor, slope: None, last: None }
    }

    /// So many steps towards the least of the energy with these pulls, from where the last ones ended.
    pub fn go(&mut self, pulls: &[Pull], u: &mut [Vec3], steps: usize) {
        let mut slope = self.slope.take().unwrap_or_else(|| self.energy.gradient(u));
        let mut residual = slope.clone();
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
            let of_energy = self.energy.curvature(&direction);
            let mut image = of_energy.clone();
            pulls::add_curvature(pulls, &direction, &mut image);
            let step = dot(&residual, &direction) / dot(&direction, &image);
            // Already there, to rounding.
            if !(step.is_finite() && square > 0.0) {
                break;
            }
            slope.iter_mut().zip(&of_energy).for_each(|(s, &q)| *s += q * step);
            u.iter_mut().zip(&direction).for_each(|(u, &d)| *u += d * step);
            let before = residual.clone();
            residual.iter_mut().zip(&image).for_each(|(r, &q)| *r -= q * step);
            self.last = Some(Step { direction, residual: before, square });
        }
        self.slope = Some(slope);
    }
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::fit::energy::TermWeights;
    use crate::transfer::testing::bumpy_grid;

    #[test]
    fn the_energy_falls_with_every_step_and_with_every_look_up() {
        let mesh = bumpy_grid(9);
        let n = mesh.vertices().len();
        let weights = TermWeights { smoothness: 1.0, identity: 0.1 };
        let energy = Energy::new(&mesh, 1.0, weights, |_| false).unwrap();
        // Planes that no uncoupled metric is exact for, and that lie elsewhere at each look-up.
        let plane = |v: usize, turn: f64| Pull {
            corners: [v as u32; 3],
            weights: Vec3::X,
            goal: mesh.rest()[v] * 1.3 + Vec3::new(0.05, turn, (v as f64).sin() * 0.02),
            normal: Vec3::new((v as f64 + turn).cos(), (v as f64 + turn).sin(), 0.7).normalize(),
            along: 100.0,
            across: 2.0,
        };
        let looked_up = |turn: f64| -> Vec<Pull> { (0..n).map(|v| plane(v, turn)).collect() };
        let gradient = |pulls: &[Pull], u: &[Vec3]| {
            let mut gradient = energy.gradient(u);
            pulls::add_gradient(pulls, u, &mut gradient);
            gradient
        };
        let metric = pulls::uncoupled(&looked_up(0.0), n);
        let mut descent = Descent::new(&energy, energy.factor(&metric).unwrap());
        let mut u = energy.rest();
        for turn in [0.0, 0.0, 0.0, 0.01, 0.02, 0.02, 0.03] {
            let (pulls, before) = (looked_up(turn), u.clone());
            descent.go(&pulls, &mut u, 1);
            // Of a quadratic energy the difference is the mean of the gradients along the way, exactly.
            let moved: Vec<Vec3> = u.iter().zip(&before).map(|(u, b)| *u - *b).collect();
            let fallen = -dot(&gradient(&pulls, &u), &moved) - dot(&gradient(&pulls, &before), &moved);
            assert!(fallen > 0.0, "it rose by {}", -fallen);
        }
    }
}
