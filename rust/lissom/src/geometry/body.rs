//! How deep a point is in a body.
//!
//! Its nearest point of the surface is found in a tree of triangles, by what no triangle of a node can be nearer than:
//!
//! ```text
//!     max( distance to the box,   n . p - max n . x,   min n . x - n . p )
//! ```
//!
//! the box and, in the direction `n` that the node's triangles face, the slab (Kay & Kajiya 1986, Ray Tracing Complex
//! Scenes). Near the middle of a round body all of its surface is about equally far. There the boxes of single triangles
//! are off by their own size and tell nothing; slabs are off by the square of it.

use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{Triangle, TrianglePointLocation};

use super::boxes::Boxes;
use super::groups::Groups;
use super::rows::Rows;
use super::solid::Solid;
use crate::Vec3;

/// Triangles of a leaf.
const LEAF: usize = 4;

/// Bodies, each for itself: where they overlap, what is in any of them is inside.
pub struct Bodies {
    bodies: Vec<Body>,
    boxes: Boxes,
}

/// A closed surface whose triangles face outwards, and the tree of them.
struct Body {
    solid: Solid,
    triangles: Vec<Leaf>,
    /// The root first, children after their parents.
    nodes: Vec<Node>,
    box_of_all: [Vec3; 2],
}

/// A triangle by its number and corners.
#[derive(Clone, Copy)]
struct Leaf(u32, [Vec3; 3]);

struct Node {
    least: Vec3,
    most: Vec3,
    normal: Vec3,
    /// The slab along `normal`.
    slab: [f64; 2],
    below: Below,
}

enum Below {
    /// These triangles.
    Triangles(std::ops::Range<usize>),
    /// The next node, and this one.
    Nodes(usize),
}

impl Bodies {
    /// The connected parts of `triangles`.
    pub fn parts(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let joined = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let groups = Groups::joining(vertices.len(), joined);
        let part = |t: &[u32; 3]| groups.of()[t[0] as usize];
        let of_part = Rows::sort(groups.count(), triangles.iter().map(|t| (part(t), *t)));
        let mut place = vec![0u32; vertices.len()];
        let members = groups.members();
        for part in members.iter() {
            (0u32..).zip(part).for_each(|(k, &v)| place[v as usize] = k);
        }
        let body = |(part, own): (&[u32], &[[u32; 3]])| {
            let corners = own.iter().map(|t| t.map(|v| place[v as usize])).collect();
            Body::new(part.iter().map(|&v| vertices[v as usize]).collect(), corners)
        };
        let bodies: Vec<Body> = members.iter().zip(of_part.iter()).filter_map(body).collect();
        let boxes = Boxes::around(bodies.iter().map(|body| body.box_of_all));
        Self { bodies, boxes }
    }

    /// How deep a point is in the body that it is deepest in, and the nearest point of that one's surface; `None` outside.
    pub fn deepest(&self, point: Vec3) -> Option<(f64, Vec3)> {
        let depths = self.boxes.within(point, 0.0).into_iter().filter_map(|k| self.bodies[k].depth(point));
        depths.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Body {
    /// `None` without triangles.
    fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        let leaves =
            (0u32..).zip(&triangles).map(|(t, corners)| Leaf(t, corners.map(|v| vertices[v as usize])));
        let mut leaves: Vec<Leaf> = leaves.collect();
        let mut nodes = Vec::with_capacity(leaves.len());
        split(&mut leaves, 0, &mut nodes);
        let box_of_all = nodes.first().map(|root| [root.least, root.most])?;
        Some(Self { solid: Solid::new(vertices, triangles)?, triangles: leaves, nodes, box_of_all })
    }

    /// How deep a point is inside, and the nearest point of the surface; `None` outside.
    fn depth(&self, point: Vec3) -> Option<(f64, Vec3)> {
        let [least, most] = self.box_of_all;
        if !(point.cmpge(least).all() && point.cmple(most).all()) {
            return None;
        }
        let (distance, triangle, nearest, location) = self.nearest(point)?;
        self.solid.is_behind(point, nearest, triangle, location).then_some((distance, nearest))
    }

    fn nearest(&self, point: Vec3) -> Option<(f64, u32, Vec3, TrianglePointLocation)> {
        let mut best = (f64::INFINITY, 0, Vec3::ZERO, TrianglePointLocation::OnSolid);
        let mut left = vec![(0.0, 0)];
        while let Some((bound, at)) = left.pop() {
            if bound >= best.0 {
                continue;
            }
            match &self.nodes[at].below {
                Below::Triangles(range) => {
                    for &Leaf(triangle, [a, b, c]) in &self.triangles[range.clone()] {
                        let (found, location) =
                            Triangle::new(a, b, c).project_local_point_and_get_location(point, false);
                        let distance = found.point.distance(point);
                        if distance < best.0 {
                            best = (distance, triangle, found.point, location);
                        }
                    }
                }
                &Below::Nodes(second) => {
                    let both = [at + 1, second].map(|node| (self.nodes[node].bound(point), node));
                    // The nearer one comes first.
                    let [near, far] = if both[0].0 <= both[1].0 { both } else { [both[1], both[0]] };
                    left.extend([far, near]);
                }
            }
        }
        best.0.is_finite().then_some(best)
    }
}

impl Node {
    /// No triangle is nearer.
    fn bound(&self, point: Vec3) -> f64 {
        let height = self.normal.dot(point);
        let outside = (self.least - point).max(point - self.most).max(Vec3::ZERO);
        outside.length().max(height - self.slab[1]).max(self.slab[0] - height)
    }
}

/// Sorts `leaves`, which begin at `start`, into a tree.
fn split(leaves: &mut [Leaf], start: usize, nodes: &mut Vec<Node>) {
    let corners = || leaves.iter().flat_map(|leaf| leaf.1);
    let least = corners().fold(Vec3::INFINITY, Vec3::min);
    let most = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let across = |Leaf(_, [a, b, c]): &Leaf| (*b - *a).cross(*c - *a);
    let normal = leaves.iter().map(across).sum::<Vec3>().normalize_or_zero();
    let heights = corners().map(|x| normal.dot(x));
    let slab = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    let at = nodes.len();
    let count = leaves.len();
    if count == 0 {
        return;
    }
    nodes.push(Node { least, most, normal, slab, below: Below::Triangles(start..start + count) });
    if count > LEAF {
        let extent = most - least;
        let axis = (0..3).fold(0, |axis, k| if extent[k] > extent[axis] { k } else { axis });
        let along = |Leaf(_, [a, b, c]): &Leaf| a[axis] + b[axis] + c[axis];
        let (first, second) = {
            leaves.select_nth_unstable_by(count / 2, |a, b| along(a).total_cmp(&along(b)));
            leaves.split_at_mut(count / 2)
        };
        split(first, start, nodes);
        let next = nodes.len();
        split(second, start + count / 2, nodes);
        nodes[at].below = Below::Nodes(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_overlap_are_bodies_of_their_own() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p * 2.0);
        let vertices = corners.into_iter().chain(corners.map(|p| p + Vec3::splat(0.1))).collect::<Vec<_>>();
        let faces = [[0u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles: Vec<[u32; 3]> = (0..2).flat_map(|k| faces.map(|t| t.map(|v| v + 4 * k))).collect();
        let bodies = Bodies::parts(&vertices, &triangles);
        let depths = |p: Vec3| bodies.bodies.iter().filter_map(move |s| s.depth(p)).map(|of| of.0);
        // In the first alone, beside the surface of the second; in both; in none.
        for (z, count) in [(0.09, 1), (0.3, 2), (-0.1, 0)] {
            let p = Vec3::new(0.3, 0.3, z);
            assert_eq!(depths(p).count(), count);
            assert_eq!(bodies.deepest(p).map(|of| of.0), depths(p).max_by(f64::total_cmp));
        }
    }

    #[test]
    fn depths_are_those_of_the_nearest_triangle() {
        let (rows, columns) = (14u32, 20u32);
        let at = |i: u32, j: u32| 1 + (i - 1) * columns + j % columns;
        let mut vertices = vec![Vec3::Z];
        for i in 1..rows {
            for j in 0..columns {
                let (u, w) = (
                    f64::from(i) * 3.2 / f64::from(rows),
                    f64::from(j) * std::f64::consts::TAU / f64::from(columns),
                );
                vertices.push(
                    Vec3::new(u.sin() * w.cos(), 0.7 * u.sin() * w.sin(), u.cos())
                        * (1.0 + 0.1 * (3.0 * w).sin()),
                );
            }
        }
        vertices.push(-Vec3::Z);
        let last = vertices.len() as u32 - 1;
        let mut triangles = Vec::new();
        for j in 0..columns {
            triangles.extend([[0, at(1, j), at(1, j + 1)], [last, at(rows - 1, j + 1), at(rows - 1, j)]]);
            for i in 1..rows - 1 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let solid = Solid::new(vertices.clone(), triangles.clone()).unwrap();
        let body = Bodies::parts(&vertices, &triangles);
        let mut inside = 0;
        for k in 0..1000 {
            let p = Vec3::new(f64::from(k % 10), f64::from(k / 10 % 10), f64::from(k / 100)) * 0.22
                - Vec3::splat(1.0);
            let side = solid.side(p, f64::MAX).unwrap();
            let depth = body.deepest(p);
            assert_eq!(depth.is_some(), side.signed_distance < 0.0, "{p}");
            if let Some((depth, nearest)) = depth {
                inside += 1;
                assert!(
                    (depth + side.signed_distance).abs() < 1e-12
                        && (nearest.distance(p) - depth).abs() < 1e-12
                );
            }
        }
        assert!(inside > 100);
    }
}
