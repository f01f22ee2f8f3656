//! Outlines with fewer points: one after another is left out, the least missed first, as long as no place of the
//! outline moves further than a tolerance, no tip gets sharp, and nothing crosses.
//!
//! Nothing crosses since a point goes only where the triangle that it makes with its neighbours holds no other.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;
use rustc_hash::FxHashMap;

use crate::{Job, Result};

/// Corners of the drawing are not made sharper than this: below, triangles cannot be good (Ruppert 1995).
const TIP: f64 = 60.0;

/// Steps of the tolerance in which points are told apart; among equals the shortest edges join first, so that all
/// get about as long.
const STEPS: f64 = 16.0;

/// Steps of work between two looks at the job.
const GLANCE: usize = 4096;

/// Rings in one list, of which some points are left.
struct Outlines {
    points: Vec<DVec2>,
    /// Neighbours that are left.
    before: Vec<u32>,
    after: Vec<u32>,
    gone: Vec<bool>,
    /// First point of the ring of each, and how many it had.
    ring: Vec<(u32, u32)>,
    /// Those left, by unit squares.
    squares: FxHashMap<(i32, i32), Vec<u32>>,
    tolerance: f64,
}

/// What it costs to leave a point out, and when that was found.
type Candidate = Reverse<(u64, u64, [u32; 3])>;

/// The rings without the points that are not missed.
pub fn simplified(rings: &[Vec<DVec2>], tolerance: f64, job: &Job) -> Result<Vec<Vec<DVec2>>> {
    let mut outlines = Outlines::new(rings, tolerance);
    let mut queue: BinaryHeap<Candidate> =
        (0..outlines.points.len()).filter_map(|b| outlines.candidate(b)).collect();
    let mut turn = 0;
    while let Some(Reverse((_, _, found @ [a, b, c]))) = queue.pop() {
        turn += 1;
        if turn % GLANCE == 0 {
            job.check()?;
        }
        if outlines.gone[b as usize] || outlines.around(b as usize) != found || !outlines.free(found) {
            continue;
        }
        outlines.leave_out(found);
        queue.extend([a, c].iter().filter_map(|&p| outlines.candidate(p as usize)));
    }
    let mut left = Vec::new();
    let mut first = 0;
    for ring in rings {
        let of = first..first + ring.len();
        left.push(of.clone().filter(|&p| !outlines.gone[p]).map(|p| outlines.points[p]).collect());
        first = of.end;
    }
    Ok(left)
}

impl Outlines {
    fn new(rings: &[Vec<DVec2>], tolerance: f64) -> Self {
        let points: Vec<DVec2> = rings.concat();
        let (mut before, mut after, mut ring) = (Vec::new(), Vec::new(), Vec::new());
        for of in rings {
            let (first, n) = (ring.len() as u32, of.len() as u32);
            before.extend((0..n).map(|k| first + (k + n - 1) % n));
            after.extend((0..n).map(|k| first + (k + 1) % n));
            ring.extend((0..n).map(|_| (first, n)));
        }
        let mut squares: FxHashMap<(i32, i32), Vec<u32>> = FxHashMap::default();
        for (p, point) in points.iter().enumerate() {
            squares.entry(square(*point)).or_default().push(p as u32);
        }
        Self { gone: vec![false; points.len()], points, before, after, ring, squares, tolerance }
    }

    /// A point between its neighbours.
    fn around(&self, b: usize) -> [u32; 3] {
        [self.before[b], b as u32, self.after[b]]
    }

    fn at(&self, p: u32) -> DVec2 {
        self.points[p as usize]
    }

    fn candidate(&self, b: usize) -> Option<Candidate> {
        let [a, _, c] = self.around(b);
        let (before, after) = (self.before[a as usize], self.after[c as usize]);
        // A ring keeps three points, and more than none of its area.
        if after == a || self.flat([before, a, c, after]) || self.sharper(before, a, b as u32, c) {
            return None;
        }
        if self.sharper(after, c, b as u32, a) {
            return None;
        }
        let moved = self.moved(a, c);
        let length = self.at(a).distance_squared(self.at(c));
        let key = ((STEPS * moved / self.tolerance) as u64, length.to_bits(), self.around(b));
        (moved <= self.tolerance).then_some(Reverse(key))
    }

    /// Whether a ring of these alone would have no area.
    fn flat(&self, [before, a, c, after]: [u32; 4]) -> bool {
        before == after && (self.at(a) - self.at(before)).perp_dot(self.at(c) - self.at(before)).abs() < 1e-9
    }

    /// Whether the drawing's corner at `p` would get sharp, were its edge to `old` one to `new`.
    fn sharper(&self, other: u32, p: u32, old: u32, new: u32) -> bool {
        let towards = |q: u32| self.at(q) - self.at(p);
        let inner = |q: u32| {
            // The drawing is to the left of the way from `before` to `after`.
            let (after, before) = if self.after[p as usize] == old { (q, other) } else { (other, q) };
            towards(after).angle_to(towards(before)).rem_euclid(std::f64::consts::TAU)
        };
        let angle = inner(new);
        angle < TIP.to_radians() && angle < inner(old)
    }

    /// How far the outline between two of its points goes from the straight line.
    fn moved(&self, a: u32, c: u32) -> f64 {
        let (first, count) = self.ring[a as usize];
        let (start, end) = (self.at(a), self.at(c));
        let along = end - start;
        let span = (c + count - a) % count;
        let distance = |step: u32| {
            let point = self.at(first + (a - first + step) % count) - start;
            let part = (point.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            point.distance(part * along)
        };
        (1..span).map(distance).fold(0.0, f64::max)
    }

    /// Whether no other point that is left lies in the triangle.
    fn free(&self, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|p| self.at(p));
        let ((low, high), sides) = (bounds([a.x, b.x, c.x]), [(a, b), (b, c), (c, a)]);
        let first = low.floor() as i32;
        (first..=high.floor() as i32).all(|column| {
            // Only squares that the triangle touches: long ones are thin.
            let (left, right) = (f64::from(column), f64::from(column + 1));
            let heights = sides.iter().filter_map(|&(p, q)| {
                let (p, q) = if p.x <= q.x { (p, q) } else { (q, p) };
                let at = |x: f64| if q.x > p.x { p.y + (q.y - p.y) * (x - p.x) / (q.x - p.x) } else { p.y };
                let (from, to) = (p.x.max(left), q.x.min(right));
                (from <= to).then(|| [at(from), if q.x > p.x { at(to) } else { q.y }])
            });
            let (low, high) = bounds(heights.flatten());
            (low.floor() as i32..=high.floor() as i32).all(|row| {
                let others = self.squares.get(&(column, row)).into_iter().flatten();
                others.filter(|p| !corners.contains(p)).all(|&p| !within(self.at(p), [a, b, c]))
            })
        })
    }

    fn leave_out(&mut self, [a, b, c]: [u32; 3]) {
        self.gone[b as usize] = true;
        self.after[a as usize] = c;
        self.before[c as usize] = a;
        if let Some(square) = self.squares.get_mut(&square(self.points[b as usize])) {
            square.retain(|&p| p != b);
        }
    }
}

fn square(point: DVec2) -> (i32, i32) {
    (point.x.floor() as i32, point.y.floor() as i32)
}

fn bounds(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let all = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), all)
}

/// Whether a point lies in a triangle or on its border.
fn within(point: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
    let side = |p: DVec2, q: DVec2| (q - p).perp_dot(point - p);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}
