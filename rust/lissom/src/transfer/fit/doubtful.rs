//! Doubtful markers: those that lie where the others around them do not put them.
//!
//! ```text
//!     p(x) = sum_j a_j |x - x_j| + b + B x        p(x_j) = c_j at the markers around
//! ```
//!
//! The biharmonic spline through the markers nearest to one (Bookstein 1989, Principal Warps, in space) says where
//! that one belongs. Where this is off by much more than usual, the worst is left out, and the rest asked again,
//! since a wrong marker spoils what is said of those beside it.

use crate::Vec3;
use crate::linear::dense;

/// Fewer markers do not tell which of them is wrong.
const FEWEST: usize = 10;

/// Markers around that a spline goes through.
const AROUND: usize = 20;

/// Smoothing, in unit coordinates: markers are a little off anyway.
const SMOOTHING: f64 = 0.01;

/// A marker is doubtful from so many times the tolerance on, ...
const TOLERANCES: f64 = 3.0;

/// ... and from so many times on what the others are off by at the median, over what is known of them.
const MEDIANS: f64 = 6.0;

/// A tolerance below is that of rounding, in unit coordinates.
const LEAST: f64 = 1e-3;

/// Most of the markers that may be left out.
const MOST: f64 = 0.2;

/// A marker or a curve that lies where the others do not put it.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubtful {
    /// Its number among its like.
    pub number: u32,
    /// How far it is from there, in percent of the target's diagonal.
    pub percent: f64,
    /// What the warnings say of it.
    pub warning: String,
}

/// What the others say of each marker.
pub struct Doubts {
    /// The doubtful ones, and how far each is from where it is expected, in unit coordinates.
    pub markers: Vec<(usize, f64)>,
    /// How far the others are off at the median, in unit coordinates: of exact markers what differs from face to face,
    /// of others how exactly they were placed. The tolerance where they are too few to tell.
    pub scatter: f64,
}

/// Which of `markers`, places of the source and where these belong, are doubtful, for a tolerance in unit coordinates.
pub fn doubtful(markers: &[(Vec3, Vec3)], tolerance: f64) -> Doubts {
    let mut kept: Vec<usize> = (0..markers.len()).collect();
    let (mut found, mut scatter) = (Vec::new(), tolerance);
    while kept.len() >= FEWEST && (found.len() as f64) < MOST * markers.len() as f64 {
        let all: Vec<[f64; 2]> = kept.iter().map(|&i| off(markers, &kept, i)).collect();
        let median = |which: usize| {
            let mut sorted: Vec<f64> = all.iter().map(|off| off[which]).collect();
            sorted.sort_unstable_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        scatter = median(0);
        let limits = [TOLERANCES * tolerance.max(LEAST), MEDIANS * median(1)];
        let worst = (0..kept.len()).max_by(|&a, &b| all[a][1].total_cmp(&all[b][1]));
        match worst.filter(|&w| (0..2).all(|which| all[w][which] > limits[which])) {
            Some(worst) => found.push((kept.remove(worst), all[worst][0])),
            None => break,
        }
    }
    found.sort_unstable_by_key(|&(i, _)| i);
    Doubts { markers: found, scatter }
}

/// How far marker `i` is from where the others among `kept` put it, and over what they let it vary, the root of the
/// variance of kriging (Matheron 1963): what lies outside of all others is not known by them.
fn off(markers: &[(Vec3, Vec3)], kept: &[usize], i: usize) -> [f64; 2] {
    let at = markers[i].0;
    let mut around: Vec<usize> = kept.iter().copied().filter(|&j| j != i).collect();
    around.sort_by(|&a, &b| markers[a].0.distance(at).total_cmp(&markers[b].0.distance(at)));
    around.truncate(AROUND);
    let k = around.len();
    let point = |j: usize| markers[around[j]].0 - at;
    let linear = |j: usize, c: usize| if c == 0 { 1.0 } else { point(j)[c - 1] };
    let entry = |row: usize, column: usize| match (row < k, column < k) {
        (true, true) if row == column => SMOOTHING,
        (true, true) => -point(row).distance(point(column)),
        (true, false) => linear(row, column - k),
        (false, true) => linear(column, row - k),
        // Markers in one plane leave the slope across it open: as small as it goes.
        (false, false) => {
            if row == column {
                -1e-9
            } else {
                0.0
            }
        }
    };
    // How much each of them counts in what is expected at the origin.
    let to = |row: usize| match row {
        _ if row < k => -point(row).length(),
        _ if row == k => 1.0,
        _ => 0.0,
    };
    let solved = dense::solve(k + 4, entry, &(0..k + 4).map(|row| Vec3::X * to(row)).collect::<Vec<_>>());
    let expected: Vec3 = (0..k).map(|j| markers[around[j]].1 * solved[j].x).sum();
    let variance: f64 = -(0..k + 4).map(|row| solved[row].x * to(row)).sum::<f64>();
    let off = markers[i].1.distance(expected);
    [off, off / variance.max(SMOOTHING).sqrt()]
}
