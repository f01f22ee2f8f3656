//! The way of one rotation over time.
//!
//! Near a whole turn the axis of `log R` is noise. Beyond half a turn a triangle therefore turns about
//! the axis that it inherits, by its *twist* about that axis with whole turns counted, and what is
//! left of its rotation, the *swing*, is a second factor:
//!
//! ```text
//!     R(t) = exp(t angle axis) exp(t swing)
//! ```
//!
//! Reversed in time this is of the same form, about the same axis.

use std::f64::consts::{PI, TAU};

use crate::{Mat3, Vec3, rotation};

/// Half a turn, give or take this many radians, has two ways.
pub(super) const HALF_TURN: f64 = 0.02;

/// Radians that are rounding.
const ROUNDING: f64 = 1e-9;

/// Parts whose centroid is displaced by less, in unit coordinates, turn in their place.
const IN_PLACE: f64 = 1e-3;

/// A turn that knows its way: `exp(t angle axis) exp(t swing)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn {
    pub axis: Vec3,
    pub angle: f64,
    pub swing: Vec3,
}

impl Turn {
    pub const NONE: Self = Self { axis: Vec3::ZERO, angle: 0.0, swing: Vec3::ZERO };

    /// About one axis, by a rotation vector.
    pub fn about(omega: Vec3) -> Self {
        let angle = omega.length();
        let axis = if angle > 0.0 { omega / angle } else { Vec3::ZERO };
        Self { axis, angle, swing: Vec3::ZERO }
    }

    /// The mean of several turns to follow.
    pub fn mean(turns: impl ExactSizeIterator<Item = Self>) -> Self {
        let share = 1.0 / turns.len() as f64;
        let (main, swing) = turns.fold((Vec3::ZERO, Vec3::ZERO), |(main, swing), turn| {
            (main + turn.axis * turn.angle * share, swing + turn.swing * share)
        });
        Self { swing, ..Self::about(main) }
    }

    /// Whether it is more than half a turn, and not by rounding.
    pub fn is_beyond_half(&self) -> bool {
        self.angle.abs() > PI + ROUNDING
    }

    /// Rotation vector, as far as the two factors have one.
    pub fn omega(&self) -> Vec3 {
        self.axis * self.angle + self.swing
    }

    /// The rotation at time `t`.
    pub fn at(&self, t: f64) -> Mat3 {
        let main = rotation::exp(self.axis * (t * self.angle));
        if self.swing == Vec3::ZERO { main } else { main * rotation::exp(self.swing * t) }
    }

    /// The way to `r` nearest to this one.
    pub fn nearest_to(&self, r: Mat3) -> Self {
        let q = glam::DQuat::from_mat3(&r);
        let twist = 2.0 * Vec3::new(q.x, q.y, q.z).dot(self.axis).atan2(q.w);
        let angle = twist + TAU * ((self.angle - twist) / TAU).round();
        if angle.abs() > PI + ROUNDING {
            let swing = rotation::log(rotation::exp(-self.axis * angle) * r);
            return Self { axis: self.axis, angle, swing };
        }
        Self::about(rotation::nearest_branch(rotation::log(r), self.omega()))
    }

    /// The way to `r` of a triangle that folds over one of this turn by half a turn, as pages and wings do: either way round
    /// is as near, and [`sided_log`] takes the side. `leaves` tells how far it leaves its place beside the other.
    pub fn folded(self, r: Mat3, leaves: impl FnOnce(Mat3) -> Vec3) -> Option<Self> {
        let beside = self.at(1.0);
        let fold = r * beside.transpose();
        if !is_half(rotation::log(fold)) {
            return None;
        }
        let turn = self.nearest_to(r);
        let way = turn.omega() - self.omega();
        // Beside its fold a triangle goes by as little as it is large, and to that side all the same.
        let side = sided_log(fold, leaves(beside).normalize_or_zero());
        Some(if way.dot(side) >= 0.0 { turn } else { Self::about(self.omega() - way).nearest_to(r) })
    }
}

/// Whether a rotation is half a turn, as near one way round as the other.
pub(super) fn is_half(omega: Vec3) -> bool {
    omega.length() > PI - HALF_TURN
}

/// `log R`. Half a turn goes to the side on which the part, whose centroid is displaced by `drift`, then passes: the one
/// where the largest coordinate is positive. Neither noise nor which end is the start changes that. A part that turns
/// in its place has the axis for its side.
pub(super) fn sided_log(r: Mat3, drift: Vec3) -> Vec3 {
    let omega = rotation::log(r);
    if !is_half(omega) {
        return omega;
    }
    let axis = omega.normalize();
    let passes = drift.cross(axis);
    let side = if passes.length() > IN_PLACE { passes } else { axis };
    let backward = side.min_element().abs() > side.max_element();
    if backward { rotation::nearest_branch(omega, -omega) } else { omega }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: Mat3, b: Mat3) -> f64 {
        crate::matrix::norm_squared(a - b).sqrt()
    }

    #[test]
    fn the_nearest_turn_leads_to_the_rotation_and_back() {
        let near = Turn::about(Vec3::new(0.2, -0.1, 1.0).normalize() * 9.0);
        for tilt in [Vec3::ZERO, Vec3::X * 0.1, Vec3::new(-0.5, 0.3, 0.1)] {
            let r = near.at(1.0) * rotation::exp(tilt);
            let turn = near.nearest_to(r);
            assert!(apart(turn.at(1.0), r) < 1e-12 && apart(turn.at(0.0), Mat3::IDENTITY) == 0.0);
            assert!((turn.angle - 9.0).abs() < 0.3 && turn.swing.length() < 0.7, "{turn:?}");
        }
    }

    #[test]
    fn reversed_in_time_a_turn_is_the_turn_of_the_inverse() {
        let near = Turn::about(Vec3::Y * 7.0);
        let turn = near.nearest_to(near.at(1.0) * rotation::exp(Vec3::new(0.3, 0.2, -0.4)));
        let back = Turn::about(-Vec3::Y * 7.0).nearest_to(turn.at(1.0).transpose());
        for t in [0.2, 0.5, 0.9] {
            assert!(apart(back.at(1.0 - t), turn.at(t) * turn.at(1.0).transpose()) < 1e-12);
        }
    }

    #[test]
    fn near_a_whole_turn_the_axis_is_inherited() {
        let near = Turn::about(Vec3::Z * 6.2);
        let turn = near.nearest_to(rotation::exp(Vec3::X * 0.01));
        assert!((turn.angle - TAU).abs() < 1e-12 && turn.axis == Vec3::Z);
        assert!((turn.swing - Vec3::X * 0.01).length() < 1e-12);
    }

    #[test]
    fn below_half_a_turn_the_shortest_is_taken() {
        let turn = Turn::about(Vec3::Z * 3.0).nearest_to(rotation::exp(Vec3::X * 0.01));
        assert!((turn.omega() - Vec3::X * 0.01).length() < 1e-12);
    }

    #[test]
    fn half_a_turn_passes_on_the_same_side_whatever_the_noise_and_the_order_of_the_ends() {
        let drift = Vec3::new(-2.0, 0.3, 0.1);
        for noise in [0.0, 1e-9, -1e-9, 1e-3, -1e-3] {
            let r = rotation::exp(Vec3::new(0.1, 1.0, 0.0).normalize() * (PI + noise));
            let there = sided_log(r, drift);
            assert!(is_half(there) && drift.cross(there).z > 0.0, "{there}");
            assert!((sided_log(r.transpose(), -drift) + there).length() < 1e-6);
            assert!(sided_log(r, Vec3::ZERO).y > 0.0);
        }
    }
}
