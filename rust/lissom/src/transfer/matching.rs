//! Matching: which source triangle belongs to which target triangle, many to many.
//!
//! Once the source is fitted, every triangle of either mesh is matched with the triangle of the
//! other whose centroid is nearest, among those that face the same way, if the surface is within
//! reach (Sumner & Popović 2004, section 4.3).
//!
//! A triangle whose component has a partner ([`super::component_pairs`]) within reach is matched there, although
//! another component may be nearer.

use rayon::prelude::*;

use super::component_pairs::{ComponentPairs, Overlap, triangle_components};
use crate::geometry::surface::Surface;
use crate::{Job, Mesh, Result, Vec3};

/// Triangles looked up between two looks at the job.
const BATCH: usize = 4096;

/// One of the two meshes, where the fit has put it.
pub struct FittedMesh<'a> {
    mesh: &'a Mesh,
    positions: &'a [Vec3],
    surface: &'a Surface,
    /// Component of each triangle.
    component: Vec<u32>,
    /// Vertices, and triangles with such a corner, that match nothing.
    masked_vertex: &'a [bool],
    masked: Vec<bool>,
}

/// For each triangle, its match.
type Matches = Vec<Option<u32>>;

impl<'a> FittedMesh<'a> {
    /// `surface` holds the triangles of `mesh` at their fitted `positions`.
    /// `masked_vertex` are left out on both sides of every match.
    pub fn new(
        mesh: &'a Mesh,
        positions: &'a [Vec3],
        surface: &'a Surface,
        masked_vertex: &'a [bool],
    ) -> Self {
        let masked = masked_triangles(mesh, masked_vertex);
        Self { mesh, positions, surface, component: triangle_components(mesh), masked_vertex, masked }
    }

    /// Whether a triangle has a masked corner.
    pub fn is_masked(&self, triangle: usize) -> bool {
        self.masked[triangle]
    }

    /// Whether a vertex is masked.
    pub fn is_masked_vertex(&self, vertex: usize) -> bool {
        self.masked_vertex[vertex]
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// Its vertices where the fit has put them.
    pub fn positions(&self) -> &'a [Vec3] {
        self.positions
    }

    /// Its triangles there.
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// The component of a triangle.
    pub fn component(&self, triangle: usize) -> u32 {
        self.component[triangle]
    }

    /// The match of every triangle in `other`; in the partner of its component where that is within
    /// reach.
    fn nearest(&self, other: &FittedMesh, partner: &[Option<u32>], reach: f64, job: &Job) -> Result<Matches> {
        let count = self.component.len();
        let mut found = Vec::with_capacity(count);
        for start in (0..count).step_by(BATCH) {
            job.check()?;
            let batch = (start..count.min(start + BATCH)).into_par_iter().map(|t| {
                if self.masked[t] {
                    return None;
                }
                let (at, normal) = (self.surface.centroid(t), self.surface.normals()[t]);
                // Reach is measured to the surface: centroids of large triangles are far from anything.
                let look = |accept: &(dyn Fn(usize) -> bool + Sync)| {
                    other.surface.closest_compatible_point_on(at, normal, reach, accept)?;
                    other.surface.closest_compatible_centroid(at, normal, accept)
                };
                let partner = partner[self.component[t] as usize];
                let hit = partner
                    .and_then(|partner| look(&|s| other.component[s] == partner && !other.masked[s]))
                    .or_else(|| look(&|s| !other.masked[s]));
                hit.map(|hit| hit.triangle as u32)
            });
            found.par_extend(batch);
        }
        Ok(found)
    }
}

/// Which triangles have a masked corner.
pub fn masked_triangles(mesh: &Mesh, vertices: &[bool]) -> Vec<bool> {
    mesh.triangles().iter().map(|t| t.iter().any(|&v| vertices[v as usize])).collect()
}

/// Pairs `(triangle of source, triangle of target)`, sorted, each once, among the triangles in use; and which
/// components are partners.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn match_triangles(
    source: &FittedMesh,
    target: &FittedMesh,
    reach: f64,
    job: &Job,
) -> Result<(Vec<[u32; 2]>, ComponentPairs)> {
    let counts = [source, target].map(|side| side.mesh.components().count());
    let mut partners = ComponentPairs::none(counts);
    let mut of_source = source.nearest(target, &partners.of_source, reach, job)?;
    let mut of_target = target.nearest(source, &partners.of_target, reach, job)?;
    if counts != [1, 1] {
        let mut overlap = Overlap::new(counts);
        for (s, t) in of_source.iter().enumerate().filter_map(|(s, t)| t.map(|t| (s, t as usize))) {
            overlap.add(source.component[s], target.component[t], source.mesh.areas()[s]);
        }
        for (t, s) in of_target.iter().enumerate().filter_map(|(t, s)| s.map(|s| (t, s as usize))) {
            overlap.add(source.component[s], target.component[t], target.mesh.areas()[t]);
        }
        partners = overlap.partners();
        of_source = source.nearest(target, &partners.of_source, reach, job)?;
        of_target = target.nearest(source, &partners.of_target, reach, job)?;
    }
    let forth = (0u32..).zip(&of_source).filter_map(|(s, t)| t.map(|t| [s, t]));
    let back = (0u32..).zip(&of_target).filter_map(|(t, s)| s.map(|s| [s, t]));
    let mut pairs: Vec<[u32; 2]> = forth.chain(back).collect();
    pairs.sort_unstable();
    pairs.dedup();
    Ok((pairs, partners))
}
