//! The fewest times between which straight lines stay within a tolerance of the path.
//!
//! Playback by shape keys is a polyline in time: between keys `a` and `b` a vertex is at
//! `((b-t) x(a) + (t-a) x(b)) / (b-a)`. Its distance from `x(t)` is that of the arcs `y` (see `path`),
//! since straight lines cancel. Keys are chosen on a fine grid of times, by breadth-first search: all
//! times reachable with one segment, with two, ...; so with fewer keys on the grid it cannot be done.
//! Among the choices of that many keys, the one whose largest error is least is taken.
//!
//! A few vertices decide. The search knows only those, and takes in the worst offender of each
//! segment until no vertex of the mesh offends: what is impossible for a few is for all.

use rayon::prelude::*;

use super::path::Inbetween;
use super::sampled::{Sampled, Track, midpoint};
use crate::{Error, Fault, Job, Result, Vec3};

/// Keys lie on multiples of `1 / GRID`; a power of two, fine enough for 32 even segments.
const GRID: usize = 2048;

/// Errors are looked at on every so many grid times.
const STRIDE: usize = 2;

/// Share of the tolerance kept in hand for what interpolation and the stride do not see: up to 1/512
/// for the one, and `(keys STRIDE / GRID)^2`, 1/1024 at 32 keys, for the other.
const IN_HAND: f64 = 1.0 / 256.0;

/// The least error for a number of keys is found to within this fraction.
const EVENNESS: f64 = 0.02;

/// To find the vertices with the largest errors, a segment is looked at in so many places. The peak of a parabola is then
/// missed by 0.4 %, so all that come within a hundredth of the largest are looked at closely.
const PROBES: usize = 16;
const CLOSE: f32 = 0.99;

/// Below this fraction of the straight line's error there is no telling errors from rounding.
const NOTHING: f64 = 1e-9;

/// Times for keys, and how well straight lines between them follow the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyframes {
    /// Ascending, with 0 and 1.
    pub times: Vec<f64>,
    /// Largest distance of any vertex at any time from the path, in the mesh's own units.
    pub error: f64,
    /// Whether more keys would have been needed.
    pub warnings: Vec<String>,
}

impl Inbetween {
    /// The fewest times, with 0 and 1 among them, whose straight-line playback stays within
    /// `tolerance` (in the mesh's own units) of the path at every vertex and time.
    ///
    /// Where `max_keys` do not suffice, the `max_keys` times with the least error, and a warning.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a tolerance that is not positive or fewer than two keys,
    /// [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn keyframes(&self, tolerance: f64, max_keys: usize, job: &Job) -> Result<Keyframes> {
        let invalid = |argument, problem: &str| Err(Error::InvalidValue(Fault::new(argument, problem)));
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return invalid("tolerance", "not a positive number");
        }
        if max_keys < 2 {
            return invalid("max_keys", "less than 2: both ends are keys");
        }
        let sampled = self.sampled(|_| Some(tolerance), job)?;
        let found = search(&sampled.tracks, Some(tolerance * (1.0 - IN_HAND)), max_keys, job)?;
        let error = found.error + sampled.unseen;
        let warnings = match found.enough {
            true if error <= tolerance => Vec::new(),
            true => vec![format!("tolerance: the path changes too fast to be sure of less than {error:.3e}")],
            false => vec![format!("max_keys: {max_keys} keys leave an error of {error:.3e}")],
        };
        Ok(Keyframes { times: found.times, error, warnings })
    }

    /// The `count` times, with 0 and 1 among them, whose straight-line playback has the least error; fewer where they do as
    /// well. Of a path that is straight to single precision these are 0 and 1: the rest is rounding.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for fewer than two keys, [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn keyframes_by_count(&self, count: usize, job: &Job) -> Result<Keyframes> {
        if count < 2 {
            return Err(Error::InvalidValue(Fault::new("count", "less than 2: both ends are keys")));
        }
        self.sampled_for(count, job)?.keyframes(count, job)
    }
}

impl Sampled {
    /// The `count` times with the least error, or fewer.
    pub fn keyframes(&self, count: usize, job: &Job) -> Result<Keyframes> {
        let found = search(&self.tracks, None, count, job)?;
        Ok(Keyframes { times: found.times, error: found.error + self.unseen, warnings: Vec::new() })
    }
}

/// What a search found, and whether it kept the tolerance.
struct Found {
    times: Vec<f64>,
    error: f64,
    enough: bool,
}

/// The fewest keys, at most `most`, that keep all tracks within `aim`, or the `most` keys with the least error.
fn search(tracks: &[Track], aim: Option<f64>, most: usize, job: &Job) -> Result<Found> {
    let size = |track: &Track| track.iter().map(|y| y.length_squared()).fold(0.0, f64::max);
    let farthest = tracks.par_iter().enumerate().map(|(i, track)| (size(track), i));
    let Some((_, farthest)) = farthest.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Ok(Found { times: vec![0.0, 1.0], error: 0.0, enough: true });
    };
    let mut known = vec![farthest];
    loop {
        job.check()?;
        let few: Vec<Track> = known.iter().map(|&i| refined(&tracks[i])).collect();
        let enough = match aim {
            Some(aim) => fewest(&few, aim, most, job)?,
            None => None,
        };
        let (keys, least) = evenly(&few, enough.as_ref().map_or(most, Vec::len), job)?;
        let allowed = match (aim, &enough) {
            (Some(aim), Some(_)) => aim,
            _ => least * (1.0 + EVENNESS),
        };
        let worst = worst(tracks, &keys);
        let offenders = worst.iter().filter(|(error, i)| *error > allowed && !known.contains(i));
        let mut offenders: Vec<usize> = offenders.map(|&(_, i)| i).collect();
        offenders.sort_unstable();
        offenders.dedup();
        if offenders.is_empty() {
            let error = worst.iter().fold(0.0, |e: f64, w| e.max(w.0));
            let times = keys.into_iter().map(|k| k as f64 / GRID as f64).collect();
            return Ok(Found { times, error, enough: enough.is_some() });
        }
        known.extend(offenders);
    }
}

/// A track on the grid.
fn refined(track: &Track) -> Track {
    let mut fine = track.clone();
    while fine.len() <= GRID {
        let steps = fine.len() - 1;
        let between: Vec<Vec3> = (0..steps).map(|k| midpoint(steps, k, |i| fine[i])).collect();
        fine = (0..=2 * steps).map(|i| if i % 2 == 0 { fine[i / 2] } else { between[i / 2] }).collect();
    }
    fine
}

/// Squared distance at grid time `s` between the track and its chord from `a` to `b`.
fn error_squared(track: &Track, a: usize, b: usize, s: usize) -> f64 {
    let share = (s - a) as f64 / (b - a) as f64;
    track[a].lerp(track[b], share).distance_squared(track[s])
}

/// The grid times between two keys at which errors are looked at.
fn between(a: usize, b: usize) -> impl Iterator<Item = usize> {
    (a + 1..b).step_by(STRIDE)
}

/// The fewest keys, as grid times, that keep `tracks` within `tolerance`; `None` if more than `most`.
fn fewest(tracks: &[Track], tolerance: f64, most: usize, job: &Job) -> Result<Option<Vec<usize>>> {
    let limit = tolerance * tolerance;
    let good = |a: usize, b: usize, s: usize| tracks.iter().all(|y| error_squared(y, a, b, s) <= limit);
    // The middle first: where a chord is too long, it shows there.
    let fits = |a: usize, b: usize| good(a, b, a.midpoint(b)) && between(a, b).all(|s| good(a, b, s));

    let mut from = vec![None; GRID + 1];
    let mut level = vec![0];
    for _ in 1..most {
        job.check()?;
        let reached: Vec<(usize, usize)> = (1..=GRID)
            .into_par_iter()
            .filter(|&b| from[b].is_none())
            .filter_map(|b| level.iter().find(|&&a| a < b && fits(a, b)).map(|&a| (a, b)))
            .collect();
        for &(a, b) in &reached {
            from[b] = Some(a);
        }
        if from[GRID].is_some() {
            let mut keys = vec![GRID];
            while let Some(a) = from[keys[keys.len() - 1]] {
                keys.push(a);
            }
            keys.reverse();
            return Ok(Some(keys));
        }
        level = reached.into_iter().map(|(_, b)| b).collect();
    }
    Ok(None)
}

/// The choice of `count` keys whose largest error over `tracks` is least, and that error, both
/// to within [`EVENNESS`].
fn evenly(tracks: &[Track], count: usize, job: &Job) -> Result<(Vec<usize>, f64)> {
    let chord = tracks.iter().flat_map(|y| between(0, GRID).map(|s| error_squared(y, 0, GRID, s)));
    let straight = chord.fold(0.0, f64::max).sqrt();
    let (mut low, mut high) = (0.0, straight);
    let mut best = vec![0, GRID];
    while high > low * (1.0 + EVENNESS) && high > NOTHING * straight {
        // Errors fall by powers as keys are added: halve the exponent, once it is known from where.
        let middle = if low > 0.0 { f64::sqrt(low * high) } else { high / 4.0 };
        match fewest(tracks, middle, count, job)? {
            Some(keys) => (best, high) = (keys, middle),
            None => low = middle,
        }
    }
    Ok((best, high))
}

/// The largest error of each segment, and the track that has it.
fn worst(tracks: &[Track], keys: &[usize]) -> Vec<(f64, usize)> {
    let segments = keys.len() - 1;
    let grid = |k: usize| k as f64 / GRID as f64;
    // At a few times each, to know which tracks to look at.
    let errors: Vec<Vec<f32>> = (tracks.par_iter())
        .map(|track| {
            let at_keys: Vec<Vec3> = keys.iter().map(|&k| cubic(track, grid(k))).collect();
            let error = |k: usize| {
                let probe = |i: usize| {
                    let share = i as f64 / (PROBES + 1) as f64;
                    let t = grid(keys[k]) * (1.0 - share) + grid(keys[k + 1]) * share;
                    at_keys[k].lerp(at_keys[k + 1], share).distance_squared(cubic(track, t))
                };
                (1..=PROBES).map(probe).fold(0.0, f64::max).sqrt() as f32
            };
            (0..segments).map(error).collect()
        })
        .collect();
    let largest: Vec<f32> =
        (0..segments).map(|k| errors.iter().map(|of| of[k]).fold(0.0, f32::max)).collect();
    let close = |of: &[f32]| (0..segments).any(|k| of[k] >= CLOSE * largest[k]);
    let candidates: Vec<usize> = (0..tracks.len()).filter(|&i| close(&errors[i])).collect();

    let none = || vec![(0.0, 0); segments];
    let larger = |a: (f64, usize), b: (f64, usize)| if b.0 > a.0 { b } else { a };
    let errors = candidates.par_iter().fold(none, |mut errors, &i| {
        let track = refined(&tracks[i]);
        for (error, key) in errors.iter_mut().zip(keys.windows(2)) {
            let here = between(key[0], key[1]).map(|s| error_squared(&track, key[0], key[1], s));
            *error = larger(*error, (here.fold(0.0, f64::max), i));
        }
        errors
    });
    let all = errors.reduce(none, |a, b| a.into_iter().zip(b).map(|(a, b)| larger(a, b)).collect());
    all.into_iter().map(|(squared, i)| (squared.sqrt(), i)).collect()
}

/// The track at time `t`, by the cubic through the four nearest steps.
fn cubic(track: &Track, t: f64) -> Vec3 {
    let steps = track.len() - 1;
    let first = ((t * steps as f64) as usize).saturating_sub(1).min(steps - 3);
    let s = t * steps as f64 - first as f64;
    let (a, b, c) = (s - 1.0, s - 2.0, s - 3.0);
    track[first] * (-a * b * c / 6.0)
        + track[first + 1] * (s * b * c / 2.0)
        + track[first + 2] * (-s * a * c / 2.0)
        + track[first + 3] * (s * a * b / 6.0)
}
