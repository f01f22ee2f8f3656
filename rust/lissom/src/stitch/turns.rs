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

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::fans::{Fans, GRAIN};
use crate::linear::{Lanes, add_scaled, add_scaled_squares};
use crate::matrix::dot;
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
    /// How far to turn each, as [`turned`] does, to the rotation that fits its cell best; none where they are smoothed.
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
        let places: Vec<Lanes> =
            displacements.par_iter().with_min_len(GRAIN).map(|d| [d.x, d.y, d.z, 0.0]).collect();
        let mut torques = vec![Vec3::ZERO; rotations.len()];
        let mut misfits = vec![Vec3::ZERO; if smoothing > 0.0 { 0 } else { rotations.len() }];
        let mut of_misfits = misfits.chunks_mut(GRAIN);
        let blocks = torques.chunks_mut(GRAIN).enumerate();
        let blocks: Vec<_> =
            blocks.map(|(b, t)| (b * GRAIN, t, of_misfits.next().unwrap_or_default())).collect();
        let shape = Shape { fans: self, rest, smoothing, rotations, places: &places, per_edge };
        let (arch, nearest, more) = (Arch::new(), &nearest, &more);
        let blocks = blocks.into_par_iter().map(|(first, torques, misfits)| {
            arch.dispatch(Block { shape, nearest, more, first, torques, misfits })
        });
        let parts: Vec<(f64, f64)> = blocks.collect();
        // Summed in blocks, not by the threads, so that results repeat to the last bit.
        let (energy, size) = parts.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        Turning { torques, misfits, energy, size }
    }
}

/// What the energy is of.
#[derive(Clone, Copy)]
struct Shape<'a> {
    fans: &'a Fans,
    rest: &'a [Mat3],
    smoothing: f64,
    rotations: &'a [Quat],
    /// The displacements.
    places: &'a [Lanes],
    per_edge: f64,
}

/// Some vertices from `first` on: their torques and misfits are written, the parts of energy and size returned.
struct Block<'a, N, M> {
    shape: Shape<'a>,
    nearest: &'a N,
    more: &'a M,
    first: usize,
    torques: &'a mut [Vec3],
    misfits: &'a mut [Vec3],
}

impl<N: Fn(Mat3) -> Mat3, M: Fn(usize) -> (Mat3, f64)> WithSimd for Block<'_, N, M> {
    type Output = (f64, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (f64, f64) {
        let Self { shape: Shape { rest, smoothing, rotations, per_edge, .. }, nearest, more, .. } = self;
        let mut sums = (0.0, 0.0);
        for (k, torque) in self.torques.iter_mut().enumerate() {
            let i = self.first + k;
            let Cell { covariance, squares, apart, pull } = self.shape.cell(simd, i);
            let (further, larger) = more(i);
            let covariance = covariance * (1.0 / per_edge) + further;
            let (r, rest) = (Mat3::from_quat(rotations[i]), rest[i]);
            let change = r - Mat3::IDENTITY;
            *torque = -axial_of(r, covariance) - axial_of(change, rest) - pull * (8.0 * smoothing);
            if let Some(misfit) = self.misfits.get_mut(k) {
                *misfit = cayley(nearest(r.transpose() * (covariance + rest)));
            }
            // Each edge is seen from both its ends.
            let size = 0.5 * squares + larger + dot(change * rest, change);
            sums.0 += size - 2.0 * dot(change, covariance) + 8.0 * smoothing * apart;
            sums.1 += size;
        }
        sums
    }
}

/// Sums over the edges at a vertex.
struct Cell {
    covariance: Mat3,
    /// Of the squared lengths of the edges' displacements.
    squares: f64,
    /// Of the squared sines of half the angles to the neighbours' rotations, and half its gradient.
    apart: f64,
    pull: Vec3,
}

impl Shape<'_> {
    #[allow(clippy::needless_range_loop)]
    #[inline(always)]
    fn cell<S: Simd>(&self, simd: S, i: usize) -> Cell {
        let [x, y, z, w] = self.rotations[i].to_array();
        // Of the product `R_i^-1 R_j`, by the components of `R_j`.
        let columns = [[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]];
        let own = self.places[i];
        let [mut a, mut b, mut c] = [[0.0; 4]; 3];
        let (mut squares, mut apart, mut pull) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for spoke in self.fans.at(i) {
            let (j, weight, m) = (spoke.neighbour as usize, spoke.weight, spoke.own);
            let mut edge = self.places[j];
            add_scaled(simd, &mut edge, -1.0, &own);
            add_scaled(simd, &mut a, m.x, &edge);
            add_scaled(simd, &mut b, m.y, &edge);
            add_scaled(simd, &mut c, m.z, &edge);
            add_scaled_squares(simd, &mut squares, weight, &edge);
            if self.smoothing > 0.0 {
                // Sine and cosine of half the angle between them.
                let p = self.rotations[j].to_array();
                let mut turn = [0.0; 4];
                for k in 0..4 {
                    add_scaled(simd, &mut turn, p[k], &columns[k]);
                }
                let weight = weight.max(0.0);
                add_scaled_squares(simd, &mut apart, weight, &turn);
                add_scaled(simd, &mut pull, weight * turn[3], &turn);
            }
        }
        Cell {
            covariance: Mat3::from_cols(vector(a), vector(b), vector(c)),
            squares: vector(squares).element_sum(),
            apart: vector(apart).element_sum(),
            pull: vector(pull),
        }
    }
}

#[inline(always)]
fn vector([x, y, z, _]: Lanes) -> Vec3 {
    Vec3::new(x, y, z)
}

/// The axial vector of `a^T b`.
#[inline(always)]
fn axial_of(a: Mat3, b: Mat3) -> Vec3 {
    Vec3::new(
        a.z_axis.dot(b.y_axis) - a.y_axis.dot(b.z_axis),
        a.x_axis.dot(b.z_axis) - a.z_axis.dot(b.x_axis),
        a.y_axis.dot(b.x_axis) - a.x_axis.dot(b.y_axis),
    )
}

/// The vector of which a rotation is the Cayley transform.
fn cayley(rotation: Mat3) -> Vec3 {
    let q = Quat::from_mat3(&rotation);
    let q = if q.w < 0.0 { -q } else { q };
    Vec3::new(q.x, q.y, q.z) * (2.0 / q.w.max(LEAST_COSINE))
}
