//! Where a component goes that nothing holds: about the axis of its own rigid motion.
//!
//! The rigid motion that takes `start` nearest to `end` (Kabsch 1976) is a screw: a turn by `theta` about an axis `k` and a shift
//! along it. The centroid follows that screw,
//!
//! ```text
//!     c(t) = c(0) + (exp(t theta k) - I) u + t d_k,        (exp(theta k) - I) u = d - d_k
//! ```
//!
//! with its displacement `d` from end to end and `d_k` the part along the axis. Where no rigid motion accounts for the two
//! shapes it goes straight.

use crate::geometry::rigid::Alignment;
use crate::{Vec3, rotation};

/// The rigid motion must account for this share of the two shapes, as the correlation of their positions.
const ACCOUNTED: f64 = 0.75;

/// Angles in radians below which there is no telling an arc from a straight line.
const STRAIGHT: f64 = 1e-9;

/// A screw, by its rotation vector and the arm `u` from the axis to the centroid.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Screw {
    turn: Vec3,
    arm: Vec3,
}

impl Screw {
    /// The screw of some points, each from where it is to where it goes; the way round, and as many turns, as their
    /// triangles `turn` on the mean.
    pub fn of(points: impl Iterator<Item = (Vec3, Vec3)> + Clone, turn: Vec3) -> Self {
        let motion = Alignment::of(points);
        let (from, to) = motion.centroids();
        let turn = rotation::nearest_branch(rotation::log(motion.rotation()), turn);
        let angle = turn.length();
        if angle < STRAIGHT || motion.correlation() < ACCOUNTED {
            return Self::default();
        }
        let axis = turn / angle;
        let across = (to - from).reject_from_normalized(axis);
        Self { turn, arm: (across + axis.cross(across) / (0.5 * angle).tan()) * -0.5 }
    }

    /// How far the centroid is off the straight line at time `t`.
    pub fn at(&self, t: f64) -> Vec3 {
        let moved = |t: f64| rotation::exp(self.turn * t) * self.arm - self.arm;
        moved(t) - moved(1.0) * t
    }
}
