//! Discrete differential operators on a triangle mesh, one a file.
//!
//! | file | operator | |
//! |---|---|---|
//! | [`gradient`] | `G`: positions to deformation gradients | Sumner & Popović 2004 |
//! | [`divergence`] | `-G^T M`: targets to right-hand sides | Botsch et al. 2006 |
//! | [`cotangent`] | `L = G^T M G`, positive semidefinite | Pinkall & Polthier 1993 |
//! | [`graph`] | the uniform Laplacian of the edges | Taubin 1995 |
//! | [`mass`] | lumped vertex areas | Meyer et al. 2003 |
//! | [`principal`] | principal curvatures and directions | Cohen-Steiner & Morvan 2003 |

pub mod cotangent;
pub mod divergence;
pub mod gradient;
pub mod graph;
pub mod mass;
pub mod principal;

use rayon::prelude::*;

use crate::{Mesh, Vec3};

/// `g_tc = area_t grad phi_c` of every corner: the gradient of the corner's hat function times the
/// triangle's area, in unit coordinates.
///
/// Written with the (mollified) cotangents, `g_i = w_ij (v_i - v_j) + w_ik (v_i - v_k)`, it is
/// defined for triangles without area, and the rest positions have the gradient that they ought to.
pub fn hat_gradients(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    hat_gradients_at(mesh, mesh.half_cotangents(), mesh.rest())
}

/// The same with other weights, each of the edge opposite to its corner, and the vertices at `x`.
pub(crate) fn hat_gradients_at(mesh: &Mesh, weights: &[[f64; 3]], x: &[Vec3]) -> Vec<[Vec3; 3]> {
    let triangles = mesh.triangles().par_iter().zip(weights);
    triangles.map(|(t, w)| corner_hat_gradients(t.map(|v| x[v as usize]), *w)).collect()
}

/// The scaled hat gradients of one triangle, from its corners and the weights of the edges opposite.
pub(crate) fn corner_hat_gradients([a, b, c]: [Vec3; 3], w: [f64; 3]) -> [Vec3; 3] {
    let (bc, ca, ab) = ((c - b) * w[0], (a - c) * w[1], (b - a) * w[2]);
    [ca - ab, ab - bc, bc - ca]
}
