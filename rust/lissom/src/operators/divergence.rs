//! Divergence: what a field of target matrices asks of each vertex.
//!
//! `b_i = sum over corners (t, c) at i of C_t g_tc`, the right-hand side of `L x = b`; the transpose
//! of the gradient.

use rayon::prelude::*;

use crate::mesh::Adjacency;
use crate::{Mat3, Vec3};

/// Divergence of one 3 x 3 matrix per triangle; one vector per vertex.
///
/// `hats` are those of [`super::hat_gradients`].
pub fn divergence(adjacency: &Adjacency, hats: &[[Vec3; 3]], targets: &[Mat3]) -> Vec<Vec3> {
    (0..adjacency.vertex_count())
        .into_par_iter()
        .with_min_len(1024)
        .map(|v| {
            let corners = adjacency.corners_of(v).iter();
            corners.fold(Vec3::ZERO, |sum, c| {
                let t = c.triangle as usize;
                sum + targets[t] * hats[t][usize::from(c.corner)]
            })
        })
        .collect()
}
