//! `S(t)`: how far each triangle has stretched at time `t`.
//!
//! Both ways are combinations of the edges at the two ends, the latter turned back:
//!
//! ```text
//!     S(t) e(start) = p(t) e(start) + q(t) R^T e(end)
//!
//!     linear        p = 1 - t,  q = t                                  (Alexa, Cohen-Or & Levin 2000)
//!     logarithmic   S(t) = S^t:  q = (a^t - b^t) / (a - b),  p = a^t - q a
//! ```
//!
//! with the two stretches `a >= b` of the triangle (Sylvester's formula for a function of a 2 x 2 matrix). By the
//! second a triangle grows by the same factor in equal times, and its area never falls below both ends'.

use rayon::prelude::*;

use super::rotations::TriangleMotion;
use crate::geometry::triangle::normal_and_area;
use crate::matrix::trace;
use crate::operators::gradient::triangle_gradient;
use crate::options::choices;
use crate::{Mesh, Vec3};

/// Stretches nearer to each other than this fraction are taken as one.
const EQUAL: f64 = 1e-6;

choices! {
    /// How stretches go from start to end.
    pub enum Stretch {
        /// Lengths grow by the same amount in equal times (Alexa, Cohen-Or & Levin 2000).
        Linear = "linear",
        /// Lengths grow by the same factor in equal times; triangles that collapse or turn over go in equal steps.
        Logarithmic = "logarithmic",
    }
}

/// The two stretches of each triangle; `None` where it has none that are positive.
pub(super) fn stretches(
    mesh: &Mesh,
    motions: &[TriangleMotion],
    a: &[Vec3],
    b: &[Vec3],
) -> Vec<Option<[f64; 2]>> {
    let triangles = mesh.triangles().par_iter().zip(motions);
    triangles
        .map(|(t, motion)| {
            let turn = motion.rotation()?;
            let [p, q] = [a, b].map(|x| t.map(|v| x[v as usize]));
            let stretch = turn.transpose() * triangle_gradient(p, q);
            let trace = trace(stretch) - 1.0;
            let product = normal_and_area(q).1 / normal_and_area(p).1;
            let root = (0.25 * trace * trace - product).max(0.0).sqrt();
            let largest = 0.5 * trace + root;
            let both = [largest, product / largest];
            both.iter().all(|s| s.is_finite() && *s > 0.0).then_some(both)
        })
        .collect()
}

/// `p(t)` and `q(t)`.
pub(super) fn shares(stretches: Option<[f64; 2]>, t: f64) -> (f64, f64) {
    let Some([a, b]) = stretches else { return (1.0 - t, t) };
    if (a - b).abs() <= EQUAL * a {
        let q = t * (a * b).sqrt().powf(t - 1.0);
        return ((a * b).sqrt().powf(t) - q * (a * b).sqrt(), q);
    }
    let q = (a.powf(t) - b.powf(t)) / (a - b);
    (a.powf(t) - q * a, q)
}
