//! Cotangent Laplacian `L = G^T M G` (Pinkall & Polthier 1993): positive semidefinite, rows sum to 0.

use crate::Mesh;
use crate::linear::SymmetricMatrix;

/// The cotangent Laplacian, n x n: `(L x)_i = sum_j w_ij (x_i - x_j)` with
/// `w_ij = (cot alpha + cot beta) / 2` over the triangles beside the edge.
pub fn cotangent_laplacian(mesh: &Mesh) -> SymmetricMatrix {
    corner_laplacian(mesh, mesh.half_cotangents())
}

/// The Laplacian of other weights, each of the edge opposite to its corner.
pub(crate) fn corner_laplacian(mesh: &Mesh, weights: &[[f64; 3]]) -> SymmetricMatrix {
    let edges = mesh.triangles().iter().zip(weights);
    let edges = edges.flat_map(|(&[a, b, c], w)| [(b, c, w[0]), (c, a, w[1]), (a, b, w[2])]);
    SymmetricMatrix::laplacian(mesh.rest().len(), edges)
}
