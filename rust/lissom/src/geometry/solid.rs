//! The inside of a closed surface, by the sign of the distance to it.
//!
//! The sign is that of the pseudo-normal of the face, edge or vertex that is nearest (Bærentzen & Aanæs 2005,
//! Signed Distance Computation Using the Angle Weighted Pseudonormal); parry has them.

use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::groups::Groups;
use super::rows::Rows;
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

    /// The connected parts of `triangles`, each for itself: where they overlap, what is in any of them is inside.
    pub fn parts(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Self> {
        let joined = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let groups = Groups::joining(vertices.len(), joined);
        let part = |t: &[u32; 3]| groups.of()[t[0] as usize];
        let of_part = Rows::sort(groups.count(), triangles.iter().map(|t| (part(t), *t)));
        let mut place = vec![0u32; vertices.len()];
        let members = groups.members();
        for part in members.iter() {
            (0u32..).zip(part).for_each(|(k, &v)| place[v as usize] = k);
        }
        let solid = |(part, own): (&[u32], &[[u32; 3]])| {
            let corners = own.iter().map(|t| t.map(|v| place[v as usize])).collect();
            Self::new(part.iter().map(|&v| vertices[v as usize]).collect(), corners)
        };
        members.iter().zip(of_part.iter()).filter_map(solid).collect()
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

    /// How deep a point is inside, and the nearest point of the surface; `None` outside.
    pub fn depth(&self, point: Vec3) -> Option<(f64, Vec3)> {
        let side = self.0.local_aabb().contains_local_point(point).then(|| self.side(point, f64::MAX))??;
        (side.signed_distance < 0.0).then_some((side.hit.distance, side.hit.point))
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
        assert!(
            solid.side(Vec3::new(-0.2, 0.1, 0.0), 0.1).is_none() && solid.depth(Vec3::X * -0.1).is_none()
        );
        let (depth, nearest) = solid.depth(Vec3::X * 0.1).unwrap();
        assert!((depth - 0.1).abs() < 1e-12 && nearest.length() < 1e-12);
    }

    #[test]
    fn parts_that_overlap_are_solids_of_their_own() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p * 2.0);
        let vertices = corners.into_iter().chain(corners.map(|p| p + Vec3::splat(0.1))).collect::<Vec<_>>();
        let faces = [[0u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles: Vec<[u32; 3]> = (0..2).flat_map(|k| faces.map(|t| t.map(|v| v + 4 * k))).collect();
        let depths = |p: Vec3| Solid::parts(&vertices, &triangles).iter().filter_map(|s| s.depth(p)).count();
        // In the first alone, beside the surface of the second; in both; in none.
        assert_eq!([0.09, 0.3, -0.1].map(|z| depths(Vec3::new(0.3, 0.3, z))), [1, 2, 0]);
    }
}
