//! Bodies: closed surfaces in which something may be, and how deep.

use super::body::{Body, SignedDistance};
use super::boxes::Boxes;
use super::groups::Groups;
use super::rows::Rows;
use crate::Vec3;

/// Bodies, each for itself: where they overlap, what is in any of them is inside.
pub struct Bodies {
    all: Vec<Body>,
    boxes: Boxes,
}

impl Bodies {
    /// The connected parts of `triangles`, which face outwards.
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
            let at: Vec<Vec3> = part.iter().map(|&v| vertices[v as usize]).collect();
            Some((Body::new(&at, corners)?, at))
        };
        let (all, points): (Vec<Body>, Vec<Vec<Vec3>>) =
            members.iter().zip(of_part.iter()).filter_map(body).unzip();
        Self { all, boxes: Boxes::around(points) }
    }

    /// The side of the body that a point is deepest in or, outside of all, nearest to; `None` where that is
    /// higher than `reach`, which may be negative.
    pub fn side(&self, point: Vec3, reach: f64) -> Option<SignedDistance> {
        let sides = self.boxes.within(point, reach.max(0.0)).into_iter().filter_map(|k| {
            // Inside, the surface may be further away.
            let side = self.all[k].side(point, f64::INFINITY)?;
            (side.signed_distance <= reach).then_some(side)
        });
        sides.min_by(|a, b| a.signed_distance.total_cmp(&b.signed_distance))
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
        let sides = |p: Vec3| bodies.all.iter().filter_map(move |body| body.side(p, f64::INFINITY));
        let depths = |p: Vec3| sides(p).map(|side| side.signed_distance).filter(|&d| d < 0.0);
        // In the first alone, beside the surface of the second; in both; in none.
        for (z, count) in [(0.09, 1), (0.3, 2), (-0.1, 0)] {
            let p = Vec3::new(0.3, 0.3, z);
            assert_eq!(depths(p).count(), count);
            assert_eq!(
                bodies.side(p, 0.0).map(|side| side.signed_distance),
                depths(p).min_by(f64::total_cmp)
            );
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
        let body = Body::new(&vertices, triangles.clone()).unwrap();
        let bodies = Bodies::parts(&vertices, &triangles);
        let mut inside = 0;
        for k in 0..1000 {
            let p = Vec3::new(f64::from(k % 10), f64::from(k / 10 % 10), f64::from(k / 100)) * 0.22
                - Vec3::splat(1.0);
            let side = body.side(p, f64::MAX).unwrap();
            let of_any = bodies.side(p, 0.0).map(|side| side.signed_distance);
            assert_eq!(of_any, (side.signed_distance < 0.0).then_some(side.signed_distance), "{p}");
            inside += u32::from(of_any.is_some());
        }
        assert!(inside > 100);
    }
}
