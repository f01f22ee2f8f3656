//! Which unknowns are substituted side by side.
//!
//! An unknown is needed by those above it in the elimination tree alone (Liu 1990, The Role of Elimination Trees in
//! Sparse Factorization), so subtrees do not need each other: they come first, several at once, then what is above all
//! of them, and backwards the other way round. A part is some subtrees of about equal work. What it takes from the rows
//! above is summed up with the part, and handed over in the order of the parts, so that results do not depend on the
//! threads.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use rayon::prelude::*;

/// One part may have at most this fraction, one over it, of all work: what is above the parts grows with their number,
/// and waits.
const PARTS: usize = 6;

/// No slot: a row above the part.
const NONE: u32 = u32::MAX;

/// The parts of one factor, and how vectors lie in them.
#[derive(Debug)]
pub(super) struct Schedule {
    subtrees: Vec<Part>,
    top: Part,
    /// Of each place of a vector, the unknown.
    unknowns: Vec<u32>,
    /// Of each unknown, its place.
    places: Vec<u32>,
}

/// Columns of the factor with their rows, in a numbering of its own: its own unknowns, then those above.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub blocks: Vec<Block>,
    /// Below the diagonal, of all blocks.
    pub rows: Vec<u32>,
    /// Number of unknowns of its own.
    size: usize,
    /// The places in the top of the rows above.
    above: Vec<u32>,
}

/// A few columns of one pattern.
#[derive(Debug)]
pub(super) struct Block {
    /// Its unknowns.
    pub columns: Range<usize>,
    /// Among the part's rows.
    pub rows: Range<usize>,
    /// Among those of the factor.
    pub values: Range<usize>,
}

impl Schedule {
    /// Of a factor whose column `k` is unknown `unknown(k)`.
    pub fn of(symbolic: &SymbolicSupernodalCholesky<u32>, unknown: impl Fn(usize) -> u32) -> Self {
        let count = symbolic.n_supernodes();
        let columns = |s: usize| symbolic.supernode_begin()[s] as usize..symbolic.supernode_end()[s] as usize;
        let range = |ends: &[u32], s: usize| ends[s] as usize..ends[s + 1] as usize;
        let rows = |s: usize| &symbolic.row_idx()[range(symbolic.col_ptr_for_row_idx(), s)];
        let mut block_of = vec![0; symbolic.nrows()];
        (0..count).for_each(|s| columns(s).for_each(|k| block_of[k] = s));
        let parents: Vec<Option<usize>> =
            (0..count).map(|s| rows(s).iter().min().map(|&row| block_of[row as usize])).collect();
        let mut work: Vec<usize> = (0..count).map(|s| range(symbolic.col_ptr_for_val(), s).len()).collect();
        (0..count).for_each(|s| {
            if let Some(parent) = parents[s] {
                work[parent] += work[s];
            }
        });
        let roots = (0..count).filter(|&s| parents[s].is_none()).map(|s| work[s]);
        let most = roots.sum::<usize>() / PARTS;
        // Whole subtrees, some of them to a part.
        let (mut parts, mut filled): (Vec<Vec<usize>>, usize) = (Vec::new(), usize::MAX);
        let mut part_of = vec![None; count];
        for s in 0..count {
            if work[s] <= most && parents[s].is_none_or(|parent| work[parent] > most) {
                if filled.saturating_add(work[s]) > most {
                    parts.push(Vec::new());
                    filled = 0;
                }
                filled += work[s];
                part_of[s] = Some(parts.len() - 1);
            }
        }
        let mut top = Vec::new();
        for s in (0..count).rev() {
            part_of[s] = part_of[s].or_else(|| parents[s].and_then(|parent| part_of[parent]));
            part_of[s].map_or(&mut top, |part| &mut parts[part]).push(s);
        }
        let mut place_in_top = vec![NONE; symbolic.nrows()];
        let above = top.iter().rev().flat_map(|&s| columns(s));
        above.zip(0..).for_each(|(k, place)| place_in_top[k] = place);
        let mut local = vec![NONE; symbolic.nrows()];
        let mut unknowns = Vec::new();
        let mut part = |supernodes: &[usize]| {
            let mut part = Part::default();
            for &s in supernodes.iter().rev() {
                let start = part.size;
                columns(s).for_each(|k| {
                    local[k] = part.size as u32;
                    part.size += 1;
                    unknowns.push(unknown(k));
                });
                let values = range(symbolic.col_ptr_for_val(), s);
                part.blocks.push(Block { columns: start..part.size, rows: 0..0, values });
            }
            let mut met = Vec::new();
            for (block, &s) in part.blocks.iter_mut().zip(supernodes.iter().rev()) {
                let start = part.rows.len();
                for &row in rows(s) {
                    let local = &mut local[row as usize];
                    if *local == NONE {
                        *local = (part.size + part.above.len()) as u32;
                        part.above.push(place_in_top[row as usize]);
                        met.push(row);
                        unknowns.push(NONE);
                    }
                    part.rows.push(*local);
                }
                block.rows = start..part.rows.len();
            }
            met.into_iter().for_each(|row| local[row as usize] = NONE);
            part
        };
        let subtrees: Vec<Part> = parts.iter().map(|supernodes| part(supernodes)).collect();
        let top = part(&top);
        let mut places = vec![0; symbolic.nrows()];
        for (place, &unknown) in (0..).zip(&unknowns).filter(|(_, unknown)| **unknown != NONE) {
            places[unknown as usize] = place;
        }
        Self { subtrees, top, unknowns, places }
    }

    /// Of each unknown, its place in a vector.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// A vector of `of` the unknowns, zero in the rows above parts.
    pub fn vector<T: Copy + Default + Send>(&self, of: impl Fn(u32) -> T + Sync) -> Vec<T> {
        let at = |&unknown: &u32| if unknown == NONE { T::default() } else { of(unknown) };
        self.unknowns.par_iter().with_min_len(4096).map(at).collect()
    }

    /// Replaces a vector by what `forward`, then `backward` make of each part of it.
    pub fn run<T: Copy + Send + Sync>(
        &self,
        vector: &mut [T],
        add: impl Fn(T, T) -> T,
        forward: impl Fn(&Part, &mut [T]) + Sync,
        backward: impl Fn(&Part, &mut [T]) + Sync,
    ) {
        let mut rest = vector;
        let mut shares: Vec<(&Part, &mut [T])> = Vec::with_capacity(self.subtrees.len());
        for part in &self.subtrees {
            let (own, others) = rest.split_at_mut(part.size + part.above.len());
            shares.push((part, own));
            rest = others;
        }
        let top = rest;
        shares.par_iter_mut().with_max_len(1).for_each(|(part, share)| forward(part, share));
        for (part, share) in &shares {
            for (&place, &taken) in part.above.iter().zip(&share[part.size..]) {
                let above = &mut top[place as usize];
                *above = add(*above, taken);
            }
        }
        forward(&self.top, top);
        backward(&self.top, top);
        let top = &*top;
        shares.par_iter_mut().with_max_len(1).for_each(|(part, share)| {
            for (&place, above) in part.above.iter().zip(&mut share[part.size..]) {
                *above = top[place as usize];
            }
            backward(part, share);
        });
    }
}
