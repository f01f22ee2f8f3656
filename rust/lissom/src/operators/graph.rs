//! Uniform Laplacian of the edge graph (Taubin 1995): degree minus adjacency.

use crate::Mesh;
use crate::linear::SymmetricMatrix;

/// The uniform graph Laplacian, n x n: `(L x)_i = sum over neighbours j of (x_i - x_j)`.
pub fn graph_laplacian(mesh: &Mesh) -> SymmetricMatrix {
    let edges = mesh.adjacency().edges().iter().map(|&[a, b]| (a, b, 1.0));
    SymmetricMatrix::laplacian(mesh.vertices().len(), edges)
}
