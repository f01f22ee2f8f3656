//! Small dense systems.

use faer::Mat;
use faer::prelude::Solve;

use crate::Vec3;

/// The inverse of the `n` x `n` matrix with entries `a(row, column)`, row by row; not finite where it has none.
pub fn inverse(n: usize, a: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let inverse = Mat::from_fn(n, n, a).partial_piv_lu().solve(Mat::<f64>::identity(n, n));
    (0..n * n).map(|k| inverse[(k / n, k % n)]).collect()
}

/// The solution of the `n` x `n` system with entries `a(row, column)`; not finite where it has none.
pub fn solve(n: usize, a: impl Fn(usize, usize) -> f64, b: &[Vec3]) -> Vec<Vec3> {
    let solved = Mat::from_fn(n, n, a).partial_piv_lu().solve(Mat::from_fn(n, 3, |row, axis| b[row][axis]));
    (0..n).map(|row| Vec3::new(solved[(row, 0)], solved[(row, 1)], solved[(row, 2)])).collect()
}
