//! Differences of positions that vertices own besides their edges.
//!
//! ```text
//!     sum_i  f_i | (D x)_i - R_i (D v)_i |^2
//! ```
//!
//! Row `i` of `D` combines positions with coefficients that sum to zero: the Laplacian of a vertex, or what lies opposite to
//! it less itself.

use rayon::prelude::*;

use super::fans::GRAIN;
use crate::geometry::rows::Rows;
use crate::linear::SymmetricMatrix;
use crate::matrix::outer;
use crate::{Mat3, Result, Vec3};

/// The rows of `D`, how much each counts, and what they make of the rest pose.
#[derive(Debug)]
pub struct Differences {
    rows: Rows<(u32, f64)>,
    columns: Rows<(u32, f64)>,
    factor: Vec<f64>,
    rest: Vec<Vec3>,
}

impl Differences {
    /// Of a row and a factor per vertex; a row names no vertex twice.
    pub fn new(rows: Rows<(u32, f64)>, factor: Vec<f64>, rest: &[Vec3]) -> Self {
        let entries =
            (0..rows.count()).flat_map(|i| rows.of(i).iter().map(move |&(j, d)| (j, (i as u32, d))));
        let columns = Rows::sort(rows.count(), entries);
        let rest = rows.iter().map(|row| combination(row, rest)).collect();
        Self { rows, columns, factor, rest }
    }

    /// `D^T F D`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::OutOfMemory`].
    pub fn matrix(&self) -> Result<SymmetricMatrix> {
        let rows = self.factor.iter().copied().zip(self.rows.iter());
        SymmetricMatrix::normal(self.rest.len(), rows)
    }

    /// Adds `D^T F (C - I) D v`, what the targets ask of each vertex. `changed` multiplies a vector by the `C - I` of
    /// a vertex.
    pub fn add_divergence(&self, changed: impl Fn(usize, Vec3) -> Vec3 + Sync, divergence: &mut [Vec3]) {
        let rest = self.rest.par_iter().zip(&self.factor).enumerate().with_min_len(GRAIN);
        let asked: Vec<Vec3> = rest.map(|(i, (&rest, factor))| changed(i, rest) * *factor).collect();
        let sums = divergence.par_iter_mut().enumerate();
        sums.for_each(|(j, sum)| *sum += combination(self.columns.of(j), &asked));
    }

    /// What the differences of a vertex add to its covariance and to the size of the displacements.
    pub fn at(&self, i: usize, displacements: &[Vec3]) -> (Mat3, f64) {
        let difference = combination(self.rows.of(i), displacements);
        (self.covariance(i, difference), self.factor[i] * difference.length_squared())
    }

    /// What they add to the covariance at rest.
    pub fn rest_covariance(&self, i: usize) -> Mat3 {
        self.covariance(i, self.rest[i])
    }

    fn covariance(&self, i: usize, difference: Vec3) -> Mat3 {
        outer(difference, self.rest[i]) * self.factor[i]
    }
}

fn combination(row: &[(u32, f64)], vectors: &[Vec3]) -> Vec3 {
    row.iter().fold(Vec3::ZERO, |sum, &(j, value)| sum + vectors[j as usize] * value)
}
