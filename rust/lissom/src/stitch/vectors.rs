//! Sums of one vector per vertex.

use rayon::prelude::*;

use crate::Vec3;

/// Vectors are worked on in blocks of this size, so that sums do not depend on the threads.
pub(super) const BLOCK: usize = 4096;

/// `a.b`, summed in blocks.
pub(super) fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let blocks: Vec<f64> = (a.par_chunks(BLOCK).zip(b.par_chunks(BLOCK)))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum())
        .collect();
    blocks.iter().sum()
}

/// `a += factor b`.
pub(super) fn add(a: &mut [Vec3], factor: f64, b: &[Vec3]) {
    a.par_iter_mut().zip(b).with_min_len(BLOCK).for_each(|(a, b)| *a += *b * factor);
}

/// `from + length * direction`.
pub(super) fn moved(from: &[Vec3], direction: &[Vec3], length: f64) -> Vec<Vec3> {
    let along = |(x, d): (&Vec3, &Vec3)| *x + *d * length;
    from.par_iter().zip(direction).with_min_len(BLOCK).map(along).collect()
}
