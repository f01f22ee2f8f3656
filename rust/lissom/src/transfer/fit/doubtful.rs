//! Doubtful markers: those that lie where the others around them do not put them.
//!
//! ```text
//!     p(x) = sum_j a_j |x - x_j| + b + B x        p(x_j) = c_j at the markers around
//! ```
//!
//! The biharmonic spline through the markers nearest to one (Bookstein 1989, Principal Warps, in space) says where
//! that one belongs. Where this is off by much more than usual, the worst is left out, and the rest asked again,
//! since a wrong marker spoils what is said of those beside it.

use super::markers::Marker;
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

/// ... and from so many times on what the others are off by at the median.
const MEDIANS: f64 = 4.0;

/// Most of the markers that may be left out.
const MOST: f64 = 0.2;

/// What the others say of each marker.
pub struct Doubts {
    /// The doubtful ones, and how far each is from where it is expected, in unit coordinates.
    pub markers: Vec<(usize, f64)>,
    /// How far the others are off at the median, in unit coordinates: of exact markers what differs from face to face,
    /// of others how exactly they were placed. The tolerance where they are too few to tell.
    pub scatter: f64,
}

/// Which of `markers` are doubtful, for a tolerance in unit coordinates.
pub fn doubtful(markers: &[Marker], tolerance: f64) -> Doubts {
    let mut kept: Vec<usize> = (0..markers.len()).collect();
    let (mut found, mut scatter) = (Vec::new(), tolerance);
    while kept.len() >= FEWEST && (found.len() as f64) < MOST * markers.len() as f64 {
        let off: Vec<f64> =
            kept.iter().map(|&i| markers[i].goal.distance(expected(markers, &kept, i))).collect();
        let mut sorted = off.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        scatter = sorted[sorted.len() / 2];
        let limit = (TOLERANCES * tolerance).max(MEDIANS * scatter);
        let worst = (0..kept.len()).max_by(|&a, &b| off[a].total_cmp(&off[b]));
        match worst.filter(|&w| off[w] > limit) {
            Some(worst) => found.push((kept.remove(worst), off[worst])),
            None => break,
        }
    }
    found.sort_unstable_by_key(|&(i, _)| i);
    Doubts { markers: found, scatter }
}

/// Where the others among `kept` put marker `i`.
fn expected(markers: &[Marker], kept: &[usize], i: usize) -> Vec3 {
    let at = markers[i].rest;
    let mut around: Vec<usize> = kept.iter().copied().filter(|&j| j != i).collect();
    around.sort_by(|&a, &b| markers[a].rest.distance(at).total_cmp(&markers[b].rest.distance(at)));
    around.truncate(AROUND);
    let k = around.len();
    let point = |j: usize| markers[around[j]].rest - at;
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
    let goal = |row: usize| if row < k { markers[around[row]].goal } else { Vec3::ZERO };
    let solved = dense::solve(k + 4, entry, &(0..k + 4).map(goal).collect::<Vec<_>>());
    (0..k).map(|j| solved[j] * -point(j).length()).sum::<Vec3>() + solved[k]
}
