//! Rays: where one meets a triangle.

use crate::Vec3;

/// A ray that misses a triangle by less than this part of it hits it.
const SLIT: f64 = 1e-9;

/// How far along a ray lies a triangle, and the barycentric coordinates there (Möller & Trumbore 1997, Fast, Minimum
/// Storage Ray/Triangle Intersection).
pub fn crossing([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f64, Vec3)> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::surface::Surface;
    use crate::geometry::triangle::normal_and_area;

    #[test]
    fn a_ray_leaves_where_the_nearest_of_all_triangles_says() {
        for (shift, scale) in [(Vec3::ZERO, 1.0), (Vec3::new(3e4, -1e3, 7.0), 1.0), (Vec3::ONE, 1e-6)] {
            let at = |i: usize, j: usize| {
                let (x, y) = (i as f64, j as f64);
                Vec3::new(x, y, (1.3 * x).sin() + (0.9 * y).cos()) * scale + shift
            };
            let squares = (0..14 * 14).map(|k| (k / 14, k % 14));
            let halves = squares.flat_map(|(i, j)| {
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            });
            let corners: Vec<[Vec3; 3]> = halves.collect();
            let surface = Surface::new(corners.clone());
            let mut met = 0;
            for k in 0..600 {
                let a = f64::from(k);
                // Through vertices and between them, along the axes, and from far away.
                let origin = at(k as usize % 14, k as usize / 14 % 14);
                let off = Vec3::new((7.0 * a).sin(), (3.0 * a).cos(), -2.0) * f64::from(k % 3);
                let off = if k % 50 == 0 { off * 1e3 } else { off };
                let tilted = Vec3::new(a.sin(), (5.0 * a).sin(), 0.6 + (2.0 * a).cos()).normalize();
                let origin = origin + off * scale;
                for direction in [tilted, Vec3::AXES[k as usize % 3], -off.normalize_or_zero()] {
                    let facing = corners.iter().filter(|c| normal_and_area(**c).0.dot(direction) > 0.0);
                    let crossed = facing.filter_map(|c| crossing(*c, origin, direction));
                    let expected = crossed.map(|(distance, _)| distance).fold(f64::INFINITY, f64::min);
                    let found = surface.exit(origin, direction, |_| true);
                    assert_eq!(found.map_or(f64::INFINITY, |hit| hit.distance), expected);
                    met += usize::from(found.is_some());
                }
            }
            assert!(met > 300, "{met}");
        }
    }
}
