//! Rotations at the vertices as the unknowns.
//!
//! With the positions that match them best, the energy of unit quaternions `R_i` at the vertices is
//!
//! ```text
//!     E(R) = min_x  sum_i sum_{e in cell i} w_e |e(x) - R_i e(v)|^2   +   s sum_ij w_ij |R_i - R_j|^2
//! ```
//!
//! Because `x` is at its minimum, the gradient is the one for fixed positions: turning `R_i` to `R_i exp(o)` changes
//! the energy by twice `o` times the *torque*, the axial vector of `R_i^T M_i`, with the covariance of the cell and what
//! the neighbours add in `M_i`. All is written in `C = R - I` and displacements, which are exactly zero at rest.

use rayon::prelude::*;

use super::fans::{Fans, GRAIN};
use crate::matrix::{axial, dot, outer};
use crate::{Mat3, Quat, Vec3};

/// Smallest cosine of half the turn to the best rotation: its Cayley transform is infinite for half a turn.
const LEAST_COSINE: f64 = 0.1;

/// What cells are, at rest.
pub struct AtRest<'a, N> {
    /// Their covariances.
    pub covariances: &'a [Mat3],
    /// `s`.
    pub smoothing: f64,
    /// The turn of a cell that fits a covariance best.
    pub nearest: N,
}

/// The energy of rotations and shape, and its gradient.
#[derive(Debug, Default)]
pub struct Turning {
    /// Half the gradient by the rotation of each vertex, in the frame that it turns.
    pub torques: Vec<Vec3>,
    /// How far to turn each, as [`turned`] does, to the rotation that fits its cell best; zero where they are smoothed.
    pub misfits: Vec<Vec3>,
    /// The energy, over the number of cells that an edge is in.
    pub energy: f64,
    /// The size of what it was summed from, which its rounding is relative to.
    pub size: f64,
}

/// `R_i exp(o_i)` to first order, by the Cayley transform, which is a rotation for every `o`.
pub fn turned(rotations: &[Quat], by: &[Vec3], length: f64) -> Vec<Quat> {
    let half = 0.5 * length;
    let turn = |(q, o): (&Quat, &Vec3)| {
        let o = *o * half;
        (*q * Quat::from_xyzw(o.x, o.y, o.z, 1.0)).normalize()
    };
    rotations.par_iter().zip(by).with_min_len(GRAIN).map(turn).collect()
}

/// `(R - I) v`.
#[inline]
pub fn turned_less(q: Quat, v: Vec3) -> Vec3 {
    let u = Vec3::new(q.x, q.y, q.z);
    2.0 * u.cross(v * q.w + u.cross(v))
}

impl Fans {
    /// `div (R - I)`.
    pub fn turn_divergence(&self, rotations: &[Quat], per_edge: f64) -> Vec<Vec3> {
        self.map(|i| {
            let own = -turned_less(rotations[i], self.total(i));
            let pulls = self.pulls_at(i).iter();
            let all = pulls.fold(own, |sum, &(j, pull)| sum + turned_less(rotations[j as usize], pull));
            all * (1.0 / per_edge)
        })
    }

    /// The energy of `rotations` and `displacements` and its torques. `more` adds to the covariance of a vertex and to
    /// the size of its displacements.
    pub fn turning(
        &self,
        AtRest { covariances: rest, smoothing, nearest }: AtRest<'_, impl Fn(Mat3) -> Mat3 + Sync + Send>,
        rotations: &[Quat],
        displacements: &[Vec3],
        per_edge: f64,
        more: impl Fn(usize) -> (Mat3, f64) + Sync + Send,
    ) -> Turning {
        let at = |i: usize| {
            let (mut covariance, mut stretch) = (Mat3::ZERO, 0.0);
            let (mut apart, mut pull) = (0.0, Vec3::ZERO);
            let (q, d) = (rotations[i], displacements[i]);
            let u = Vec3::new(q.x, q.y, q.z);
            for spoke in self.at(i) {
                let edge = displacements[spoke.neighbour as usize] - d;
                covariance += outer(edge, spoke.own);
                stretch += spoke.weight * edge.length_squared();
                if smoothing > 0.0 {
                    // The imaginary part of `R_i^-1 R_j`, the sine of half the angle between them.
                    let p = rotations[spoke.neighbour as usize];
                    let (v, weight) = (Vec3::new(p.x, p.y, p.z), spoke.weight.max(0.0));
                    let sine = v * q.w - u * p.w - u.cross(v);
                    let cosine = q.w * p.w + u.dot(v);
                    apart += weight * sine.length_squared();
                    pull += sine * (weight * cosine);
                }
            }
            let (further, larger) = more(i);
            let covariance = covariance * (1.0 / per_edge) + further;
            let (r, rest) = (Mat3::from_quat(q), rest[i]);
            let change = r - Mat3::IDENTITY;
            let turned = r.transpose() * covariance + change.transpose() * rest;
            let torque = -axial(turned) - pull * (8.0 * smoothing);
            let misfit = if smoothing > 0.0 { Vec3::ZERO } else { cayley(nearest(turned + rest)) };
            // Each edge is seen from both its ends.
            let size = 0.5 * stretch + larger + dot(change * rest, change);
            ((torque, misfit), (size - 2.0 * dot(change, covariance) + 8.0 * smoothing * apart, size))
        };
        let vertices = (0..rotations.len()).into_par_iter().with_min_len(GRAIN);
        let ((torques, misfits), parts): ((Vec<_>, Vec<_>), Vec<(f64, f64)>) = vertices.map(at).unzip();
        // Summed in order, not by the threads, so that results repeat to the last bit.
        let (energy, size) = parts.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        Turning { torques, misfits, energy, size }
    }
}

/// The vector of which a rotation is the Cayley transform.
fn cayley(rotation: Mat3) -> Vec3 {
    let q = Quat::from_mat3(&rotation);
    let q = if q.w < 0.0 { -q } else { q };
    Vec3::new(q.x, q.y, q.z) * (2.0 / q.w.max(LEAST_COSINE))
}
