//! Rotations: polar decomposition, logarithm, and the branches of the logarithm.
//!
//! The nearest rotation to `M` maximises `tr(R^T M)` over rotations. For `M = U diag(s) V^T` with
//! descending `s` it is `R = U diag(1, 1, det(U V^T)) V^T` (Kabsch 1976; Umeyama 1991), which exists
//! for reflections and for matrices of any rank.
//!
//! The maximum itself, `l = s1 + s2 + det(U V^T) s3`, is the largest root of
//! `(l^2 - |M|^2)^2 = 4 |cof M|^2 + 8 l det M` (Horn 1987's characteristic polynomial, in invariants), and `R` is its
//! derivative by `M` (compare Lin, Chitalu & Komura 2022, Isotropic ARAP Energy Using Cauchy-Green
//! Invariants): no singular vectors are needed unless the root is nearly double.

use std::f64::consts::TAU;

use crate::matrix::{cross, norm_squared};
use crate::{Mat3, Vec3};

/// Smallest `(s1 + s2) (s1 + s3) (s2 + s3) / |M|^3` for which the derivative of the root is used; its largest
/// value, for a rotation, is `8 * 3^(-3/2) = 1.5`. Below, too many digits would be lost.
const SIMPLE_ROOT: f64 = 0.01;

/// Singular values below this fraction of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-14;

/// The rotation nearest to `m` in the Frobenius norm; always of determinant +1.
///
/// The zero matrix, and any matrix that is not finite, gives the identity. Where several rotations
/// are equally near (rank one, or a tie under reflection), one of them.
pub fn nearest_rotation(m: Mat3) -> Mat3 {
    let norm = norm_squared(m).sqrt();
    if !norm.is_finite() || norm < f64::MIN_POSITIVE {
        return Mat3::IDENTITY;
    }
    let m = m * (1.0 / norm);
    root_rotation(m).unwrap_or_else(|| svd_rotation(m))
}

/// `m = R S` with a rotation `R` and a symmetric `S`, which has a negative eigenvalue where `m`
/// reflects.
pub fn polar(m: Mat3) -> (Mat3, Mat3) {
    let r = nearest_rotation(m);
    let s = r.transpose() * m;
    (r, (s + s.transpose()) * 0.5)
}

/// The nearest rotation to a matrix of norm 1 as the derivative of the largest root; `None` where the root
/// is nearly double.
fn root_rotation(m: Mat3) -> Option<Mat3> {
    let cofactors = cofactors(m);
    let determinant = m.x_axis.dot(cofactors.x_axis);
    let squares = norm_squared(cofactors);
    // The root for determinant 0. The polynomial is convex from there on.
    let mut root = (1.0 + 2.0 * squares.sqrt()).sqrt();
    // A quarter of the slope, half the product of the three sums of two singular values.
    let slope = |root: f64| root * (root * root - 1.0) - 2.0 * determinant;
    // Towards a double root Newton's steps only halve, and jump where rounding takes over.
    let found = (0..10).any(|_| {
        let excess = root * root - 1.0;
        let step = (excess * excess - 4.0 * squares - 8.0 * root * determinant) / (4.0 * slope(root));
        root -= step;
        // Convergence is quadratic: a step of 1e-9 leaves an error of 1e-18.
        step.abs() < 1e-9
    });
    let slope = slope(root);
    if !found || slope <= 2.0 * SIMPLE_ROOT {
        return None;
    }
    let derivative = m * (root * root + 1.0) - m * (m.transpose() * m) * 2.0 + cofactors * (2.0 * root);
    let r = derivative * (1.0 / slope);
    // One step of Newton and Schulz takes the last rounding out of the orthogonality.
    Some(r * 1.5 - r * (r.transpose() * r) * 0.5)
}

/// `det(m) m^-T`, defined also where `m` is singular.
fn cofactors(m: Mat3) -> Mat3 {
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    Mat3::from_cols(b.cross(c), c.cross(a), a.cross(b))
}

/// One-sided Jacobi: `m V = U diag(s)`; only the last axis may have to be flipped or invented.
fn svd_rotation(m: Mat3) -> Mat3 {
    let mut u = [m.x_axis, m.y_axis, m.z_axis];
    let mut v = [Vec3::X, Vec3::Y, Vec3::Z];
    for _ in 0..30 {
        let mut largest: f64 = 0.0;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (app, aqq, apq) = (u[p].length_squared(), u[q].length_squared(), u[p].dot(u[q]));
            let size = (app * aqq).sqrt();
            if apq.abs() <= f64::EPSILON * size || size == 0.0 {
                continue;
            }
            largest = largest.max(apq.abs() / size);
            let zeta = (aqq - app) / (2.0 * apq);
            let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let c = 1.0 / t.hypot(1.0);
            let s = c * t;
            (u[p], u[q]) = (u[p] * c - u[q] * s, u[p] * s + u[q] * c);
            (v[p], v[q]) = (v[p] * c - v[q] * s, v[p] * s + v[q] * c);
        }
        if largest < 1e-15 {
            break;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| u[b].length_squared().total_cmp(&u[a].length_squared()));
    let [a, b, _] = order;
    let largest = u[a].length();
    let u0 = u[a] / largest;
    let u1 = if u[b].length() > RANK_TOLERANCE * largest {
        (u[b] - u0 * u0.dot(u[b])).normalize()
    } else {
        // Rank one: the turn about the one known axis is free; take the least.
        let across = v[b] - u0 * u0.dot(v[b]);
        if across.length() > 1e-3 { across.normalize() } else { u0.any_orthonormal_vector() }
    };
    let left = Mat3::from_cols(u0, u1, u0.cross(u1));
    let right = Mat3::from_cols(v[a], v[b], v[a].cross(v[b]));
    left * right.transpose()
}

/// Rotation vector (axis times angle, radians) of a rotation, with an angle in 0 to pi. Of the two axes of
/// half a turn, the one whose largest component is positive.
pub fn log(r: Mat3) -> Vec3 {
    let q = glam::DQuat::from_mat3(&r).normalize();
    let half = q.w.abs() < 1e-12;
    let largest = [q.x, q.y, q.z].into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let q = if (half && largest < 0.0) || (!half && q.w < 0.0) { -q } else { q };
    let (imaginary, real) = (Vec3::new(q.x, q.y, q.z), q.w);
    let sine = imaginary.length();
    if sine < 1e-12 {
        return imaginary * (2.0 / real);
    }
    imaginary * (2.0 * sine.atan2(real) / sine)
}

/// The rotation by `|omega|` radians about `omega` (Rodrigues).
pub fn exp(omega: Vec3) -> Mat3 {
    Mat3::from_quat(glam::DQuat::from_scaled_axis(omega))
}

/// `J` of `exp(omega + d) = exp(J d) exp(omega)` to first order (Bullo & Murray 1995, Proportional Derivative Control
/// on the Euclidean Group).
pub fn left_jacobian(omega: Vec3) -> Mat3 {
    let (angle, w) = (omega.length(), cross(omega));
    // Below, the series; its next terms are 1e-14.
    let (a, b) = if angle < 1e-3 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        let square = angle * angle;
        (2.0 * (0.5 * angle).sin().powi(2) / square, (angle - angle.sin()) / (square * angle))
    };
    Mat3::IDENTITY + w * a + w * w * b
}

/// Among the rotation vectors that give the same rotation as `omega`, the one nearest to
/// `reference`: `omega + 2 pi k omega / |omega|`.
pub fn nearest_branch(omega: Vec3, reference: Vec3) -> Vec3 {
    let angle = omega.length();
    if angle < 1e-12 {
        // No axis of its own: whole turns can only be about the reference.
        let turns = (reference.length() / TAU).round();
        return omega + reference.normalize_or_zero() * (turns * TAU);
    }
    let axis = omega / angle;
    axis * (angle + TAU * ((reference.dot(axis) - angle) / TAU).round())
}

/// Puts rotation vectors of angles up to pi on branches that agree with each other, in place.
///
/// Two rotations by 179 and 181 degrees are 2 degrees apart, their vectors 358. Each is taken on the
/// branch nearest to the one before it on the minimum spanning tree of relative angles (Prim 1957), which
/// grows from the identity where something is `anchored` to it, else from the least rotation.
pub fn agree(vectors: &mut [Vec3], anchored: bool) {
    let turns: Vec<glam::DQuat> = vectors.iter().map(|&v| glam::DQuat::from_scaled_axis(v)).collect();
    // How near each is to the tree, as the cosine of half the relative angle, and to what.
    let mut near: Vec<(f64, Option<Vec3>)> = turns.iter().map(|q| (q.w.abs(), None)).collect();
    let mut left: Vec<usize> = (0..vectors.len()).collect();
    let mut first = !anchored;
    while let Some(place) = (0..left.len()).max_by(|&a, &b| near[left[a]].0.total_cmp(&near[left[b]].0)) {
        let next = left.swap_remove(place);
        if let Some(reference) = near[next].1 {
            let nearest = nearest_branch(vectors[next], reference);
            // Half a turn from its reference it may be either, and stays what it is.
            if nearest.distance(reference) < vectors[next].distance(reference) - 1e-9 {
                vectors[next] = nearest;
            }
        }
        for &other in &left {
            let cosine = turns[other].dot(turns[next]).abs();
            if first || cosine > near[other].0 {
                near[other] = (cosine, Some(vectors[next]));
            }
        }
        first = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: Mat3, b: Mat3) -> f64 {
        norm_squared(a - b).sqrt()
    }

    #[test]
    fn nearest_rotation_of_nothing_is_the_identity() {
        assert_eq!(nearest_rotation(Mat3::ZERO), Mat3::IDENTITY);
        assert_eq!(nearest_rotation(Mat3::IDENTITY * f64::NAN), Mat3::IDENTITY);
        assert!(distance(nearest_rotation(Mat3::IDENTITY * 1e-300), Mat3::IDENTITY) < 1e-12);
    }

    #[test]
    fn the_left_jacobian_is_the_derivative_of_the_exponential() {
        let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        for angle in [0.0, 5e-4, 2e-3, 1.0, 3.0, 7.0] {
            for d in Vec3::AXES {
                let (omega, h) = (axis * angle, 1e-5);
                let difference = (exp(omega + d * h) - exp(omega - d * h)) * (0.5 / h);
                assert!(distance(difference, cross(left_jacobian(omega) * d) * exp(omega)) < 1e-9);
            }
        }
    }

    #[test]
    fn rotations_that_are_near_get_vectors_that_are_near() {
        let found = |degrees: &[f64], anchored: bool| -> Vec<f64> {
            let own = degrees.iter().map(|d| log(exp(Vec3::Z * d.to_radians())));
            let mut vectors: Vec<Vec3> = own.collect();
            agree(&mut vectors, anchored);
            vectors.iter().map(|v| v.z.to_degrees().round()).collect()
        };
        assert_eq!(found(&[181.0, 170.0, 189.0], true), [181.0, 170.0, 189.0]);
        assert_eq!(found(&[0.0, 220.0, 110.0, 350.0], true), [0.0, 220.0, 110.0, -10.0]);
        // What is at rest decides whether 260 degrees are 260 or -100.
        assert_eq!(found(&[90.0, 260.0], false), [90.0, 260.0]);
        assert_eq!(found(&[90.0, 260.0], true), [90.0, -100.0]);
        assert_eq!(found(&[0.0, 180.0], false), [0.0, 180.0]);
        assert_eq!(found(&[], true), [0.0; 0]);
    }

    #[test]
    fn branches_differ_by_whole_turns() {
        let axis = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        for turns in -3..=3 {
            let true_angle = 1.1 + TAU * f64::from(turns);
            let found = nearest_branch(log(exp(axis * true_angle)), axis * (true_angle + 0.4));
            assert!((found - axis * true_angle).length() < 1e-9);
        }
        let whole = nearest_branch(Vec3::ZERO, axis * (TAU + 0.1));
        assert!((whole - axis * TAU).length() < 1e-12);
    }
}
