//! Anderson acceleration of a fixed-point iteration `x <- G(x)`.
//!
//! The next iterate is the combination of the last few `G(x)` whose residuals `F = G(x) - x` cancel
//! best (Anderson 1965; Walker & Ni 2011). The caller checks that it helps.

use std::collections::VecDeque;

use rayon::prelude::*;

use crate::Vec3;

/// How many earlier steps are combined. Peng et al. (2018) use 5; more gain little.
const WINDOW: usize = 5;

/// Added to the diagonal of the small system, relative to its trace, against parallel residuals.
const REGULARIZATION: f64 = 1e-12;

/// The last steps of an iteration.
#[derive(Debug, Default)]
pub(super) struct Anderson {
    /// The last residual `F` and image `G`.
    last: Option<(Vec<Vec3>, Vec<Vec3>)>,
    /// Differences of successive residuals and images, newest first.
    steps: VecDeque<(Vec<Vec3>, Vec<Vec3>)>,
}

impl Anderson {
    /// The accelerated successor of `x`, of which `image` is the plain one.
    pub fn combine(&mut self, x: &[Vec3], image: &[Vec3]) -> Vec<Vec3> {
        let residual = difference(image, x);
        if let Some((residual_before, image_before)) = self.last.take() {
            self.steps.truncate(WINDOW - 1);
            self.steps
                .push_front((difference(&residual, &residual_before), difference(image, &image_before)));
        }
        let combined = match self.weights(&residual) {
            Some(weights) => (0..x.len())
                .into_par_iter()
                .with_min_len(4096)
                .map(|i| {
                    weights.iter().zip(&self.steps).fold(image[i], |sum, (&w, step)| sum - step.1[i] * w)
                })
                .collect(),
            None => image.to_vec(),
        };
        self.last = Some((residual, image.to_vec()));
        combined
    }

    /// `min_w | F - sum_k w_k dF_k |^2` by its normal equations.
    fn weights(&self, residual: &[Vec3]) -> Option<Vec<f64>> {
        let m = self.steps.len();
        if m == 0 {
            return None;
        }
        let gram = faer::Mat::from_fn(m, m, |i, j| dot(&self.steps[i].0, &self.steps[j].0));
        let lift = REGULARIZATION * (0..m).map(|i| gram[(i, i)]).sum::<f64>();
        let a = faer::Mat::from_fn(m, m, |i, j| gram[(i, j)] + if i == j { lift } else { 0.0 });
        let b = faer::Mat::from_fn(m, 1, |i, _| dot(&self.steps[i].0, residual));
        let llt = a.llt(faer::Side::Lower).ok()?;
        let w = faer::linalg::solvers::Solve::solve(&llt, &b);
        let w: Vec<f64> = (0..m).map(|i| w[(i, 0)]).collect();
        w.iter().all(|w| w.is_finite()).then_some(w)
    }
}

fn difference(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.par_iter().zip(b).with_min_len(4096).map(|(a, b)| *a - *b).collect()
}

/// Summed in blocks of fixed size, so that the result does not depend on the threads.
fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let blocks: Vec<f64> = (a.par_chunks(4096).zip(b.par_chunks(4096)))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum())
        .collect();
    blocks.iter().sum()
}
