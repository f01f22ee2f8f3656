//! The turn of a handle about its centre as one more unknown beside rotations at the vertices.
//!
//! ```text
//!     E(R, Q) = min_x E(R, x)      x_v = p + Q_h a_v  at the vertices of handle h
//! ```
//!
//! Turning `Q` to `Q exp(o)` changes the energy by twice `o` times `Q^T sum_v (Q a_v) x f_v`, with the force `f_v` that
//! holds a vertex where it is asked to be. The rotations around a handle would not let it turn alone: each of them
//! turns along by the handle's harmonic weight, and the unknowns of the descent are how they differ from that. What a
//! handle's turn then meets is the stiffness of the whole body, which the metric has for it from the rest pose.

use rayon::prelude::*;

use super::goal::Goal;
use super::region::Region;
use crate::{Mat3, Quat, Vec3};

/// A handle that turns about a point.
#[derive(Debug)]
pub(super) struct Lever<'a> {
    /// Its vertices, and how they lie about the point before it turns further.
    pub arms: Vec<(u32, Vec3)>,
    /// How much each vertex turns along.
    pub weights: &'a [f64],
    /// The inverse of the stiffness.
    pub compliance: Mat3,
}

impl<'a> Lever<'a> {
    /// A handle that turns about a point, which is where a goal takes it.
    pub fn of(
        region: &Region,
        goal: &Goal,
        (handle, pivot): (usize, Vec3),
        weights: &'a [f64],
        compliance: Mat3,
    ) -> Self {
        let rest = region.mesh().rest();
        let members = (0..rest.len()).filter(|&v| region.handle_of(v) == Some(handle));
        let arms = members.map(|v| (v as u32, rest[v] + goal.displacements[v] - pivot)).collect();
        Self { arms, weights, compliance }
    }
}

/// The displacements that handles ask for, some of which have turned.
pub(super) fn asked(displacements: &[Vec3], levers: &[Lever], turns: &[Quat]) -> Vec<Vec3> {
    let mut asked = displacements.to_vec();
    for (lever, &turn) in levers.iter().zip(turns) {
        lever.arms.iter().for_each(|&(v, arm)| asked[v as usize] += turn * arm - arm);
    }
    asked
}

/// Adds half the gradients by the handles' turns to those by the rotations.
pub(super) fn add_torques(
    torques: &mut Vec<Vec3>,
    levers: &[Lever],
    (rotations, turns): (&[Quat], &[Quat]),
    forces: &[Vec3],
) {
    for (lever, turn) in levers.iter().zip(turns) {
        let own = lever.arms.iter().map(|&(v, arm)| (*turn * arm).cross(forces[v as usize]));
        let along = rotations.iter().zip(&*torques).zip(lever.weights);
        let along = along.fold(Vec3::ZERO, |sum, ((&r, &torque), &weight)| sum + r * torque * weight);
        let torque = turn.inverse() * (own.sum::<Vec3>() + along);
        torques.push(torque);
    }
}

/// A direction of the rotations alone, from one of how they differ from turning along.
pub(super) fn with_levers(
    direction: &[Vec3],
    levers: &[Lever],
    (rotations, turns): (&[Quat], &[Quat]),
) -> Vec<Vec3> {
    let (own, of_handles) = direction.split_at(rotations.len());
    let of_handles: Vec<Vec3> = turns.iter().zip(of_handles).map(|(&turn, &o)| turn * o).collect();
    let at = |i: usize| {
        let along = levers.iter().zip(&of_handles).fold(Vec3::ZERO, |sum, (l, &o)| sum + o * l.weights[i]);
        own[i] + rotations[i].inverse() * along
    };
    (0..own.len()).into_par_iter().with_min_len(1024).map(at).collect()
}
