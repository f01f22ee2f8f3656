//! Doubtful markers: those that lie where the others around them do not put them.
//!
//! ```text
//!     p(x) = sum_j a_j |x - x_j| + b + B x        p(x_j) = c_j at the markers around
//! ```
//!
//! The biharmonic spline through the markers nearest to one (Bookstein 1989, Principal Warps, in space) says where
//! that one belongs. Where this is off by much more than usual, the worst is left out, and the rest asked again,
//! since a wrong marker spoils what is said of those beside it.
//!
//! Two that are exchanged, as left and right are, bear each other out where there are few: they are found by how much
//! better all lie with the two changed back. One of a few that is quite elsewhere is found in the same way, by how well the
//! others lie without it.

use super::markers::ELSEWHERE;
use crate::Vec3;
use crate::geometry::rigid::Alignment;
use crate::linear::dense;

/// Fewer markers do not tell which of them is wrong, nor how exactly they were placed.
pub const FEWEST: usize = 10;

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

/// Two markers are exchanged where all lie within this share of how they lie else, by a similarity; of fewer markers
/// than these one is better without any.
const EXCHANGED: f64 = 0.5;
const FEWEST_EXCHANGED: usize = 6;

/// One of a few is apart where the others lie by a similarity within this share of how far it is off then; of fewer than
/// these any is.
const APART: f64 = 0.15;
const FEWEST_APART: usize = 6;

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
    let most = MOST * markers.len() as f64;
    while kept.len() >= FEWEST_EXCHANGED && (found.len() as f64) < most {
        let Some(pair) = exchanged(markers, &kept, tolerance.max(LEAST)) else { break };
        found.extend(pair);
        kept.retain(|i| pair.iter().all(|(j, _)| i != j));
    }
    if (FEWEST_APART..FEWEST).contains(&kept.len())
        && let Some((apart, by)) = apart(markers, &kept)
    {
        found.push((apart, by));
        kept.retain(|&i| i != apart);
    }
    while kept.len() >= FEWEST && (found.len() as f64) < most {
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

/// The one marker among a few `kept` without which the others lie by a similarity much better, and how far it is off: by
/// more than proportions explain.
fn apart(markers: &[(Vec3, Vec3)], kept: &[usize]) -> Option<(usize, f64)> {
    let without = |&i: &usize| {
        let others = || kept.iter().filter(|&&j| j != i).map(|&j| markers[j]);
        let fit = Alignment::of(others()).similar();
        let squares = others().map(|(from, to)| fit.apply(from).distance_squared(to)).sum::<f64>();
        let scatter = (squares / (kept.len() - 1) as f64).sqrt();
        (i, fit.apply(markers[i].0).distance(markers[i].1), scatter)
    };
    let (i, off, scatter) = kept.iter().map(without).min_by(|a, b| a.2.total_cmp(&b.2))?;
    (off > ELSEWHERE && scatter < APART * off).then_some((i, off))
}

/// The two markers among `kept` that are exchanged, and how far each is off; by more than a few times the tolerance.
fn exchanged(markers: &[(Vec3, Vec3)], kept: &[usize], tolerance: f64) -> Option<[(usize, f64); 2]> {
    let lie = |swapped: [usize; 2]| {
        let goal = |i: usize| match swapped {
            [a, b] if i == a => markers[b].1,
            [a, b] if i == b => markers[a].1,
            _ => markers[i].1,
        };
        let places = kept.iter().map(|&i| (markers[i].0, goal(i)));
        let fit = Alignment::of(places.clone()).similar();
        let squares = places.map(|(from, to)| fit.apply(from).distance_squared(to)).sum::<f64>();
        ((squares / kept.len() as f64).sqrt(), fit)
    };
    let (scatter, fit) = lie([kept[0]; 2]);
    if scatter < tolerance {
        return None;
    }
    let off = |i: usize, at: usize| fit.apply(markers[i].0).distance(markers[at].1);
    let nearer = |&(a, b): &(usize, usize)| {
        let is_far = markers[a].1.distance(markers[b].1) > TOLERANCES * tolerance;
        // Of many, the others say so at once; few may be turned by the two.
        let is_few = kept.len() <= AROUND;
        is_far && (is_few || off(a, b) < off(a, a) && off(b, a) < off(b, b))
    };
    let pairs = kept.iter().enumerate().flat_map(|(n, &a)| kept[..n].iter().map(move |&b| (b, a)));
    let swapped = pairs.filter(nearer).map(|(a, b)| (lie([a, b]), [a, b]));
    let ((least, fit), pair) = swapped.min_by(|(p, _), (q, _)| p.0.total_cmp(&q.0))?;
    (least < EXCHANGED * scatter).then(|| pair.map(|i| (i, fit.apply(markers[i].0).distance(markers[i].1))))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Markers all over a body of unit size, off by up to `amount`, which no two do alike.
    fn markers(count: usize, seed: usize, amount: f64) -> Vec<(Vec3, Vec3)> {
        let noise =
            |k: usize, c: usize| ((12.9898 * k as f64 + 78.233 * c as f64).sin() * 43758.5453).fract();
        let vector = |k: usize| Vec3::new(noise(k, 1), noise(k, 2), noise(k, 3));
        (0..count)
            .map(|i| {
                let at = vector(101 * seed + i) * 0.4;
                (at, at * 1.1 + Vec3::X + vector(977 * (seed + 1) + i) * amount)
            })
            .collect()
    }

    #[test]
    fn two_that_are_exchanged_among_few_are_found_and_no_others() {
        for seed in 0..40 {
            for count in [6, 8, 13, 21] {
                let right = markers(count, seed, 0.04);
                assert_eq!(exchanged(&right, &(0..count).collect::<Vec<_>>(), 0.01), None);
                let far = |&j: &usize| right[0].0.distance(right[j].0) > 0.3;
                let Some(other) = (1..count).find(far) else { continue };
                let mut wrong = right.clone();
                (wrong[0].1, wrong[other].1) = (right[other].1, right[0].1);
                let found: Vec<usize> = doubtful(&wrong, 0.01).markers.iter().map(|d| d.0).collect();
                assert_eq!(found, [0, other], "{seed} {count}");
            }
        }
    }

    #[test]
    fn one_of_a_few_that_is_elsewhere_is_found_and_no_other() {
        for seed in 0..40 {
            for count in 6..FEWEST {
                let mut wrong = markers(count, seed, 0.02);
                assert!(doubtful(&wrong, 0.01).markers.is_empty(), "{seed} {count}");
                let at = seed % count;
                wrong[at].1 += Vec3::new(0.15, -0.1, 0.2);
                let found: Vec<usize> = doubtful(&wrong, 0.01).markers.iter().map(|d| d.0).collect();
                assert_eq!(found, [at], "{seed} {count}");
            }
        }
    }
}
