//! Deformation gradients: the linear map of each triangle from rest to a posed mesh.
//!
//! `Q = [e1' e2' n'] [e1 e2 n]^-1` with edges `e` and unit normals `n`: the in-plane part is the
//! gradient of the posed positions, and the normal goes to the normal. Sumner & Popović (2004) scale
//! the fourth vertex by the square root of the area instead; the in-plane part is the same, and only
//! it takes part in stitching.

use rayon::prelude::*;

use crate::geometry::triangle::normal_and_area;
use crate::matrix::outer;
use crate::{Mat3, Mesh, Vec3, rotation};

/// Triangles whose height is below this fraction of their longest edge have no gradient of their
/// own: they turn and stretch with their longest edge.
const DEGENERATE: f64 = 1e-7;

/// Deformation gradients of `posed`, (n) positions in any units that share a scale with
/// `mesh.rest()`; one 3 x 3 matrix per triangle.
pub fn deformation_gradients(mesh: &Mesh, posed: &[Vec3]) -> Vec<Mat3> {
    let rest = mesh.rest();
    mesh.triangles()
        .par_iter()
        .map(|t| triangle_gradient(t.map(|v| rest[v as usize]), t.map(|v| posed[v as usize])))
        .collect()
}

/// The deformation gradient that takes triangle `rest` to triangle `posed`.
pub fn triangle_gradient(rest: [Vec3; 3], posed: [Vec3; 3]) -> Mat3 {
    let (normal, area) = normal_and_area(rest);
    let edges = |p: [Vec3; 3]| [p[1] - p[0], p[2] - p[0], p[2] - p[1]];
    let e = edges(rest);
    let longest =
        (0..3).max_by(|&i, &j| e[i].length_squared().total_cmp(&e[j].length_squared())).unwrap_or(0);
    let length_squared = e[longest].length_squared();
    let moved = edges(posed);
    if 2.0 * area <= DEGENERATE * length_squared {
        return along(e[longest], moved[longest]);
    }
    let (moved_normal, _) = normal_and_area(posed);
    // Rows of [e1 e2 n]^-1, the dual basis.
    let volume = 2.0 * area;
    let (d1, d2) = (e[1].cross(normal) / volume, normal.cross(e[0]) / volume);
    outer(moved[0], d1) + outer(moved[1], d2) + outer(moved_normal, normal)
}

/// Both singular values of the map from triangle `rest` to `posed`, the larger first.
pub fn singular_values(rest: [Vec3; 3], posed: [Vec3; 3]) -> [f64; 2] {
    let (normal, _) = normal_and_area(rest);
    let gradient = triangle_gradient(rest, posed);
    let a = normal.any_orthonormal_vector();
    let (fa, fb) = (gradient * a, gradient * normal.cross(a));
    // Sum of their squares, and their product.
    let (squares, product) = (fa.length_squared() + fb.length_squared(), fa.cross(fb).length());
    let (plus, minus) = ((squares + 2.0 * product).sqrt(), (squares - 2.0 * product).max(0.0).sqrt());
    [0.5 * (plus + minus), 0.5 * (plus - minus)]
}

/// The least turn that takes the direction of `from` to that of `to`, and the stretch along it.
fn along(from: Vec3, to: Vec3) -> Mat3 {
    let (Some(a), Some(b)) = (from.try_normalize(), to.try_normalize()) else {
        return Mat3::IDENTITY;
    };
    let turn = rotation::exp(glam::DQuat::from_rotation_arc(a, b).to_scaled_axis());
    turn * (Mat3::IDENTITY + outer(a, a) * (to.length() / from.length() - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_is_its_own_gradient_in_the_plane() {
        let map = Mat3::from_cols(Vec3::new(2.0, 0.1, 0.0), Vec3::new(0.3, 1.5, 0.2), Vec3::Z);
        let rest = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.0, 0.5), Vec3::new(0.2, 1.1, -0.4)];
        let q = triangle_gradient(rest, rest.map(|p| map * p + Vec3::ONE));
        for (i, j) in [(0, 1), (1, 2)] {
            let edge = rest[j] - rest[i];
            assert!((q * edge - map * edge).length() < 1e-13);
        }
        let normal = (rest[1] - rest[0]).cross(rest[2] - rest[0]).normalize();
        let moved = (map.inverse().transpose() * normal).normalize();
        assert!((q * normal - moved).length() < 1e-13);
    }

    #[test]
    fn a_flat_triangle_follows_its_longest_edge() {
        let rest = [Vec3::ZERO, Vec3::X, Vec3::X * 0.5];
        let q = triangle_gradient(rest, [Vec3::ZERO, Vec3::Y * 2.0, Vec3::Y]);
        assert!((q * Vec3::X - Vec3::Y * 2.0).length() < 1e-12);
        assert!(q.is_finite());
    }

    #[test]
    fn a_triangle_is_stretched_as_its_map_is() {
        let rest = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, -0.4, 0.2), Vec3::new(0.3, 0.8, -0.5)];
        let turn = rotation::exp(Vec3::new(0.4, -1.0, 0.7));
        let along = (rest[1] - rest[0]).normalize();
        let map = |p: Vec3| turn * (p + along * (1.7 * (p - rest[0]).dot(along)));
        for (posed, known) in [(rest.map(map), [2.7, 1.0]), (rest, [1.0, 1.0])] {
            let found = singular_values(rest, posed);
            // Where they are equal, half of the digits are lost.
            assert!((found[0] - known[0]).abs() < 1e-7 && (found[1] - known[1]).abs() < 1e-7, "{found:?}");
        }
    }
}
