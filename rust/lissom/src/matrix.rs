//! The algebra of 3 x 3 matrices that glam lacks.

use crate::{Mat3, Vec3};

/// `a b^T`.
#[inline]
pub fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// `[a]x`, `[a]x b = a x b`.
#[inline]
pub fn cross(a: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, a.z, -a.y), Vec3::new(-a.z, 0.0, a.x), Vec3::new(a.y, -a.x, 0.0))
}

/// `a : b = tr(a^T b)`.
#[inline]
pub fn dot(a: Mat3, b: Mat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

/// The vector `a` with `a . o = o^ : m` for every `o`, where `o^` is the matrix of the cross product by `o`.
#[inline]
pub fn axial(m: Mat3) -> Vec3 {
    Vec3::new(m.y_axis.z - m.z_axis.y, m.z_axis.x - m.x_axis.z, m.x_axis.y - m.y_axis.x)
}

/// `tr a`.
#[inline]
pub fn trace(a: Mat3) -> f64 {
    a.x_axis.x + a.y_axis.y + a.z_axis.z
}

/// `|a|_F^2`.
#[inline]
pub fn norm_squared(a: Mat3) -> f64 {
    dot(a, a)
}

/// Orthonormal, right-handed eigenvectors of a symmetric matrix, by descending eigenvalue (Jacobi 1846).
pub fn eigenvectors(mut a: Mat3) -> Mat3 {
    let mut axes = Mat3::IDENTITY;
    // Convergence is quadratic: ten sweeps leave nothing.
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(30) {
        let angle = 0.5 * (2.0 * a.col(q)[p]).atan2(a.col(q)[q] - a.col(p)[p]);
        let mut turn = Mat3::IDENTITY;
        (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (angle.cos(), angle.cos());
        (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (angle.sin(), -angle.sin());
        a = turn.transpose() * a * turn;
        axes *= turn;
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a.col(j)[j].total_cmp(&a.col(i)[i]));
    let (x, y) = (axes.col(order[0]), axes.col(order[1]));
    Mat3::from_cols(x, y, x.cross(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_those_that_a_matrix_is_made_of() {
        let turn = crate::rotation::exp(Vec3::new(0.4, -1.3, 2.0));
        for values in
            [Vec3::new(3.0, 2.0, -1.0), Vec3::new(2.0, 2.0, 1.0), Vec3::new(1.0, 1e-9, 0.0), Vec3::ZERO]
        {
            let a = turn * Mat3::from_diagonal(values) * turn.transpose();
            let axes = eigenvectors(a);
            let diagonal = axes.transpose() * a * axes;
            assert!(norm_squared(diagonal - Mat3::from_diagonal(values)) < 1e-28, "{diagonal:?}");
            assert!(norm_squared(axes.transpose() * axes - Mat3::IDENTITY) < 1e-28);
            assert!(axes.determinant() > 0.0);
        }
    }
}
