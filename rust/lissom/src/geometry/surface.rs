//! Closest compatible point: the nearest point of a surface whose normal agrees.
//!
//! Two points are *compatible* when the angle between their normals is below 90 degrees (Sumner &
//! Popović 2004, section 4.2), which keeps the two sides of an ear or a lip apart.

use rayon::prelude::*;

use super::ray::crossing;
use super::tree::{Bounds, Tree};
use super::triangle::{closest_weights, normal_and_area};
use crate::Vec3;

/// Reach is meant to include what is just as far; by this part of its square, which rounding loses.
const ROUNDING: f64 = 1e-12;

/// Triangles a task takes at least.
const GRAIN: usize = 1024;

/// Triangles in a bounding volume hierarchy.
pub struct Surface {
    tree: Tree,
    /// In the order of the tree; those that are left out come last.
    leaves: Vec<Leaf>,
    /// Where each triangle is among them.
    slot: Vec<u32>,
}

#[repr(C)]
struct Leaf {
    // What most of those that are looked at are left out by comes first, to be in the cache together.
    normal: Vec3,
    triangle: u32,
    corners: [Vec3; 3],
}

/// What a query found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The triangle, as the surface counts them.
    pub triangle: usize,
    /// The point on it.
    pub point: Vec3,
    /// Its barycentric coordinates.
    pub weights: Vec3,
    /// How far that is from the point asked for.
    pub distance: f64,
}

impl Leaf {
    fn new(triangle: u32, corners: [Vec3; 3]) -> Self {
        Self { corners, normal: normal_and_area(corners).0, triangle }
    }

    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.corners;
        Bounds { place: [a.min(b).min(c), a.max(b).max(c)], normal: self.normal }
    }

    #[inline]
    fn at(&self, weights: Vec3) -> Vec3 {
        let [a, b, c] = self.corners;
        match weights.to_array() {
            // Corners to the bit.
            [1.0, ..] => a,
            [_, 1.0, _] => b,
            [.., 1.0] => c,
            [_, v, w] => a + (b - a) * v + (c - a) * w,
        }
    }

    fn centroid(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }

    /// The point nearest to `point`, where that can be nearer than the square of `least`: its weights, itself and the
    /// square of its distance.
    #[inline]
    fn closest(&self, point: Vec3, least: f64) -> Option<(f64, (Vec3, Vec3))> {
        let off = self.normal.dot(point - self.corners[0]);
        if off * off > least {
            return None;
        }
        let weights = closest_weights(point, self.corners, self.normal);
        let found = self.at(weights);
        Some((found.distance_squared(point), (weights, found)))
    }
}

impl Surface {
    /// A surface of triangles, given by their corners.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        Self::where_open(corners, |_| true)
    }

    /// The surface of `triangles` with the vertices at `positions`.
    pub fn of(triangles: &[[u32; 3]], positions: &[Vec3]) -> Self {
        Self::new(triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect())
    }

    /// The same, of which nothing is found that is not `open`.
    pub fn where_open(corners: Vec<[Vec3; 3]>, open: impl Fn(usize) -> bool) -> Self {
        let all = 0..corners.len() as u32;
        let leaf = |t: u32| Leaf::new(t, corners[t as usize]);
        let of_triangle = |t| leaf(t).bounds();
        let bounds: Vec<Bounds> = all.clone().into_par_iter().with_min_len(GRAIN).map(of_triangle).collect();
        let (tree, mut order) = Tree::new(&bounds, all.clone().filter(|&t| open(t as usize)));
        order.extend(all.filter(|&t| !open(t as usize)));
        let mut slot = vec![0; corners.len()];
        (0..).zip(&order).for_each(|(place, &t)| slot[t as usize] = place);
        let leaves = order.par_iter().with_min_len(GRAIN).map(|&t| leaf(t)).collect();
        Self { tree, leaves, slot }
    }

    /// Moves it to where the corners of its `triangles` are at `positions` now.
    pub fn follow(&mut self, triangles: &[[u32; 3]], positions: &[Vec3]) {
        let moved = |leaf: &mut Leaf| {
            *leaf =
                Leaf::new(leaf.triangle, triangles[leaf.triangle as usize].map(|v| positions[v as usize]));
        };
        self.leaves.par_iter_mut().with_min_len(GRAIN).for_each(moved);
        let leaves = &self.leaves;
        self.tree.fit(|slot| leaves[slot as usize].bounds());
    }

    /// The unit normal of a triangle.
    pub fn normal(&self, triangle: usize) -> Vec3 {
        self.leaf(triangle).normal
    }

    /// The centre of a triangle.
    pub fn centroid(&self, triangle: usize) -> Vec3 {
        self.leaf(triangle).centroid()
    }

    /// Barycentric coordinates of the point of a triangle that is nearest to `point`.
    pub fn weights(&self, triangle: usize, point: Vec3) -> Vec3 {
        let leaf = self.leaf(triangle);
        closest_weights(point, leaf.corners, leaf.normal)
    }

    /// The nearest point of all; `None` for a surface without triangles or a point that is not finite.
    pub fn closest_point(&self, point: Vec3) -> Option<Hit> {
        self.closest_point_within(point, f64::INFINITY)
    }

    /// The same, no further away than `reach`.
    pub fn closest_point_within(&self, point: Vec3, reach: f64) -> Option<Hit> {
        self.closest_point_on(point, reach, |_| true)
    }

    /// The same on triangles that are accepted.
    pub fn closest_point_on(&self, point: Vec3, reach: f64, accept: impl Fn(usize) -> bool) -> Option<Hit> {
        let at = |leaf: &Leaf, least| {
            if accept(leaf.triangle as usize) { leaf.closest(point, least) } else { None }
        };
        self.nearest(point, None, reach, at)
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
        let at = |leaf: &Leaf, least| {
            let counts = leaf.normal.dot(normal) > 0.0 && accept(leaf.triangle as usize);
            if counts { leaf.closest(point, least) } else { None }
        };
        self.nearest(point, Some(normal), reach, at)
    }

    /// The triangle with the nearest centroid.
    pub fn closest_centroid(&self, point: Vec3) -> Option<Hit> {
        self.nearest(point, None, f64::INFINITY, |leaf, _| Some(centroid(leaf, point)))
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
        let at = |leaf: &Leaf, _| {
            let counts = leaf.normal.dot(normal) > 0.0 && accept(leaf.triangle as usize);
            counts.then(|| centroid(leaf, point))
        };
        self.nearest(point, Some(normal), reach, at)
    }

    /// Where a ray of unit `direction` first leaves through an accepted triangle, and the barycentric coordinates there.
    /// No ray slips through between two triangles.
    pub fn exit(&self, origin: Vec3, direction: Vec3, accept: impl Fn(usize) -> bool) -> Option<Hit> {
        let at = |slot: u32, _| {
            let leaf = &self.leaves[slot as usize];
            let leaves = leaf.normal.dot(direction) > 0.0 && accept(leaf.triangle as usize);
            let (distance, weights) = leaves.then(|| crossing(leaf.corners, origin, direction))??;
            Some((distance, (leaf, weights)))
        };
        let (distance, (leaf, weights)) = self.tree.along(origin, direction, at)?;
        Some(Hit { triangle: leaf.triangle as usize, point: leaf.at(weights), weights, distance })
    }

    fn leaf(&self, triangle: usize) -> &Leaf {
        &self.leaves[self.slot[triangle] as usize]
    }

    /// The point of a triangle that is nearest to `point`.
    pub fn project(&self, triangle: usize, point: Vec3) -> Vec3 {
        self.leaf(triangle).at(self.weights(triangle, point))
    }

    /// The least of what `at` tells of a leaf: the square of a distance, and the weights and point that it is to.
    fn nearest(
        &self,
        point: Vec3,
        facing: Option<Vec3>,
        reach: f64,
        at: impl Fn(&Leaf, f64) -> Option<(f64, (Vec3, Vec3))>,
    ) -> Option<Hit> {
        let probe = self.tree.probe(point, facing)?;
        let at = |slot: u32, least| {
            let leaf = &self.leaves[slot as usize];
            at(leaf, least).map(|(squared, found)| (squared, (leaf.triangle, found)))
        };
        let limit = reach * reach * (1.0 + ROUNDING) + f64::MIN_POSITIVE;
        let (squared, (triangle, (weights, point))) = self.tree.nearest(&probe, limit, at)?;
        Some(Hit { triangle: triangle as usize, point, weights, distance: squared.sqrt() })
    }
}

fn centroid(leaf: &Leaf, point: Vec3) -> (f64, (Vec3, Vec3)) {
    let centre = leaf.centroid();
    (centre.distance_squared(point), (Vec3::splat(1.0 / 3.0), centre))
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
            let hit = up(x, y).unwrap();
            assert!((hit.distance - 1.1).abs() < 1e-12 && (hit.weights.element_sum() - 1.0).abs() < 1e-12);
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
    #[test]
    fn what_is_not_open_is_not_found_and_what_moves_is_found_where_it_is() {
        let (point, corners) = (Vec3::new(0.7, 0.2, 0.2), sheet().leaves);
        let mut corners: Vec<(u32, [Vec3; 3])> =
            corners.iter().map(|leaf| (leaf.triangle, leaf.corners)).collect();
        corners.sort_unstable_by_key(|leaf| leaf.0);
        let corners: Vec<[Vec3; 3]> = corners.into_iter().map(|leaf| leaf.1).collect();
        let mut surface = Surface::where_open(corners.clone(), |t| t != 0);
        let hit = surface.closest_compatible_point(point, Vec3::Z).unwrap();
        assert!(hit.triangle == 1 && hit.point.distance(Vec3::new(0.45, 0.45, 0.1)) < 1e-12);
        assert!(surface.normal(0) == Vec3::Z && (surface.centroid(0).z - 0.1).abs() < 1e-12);
        let moved: Vec<Vec3> = corners.iter().flatten().map(|&p| p * 2.0 + Vec3::X).collect();
        surface.follow(&[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]], &moved);
        let hit = surface.closest_compatible_point(point * 2.0 + Vec3::X, Vec3::Z).unwrap();
        assert!(hit.triangle == 1 && hit.point.distance(Vec3::new(1.9, 0.9, 0.2)) < 1e-12);
        assert!(hit.weights.distance(Vec3::new(0.55, 0.45, 0.0)) < 1e-12);
    }

    #[test]
    fn places_of_slivers_and_points_are_the_nearest_there_are() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        for (corners, point, nearest) in [
            ([at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1e-12)], Vec3::new(0.3, 1.0, 2.0), at(0.3, 0.0)),
            ([at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0)], at(1.7, 3.0), at(1.7, 0.0)),
            ([at(1.0, 2.0); 3], Vec3::ZERO, at(1.0, 2.0)),
            // Beyond the edge at the obtuse corner, nearest to the corner.
            ([at(0.0, 0.0), at(1.0, 0.0), at(-1.0, 0.2)], at(-0.01, -0.3), at(0.0, 0.0)),
        ] {
            let surface = Surface::new(vec![corners]);
            let hit = surface.closest_point(point).unwrap();
            assert!(hit.point.distance(nearest) < 1e-9, "{} instead of {nearest}", hit.point);
            assert!((hit.distance - point.distance(nearest)).abs() < 1e-9);
            assert!((hit.weights.element_sum() - 1.0).abs() < 1e-12);
        }
    }
}
