//! Limited-memory BFGS in the metric of a matrix `K` that is factored once.
//!
//! ```text
//!     d = -H g,    H from the last steps s and changes of gradient y, and H_0 = (s.y / y.K^-1 y) K^-1
//! ```
//!
//! Nocedal 1980, Updating Quasi-Newton Matrices with Limited Storage, with the metric of Liu, Bouaziz & Kavan
//! 2017, Quasi-Newton Methods for Real-Time Simulation of Hyperelastic Materials. Because `K^-1 y` is kept
//! with `y`, the two loops need no solve of their own.

use rayon::prelude::*;

use super::vectors::{BLOCK, add, dot};
use crate::Vec3;

/// How many earlier steps are kept. In this metric more of them gain nothing.
const WINDOW: usize = 2;

/// A step whose curvature `s.y` is below this fraction of `y.K^-1 y` teaches nothing but rounding.
const LEAST_CURVATURE: f64 = 1e-10;

/// The last steps of a descent.
#[derive(Debug, Default)]
pub(super) struct Lbfgs {
    /// Oldest first.
    steps: Vec<CurvaturePair>,
    last: Option<Last>,
}

#[derive(Debug)]
struct CurvaturePair {
    s: Vec<Vec3>,
    y: Vec<Vec3>,
    /// `K^-1 y`.
    z: Vec<Vec3>,
    /// `s.y`.
    curvature: f64,
}

/// Where the last direction began, and the direction.
#[derive(Debug)]
struct Last {
    gradient: Vec<Vec3>,
    preconditioned: Vec<Vec3>,
    direction: Vec<Vec3>,
}

impl Lbfgs {
    /// The direction of descent at a point of the given gradient, where `preconditioned` is `K^-1` of it. Learns
    /// from the step that led there: `length` times the last direction.
    pub fn direction(&mut self, gradient: &[Vec3], preconditioned: &[Vec3], length: f64) -> Vec<Vec3> {
        if let Some(last) = self.last.take() {
            self.learn(last, gradient, preconditioned, length);
        }
        let (mut q, mut d) = (gradient.to_vec(), preconditioned.to_vec());
        let mut alphas = Vec::with_capacity(self.steps.len());
        for step in self.steps.iter().rev() {
            let alpha = dot(&step.s, &q) / step.curvature;
            add(&mut q, -alpha, &step.y);
            add(&mut d, -alpha, &step.z);
            alphas.push(alpha);
        }
        if let Some(newest) = self.steps.last() {
            let scale = newest.curvature / dot(&newest.y, &newest.z);
            d.par_iter_mut().with_min_len(BLOCK).for_each(|d| *d *= scale);
        }
        for (step, alpha) in self.steps.iter().zip(alphas.iter().rev()) {
            let beta = dot(&step.y, &d) / step.curvature;
            add(&mut d, alpha - beta, &step.s);
        }
        d.par_iter_mut().with_min_len(BLOCK).for_each(|d| *d = -*d);
        let (gradient, preconditioned) = (gradient.to_vec(), preconditioned.to_vec());
        self.last = Some(Last { gradient, preconditioned, direction: d.clone() });
        d
    }

    fn learn(&mut self, last: Last, gradient: &[Vec3], preconditioned: &[Vec3], length: f64) {
        let mut s = last.direction;
        s.par_iter_mut().with_min_len(BLOCK).for_each(|s| *s *= length);
        let (mut y, mut z) = (gradient.to_vec(), preconditioned.to_vec());
        add(&mut y, -1.0, &last.gradient);
        add(&mut z, -1.0, &last.preconditioned);
        let curvature = dot(&s, &y);
        // Without positive curvature the model would lead uphill.
        if curvature <= LEAST_CURVATURE * dot(&y, &z) {
            return self.steps.clear();
        }
        if self.steps.len() == WINDOW {
            self.steps.remove(0);
        }
        self.steps.push(CurvaturePair { s, y, z, curvature });
    }
}
