//! Lumped mass: the area that belongs to each vertex.

use crate::Mesh;

/// One third of the area of the triangles at each vertex, in unit coordinates.
pub fn lumped_mass(mesh: &Mesh) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.vertices().len()];
    for (t, area) in mesh.triangles().iter().zip(mesh.areas()) {
        for &v in t {
            mass[v as usize] += area / 3.0;
        }
    }
    mass
}
