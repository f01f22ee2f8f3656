//! A target matrix per triangle.

use rayon::prelude::*;

use super::targets::{HatGradients, Local};
use crate::matrix::{dot, outer};
use crate::operators::corner_hat_gradients;
use crate::{Mat3, Mesh, Vec3};

/// Triangles or vertices that a thread takes at least.
const GRAIN: usize = 1024;

/// Sums at the vertices what `of(triangle, vertices)` says of its corners.
pub(super) fn gather(mesh: &Mesh, of: impl Fn(usize, [u32; 3]) -> [Vec3; 3] + Sync) -> Vec<Vec3> {
    let triangles = mesh.triangles().par_iter().enumerate().with_min_len(GRAIN);
    let corners: Vec<[Vec3; 3]> = triangles.map(|(t, &vertices)| of(t, vertices)).collect();
    let at = |v: usize| {
        let around = mesh.adjacency().corners_of(v).iter();
        around.fold(Vec3::ZERO, |sum, c| sum + corners[c.triangle as usize][usize::from(c.corner)])
    };
    (0..mesh.rest().len()).into_par_iter().with_min_len(GRAIN).map(at).collect()
}

fn covariance([a, b, c]: [Vec3; 3], hats: HatGradients) -> Mat3 {
    // The hats sum to zero, so any origin does.
    outer(b - a, hats[1]) + outer(c - a, hats[2])
}

pub(super) fn covariances(mesh: &Mesh, hats: impl Fn(usize) -> HatGradients + Sync, x: &[Vec3]) -> Vec<Mat3> {
    let triangles = mesh.triangles().par_iter().enumerate().with_min_len(GRAIN);
    triangles.map(|(t, vertices)| covariance(vertices.map(|v| x[v as usize]), hats(t))).collect()
}

pub(super) fn local_step(
    mesh: &Mesh,
    weights: &[[f64; 3]],
    hats: impl Fn(usize) -> HatGradients + Sync,
    x: &[Vec3],
    pick: impl Fn(usize, Mat3) -> Mat3 + Sync,
) -> Local {
    let of = |(t, vertices): (usize, &[u32; 3])| {
        let corners = vertices.map(|v| x[v as usize]);
        let covariance = covariance(corners, hats(t));
        let target = pick(t, covariance);
        let own = corner_hat_gradients(corners, weights[t]);
        let [a, b, c] = corners;
        let size = (b - a).dot(own[1]) + (c - a).dot(own[2]);
        (target - Mat3::IDENTITY, (size - 2.0 * dot(target, covariance), size))
    };
    let triangles = mesh.triangles().par_iter().enumerate().with_min_len(GRAIN);
    let (changes, parts): (Vec<Mat3>, Vec<(f64, f64)>) = triangles.map(of).unzip();
    // Summed in order, not by the threads, so that results repeat to the last bit.
    let (energy, size) = parts.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Local { changes, energy, size }
}
