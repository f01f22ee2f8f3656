//! Images: where the vertices of one mesh lie on the other ([`SurfacePoint`]).
//!
//! The image of a vertex is the closest point of the other surface that faces the same way, in the partner of
//! its component where that has one ([`super::component_pairs`]).

use super::side::Placed;
use crate::geometry::surface::Hit;
use crate::transfer::image::SurfacePoint;
use crate::{Job, Result, Vec3};

/// Points closer than this are the same, in unit coordinates: normals differ at rims that are cut otherwise.
const SAME: f64 = 1e-3;

/// Beyond, normals are no more than 60 degrees apart: those of an arm beside a shirt are.
const LEAST_COSINE: f64 = 0.5;

/// How much further away than another component the partner may be, as lids lie under tear films.
const DETOUR: f64 = 1e-3;

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
    of_vertices(of, job, |v, component| {
        let (point, normal) = (of.positions[v], of.normals[v]);
        let hit = on.surface.closest_compatible_point_of(partner[component], point, normal, reach)?;
        Some(SurfacePoint { triangle: hit.triangle as u32, weights: hit.weights })
    })
}

/// The same for meshes that lie on each other as they are ([`super::overlap`]). A vertex that has none so takes the image
/// of what is across the thickness of its own mesh, as the inside of clothes does.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn images_of_overlap(
    on: &Placed,
    of: &Placed,
    partner: &[Option<u32>],
    reach: f64,
    job: &Job,
) -> Result<Vec<Option<SurfacePoint>>> {
    of_vertices(of, job, |v, component| {
        let (point, normal) = (of.positions[v], of.normals[v].normalize_or_zero());
        let image = |point, normal, component: usize| {
            let hit = on.closest(point, normal, reach, partner[component], DETOUR)?;
            let image = SurfacePoint { triangle: hit.triangle as u32, weights: hit.weights };
            is_trusted(on, &hit, point, normal).then_some(image)
        };
        image(point, normal, component).or_else(|| {
            let across =
                of.surface.exit(point, -normal, |_| true).filter(|across| across.distance <= reach)?;
            let normal = of.normal(across.triangle, across.weights);
            image(across.point, normal, of.side.component[across.triangle] as usize)
        })
    })
}

/// By `image`, of each vertex in a face that is not masked, with its component.
fn of_vertices(
    of: &Placed,
    job: &Job,
    image: impl Fn(usize, usize) -> Option<SurfacePoint> + Sync,
) -> Result<Vec<Option<SurfacePoint>>> {
    let components = of.side.mesh.components();
    job.in_batches(of.positions.len(), |v| {
        let component = components.of_vertex(v).filter(|_| !of.side.masked_vertex[v])?;
        image(v, component)
    })
}

fn is_trusted(on: &Placed, hit: &Hit, point: Vec3, normal: Vec3) -> bool {
    let there = on.normal(hit.triangle, hit.weights);
    let aside = (point - hit.point).reject_from_normalized(there).length();
    let beyond_border = aside > SAME && on.side.is_on_border(hit.triangle, hit.weights);
    hit.distance < SAME || (normal.dot(there) > LEAST_COSINE && !beyond_border)
}
