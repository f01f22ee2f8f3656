//! One of the two meshes of a fit: what of it matches nothing, where its border is, and its surface where the fit
//! has put it.

use rayon::prelude::*;

use super::component_pairs::triangle_components;
use crate::geometry::surface::{Hit, Surface};
use crate::geometry::triangle::{interpolate, vertex_normals};
use crate::{Error, Fault, Mesh, Result, Vec3};

/// A point is on an edge where the opposite corner counts for less than this.
const ON_EDGE: f64 = 1e-9;

/// What of a mesh takes part.
pub struct Side<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Component of each triangle.
    pub component: Vec<u32>,
    /// Vertices that match nothing ...
    pub masked_vertex: Vec<bool>,
    /// ... and triangles with such a corner.
    pub masked: Vec<bool>,
    /// Triangles that another one before them is too: found through that one, or each search finds all of them.
    repeated: Vec<bool>,
    /// Of each triangle, the corners opposite to an edge that no other triangle has.
    open: Vec<[bool; 3]>,
    /// Vertices of such edges.
    border: Vec<bool>,
}

impl<'a> Side<'a> {
    /// A mesh, and the vertices of it that match nothing, which an error calls `name`.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for a vertex out of range.
    pub fn new(mesh: &'a Mesh, name: &str, mask: &[u32]) -> Result<Self> {
        let n = mesh.vertices().len();
        let outside = (0..mask.len()).filter(|&i| mask[i] as usize >= n);
        if let Some(fault) = Fault::at(name, format!("vertex out of range, the mesh has {n}"), outside) {
            return Err(Error::InvalidConstraint(fault));
        }
        let mut masked_vertex = vec![false; n];
        mask.iter().for_each(|&v| masked_vertex[mesh.representative(v) as usize] = true);
        let masked = mesh.triangles().iter().map(|t| t.iter().any(|&v| masked_vertex[v as usize])).collect();
        let (mut open, mut border) = (vec![[false; 3]; mesh.triangles().len()], vec![false; n]);
        for (e, ends) in mesh.adjacency().edges().iter().enumerate() {
            let [side] = mesh.adjacency().sides_of(e) else { continue };
            let t = side.triangle as usize;
            ends.iter().for_each(|&v| border[v as usize] = true);
            (0..3).for_each(|k| open[t][k] |= !ends.contains(&mesh.triangles()[t][k]));
        }
        let (component, repeated) = (triangle_components(mesh), repeated(mesh.triangles()));
        Ok(Self { mesh, component, masked_vertex, masked, repeated, open, border })
    }

    /// The same of a mesh with the same triangles.
    pub fn of<'b>(self, mesh: &'b Mesh) -> Side<'b> {
        let Self { component, masked_vertex, masked, repeated, open, border, .. } = self;
        Side { mesh, component, masked_vertex, masked, repeated, open, border }
    }

    /// Whether a vertex is on the border of the mesh.
    pub fn is_border(&self, vertex: usize) -> bool {
        self.border[vertex]
    }

    /// Whether a point of a triangle, by its barycentric coordinates, is on the border of the mesh.
    pub fn is_on_border(&self, triangle: usize, weights: Vec3) -> bool {
        let corners = self.mesh.triangles()[triangle];
        let at_corner = |k: usize| weights[k] > 1.0 - ON_EDGE && self.border[corners[k] as usize];
        (0..3).any(|k| (self.open[triangle][k] && weights[k] < ON_EDGE) || at_corner(k))
    }
}

/// Which triangles are, from another corner on perhaps, what one before them is.
fn repeated(triangles: &[[u32; 3]]) -> Vec<bool> {
    let from_least = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
    let mut sorted: Vec<_> = triangles.iter().map(from_least).zip(0usize..).collect();
    sorted.par_sort_unstable();
    let mut repeated = vec![false; triangles.len()];
    sorted.windows(2).for_each(|pair| repeated[pair[1].1] = pair[0].0 == pair[1].0);
    repeated
}

/// A side where the fit has put it.
pub struct Placed<'a> {
    /// The side.
    pub side: &'a Side<'a>,
    /// Its vertices.
    pub positions: &'a [Vec3],
    /// Its triangles, of which those that match nothing are not found.
    pub surface: Surface,
    /// Normals of its vertices, as long as twice the area around them.
    pub normals: Vec<Vec3>,
}

impl<'a> Placed<'a> {
    /// A side with its vertices at `positions`.
    pub fn new(side: &'a Side<'a>, positions: &'a [Vec3]) -> Self {
        Self::again(side, positions, None)
    }

    /// The same, with the surface of that side where it was before, which saves sorting its triangles.
    pub fn again(side: &'a Side<'a>, positions: &'a [Vec3], before: Option<Surface>) -> Self {
        let triangles = side.mesh.triangles();
        let surface = || match before {
            Some(mut surface) => {
                surface.follow(triangles, positions);
                surface
            }
            None => {
                let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect();
                Surface::in_parts(corners, |t| !side.masked[t] && !side.repeated[t], &side.component)
            }
        };
        let (surface, normals) = rayon::join(surface, || vertex_normals(triangles, positions));
        Self { side, positions, surface, normals }
    }

    /// The closest compatible point to `point`, where the normal is `normal`, that matches something: on the
    /// component `partner` where it is at most `detour` further than any other.
    pub fn closest(
        &self,
        point: Vec3,
        normal: Vec3,
        reach: f64,
        partner: Option<u32>,
        detour: f64,
    ) -> Option<Hit> {
        let closest = |part, reach| self.surface.closest_compatible_point_of(part, point, normal, reach);
        let any = closest(None, reach)?;
        match partner {
            Some(own) if self.side.component[any.triangle] != own => {
                closest(partner, any.distance + detour).or(Some(any))
            }
            _ => Some(any),
        }
    }

    /// The normal at a point of a triangle, smooth across edges.
    pub fn normal(&self, triangle: usize, weights: Vec3) -> Vec3 {
        let corners = self.side.mesh.triangles()[triangle];
        let blend: Vec3 = interpolate(corners.map(|v| self.normals[v as usize].normalize_or_zero()), weights);
        blend.try_normalize().unwrap_or(self.surface.normal(triangle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_repeated_from_any_corner_on_but_not_by_its_other_side() {
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 0, 1], [0, 2, 1], [1, 2, 0], [3, 1, 2]];
        assert_eq!(repeated(&triangles), [false, false, true, false, true, true]);
    }
}
