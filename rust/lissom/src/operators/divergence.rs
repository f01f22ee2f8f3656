//! Divergence: what a field of target matrices asks of each vertex.
//!
//! `b_i = sum over corners (t, c) at i of C_t g_tc`, the right-hand side of `L x = b`; the transpose
//! of the gradient.

use crate::{Mat3, Vec3};

/// Divergence of one 3 x 3 matrix per triangle; one vector for each of so many vertices.
///
/// `hats` are those of [`super::hat_gradients`]. Most matrices of a key are zero, and pass without a look at
/// the hats: one pass over the triangles is faster than a parallel one over the vertices.
pub fn divergence(
    triangles: &[[u32; 3]],
    hats: &[[Vec3; 3]],
    targets: &[Mat3],
    vertices: usize,
) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; vertices];
    for ((corners, hats), target) in triangles.iter().zip(hats).zip(targets) {
        if *target != Mat3::ZERO {
            for (&v, &hat) in corners.iter().zip(hats) {
                sums[v as usize] += *target * hat;
            }
        }
    }
    sums
}
