//! The contour of an alpha at a threshold, by marching squares: closed rings with the drawing to their left, those of
//! islands counterclockwise and those of holes clockwise.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::alpha::Alpha;
use crate::{Job, Result, memory};

/// Part of the way between two pixels that contours keep from either, so that no two of them touch.
const MARGIN: f64 = 0.02;

/// Pixels are repeated beyond the picture's border once, so that contours meet it at right angles, and then end.
const BEYOND: usize = 2;

/// Bytes that a step of a contour takes while it is sought.
const STEP_BYTES: u128 = 64;

/// The alpha with what is beyond its border; columns and rows are counted from `BEYOND` pixels outside it.
struct Samples<'a> {
    alpha: Alpha<'a>,
    threshold: f64,
    columns: usize,
    rows: usize,
}

impl Samples<'_> {
    fn value(&self, column: usize, row: usize) -> f64 {
        if column == 0 || row == 0 || column + 1 == self.columns || row + 1 == self.rows {
            return 0.0;
        }
        let inner = |i: usize, n: usize| i.saturating_sub(BEYOND).min(n - 1);
        let (x, y) = (inner(column, self.alpha.width), inner(row, self.alpha.height()));
        self.alpha.values[y * self.alpha.width + x]
    }

    fn inside(&self, value: f64) -> bool {
        value >= self.threshold
    }

    /// Where the contour crosses an edge of the lattice: even ones go right from a sample, odd ones down.
    fn crossing(&self, edge: u64) -> DVec2 {
        let (sample, down) = ((edge / 2) as usize, edge % 2 == 1);
        let (column, row) = (sample % self.columns, sample / self.columns);
        let from = self.value(column, row);
        let to = if down { self.value(column, row + 1) } else { self.value(column + 1, row) };
        let part = ((self.threshold - from) / (to - from)).clamp(MARGIN, 1.0 - MARGIN);
        let along = if down { DVec2::Y } else { DVec2::X } * part;
        let size = DVec2::new(self.alpha.width as f64, self.alpha.height() as f64);
        let centre = DVec2::new(column as f64, row as f64) - (BEYOND as f64 - 0.5);
        let place = (centre + along).clamp(DVec2::ZERO, size);
        DVec2::new(place.x, size.y - place.y)
    }

    /// The steps of contours through a cell, each from an edge of the lattice to another.
    fn steps(&self, column: usize, row: usize, found: &mut Vec<[u64; 2]>) {
        // Corners clockwise from the upper left, and the edge from each to the next.
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| self.value(column + x, row + y));
        let inside = corners.map(|value| self.inside(value));
        let edge = |x: usize, y: usize, down: u64| 2 * ((row + y) * self.columns + column + x) as u64 + down;
        let edges = [edge(0, 0, 0), edge(1, 0, 1), edge(0, 1, 0), edge(0, 0, 1)];
        let enters = |k: usize| !inside[k] && inside[(k + 1) % 4];
        let leaves = |k: usize| inside[k] && !inside[(k + 1) % 4];
        // Where opposite corners are inside, the middle says whether they hang together.
        let joined = self.inside(corners.iter().sum::<f64>() / 4.0);
        for from in (0..4).filter(|&k| enters(k)) {
            let around = [1, 2, 3].map(|step| (from + if joined { 4 - step } else { step }) % 4);
            if let Some(to) = around.into_iter().find(|&k| leaves(k)) {
                found.push([edges[from], edges[to]]);
            }
        }
    }
}

/// The rings, x to the right and y up in pixels, in the order in which rows from the top meet them.
pub fn contours(alpha: Alpha<'_>, threshold: f64, job: &Job) -> Result<Vec<Vec<DVec2>>> {
    let (columns, rows) = (alpha.width + 2 * BEYOND, alpha.height() + 2 * BEYOND);
    let samples = Samples { alpha, threshold, columns, rows };
    let mut steps = Vec::new();
    for row in 0..rows - 1 {
        job.check()?;
        (0..columns - 1).for_each(|column| samples.steps(column, row, &mut steps));
        memory::check("the outline", STEP_BYTES * steps.len() as u128)?;
    }
    let mut next: FxHashMap<u64, u64> = steps.iter().map(|&[from, to]| (from, to)).collect();
    let mut rings = Vec::new();
    for [start, _] in steps {
        let (mut ring, mut at) = (Vec::new(), start);
        while let Some(to) = next.remove(&at) {
            ring.push(samples.crossing(at));
            at = to;
        }
        // Those beyond the border have been moved onto it, some to the same place.
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    Ok(rings)
}
