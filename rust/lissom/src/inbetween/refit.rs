//! Refinement: rotations refitted to the shape that came out, about those asked for.
//!
//! Local and global steps in turn (Sorkine & Alexa 2007, As-Rigid-As-Possible Surface Modeling) jump in time: a minimum
//! that a time is drawn to may be gone at the next. Here a triangle turns by `R exp(o)` from what it is asked, with the
//! vector that fits best to first order,
//!
//! ```text
//!     min_o  sum_{e in t}  w_te | R^T e(x) - s_te - o x s_te |^2,        |o| <= 1
//! ```
//!
//! which is linear in `x`, a projection, and for angles below a radian near the true one: it is its sine. The stitch is
//! a projection too, so a round hardly takes two shapes apart, and after any number of rounds the path is continuous as
//! the rotations asked for are. Rounds about the rotations of the last one would fit better, and take them apart.

use crate::matrix::{axial, outer, trace};
use crate::stitch::HatGradients;
use crate::{Mat3, Vec3, rotation};

/// How far a triangle may leave the rotation asked for, in radians.
const REACH: f64 = 1.0;

/// Share of the edges' size by which turns about any axis are resisted: needles say nothing of that about themselves.
const RESISTANCE: f64 = 0.02;

/// The rotation of a triangle refitted about `asked`, where its edges `stretched` with their `hats` came out such that
/// their covariance is `found`.
pub(super) fn refit(asked: Mat3, stretched: [Vec3; 3], hats: HatGradients, found: Mat3) -> Mat3 {
    let [a, b, c] = stretched;
    let own = outer(b - a, hats[1]) + outer(c - a, hats[2]);
    let size = trace(own);
    let metric = Mat3::from_diagonal(Vec3::splat((1.0 + RESISTANCE) * size)) - (own + own.transpose()) * 0.5;
    let m = asked.transpose() * found;
    let turn = metric.inverse() * axial(m);
    if size > 0.0 && turn.is_finite() { asked * rotation::exp(turn.clamp_length_max(REACH)) } else { asked }
}
