//! A path at equal steps, to look for keys of it.

use rayon::prelude::*;

use super::path::Inbetween;
use crate::{Job, Result, Vec3, memory};

/// The path is solved at this many steps at least and at most, and interpolated between them.
const STEPS: (usize, usize) = (16, 256);

/// Steps are halved until cubic interpolation from every other one is off by at most this fraction of
/// the tolerance. From all of them it is then off by a sixteenth of that.
const INTERPOLATION: f64 = 1.0 / 32.0;

/// The arc `y` of one vertex at equal steps from 0 to 1.
pub(super) type Track = Vec<Vec3>;

/// A path at equal steps, to look for keys of it.
pub(super) struct Sampled {
    /// The arcs of all vertices that leave the straight line, in the mesh's own units.
    pub tracks: Vec<Track>,
    /// What they are off between the steps, where no number of steps was enough.
    pub unseen: f64,
}

impl Inbetween {
    /// Fine enough for so many keys.
    pub(super) fn sampled_for(&self, count: usize, job: &Job) -> Result<Sampled> {
        // A chord over a fraction of an arc is off by about the square of that fraction.
        let segments = count.saturating_sub(1).max(1) as f64;
        let straight = self.shapes.rounding;
        self.sampled(|farthest| (farthest > straight).then_some(0.5 * farthest / (segments * segments)), job)
    }

    /// Sampled to within a `tolerance` of the largest arc; as a straight path where that says `None`.
    pub(super) fn sampled(&self, tolerance: impl Fn(f64) -> Option<f64>, job: &Job) -> Result<Sampled> {
        let n = self.shapes.stationary.len();
        let mut steps = 1;
        let mut arcs = vec![vec![Vec3::ZERO; n]; 2];
        let mut last = f64::INFINITY;
        let unseen = loop {
            // The new steps, and in the end all of them once more, vertex by vertex.
            memory::check(
                "the sampled path",
                size_of::<Vec3>() as u128 * (3 * steps + 1) as u128 * n as u128,
            )?;
            let between: Vec<f64> = (0..steps).map(|k| (k as f64 + 0.5) / steps as f64).collect();
            let mut new = Vec::with_capacity(steps);
            for chunk in between.chunks(8) {
                job.report(new.len() as f64 / steps as f64, "sampling the path");
                new.extend(self.arcs(chunk, job)?);
            }
            let off = (0..steps).into_par_iter().map(|k| {
                (0..n).map(|v| midpoint(steps, k, |i| arcs[i][v]).distance(new[k][v])).fold(0.0, f64::max)
            });
            let off = off.reduce(|| 0.0, f64::max) * self.shapes.scale;
            let mut merged = Vec::with_capacity(2 * steps + 1);
            let mut old = arcs.into_iter();
            for (a, b) in old.by_ref().zip(new) {
                merged.extend([a, b]);
            }
            merged.push(vec![Vec3::ZERO; n]);
            arcs = merged;
            steps *= 2;
            let largest = arcs.par_iter().map(|y| y.iter().map(|y| y.length_squared()).fold(0.0, f64::max));
            let largest = largest.reduce(|| 0.0, f64::max).sqrt() * self.shapes.scale;
            if steps >= STEPS.0 {
                match tolerance(largest) {
                    None => return Ok(Sampled { tracks: Vec::new(), unseen: largest }),
                    Some(tolerance) if off <= INTERPOLATION * tolerance => break 0.0,
                    Some(_) => {}
                }
            }
            if steps >= STEPS.1 {
                // It goes on falling as it did.
                break off * (off / last).min(1.0);
            }
            last = off;
        };
        let moves = |v: &usize| arcs.iter().any(|y| y[*v] != Vec3::ZERO);
        let vertices = (0..n).into_par_iter().filter(moves);
        let track = |v: usize| arcs.iter().map(|y| y[v] * self.shapes.scale).collect();
        Ok(Sampled { tracks: vertices.map(track).collect(), unseen })
    }
}

impl Sampled {
    /// Whether keys can do no more for an error.
    pub fn is_met_by(&self, error: f64) -> bool {
        error <= self.unseen
    }
}

/// Half way between steps `k` and `k + 1` of `steps`, by the cubic through the four nearest.
pub(super) fn midpoint(steps: usize, k: usize, y: impl Fn(usize) -> Vec3) -> Vec3 {
    if steps < 3 {
        return (y(k) + y(k + 1)) * 0.5;
    }
    let (first, weights) = match k {
        0 => (0, [5.0, 15.0, -5.0, 1.0]),
        _ if k + 1 == steps => (k - 2, [1.0, -5.0, 15.0, 5.0]),
        _ => (k - 1, [-1.0, 9.0, 9.0, -1.0]),
    };
    (0..4).map(|i| y(first + i) * weights[i]).sum::<Vec3>() / 16.0
}
