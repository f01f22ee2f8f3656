//! Symmetry: what a mesh has on the other side of its middle, so that a key that is the same left and right comes over
//! as such, and to see whether it has.
//!
//! A mesh is symmetric about a plane through the middle of its box, across one of the axes, when the mirror image of
//! every vertex lies on its surface, whatever its triangles. Where it lies at a vertex, they are *twins*.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::geometry::plane::{self, Plane};
use crate::geometry::surface::Surface;
use crate::geometry::triangle::{interpolate, vertex_normals};
use crate::{Mesh, Vec3};

/// Mirror images lie so near to the surface, root mean square, in unit coordinates: sculpted faces that are meant to
/// be symmetric keep to 0.05 %, and people are 0.5 % off.
const SYMMETRIC: f64 = 1e-3;

/// Vertices that are looked at before all are.
const SAMPLES: usize = 200;

/// Twins lie so near to where the mirror image of the other is, in unit coordinates: far above single precision. Were
/// it more, what is nearly symmetric would lose what it differs by.
const TWINS: f64 = 1e-5;

/// Images of twins are mirror images when they are so near to them, root mean square, in unit coordinates.
const MIRRORED: f64 = 0.01;

/// How many of the vertices must have twins.
const MOST: f64 = 0.9;

/// A plane that a mesh is symmetric about.
pub struct Mirror {
    axis: usize,
    /// Where the mirror image of each vertex lies: corners and their weights.
    places: Vec<Option<([u32; 3], Vec3)>>,
}

impl Mirror {
    /// The planes, by axis, that both meshes are symmetric about.
    pub fn of_both(source: &Mesh, target: &Mesh) -> Vec<[Self; 2]> {
        let sides = [source, target].map(|mesh| {
            let surface = Surface::of(mesh.triangles(), mesh.rest());
            (mesh, surface, vertex_normals(mesh.triangles(), mesh.rest()))
        });
        let of = |axis: usize| {
            let [source, target] = &sides;
            let few = |(mesh, surface, normals): &(&Mesh, Surface, Vec<Vec3>)| {
                let step = (mesh.rest().len() / SAMPLES).max(1);
                Self::about(axis, mesh, surface, normals, step).is_some()
            };
            if !(few(source) && few(target)) {
                return None;
            }
            let all = |(mesh, surface, normals): &(&Mesh, Surface, Vec<Vec3>)| {
                Self::about(axis, mesh, surface, normals, 1)
            };
            Some([all(source)?, all(target)?])
        };
        (0..3).filter_map(of).collect()
    }

    /// The plane across `axis`, seen from every `step`-th vertex; `None` where the mesh is not symmetric about it.
    fn about(axis: usize, mesh: &Mesh, surface: &Surface, normals: &[Vec3], step: usize) -> Option<Self> {
        let (count, plane) = (mesh.rest().len(), Plane::across(axis));
        let place = |v: usize| {
            mesh.components().of_vertex(v)?;
            let (point, normal) = (plane.reflect(mesh.rest()[v]), plane.reflect(normals[v]));
            let hit = surface.closest_compatible_point(point, normal)?;
            let corners = mesh.triangles()[hit.triangle];
            Some((hit.distance, (corners, hit.weights)))
        };
        let looked_at: Vec<usize> = (0..count).step_by(step).collect();
        let found: Vec<_> = looked_at.par_iter().map(|&v| place(v)).collect();
        let known = found.iter().flatten().count().max(1) as f64;
        let off = (found.iter().flatten().map(|(off, _)| off * off).sum::<f64>() / known).sqrt();
        (off < SYMMETRIC).then(|| Self { axis, places: found.into_iter().map(|f| Some(f?.1)).collect() })
    }

    /// How far `displacements` are from their own mirror image, root mean square over their own; 0 where there are
    /// none.
    pub fn difference(&self, displacements: &[Vec3]) -> f64 {
        let (mut off, mut own, plane) = (0.0, 0.0, Plane::across(self.axis));
        for (d, place) in displacements.iter().zip(&self.places) {
            let Some((corners, weights)) = place else { continue };
            let there = interpolate(corners.map(|v| displacements[v as usize]), *weights);
            off += d.distance_squared(plane.reflect(there));
            own += d.length_squared();
        }
        if own > 0.0 { (off / own).sqrt() } else { 0.0 }
    }
}

/// The twins of the vertices and triangles of a source and a target about one plane.
pub struct Twins {
    /// Of the source's and of the target's vertices.
    pub vertices: [Vec<Option<u32>>; 2],
    /// Of their triangles: those of the twins of their corners.
    pub triangles: [Vec<Option<u32>>; 2],
}

impl Twins {
    /// About a plane by which the `images` (points in the source's unit coordinates) of twins of the target are mirror
    /// images too; `None` where there is none. A tube has many planes, and few by which a fit is symmetric.
    pub fn of_both(source: &Mesh, target: &Mesh, images: &[Option<Vec3>]) -> Option<Self> {
        let [of_source, of_target] = [source, target].map(|mesh| plane::tree(mesh.rest()));
        let about = |axis: usize| {
            let vertices = [twins(source, &of_source, axis)?, twins(target, &of_target, axis)?];
            let off = |(v, twin): (usize, &Option<u32>)| {
                let (here, there) = ((*images.get(v)?)?, (*images.get((*twin)? as usize)?)?);
                Some(here.distance_squared(Plane::across(axis).reflect(there)))
            };
            let all: Vec<f64> = vertices[1].iter().enumerate().filter_map(off).collect();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            (mean.sqrt() < MIRRORED).then_some(vertices)
        };
        let vertices = (0..3).find_map(about)?;
        let triangles = [triangle_twins(source, &vertices[0]), triangle_twins(target, &vertices[1])];
        Some(Self { vertices, triangles })
    }

    /// The twins of three vertices of the source, where all have one.
    pub fn of_corners(&self, corners: [u32; 3]) -> Option<[u32; 3]> {
        let [a, b, c] = corners.map(|v| self.vertices[0][v as usize]);
        Some([a?, b?, c?])
    }
}

/// The twin of every vertex about the plane across `axis`; `None` where most have none.
fn twins(mesh: &Mesh, tree: &Surface, axis: usize) -> Option<Vec<Option<u32>>> {
    let (rest, plane) = (mesh.rest(), Plane::across(axis));
    let enough = |found: usize, of: usize| found as f64 >= MOST * of as f64;
    let few: Vec<Vec3> = rest.iter().copied().step_by((rest.len() / SAMPLES).max(1)).collect();
    let near = few.iter().filter(|&&p| plane::nearest(tree, plane.image(p), TWINS).is_some());
    if !enough(near.count(), few.len()) {
        return None;
    }
    let found = plane::twins(tree, rest, &plane, TWINS);
    enough(found.iter().flatten().count(), found.len()).then_some(found)
}

fn triangle_twins(mesh: &Mesh, twins: &[Option<u32>]) -> Vec<Option<u32>> {
    let sorted = |mut corners: [u32; 3]| {
        corners.sort_unstable();
        corners
    };
    let places: HashMap<[u32; 3], u32> =
        mesh.triangles().iter().map(|&corners| sorted(corners)).zip(0..).collect();
    let twin = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| twins[v as usize]);
        places.get(&sorted([a?, b?, c?])).copied()
    };
    mesh.triangles().iter().map(twin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::testing::nosed_sphere;

    #[test]
    fn a_sphere_with_a_nose_is_symmetric_but_from_front_to_back() {
        let (vertices, triangles) = nosed_sphere(30, 48);
        let mesh = Mesh::new(vertices, triangles).unwrap();
        let planes = Mirror::of_both(&mesh, &mesh);
        assert_eq!(planes.iter().map(|[plane, _]| plane.axis).collect::<Vec<_>>(), [1, 2]);
        let plane = &planes[0][1];
        let same = mesh.rest().iter().map(|p| Vec3::new(p.z, p.y * p.x, 0.1)).collect::<Vec<_>>();
        assert!(plane.difference(&same) < 0.01);
        let one_sided = mesh.rest().iter().map(|p| Vec3::X * p.y.max(0.0)).collect::<Vec<_>>();
        assert!((plane.difference(&one_sided) - 2f64.sqrt()).abs() < 0.1);
        assert_eq!(plane.difference(&vec![Vec3::ZERO; mesh.rest().len()]), 0.0);
    }
}
