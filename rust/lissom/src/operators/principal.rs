//! Principal curvatures and directions by the normal cycle (Cohen-Steiner & Morvan 2003, Restricted
//! Delaunay Triangulations and Normal Cycle).
//!
//! A mesh bends at its edges alone, and across them: an edge of dihedral angle `beta`, positive where
//! convex, and unit direction `e` adds `beta |e| e e^T`. Averaged over the triangles at a vertex (each
//! takes half of its edges) and seen in the tangent plane this is a tensor `T` whose axes are the
//! principal directions with the curvatures swapped, so that `trace(T) I - T` is the shape operator.

use crate::matrix::outer;
use crate::{Mat3, Mesh, Vec3};

/// Curvature at a vertex, in unit coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Principal {
    /// The curvatures, that of larger magnitude first; positive where the surface is convex.
    pub curvatures: [f64; 2],
    /// Unit tangent along which the surface curves most; the least curved one is across.
    pub direction: Vec3,
    /// Unit normal, the mean of the triangles' by area (thesis, equation 3-14).
    pub normal: Vec3,
}

/// Principal curvatures and directions of every vertex.
pub fn principal_directions(mesh: &Mesh) -> Vec<Principal> {
    let mut of_triangle = vec![Mat3::ZERO; mesh.triangles().len()];
    let (edges, rest, normals) = (mesh.adjacency().edges(), mesh.rest(), mesh.normals());
    for (index, &[i, j]) in edges.iter().enumerate() {
        let [a, b] = mesh.adjacency().sides_of(index) else { continue };
        let along = rest[j as usize] - rest[i as usize];
        let Some(direction) = along.try_normalize() else { continue };
        let (first, second) = if a.ascending { (a, b) } else { (b, a) };
        let (m, n) = (normals[first.triangle as usize], normals[second.triangle as usize]);
        let beta = direction.dot(m.cross(n)).atan2(m.dot(n));
        let share = outer(direction, direction) * (0.5 * beta * along.length());
        of_triangle[a.triangle as usize] += share;
        of_triangle[b.triangle as usize] += share;
    }
    let at = |v: usize| {
        let corners = mesh.adjacency().corners_of(v).iter();
        let (mut sum, mut area, mut normal) = (Mat3::ZERO, 0.0, Vec3::ZERO);
        for t in corners.map(|c| c.triangle as usize) {
            sum += of_triangle[t];
            area += mesh.areas()[t];
            normal += normals[t] * mesh.areas()[t];
        }
        in_plane(sum * (1.0 / area.max(f64::MIN_POSITIVE)), normal.try_normalize().unwrap_or(Vec3::Z))
    };
    (0..rest.len()).map(at).collect()
}

/// Axes of `trace(T) I - T` in the plane across `normal`.
fn in_plane(tensor: Mat3, normal: Vec3) -> Principal {
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let (xx, xy, yy) = (y.dot(tensor * y), -x.dot(tensor * y), x.dot(tensor * x));
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let deviation = half.hypot(xy);
    // The direction of the larger eigenvalue; that of larger magnitude where the mean is negative.
    let angle = 0.5 * xy.atan2(half) + if mean < 0.0 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
    let sign = if mean < 0.0 { -1.0 } else { 1.0 };
    Principal {
        curvatures: [mean + sign * deviation, mean - sign * deviation],
        direction: x * angle.cos() + y * angle.sin(),
        normal,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// A surface of revolution about z with the given profile (radius, height), seamless around.
    fn revolve(profile: &[(f64, f64)], around: usize) -> Mesh {
        let ring = |k: usize| TAU * k as f64 / around as f64;
        let point = |&(r, z): &(f64, f64), k: usize| Vec3::new(r * ring(k).cos(), r * ring(k).sin(), z);
        let vertices = profile.iter().flat_map(|p| (0..around).map(move |k| point(p, k))).collect();
        let mut triangles = Vec::new();
        for row in 0..profile.len() - 1 {
            for k in 0..around {
                let [a, b] = [k, (k + 1) % around].map(|k| (row * around + k) as u32);
                let [c, d] = [a + around as u32, b + around as u32];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        Mesh::new(vertices, triangles).unwrap()
    }

    #[test]
    fn a_cylinder_curves_around_and_not_along() {
        let profile: Vec<(f64, f64)> = (0..30).map(|i| (2.0, 0.2 * f64::from(i))).collect();
        let mesh = revolve(&profile, 60);
        let curvature = mesh.frame().scale / 2.0;
        let found = principal_directions(&mesh);
        for p in &found[5 * 60..25 * 60] {
            assert!((p.curvatures[0] / curvature - 1.0).abs() < 2e-3, "{p:?}");
            assert!(p.curvatures[1].abs() < 1e-9 * curvature);
            assert!(p.direction.z.abs() < 1e-9);
            assert!(p.direction.dot(p.normal).abs() < 1e-12);
        }
    }

    #[test]
    fn the_inside_of_a_torus_is_a_saddle() {
        let (large, small, around) = (3.0, 1.0, 120);
        let angle = |i: usize| TAU * i as f64 / 80.0 - PI;
        // From the innermost circle over the bottom to the outermost: normals point outwards.
        let profile: Vec<(f64, f64)> =
            (0..41).map(|i| (large + small * angle(i).cos(), small * angle(i).sin())).collect();
        let mesh = revolve(&profile, around);
        let all = principal_directions(&mesh);
        let (scale, row) = (mesh.frame().scale, 4);
        let across = angle(row).cos() / (large + small * angle(row).cos());
        let expected = [1.0 / small, across].map(|k| k * scale);
        let found = all[row * around];
        for (found, expected) in found.curvatures.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02 * scale, "{found} {expected}");
        }
        assert!(expected[1] < 0.0);
    }
}
