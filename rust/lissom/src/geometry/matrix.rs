//! The algebra of 3 x 3 matrices that glam lacks.

use crate::{Mat3, Vec3};

/// `a b^T`.
pub fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// `a : b = tr(a^T b)`.
pub fn dot(a: Mat3, b: Mat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

/// `tr a`.
pub fn trace(a: Mat3) -> f64 {
    a.x_axis.x + a.y_axis.y + a.z_axis.z
}

/// `|a|_F^2`.
pub fn norm_squared(a: Mat3) -> f64 {
    dot(a, a)
}
