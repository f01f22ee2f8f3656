//! Closest compatible point: the nearest point of a surface whose normal agrees.
//!
//! Two points are *compatible* when the angle between their normals is below 90 degrees (Sumner &
//! Popović 2004, section 4.2), which keeps the two sides of an ear or a lip apart.

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{Triangle, TrianglePointLocation};

use crate::Vec3;
use crate::geometry::triangle::normal_and_area;

/// A ray that misses a triangle by less than this part of it hits it.
const SLIT: f64 = 1e-9;

/// Triangles in a bounding volume hierarchy.
pub struct Surface {
    tree: Bvh,
    corners: Vec<[Vec3; 3]>,
    normals: Vec<Vec3>,
}

/// What a query found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The triangle, as the surface counts them.
    pub triangle: usize,
    /// The point on it.
    pub point: Vec3,
    /// How far that is from the point asked for.
    pub distance: f64,
}

impl Surface {
    /// A surface of triangles, given by their corners.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let boxes: Vec<Aabb> =
            corners.iter().map(|&[a, b, c]| Aabb::new(a.min(b).min(c), a.max(b).max(c))).collect();
        let normals = corners.iter().map(|&t| normal_and_area(t).0).collect();
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), corners, normals }
    }

    /// The surface of `triangles` with the vertices at `positions`.
    pub fn of(triangles: &[[u32; 3]], positions: &[Vec3]) -> Self {
        Self::new(triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect())
    }

    /// Unit normals of the triangles.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// The centre of a triangle.
    pub fn centroid(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners[triangle];
        (a + b + c) / 3.0
    }

    /// Barycentric coordinates of the point of a triangle that is nearest to `point`.
    pub fn weights(&self, triangle: usize, point: Vec3) -> Vec3 {
        let [a, b, c] = self.corners[triangle];
        weights(Triangle::new(a, b, c).project_local_point_and_get_location(point, false).1)
    }

    /// The nearest point of all; `None` for a surface without triangles or a point that is not finite.
    pub fn closest_point(&self, point: Vec3) -> Option<Hit> {
        self.closest_point_within(point, f64::INFINITY)
    }

    /// The same, no further away than `reach`.
    pub fn closest_point_within(&self, point: Vec3, reach: f64) -> Option<Hit> {
        self.nearest(point, reach, |t| Some(self.project(t, point)))
    }

    /// The same on triangles that are accepted.
    pub fn closest_point_on(&self, point: Vec3, reach: f64, accept: impl Fn(usize) -> bool) -> Option<Hit> {
        self.nearest(point, reach, |t| accept(t).then(|| self.project(t, point)))
    }

    /// The nearest point where the surface faces the way of `normal`; `None` where nothing does.
    pub fn closest_compatible_point(&self, point: Vec3, normal: Vec3) -> Option<Hit> {
        self.closest_compatible_point_on(point, normal, f64::INFINITY, |_| true)
    }

    /// The same within `reach`, on triangles that are accepted.
    pub fn closest_compatible_point_on(
        &self,
        point: Vec3,
        normal: Vec3,
        reach: f64,
        accept: impl Fn(usize) -> bool,
    ) -> Option<Hit> {
        self.nearest(point, reach, |t| {
            (accept(t) && self.compatible(t, normal)).then(|| self.project(t, point))
        })
    }

    /// The triangle with the nearest centroid.
    pub fn closest_centroid(&self, point: Vec3) -> Option<Hit> {
        self.nearest(point, f64::INFINITY, |t| Some(self.centroid(t)))
    }

    /// The triangle with the nearest centroid among those that face the way of `normal` and are
    /// accepted, within `reach`.
    pub fn closest_compatible_centroid(
        &self,
        point: Vec3,
        normal: Vec3,
        reach: f64,
        accept: impl Fn(usize) -> bool,
    ) -> Option<Hit> {
        self.nearest(point, reach, |t| (accept(t) && self.compatible(t, normal)).then(|| self.centroid(t)))
    }

    /// Where a ray of unit `direction` first leaves through an accepted triangle, and the barycentric coordinates there.
    /// No ray slips through between two triangles.
    pub fn exit(&self, origin: Vec3, direction: Vec3, accept: impl Fn(usize) -> bool) -> Option<(Hit, Vec3)> {
        let inverse = direction.recip();
        let to_box = |node: &BvhNode, _| {
            let pad = Vec3::splat(SLIT * node.mins().distance(node.maxs()));
            let (a, b) = ((node.mins() - pad - origin) * inverse, (node.maxs() + pad - origin) * inverse);
            // A ray along a face of the box gives 0 times infinity, which `min` and `max` pass over.
            let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
            if near <= far { near } else { f64::MAX }
        };
        let to_triangle = |t: u32, _| {
            let leaves = self.normals[t as usize].dot(direction) > 0.0 && accept(t as usize);
            leaves.then(|| crossing(self.corners[t as usize], origin, direction))?
        };
        let (t, (distance, weights)) = self.tree.find_best(f64::INFINITY, to_box, to_triangle)?;
        let [a, b, c] = self.corners[t as usize];
        let point = a * weights.x + b * weights.y + c * weights.z;
        Some((Hit { triangle: t as usize, point, distance }, weights))
    }

    fn compatible(&self, triangle: usize, normal: Vec3) -> bool {
        self.normals[triangle].dot(normal) > 0.0
    }

    /// The point of a triangle that is nearest to `point`.
    pub fn project(&self, triangle: usize, point: Vec3) -> Vec3 {
        let [a, b, c] = self.corners[triangle];
        Triangle::new(a, b, c).project_local_point(point, true).point
    }

    /// Best-first search for the least distance to `candidate(triangle)`, a point of that triangle.
    fn nearest(&self, point: Vec3, reach: f64, candidate: impl Fn(usize) -> Option<Vec3>) -> Option<Hit> {
        let to_box = |node: &BvhNode, _| {
            let outside = (node.mins() - point).max(point - node.maxs()).max(Vec3::ZERO);
            outside.length_squared()
        };
        let to_triangle =
            |t: u32, _| candidate(t as usize).map(|found| (found.distance_squared(point), found));
        let (t, (squared, found)) = self.tree.find_best(reach * reach, to_box, to_triangle)?;
        Some(Hit { triangle: t as usize, point: found, distance: squared.sqrt() })
    }
}

/// How far along a ray lies a triangle, and the barycentric coordinates there (Möller & Trumbore 1997, Fast, Minimum
/// Storage Ray/Triangle Intersection).
fn crossing([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f64, Vec3)> {
    let (ab, ac, from) = (b - a, c - a, origin - a);
    let across = direction.cross(ac);
    let q = from.cross(ab);
    let scale = 1.0 / ab.dot(across);
    let (v, w, distance) = (from.dot(across) * scale, direction.dot(q) * scale, ac.dot(q) * scale);
    let weights = Vec3::new(1.0 - v - w, v, w);
    let inside = weights.min_element() >= -SLIT && distance > 0.0 && distance.is_finite();
    let weights = weights.max(Vec3::ZERO);
    inside.then(|| (distance, weights / weights.element_sum()))
}

/// Barycentric coordinates of a place on a triangle.
pub(super) fn weights(location: TrianglePointLocation) -> Vec3 {
    // Only a solid has places that are on no triangle.
    location.barycentric_coordinates().map_or(Vec3::X, |weights| Vec3::from(weights).max(Vec3::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parallel squares that face away from each other, 0.1 apart.
    fn sheet() -> Surface {
        let at = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
        Surface::new(vec![
            [at(0.0, 0.0, 0.1), at(1.0, 0.0, 0.1), at(1.0, 1.0, 0.1)],
            [at(0.0, 0.0, 0.1), at(1.0, 1.0, 0.1), at(0.0, 1.0, 0.1)],
            [at(0.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 0.0, 0.0)],
            [at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(1.0, 1.0, 0.0)],
        ])
    }

    #[test]
    fn the_side_is_chosen_by_the_normal_not_by_the_distance() {
        let point = Vec3::new(0.7, 0.2, 0.2);
        let hit = sheet().closest_compatible_point(point, Vec3::new(0.1, 0.0, 1.0)).unwrap();
        assert_eq!((hit.triangle, hit.point), (0, Vec3::new(0.7, 0.2, 0.1)));
        let hit = sheet().closest_compatible_point(point, Vec3::new(0.1, 0.0, -1.0)).unwrap();
        assert_eq!((hit.triangle, hit.point), (2, Vec3::new(0.7, 0.2, 0.0)));
        assert!(sheet().closest_compatible_point(point, Vec3::X).is_none());
        assert_eq!(sheet().closest_point(point).unwrap().triangle, 0);
    }

    #[test]
    fn a_ray_leaves_through_edges_and_corners_too() {
        let up = |x: f64, y: f64| sheet().exit(Vec3::new(x, y, -1.0), Vec3::Z, |_| true);
        for [x, y] in [[0.7, 0.2], [0.4, 0.4], [0.0, 0.5], [1.0, 1.0], [0.0, 0.0]] {
            // Below is the side that faces down, through which nothing leaves upwards.
            let (hit, weights) = up(x, y).unwrap();
            assert!((hit.distance - 1.1).abs() < 1e-12 && (weights.element_sum() - 1.0).abs() < 1e-12);
            assert!(hit.point.distance(Vec3::new(x, y, 0.1)) < 1e-12 && hit.triangle < 2);
        }
        assert!(up(1.1, 0.5).is_none() && up(0.5, -0.1).is_none());
        assert!(sheet().exit(Vec3::new(0.7, 0.2, -1.0), Vec3::Z, |t| t != 0).is_none());
        assert!(sheet().exit(Vec3::new(0.7, 0.2, 1.0), Vec3::Z, |_| true).is_none());
    }

    #[test]
    fn centroids_are_centroids_and_reach_is_to_the_surface() {
        let point = Vec3::new(2.0 / 3.0, 1.0 / 3.0, 0.3);
        let hit = sheet().closest_compatible_centroid(point, Vec3::Z, f64::INFINITY, |_| true).unwrap();
        assert_eq!(hit.triangle, 0);
        assert!((hit.distance - 0.2).abs() < 1e-12);
        let within = |reach| sheet().closest_compatible_point_on(point, Vec3::Z, reach, |_| true).is_some();
        assert!(within(0.21) && !within(0.19));
        let other = sheet().closest_compatible_centroid(point, Vec3::Z, f64::INFINITY, |t| t != 0).unwrap();
        assert_eq!(other.triangle, 1);
    }
}
