//! Meshes of the same vertices and triangles: each vertex belongs to its own like.

use super::diagnosis::{Fit, FitReport};
use crate::transfer::correspondence::Correspondence;
use crate::transfer::image::SurfacePoint;
use crate::{Mesh, Vec3};

/// The fit of a mesh onto one of the same vertices and triangles: each belongs to its own like.
pub fn same(source: &Mesh, target: &Mesh, warnings: Vec<String>) -> Fit {
    let ids = |(&s, &t): (&u32, &u32)| [s, t];
    let pairs = source.triangle_ids().iter().zip(target.triangle_ids()).map(ids).collect();
    let corners = |mesh: &Mesh| {
        let mut images = vec![None; mesh.vertices().len()];
        for (t, &triangle) in mesh.triangles().iter().zip(mesh.triangle_ids()) {
            for (corner, &v) in t.iter().enumerate() {
                images[v as usize] = Some(SurfacePoint { triangle, weights: Vec3::AXES[corner] });
            }
        }
        mesh.follow(&mut images);
        images
    };
    let (images, back_images) = (corners(source), corners(target));
    let n = images.len();
    Fit {
        matches: Correspondence { pairs, images, back_images, ..Correspondence::default() },
        fitted_vertices: target.vertices().to_vec(),
        distances: vec![0.0; n],
        image_distances: vec![0.0; n],
        distortion: vec![1.0; source.input_triangles()],
        report: FitReport { warnings, certainty: 1.0, ..FitReport::default() },
        ..Fit::default()
    }
}
