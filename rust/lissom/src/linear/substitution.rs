//! Substitution: `L L^T x = b` for a few columns in one pass over the factor.
//!
//! A pass reads every value of `L` once, and of a surface's factor most blocks are a few columns wide. By general
//! products of matrices such a block costs more to set up than to multiply; here four right-hand sides lie side by side,
//! one vector register, and four columns of `L` are taken at once.

use pulp::{Arch, Simd, WithSimd};

use super::schedule::{Part, Schedule};

/// Right-hand sides of one pass.
pub const LANES: usize = 4;

/// An unknown of each right-hand side.
pub type Lanes = [f64; LANES];

/// Replaces `b`, a vector of the schedule, by the solution.
pub(super) fn substitute(schedule: &Schedule, values: &[f64], b: &mut [Lanes]) {
    let arch = Arch::new();
    schedule.run(
        b,
        |x, y| std::array::from_fn(|k| x[k] + y[k]),
        |part, x| arch.dispatch(Forward { part, values, x }),
        |part, x| arch.dispatch(Backward { part, values, x }),
    );
}

/// `L y = b`
struct Forward<'a> {
    part: &'a Part,
    values: &'a [f64],
    x: &'a mut [Lanes],
}

// A closure would do, but is compiled by itself, without the instructions that it is called for.
impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
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
                    1 => eliminate::<1>(values, &mut work, first),
                    2 => eliminate::<2>(values, &mut work, first),
                    3 => eliminate::<3>(values, &mut work, first),
                    _ => eliminate::<4>(values, &mut work, first),
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
struct Backward<'a> {
    part: &'a Part,
    values: &'a [f64],
    x: &'a mut [Lanes],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
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
                    1 => substitute_back::<1>(values, &mut work, left),
                    2 => substitute_back::<2>(values, &mut work, left),
                    3 => substitute_back::<3>(values, &mut work, left),
                    _ => substitute_back::<4>(values, &mut work, left),
                };
            }
            x[block.columns.clone()].copy_from_slice(&work[..size]);
        }
    }
}

/// The next `C` columns of a block, as long as `work` each, from row `first` on.
#[inline(always)]
fn columns<const C: usize>(values: &[f64], rows: usize, first: usize) -> [&[f64]; C] {
    std::array::from_fn(|c| &values[c * rows + first..(c + 1) * rows])
}

/// Solves for unknowns `first..first + C` of a block, and takes them from what is below.
// Plain loops over arrays become vector instructions.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn eliminate<const C: usize>(values: &[f64], work: &mut [Lanes], first: usize) -> usize {
    let columns = columns::<C>(values, work.len(), first);
    let (own, below) = work[first..].split_at_mut(C);
    for c in 0..C {
        let mut x = own[c];
        for p in 0..c {
            (0..LANES).for_each(|k| x[k] -= columns[p][c] * own[p][k]);
        }
        own[c] = x.map(|x| x / columns[c][c]);
    }
    let x: [Lanes; C] = std::array::from_fn(|c| own[c]);
    let columns = columns.map(|column| &column[C..][..below.len()]);
    for (row, below) in below.iter_mut().enumerate() {
        for c in 0..C {
            (0..LANES).for_each(|k| below[k] -= columns[c][row] * x[c][k]);
        }
    }
    C
}

/// Solves for the `C` unknowns before `end` of a block, from those below.
// Plain loops over arrays become vector instructions.
#[allow(clippy::needless_range_loop)]
#[inline(always)]
fn substitute_back<const C: usize>(values: &[f64], work: &mut [Lanes], end: usize) -> usize {
    let first = end - C;
    let columns = columns::<C>(&values[first * work.len()..], work.len(), first);
    let (own, below) = work[first..].split_at_mut(C);
    let mut taken = [[0.0; LANES]; C];
    let beneath = columns.map(|column| &column[C..][..below.len()]);
    for (row, below) in below.iter().enumerate() {
        for c in 0..C {
            (0..LANES).for_each(|k| taken[c][k] += beneath[c][row] * below[k]);
        }
    }
    for c in (0..C).rev() {
        let mut x = own[c];
        for p in c + 1..C {
            (0..LANES).for_each(|k| taken[c][k] += columns[c][p] * own[p][k]);
        }
        (0..LANES).for_each(|k| x[k] = (x[k] - taken[c][k]) / columns[c][c]);
        own[c] = x;
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
