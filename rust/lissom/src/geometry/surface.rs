//! Closest compatible point: the nearest point of a surface whose normal agrees.
//!
//! Two points are *compatible* when the angle between their normals is below 90 degrees (Sumner &
//! Popović 2004, section 4.2), which keeps the two sides of an ear or a lip apart.

use rayon::prelude::*;

use super::ray::crossing;
use super::rows::Rows;
use super::tree::{Bounds, Tree, squared_limit};
use super::triangle::{closest_weights, normal_and_area};
use crate::Vec3;

#[cfg(test)]
mod tests;

/// Triangles a task takes at least.
const GRAIN: usize = 1024;

/// Triangles in a bounding volume hierarchy.
pub struct Surface {
    tree: Tree,
    /// In the order of the tree; those that are left out come last.
    leaves: Vec<Leaf>,
    /// Where each triangle is among them.
    slot: Vec<u32>,
    /// The places in the tree of each part's triangles.
    parts: Rows<u32>,
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
        let nothing: [u32; 0] = [];
        Self::in_parts(corners, |_| true, &nothing)
    }

    /// The surface of `triangles` with the vertices at `positions`.
    pub fn of(triangles: &[[u32; 3]], positions: &[Vec3]) -> Self {
        Self::new(triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect())
    }

    /// The same, of which nothing is found that is not `open`, and which can be searched part by part: `part` is that of
    /// each triangle.
    pub fn in_parts(corners: Vec<[Vec3; 3]>, open: impl Fn(usize) -> bool, part: &[u32]) -> Self {
        let all = 0..corners.len() as u32;
        let leaf = |t: u32| Leaf::new(t, corners[t as usize]);
        let of_triangle = |t| leaf(t).bounds();
        let bounds: Vec<Bounds> = all.clone().into_par_iter().with_min_len(GRAIN).map(of_triangle).collect();
        let (tree, mut order) = Tree::new(&bounds, all.clone().filter(|&t| open(t as usize)));
        let count = part.iter().max().map_or(0, |&last| last as usize + 1);
        let of_slot = order.iter().filter_map(|&t| part.get(t as usize).copied());
        let parts = Rows::sort(count, of_slot.zip(0u32..));
        order.extend(all.filter(|&t| !open(t as usize)));
        let mut slot = vec![0; corners.len()];
        (0..).zip(&order).for_each(|(place, &t)| slot[t as usize] = place);
        let leaves = order.par_iter().with_min_len(GRAIN).map(|&t| leaf(t)).collect();
        Self { tree, leaves, slot, parts }
    }

    /// The same, quick to search from the middle of what it encloses, until it is moved.
    pub fn with_slabs(mut self) -> Self {
        self.tree.add_slabs(|slot| self.leaves[slot as usize].corners);
        self
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

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.leaf(triangle).corners
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
        self.nearest(point, None, reach, None, at)
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
        self.nearest(point, Some(normal), reach, None, at)
    }

    /// The same on a part, or on all.
    pub fn closest_compatible_point_of(
        &self,
        part: Option<u32>,
        point: Vec3,
        normal: Vec3,
        reach: f64,
    ) -> Option<Hit> {
        let at = |leaf: &Leaf, least| {
            if leaf.normal.dot(normal) > 0.0 { leaf.closest(point, least) } else { None }
        };
        self.nearest(point, Some(normal), reach, part, at)
    }

    /// The triangle with the nearest centroid.
    pub fn closest_centroid(&self, point: Vec3) -> Option<Hit> {
        self.nearest(point, None, f64::INFINITY, None, |leaf, _| Some(centroid(leaf, point)))
    }

    /// The triangle with the nearest centroid among those of a part, or of all, that face the way of `normal`, within
    /// `reach`.
    pub fn closest_compatible_centroid_of(
        &self,
        part: Option<u32>,
        point: Vec3,
        normal: Vec3,
        reach: f64,
    ) -> Option<Hit> {
        let at = |leaf: &Leaf, _| (leaf.normal.dot(normal) > 0.0).then(|| centroid(leaf, point));
        self.nearest(point, Some(normal), reach, part, at)
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
        part: Option<u32>,
        at: impl Fn(&Leaf, f64) -> Option<(f64, (Vec3, Vec3))>,
    ) -> Option<Hit> {
        let probe = self.tree.probe(point, facing)?;
        let at = |slot: u32, least| {
            let leaf = &self.leaves[slot as usize];
            at(leaf, least).map(|(squared, found)| (squared, (leaf.triangle, found)))
        };
        let limit = squared_limit(reach);
        let (squared, (triangle, (weights, point))) = match part {
            Some(part) => self.tree.nearest_of(self.parts.of(part as usize), &probe, limit, at),
            None => self.tree.nearest(&probe, limit, at),
        }?;
        Some(Hit { triangle: triangle as usize, point, weights, distance: squared.sqrt() })
    }
}

fn centroid(leaf: &Leaf, point: Vec3) -> (f64, (Vec3, Vec3)) {
    let centre = leaf.centroid();
    (centre.distance_squared(point), (Vec3::splat(1.0 / 3.0), centre))
}
