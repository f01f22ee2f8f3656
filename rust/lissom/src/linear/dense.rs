//! Small dense systems.

use faer::Mat;
use faer::prelude::Solve;

use crate::Vec3;

/// The solution of the `n` x `n` system with entries `a(row, column)`; not finite where it has none.
pub fn solve(n: usize, a: impl Fn(usize, usize) -> f64, b: &[Vec3]) -> Vec<Vec3> {
    let solved = Mat::from_fn(n, n, a).partial_piv_lu().solve(Mat::from_fn(n, 3, |row, axis| b[row][axis]));
    (0..n).map(|row| Vec3::new(solved[(row, 0)], solved[(row, 1)], solved[(row, 2)])).collect()
}
