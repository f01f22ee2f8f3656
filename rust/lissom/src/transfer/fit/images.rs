//! Images: where the vertices of one mesh lie on the other ([`SurfacePoint`]).
//!
//! The image of a vertex is the closest point of the other surface that faces the same way, in the partner of
//! its component where that has one ([`super::component_pairs`]).

use super::side::Placed;
use crate::transfer::image::SurfacePoint;
use crate::{Job, Result};

/// The image of every vertex of `of` on the triangles of `on`, both where the fit has put them; `None` beyond
/// `reach`, on other components than the partner, and where nothing faces the same way. Triangles count as those
/// in use.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn images(
    on: &Placed,
    of: &Placed,
    partner: &[Option<u32>],
    reach: f64,
    job: &Job,
) -> Result<Vec<Option<SurfacePoint>>> {
    let mesh = of.side.mesh;
    let surface = &on.surface;
    let image = |v: usize| {
        let component = mesh.components().of_vertex(v)?;
        if of.side.masked_vertex[v] {
            return None;
        }
        let of_partner = |s: usize| partner[component].is_none_or(|partner| on.side.component[s] == partner);
        let accept = |s: usize| !on.side.masked[s] && of_partner(s);
        let hit = surface.closest_compatible_point_on(of.positions[v], of.normals[v], reach, accept)?;
        Some(SurfacePoint {
            triangle: hit.triangle as u32,
            weights: surface.weights(hit.triangle, hit.point),
        })
    };
    job.in_batches(mesh.rest().len(), image)
}
