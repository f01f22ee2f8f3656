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
    last: Option<Heading>,
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

/// Where a direction begins, and the direction.
#[derive(Debug)]
pub(super) struct Heading {
    pub gradient: Vec<Vec3>,
    preconditioned: Vec<Vec3>,
    pub direction: Vec<Vec3>,
}

impl Lbfgs {
    /// The direction of descent at a point of the given gradient and `K^-1` of it. Learns from the step that led there:
    /// `length` times the last direction.
    pub fn direction(&mut self, [gradient, preconditioned]: [Vec<Vec3>; 2], length: f64) -> &Heading {
        if let Some(last) = self.last.take() {
            self.learn(last, &gradient, &preconditioned, length);
        }
        let mut direction = preconditioned.clone();
        if !self.steps.is_empty() {
            self.bend(gradient.clone(), &mut direction);
        }
        direction.par_iter_mut().with_min_len(BLOCK).for_each(|d| *d = -*d);
        self.last.insert(Heading { gradient, preconditioned, direction })
    }

    /// The last direction without what earlier steps tell, and without these; `None` where it was that.
    pub fn steepest(&mut self) -> Option<&Heading> {
        if self.steps.is_empty() {
            return None;
        }
        self.steps.clear();
        let last = self.last.take()?;
        Some(self.direction([last.gradient, last.preconditioned], 0.0))
    }

    /// The two loops, from a gradient `q` and `d = K^-1 q`.
    fn bend(&self, mut q: Vec<Vec3>, d: &mut [Vec3]) {
        let mut alphas = Vec::with_capacity(self.steps.len());
        for step in self.steps.iter().rev() {
            let alpha = dot(&step.s, &q) / step.curvature;
            add(&mut q, -alpha, &step.y);
            add(d, -alpha, &step.z);
            alphas.push(alpha);
        }
        if let Some(newest) = self.steps.last() {
            let scale = newest.curvature / dot(&newest.y, &newest.z);
            d.par_iter_mut().with_min_len(BLOCK).for_each(|d| *d *= scale);
        }
        for (step, alpha) in self.steps.iter().zip(alphas.iter().rev()) {
            let beta = dot(&step.y, d) / step.curvature;
            add(d, alpha - beta, &step.s);
        }
    }

    fn learn(&mut self, last: Heading, gradient: &[Vec3], preconditioned: &[Vec3], length: f64) {
        let change = |mut before: Vec<Vec3>, now: &[Vec3]| {
            before.par_iter_mut().zip(now).with_min_len(BLOCK).for_each(|(b, n)| *b = *n - *b);
            before
        };
        let mut s = last.direction;
        s.par_iter_mut().with_min_len(BLOCK).for_each(|s| *s *= length);
        let (y, z) = (change(last.gradient, gradient), change(last.preconditioned, preconditioned));
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
