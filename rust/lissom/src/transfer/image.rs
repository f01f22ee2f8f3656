//! Image: where each vertex of the target lies on the source, once that is fitted.
//!
//! A target triangle has an image on the source's surface, at rest and in every key, and changes as that
//! does; so keys come over vertex by vertex, however finely either mesh is cut. (Sumner & Popović 2004 pair whole
//! triangles by their centroids, which shifts every key by up to half a triangle.)
//!
//! The image of a vertex is the closest point of the fitted source that faces the same way, in the partner of
//! its component where that has one ([`super::component_pairs`]).

use rayon::prelude::*;

use super::matching::FittedMesh;
use crate::geometry::surface::Surface;
use crate::geometry::triangle::vertex_normals;
use crate::{Job, Result, Vec3};

/// Vertices looked up between two looks at the job.
const BATCH: usize = 4096;

/// A point of the source's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The source triangle, as the input of the mesh counts them.
    pub triangle: u32,
    /// How much each of its corners counts; they add up to 1.
    pub weights: Vec3,
}

impl SurfacePoint {
    /// What `values` at the corners of the triangle are at this point.
    pub fn blend(&self, values: [Vec3; 3]) -> Vec3 {
        values[0] * self.weights.x + values[1] * self.weights.y + values[2] * self.weights.z
    }
}

/// The image of every vertex of `of` on the triangles of `on`, both where the fit has put them; `None` beyond
/// `reach`, on other components than the partner, and where nothing faces the same way. Triangles count as those
/// in use.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn images(
    on: &FittedMesh,
    of: &FittedMesh,
    partner: &[Option<u32>],
    reach: f64,
    job: &Job,
) -> Result<Vec<Option<SurfacePoint>>> {
    let mesh = of.mesh();
    let normals = vertex_normals(mesh.triangles(), of.positions());
    let surface: &Surface = on.surface();
    let image = |v: usize| {
        let component = mesh.components().of_vertex(v)?;
        if of.is_masked_vertex(v) {
            return None;
        }
        let of_partner = |s: usize| partner[component].is_none_or(|partner| on.component(s) == partner);
        let accept = |s: usize| !on.is_masked(s) && of_partner(s);
        let hit = surface.closest_compatible_point_on(of.positions()[v], normals[v], reach, accept)?;
        Some(SurfacePoint {
            triangle: hit.triangle as u32,
            weights: surface.weights(hit.triangle, hit.point),
        })
    };
    let count = mesh.rest().len();
    let mut found = Vec::with_capacity(count);
    for start in (0..count).step_by(BATCH) {
        job.check()?;
        found.par_extend((start..count.min(start + BATCH)).into_par_iter().map(image));
    }
    Ok(found)
}
