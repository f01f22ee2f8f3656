//! The inside of a closed surface, by the sign of the distance to it.
//!
//! The sign is that of the pseudo-normal of the face, edge or vertex that is nearest (Bærentzen & Aanæs 2005,
//! Signed Distance Computation Using the Angle Weighted Pseudonormal); parry has them.

use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags, TrianglePointLocation};

use super::surface::Hit;
use crate::Vec3;

/// A closed surface whose triangles face outwards.
pub struct Solid(TriMesh);

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

impl Solid {
    /// `None` without triangles.
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        TriMesh::with_flags(vertices, triangles, TriMeshFlags::ORIENTED).ok().map(Self)
    }

    /// The side of a point that is within `reach` of the surface.
    pub fn side(&self, point: Vec3, reach: f64) -> Option<SignedDistance> {
        let (nearest, (triangle, location)) =
            self.0.project_local_point_and_get_location_with_max_dist(point, false, reach)?;
        let distance = nearest.point.distance(point);
        // Only what has no surface has places that are on no triangle.
        let weights =
            location.barycentric_coordinates().map_or(Vec3::X, |weights| Vec3::from(weights).max(Vec3::ZERO));
        Some(SignedDistance {
            signed_distance: if nearest.is_inside { -distance } else { distance },
            hit: Hit { triangle: triangle as usize, point: nearest.point, weights, distance },
            out: self.0.triangle(triangle).scaled_normal().normalize_or_zero(),
        })
    }

    /// Whether a point is inside, whose nearest point of the surface is at a place of a triangle.
    pub(super) fn is_behind(
        &self,
        point: Vec3,
        nearest: Vec3,
        triangle: u32,
        location: TrianglePointLocation,
    ) -> bool {
        let normals = self.0.pseudo_normals();
        let at_vertex = |k: u32| {
            let vertex = self.0.indices()[triangle as usize][k as usize];
            normals.and_then(|normals| normals.vertices_pseudo_normal.get(vertex as usize)).copied()
        };
        let normal = match location {
            TrianglePointLocation::OnVertex(k) => at_vertex(k),
            TrianglePointLocation::OnEdge(k, _) => normals
                .and_then(|normals| normals.edges_pseudo_normal.get(triangle as usize))
                .map(|of| of[k as usize]),
            _ => Some(self.0.triangle(triangle).scaled_normal()),
        };
        normal.is_some_and(|normal| (point - nearest).dot(normal) <= 0.0 && point != nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with a long thin spike: normals of single triangles would mistake the side beyond its tip.
    fn spike() -> Solid {
        let vertices = vec![
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(0.0, -0.5, 0.8),
            Vec3::new(0.0, -0.5, -0.8),
            Vec3::X * 9.0,
        ];
        Solid::new(vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
    }

    #[test]
    fn the_side_is_right_around_vertices_edges_and_faces() {
        let solid = spike();
        let distance = |p: Vec3| solid.side(p, f64::MAX).unwrap().signed_distance;
        assert!((distance(Vec3::new(9.5, 0.3, -0.2)) - Vec3::new(0.5, 0.3, -0.2).length()).abs() < 1e-12);
        assert!(distance(Vec3::new(0.5, 0.0, 0.0)) < 0.0 && distance(Vec3::new(-0.5, 0.0, 0.0)) == 0.5);
        assert!((0..100).all(|k| {
            let p = Vec3::new(0.09 * f64::from(k) - 1.0, 0.02, 0.01);
            (distance(p) < 0.0) == (p.x > 0.0 && p.x < 8.7) || (p.x - 8.7).abs() < 0.2
        }));
        let side = solid.side(Vec3::new(-0.2, 0.1, 0.0), 0.3).unwrap();
        assert_eq!((side.hit.triangle, side.out), (0, -Vec3::X));
        assert!((side.hit.weights.element_sum() - 1.0).abs() < 1e-12);
        assert!(solid.side(Vec3::new(-0.2, 0.1, 0.0), 0.1).is_none());
    }
}
