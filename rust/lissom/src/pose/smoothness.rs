//! How much curvature counts in ARAP (Oehri, Herholz & Sorkine-Hornung 2025, Higher Order Continuity for Smooth
//! As-Rigid-As-Possible Shape Modeling).
//!
//! ```text
//!     l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i
//! ```

use rayon::prelude::*;

use super::field::inverse_mass;
use crate::geometry::rows::Rows;
use crate::matrix::outer;
use crate::operators::cotangent::cotangent_laplacian;
use crate::stitch::turned_less;
use crate::{Mat3, Mesh, Quat, Vec3};

/// What the bending term of `smoothness` is worth, relative to the area of the region: at `l = 1/2` it
/// rules over distances below a tenth of the region's size.
const BENDING: f64 = 0.01;

/// The Laplacian's rows, how much each counts, and what they make of the rest pose.
#[derive(Debug)]
pub(super) struct Smoothness {
    pub rows: Rows<(u32, f64)>,
    /// `l h^2 / m_i`.
    pub factor: Vec<f64>,
    pub rest: Vec<Vec3>,
}

impl Smoothness {
    pub fn of(mesh: &Mesh, amount: f64) -> Self {
        let inverse = inverse_mass(mesh);
        let unit = amount * BENDING * mesh.areas().iter().sum::<f64>();
        let rows = cotangent_laplacian(mesh).rows();
        let rest = rows.iter().map(|row| combination(row, mesh.rest())).collect();
        Self { rows, factor: inverse.into_iter().map(|m| m * unit).collect(), rest }
    }

    /// Adds `sum_i f_i L_ij (R_i - I) (L v)_i`, what the second differences ask of each vertex.
    pub fn add_divergence(&self, rotations: &[Quat], divergence: &mut [Vec3]) {
        let asked: Vec<Vec3> =
            (0..rotations.len()).map(|i| turned_less(rotations[i], self.rest[i]) * self.factor[i]).collect();
        let rows = divergence.par_iter_mut().enumerate();
        rows.for_each(|(j, sum)| *sum += combination(self.rows.of(j), &asked));
    }

    /// What the second differences at a vertex add to its covariance and to the size of the displacements.
    pub fn bent(&self, i: usize, displacements: &[Vec3]) -> (Mat3, f64) {
        let bend = combination(self.rows.of(i), displacements);
        (self.covariance(i, bend), self.factor[i] * bend.length_squared())
    }

    pub fn covariance(&self, i: usize, bend: Vec3) -> Mat3 {
        outer(bend, self.rest[i]) * self.factor[i]
    }
}

fn combination(row: &[(u32, f64)], vectors: &[Vec3]) -> Vec3 {
    row.iter().fold(Vec3::ZERO, |sum, &(j, value)| sum + vectors[j as usize] * value)
}
