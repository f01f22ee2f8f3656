//! Substitution: `L L^T x = b` for a few columns in one pass over the factor.
//!
//! A pass reads every value of `L` once, and of a surface's factor most blocks are a few columns wide. By general
//! products of matrices such a block costs more to set up than to multiply; here four right-hand sides lie side by side,
//! one vector register, and four columns of `L` are taken at once.

use pulp::{Arch, Simd, WithSimd};

use super::lanes::{LANES, Lanes, add_scaled};
use super::schedule::{Part, Schedule};

/// Replaces `b`, a vector of the schedule, by the solution. Of values in single precision half is read, which is what a
/// pass waits for; the arithmetic is the same.
pub(super) fn substitute<V: Value>(schedule: &Schedule, values: &[V], b: &mut [Lanes]) {
    let arch = Arch::new();
    schedule.run(
        b,
        |x, y| std::array::from_fn(|k| x[k] + y[k]),
        |part, x| arch.dispatch(Forward { part, values, x }),
        |part, x| arch.dispatch(Backward { part, values, x }),
    );
}

/// How values of the factor are kept.
pub(super) trait Value: Copy + Into<f64> + Sync {}

impl Value for f64 {}
impl Value for f32 {}

/// `L y = b`
struct Forward<'a, V> {
    part: &'a Part,
    values: &'a [V],
    x: &'a mut [Lanes],
}

// A closure would do, but is compiled by itself, without the instructions that it is called for.
impl<V: Value> WithSimd for Forward<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { part, values, x } = self;
        let mut work = Vec::new();
        for block in &part.blocks {
            let (values, rows) = (&values[block.values.clone()], &part.rows[block.rows.clone()]);
            let size = block.columns.len();
            // What the block takes from the rows below is gathered first.
            work.clear();
            work.extend_from_slice(&x[block.columns.clone()]);
            work.resize(size + rows.len(), [0.0; LANES]);
            let mut first = 0;
            while first < size {
                let values = &values[first * work.len()..];
                first += match size - first {
                    1 => eliminate::<S, V, 1>(simd, values, &mut work, first),
                    2 => eliminate::<S, V, 2>(simd, values, &mut work, first),
                    3 => eliminate::<S, V, 3>(simd, values, &mut work, first),
                    _ => eliminate::<S, V, 4>(simd, values, &mut work, first),
                };
            }
            x[block.columns.clone()].copy_from_slice(&work[..size]);
            for (&row, taken) in rows.iter().zip(&work[size..]) {
                let x = &mut x[row as usize];
                (0..LANES).for_each(|k| x[k] += taken[k]);
            }
        }
    }
}

/// `L^T x = y`
struct Backward<'a, V> {
    part: &'a Part,
    values: &'a [V],
    x: &'a mut [Lanes],
}

impl<V: Value> WithSimd for Backward<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { part, values, x } = self;
        let mut work = Vec::new();
        for block in part.blocks.iter().rev() {
            let (values, rows) = (&values[block.values.clone()], &part.rows[block.rows.clone()]);
            let size = block.columns.len();
            work.clear();
            work.extend_from_slice(&x[block.columns.clone()]);
            work.extend(rows.iter().map(|&row| x[row as usize]));
            let mut left = size;
            while left > 0 {
                left -= match left {
                    1 => substitute_back::<S, V, 1>(simd, values, &mut work, left),
                    2 => substitute_back::<S, V, 2>(simd, values, &mut work, left),
                    3 => substitute_back::<S, V, 3>(simd, values, &mut work, left),
                    _ => substitute_back::<S, V, 4>(simd, values, &mut work, left),
                };
            }
            x[block.columns.clone()].copy_from_slice(&work[..size]);
        }
    }
}

/// The next `C` columns of a block, as long as `work` each, from row `first` on.
#[inline(always)]
fn columns<const C: usize, V>(values: &[V], rows: usize, first: usize) -> [&[V]; C] {
    std::array::from_fn(|c| &values[c * rows + first..(c + 1) * rows])
}

/// Solves for unknowns `first..first + C` of a block, and takes them from what is below.
// Plain loops over arrays become vector instructions.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn eliminate<S: Simd, V: Value, const C: usize>(
    simd: S,
    values: &[V],
    work: &mut [Lanes],
    first: usize,
) -> usize {
    let columns = columns::<C, V>(values, work.len(), first);
    let (own, below) = work[first..].split_at_mut(C);
    for c in 0..C {
        let mut x = own[c];
        for p in 0..c {
            add_scaled(simd, &mut x, -columns[p][c].into(), &own[p]);
        }
        let pivot: f64 = columns[c][c].into();
        (0..LANES).for_each(|k| own[c][k] = x[k] / pivot);
    }
    let mut x = [[0.0; LANES]; C];
    x.copy_from_slice(own);
    let columns = columns.map(|column| &column[C..][..below.len()]);
    for (row, below) in below.iter_mut().enumerate() {
        for c in 0..C {
            add_scaled(simd, below, -columns[c][row].into(), &x[c]);
        }
    }
    C
}

/// Solves for the `C` unknowns before `end` of a block, from those below.
// Plain loops over arrays become vector instructions.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn substitute_back<S: Simd, V: Value, const C: usize>(
    simd: S,
    values: &[V],
    work: &mut [Lanes],
    end: usize,
) -> usize {
    let first = end - C;
    let columns = columns::<C, V>(&values[first * work.len()..], work.len(), first);
    let (own, below) = work[first..].split_at_mut(C);
    let mut left = [[0.0; LANES]; C];
    left.copy_from_slice(own);
    let beneath = columns.map(|column| &column[C..][..below.len()]);
    for (row, below) in below.iter().enumerate() {
        for c in 0..C {
            add_scaled(simd, &mut left[c], -beneath[c][row].into(), below);
        }
    }
    for c in (0..C).rev() {
        let mut x = left[c];
        for p in c + 1..C {
            add_scaled(simd, &mut x, -columns[c][p].into(), &own[p]);
        }
        let pivot: f64 = columns[c][c].into();
        (0..LANES).for_each(|k| own[c][k] = x[k] / pivot);
    }
    C
}

#[cfg(test)]
mod tests {
    use crate::linear::columns::Columns;
    use crate::linear::{Symbolic, SymmetricMatrix};

    #[test]
    fn a_few_columns_are_solved_as_each_by_itself() {
        let side = 70;
        let at = |i: u32, j: u32| i * side + j;
        let edges = (0..side - 1).flat_map(|i| (0..side - 1).map(move |j| (i, j))).flat_map(|(i, j)| {
            let own = at(i, j);
            [(own, at(i + 1, j), 1.0), (own, at(i, j + 1), 2.0), (own, at(i + 1, j + 1), 0.3)]
        });
        let size = (side * side) as usize;
        let mut matrix = SymmetricMatrix::laplacian(size, edges);
        (0..size).for_each(|row| matrix.add_to_diagonal(row, 1e-3));
        let factor = Symbolic::analyse(&matrix).unwrap().factor(&matrix).unwrap();
        for count in 2..=8 {
            let mut together = Columns::zeros(size, count);
            (0..).zip(together.data_mut()).for_each(|(k, x)| *x = f64::from(k * 7919 % 1009) / 1009.0 - 0.4);
            let given = together.clone();
            factor.solve_columns(&mut together);
            for k in 0..count {
                let mut alone = Columns::zeros(size, 1);
                alone.column_mut(0).copy_from_slice(given.column(k));
                factor.solve_columns(&mut alone);
                let size = alone.column(0).iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                for (a, b) in together.column(k).iter().zip(alone.column(0)) {
                    assert!((a - b).abs() < 1e-11 * size, "column {k} of {count}: {a} and {b}");
                }
            }
        }
    }
}
