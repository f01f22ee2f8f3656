//! Areas, normals and cotangents of triangles.

use rayon::prelude::*;

use crate::Vec3;

/// Smallest excess `l_i + l_j - l_k` of a triangle, relative to its longest edge. Flatter ones are
/// mollified to it (Sharp & Crane 2020, A Laplacian for Nonmanifold Triangle Meshes, section 4.5);
/// ours acts on each triangle by itself, since only its own cotangents are asked for.
const MOLLIFY: f64 = 1e-5;

/// Below this part of its longest edge squared, twice the area of a triangle is too little to tell where in it a point is.
const SLIVER: f64 = 1e-9;

#[derive(Debug, Clone)]
pub(crate) struct TriangleGeometry {
    pub areas: Vec<f64>,
    pub normals: Vec<Vec3>,
    pub half_cotangents: Vec<[f64; 3]>,
    pub mollified: Vec<bool>,
}

impl TriangleGeometry {
    pub fn of(rest: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let (half_cotangents, (normals, (areas, mollified))) = triangles
            .par_iter()
            .map(|t| {
                let corners = t.map(|i| rest[i as usize]);
                let (weights, mollified) = half_cotangents(corners);
                let (normal, area) = normal_and_area(corners);
                (weights, (normal, (area, mollified)))
            })
            .unzip();
        Self { areas, normals, half_cotangents, mollified }
    }
}

/// Unit normal and area of a triangle.
pub(crate) fn normal_and_area([a, b, c]: [Vec3; 3]) -> (Vec3, f64) {
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    let edges = [c - b, a - c, b - a];
    let longest = edges.into_iter().max_by(|x, y| x.length().total_cmp(&y.length())).unwrap_or(Vec3::X);
    if length > 1e-14 * longest.length_squared() && length > f64::MIN_POSITIVE {
        (cross / length, 0.5 * length)
    } else {
        (longest.try_normalize().unwrap_or(Vec3::X).any_orthonormal_vector(), 0.5 * length)
    }
}

/// What values at the corners of a triangle are at the point of these barycentric coordinates.
#[inline]
pub(crate) fn interpolate(values: [Vec3; 3], weights: Vec3) -> Vec3 {
    (0..3).map(|k| values[k] * weights[k]).sum()
}

/// Barycentric coordinates of the point of a triangle of unit `normal` that is nearest to `point` (Ericson 2005, Real-Time
/// Collision Detection, section 5.1.5; where it is beyond an edge, on the edges that it is beyond).
#[inline]
pub(crate) fn closest_weights(point: Vec3, [a, b, c]: [Vec3; 3], normal: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let area = ab.cross(ac).dot(normal);
    let (v, w) = (ap.cross(ac).dot(normal) / area, ab.cross(ap).dot(normal) / area);
    let inside = Vec3::new(1.0 - v - w, v, w);
    // Of a sliver they are noise.
    let counts = area > SLIVER * ab.length_squared().max(ac.length_squared());
    if counts && inside.min_element() >= 0.0 {
        return inside;
    }
    let mut best = (f64::INFINITY, Vec3::X);
    for (k, from, edge) in [(0, b, c - b), (1, a, ac), (2, a, ab)] {
        if !counts || inside[k] < 0.0 {
            let (off, squared) = (point - from, edge.length_squared());
            let along = if squared > 0.0 { (off.dot(edge) / squared).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (off - edge * along).length_squared();
            if distance < best.0 {
                let [start, end] = [[1, 2], [0, 2], [0, 1]][k];
                best = (distance, Vec3::AXES[start] * (1.0 - along) + Vec3::AXES[end] * along);
            }
        }
    }
    best.1
}

/// Normals of vertices at `positions`, as long as twice the area around them.
pub(crate) fn vertex_normals(triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let cross = (b - a).cross(c - a);
        t.iter().for_each(|&v| normals[v as usize] += cross);
    }
    normals
}

/// Half the cotangent at each corner, from edge lengths, and whether they had to be mollified.
fn half_cotangents([a, b, c]: [Vec3; 3]) -> ([f64; 3], bool) {
    let edges = [c - b, a - c, b - a];
    let largest = edges.iter().fold(0.0, |largest: f64, e| largest.max(e.abs().max_element()));
    if largest == 0.0 {
        // A point: any shape will do, the equilateral one is the mildest.
        return ([0.5 / 3f64.sqrt(); 3], true);
    }
    // Angles do not depend on size, but fourth powers of small lengths would underflow.
    let mut l = edges.map(|e| (e / largest).length());
    let longest = l[0].max(l[1]).max(l[2]);
    let least_excess = (l[0] + l[1] + l[2]) - 2.0 * longest;
    let added = (MOLLIFY * longest - least_excess).max(0.0);
    l = l.map(|x| x + added);
    // Heron's formula in Kahan's order, stable for needles.
    let mut sorted = l;
    sorted.sort_by(|x, y| y.total_cmp(x));
    let [x, y, z] = sorted;
    let product = (x + (y + z)) * (z - (x - y)) * (z + (x - y)) * (x + (y - z));
    let area4 = product.max(0.0).sqrt();
    let squares = l.map(|x| x * x);
    let half = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        0.5 * (squares[j] + squares[k] - squares[i]) / area4
    };
    ([half(0), half(1), half(2)], added > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cotangents_of_a_right_isosceles_triangle() {
        let (weights, mollified) = half_cotangents([Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert!(!mollified);
        for (found, expected) in weights.into_iter().zip([0.0, 0.5, 0.5]) {
            assert!((found - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn flat_triangles_get_finite_weights_that_are_never_negative_together() {
        for c in [Vec3::new(0.5, 0.0, 0.0), Vec3::X, Vec3::ZERO, Vec3::new(0.3, 1e-12, 0.0)] {
            let (w, mollified) = half_cotangents([Vec3::ZERO, Vec3::X, c]);
            assert!(mollified);
            assert!(w.iter().all(|x| x.is_finite()));
            // Positive semidefinite: both invariants of the 3 x 3 element matrix.
            assert!(w[0] + w[1] + w[2] >= 0.0);
            assert!(w[0] * w[1] + w[1] * w[2] + w[2] * w[0] >= 0.0);
        }
    }

    #[test]
    fn triangles_of_any_size_have_the_same_angles() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.1)];
        let (expected, _) = half_cotangents(corners);
        for scale in [1e-300, 1e-100, 1e-90, 1e100] {
            let (weights, mollified) = half_cotangents(corners.map(|p| p * scale));
            assert!(!mollified);
            for (w, e) in weights.into_iter().zip(expected) {
                assert!((w - e).abs() < 1e-12, "{w} instead of {e} at {scale}");
            }
        }
    }
}
