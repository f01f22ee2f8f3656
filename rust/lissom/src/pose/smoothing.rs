//! The two terms of [`super::arap`] that bend: `smoothness`, and the metric of `rotation_smoothing`.

use super::field::inverse_mass;
use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::matrix::trace;
use crate::operators::cotangent::cotangent_laplacian;
use crate::stitch::{Differences, Stitcher};
use crate::{Job, Mat3, Mesh, Result};

/// What the bending term of `smoothness` is worth, relative to the area of the region: at `l = 1/2` it
/// rules over distances below a tenth of the region's size.
const BENDING: f64 = 0.01;

/// Smallest mass of a rotation in the metric, relative to the mean.
pub(super) const LEAST_MASS: f64 = 1e-6;

/// `l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i`.
pub(super) fn smoothness(mesh: &Mesh, amount: f64) -> Differences {
    let unit = amount * BENDING * mesh.area() / mesh.diagonal().powi(2);
    let factor = inverse_mass(mesh).into_iter().map(|m| m * unit).collect();
    Differences::new(cotangent_laplacian(mesh).rows(), factor, mesh.rest())
}

/// What gradients by smoothed rotations are divided by.
pub(super) fn metric(
    stitcher: &Stitcher,
    rest: &[Mat3],
    smoothing: f64,
    job: &Job,
) -> Result<ConstrainedSystem> {
    let mean = rest.iter().map(|s| trace(*s)).sum::<f64>() / rest.len() as f64;
    let least = (LEAST_MASS * mean).max(f64::MIN_POSITIVE);
    let edges = |i: usize| {
        let beyond = stitcher.neighbours(i).filter(move |(j, _)| i < *j);
        beyond.map(move |(j, w)| (i as u32, j as u32, 4.0 * smoothing * w.max(0.0)))
    };
    let mut matrix = SymmetricMatrix::laplacian(rest.len(), (0..rest.len()).flat_map(edges));
    rest.iter().enumerate().for_each(|(i, s)| matrix.add_to_diagonal(i, 2.0 / 3.0 * trace(*s) + least));
    let system = ConstrainedSystem::new(&matrix, Constraints::hard(rest.len(), |_| false), job)?;
    Ok(system.rounded())
}
