//! The inside of a closed surface, by the sign of the distance to it.
//!
//! The sign is that of the pseudo-normal of the face, edge or vertex that is nearest: at an edge the sum of the normals of
//! its faces, at a vertex that weighted by their angles (Bærentzen & Aanæs 2005, Signed Distance Computation Using the Angle
//! Weighted Pseudonormal).

use super::surface::{Hit, Surface};
use crate::Vec3;

/// A closed surface whose triangles face outwards.
pub struct Body {
    surface: Surface,
    triangles: Vec<[u32; 3]>,
    /// Pseudo-normals of the vertices ...
    at_vertices: Vec<Vec3>,
    /// ... and, of each triangle, of the edges opposite to its corners.
    at_edges: Vec<[Vec3; 3]>,
}

/// The nearest point of the surface.
#[derive(Debug, Clone, Copy)]
pub struct SignedDistance {
    /// The distance to it, negative inside.
    pub signed_distance: f64,
    /// The point, and the triangle that it is on.
    pub hit: Hit,
    /// The unit normal there, outwards; of the triangle, zero where that has no area.
    pub out: Vec3,
}

impl Body {
    /// `None` without triangles.
    pub fn new(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> Option<Self> {
        if triangles.is_empty() {
            return None;
        }
        let normals: Vec<Vec3> = triangles.iter().map(|t| normal(t.map(|v| vertices[v as usize]))).collect();
        let mut at_vertices = vec![Vec3::ZERO; vertices.len()];
        for (t, &normal) in triangles.iter().zip(&normals) {
            for k in 0..3 {
                let [at, next, last] = [0, 1, 2].map(|i| vertices[t[(k + i) % 3] as usize]);
                if normal != Vec3::ZERO {
                    at_vertices[t[k] as usize] += normal * (next - at).angle_between(last - at);
                }
            }
        }
        let edge = |t: &[u32; 3], k: usize| {
            let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            [a.min(b), a.max(b)]
        };
        let mut sides: Vec<([u32; 2], u32, usize)> = (0u32..)
            .zip(&triangles)
            .flat_map(|(t, corners)| [0, 1, 2].map(|k| (edge(corners, k), t, k)))
            .collect();
        sides.sort_unstable();
        let mut at_edges = vec![[Vec3::ZERO; 3]; triangles.len()];
        for sides in sides.chunk_by(|a, b| a.0 == b.0) {
            let sum: Vec3 = sides.iter().map(|&(_, t, _)| normals[t as usize]).sum();
            sides.iter().for_each(|&(_, t, k)| at_edges[t as usize][k] = sum);
        }
        let surface = Surface::of(&triangles, vertices).with_slabs();
        Some(Self { surface, triangles, at_vertices, at_edges })
    }

    /// The side of a point that is within `reach` of the surface.
    pub fn side(&self, point: Vec3, reach: f64) -> Option<SignedDistance> {
        let hit = self.surface.closest_point_within(point, reach)?;
        let corners = self.triangles[hit.triangle];
        let vertex = (0..3).find(|&k| hit.weights[k] == 1.0).map(|k| self.at_vertices[corners[k] as usize]);
        let edge = || (0..3).find(|&k| hit.weights[k] == 0.0).map(|k| self.at_edges[hit.triangle][k]);
        let face = normal(self.surface.corners(hit.triangle));
        let out = vertex.or_else(edge).unwrap_or(face);
        let is_inside = (point - hit.point).dot(out) <= 0.0;
        let signed_distance = if is_inside { -hit.distance } else { hit.distance };
        Some(SignedDistance { signed_distance, hit, out: face })
    }
}

/// The unit normal of a triangle; zero where it has no area.
fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with a long thin spike: normals of single triangles would mistake the side beyond its tip.
    fn spike() -> Body {
        let vertices =
            [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, -0.5, 0.8), Vec3::new(0.0, -0.5, -0.8), Vec3::X * 9.0];
        Body::new(&vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
    }

    #[test]
    fn the_side_is_right_around_vertices_edges_and_faces() {
        let body = spike();
        let distance = |p: Vec3| body.side(p, f64::MAX).unwrap().signed_distance;
        assert!((distance(Vec3::new(9.5, 0.3, -0.2)) - Vec3::new(0.5, 0.3, -0.2).length()).abs() < 1e-12);
        assert!(distance(Vec3::new(0.5, 0.0, 0.0)) < 0.0 && distance(Vec3::new(-0.5, 0.0, 0.0)) == 0.5);
        assert!((0..100).all(|k| {
            let p = Vec3::new(0.09 * f64::from(k) - 1.0, 0.02, 0.01);
            (distance(p) < 0.0) == (p.x > 0.0 && p.x < 8.7) || (p.x - 8.7).abs() < 0.2
        }));
        let side = body.side(Vec3::new(-0.2, 0.1, 0.0), 0.3).unwrap();
        assert_eq!((side.hit.triangle, side.out), (0, -Vec3::X));
        assert!((side.hit.weights.element_sum() - 1.0).abs() < 1e-12);
        assert!(body.side(Vec3::new(-0.2, 0.1, 0.0), 0.1).is_none());
    }
}
