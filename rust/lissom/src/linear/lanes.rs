//! Four numbers side by side: in one register where the processor has such, in more elsewhere.
//!
//! What is called for the instructions of the processor at hand has neither closures nor iterators in its loops: these may
//! be compiled by themselves, without them.

use pulp::Simd;

/// How many they are.
pub const LANES: usize = 4;

/// The numbers.
pub type Lanes = [f64; LANES];

/// `sum += factor x`
#[allow(clippy::needless_range_loop)]
#[inline(always)]
pub fn add_scaled<S: Simd>(simd: S, sum: &mut Lanes, factor: f64, x: &Lanes) {
    let each = simd.splat_f64s(factor);
    let ((sums, last), (x, x_last)) = (S::as_mut_simd_f64s(sum), S::as_simd_f64s(x));
    for k in 0..sums.len() {
        sums[k] = simd.mul_add_e_f64s(each, x[k], sums[k]);
    }
    for k in 0..last.len() {
        last[k] += factor * x_last[k];
    }
}

/// `sum += factor x x`, number by number.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
pub fn add_scaled_squares<S: Simd>(simd: S, sum: &mut Lanes, factor: f64, x: &Lanes) {
    let each = simd.splat_f64s(factor);
    let ((sums, last), (x, x_last)) = (S::as_mut_simd_f64s(sum), S::as_simd_f64s(x));
    for k in 0..sums.len() {
        sums[k] = simd.mul_add_e_f64s(simd.mul_f64s(each, x[k]), x[k], sums[k]);
    }
    for k in 0..last.len() {
        last[k] += factor * x_last[k] * x_last[k];
    }
}
