//! Images: where the vertices of one mesh lie on the other ([`SurfacePoint`]).
//!
//! The image of a vertex is the closest point of the other surface that faces the same way, in the partner of
//! its component where that has one ([`super::component_pairs`]).

use rayon::prelude::*;

use super::side::Placed;
use crate::transfer::image::SurfacePoint;
use crate::{Job, Result};

/// Vertices looked up between two looks at the job.
const BATCH: usize = 4096;

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
    let count = mesh.rest().len();
    let mut found = Vec::with_capacity(count);
    for start in (0..count).step_by(BATCH) {
        job.check()?;
        found.par_extend((start..count.min(start + BATCH)).into_par_iter().map(image));
    }
    Ok(found)
}
