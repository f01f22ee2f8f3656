//! Release: how markers let go while the surfaces take over.
//!
//! ```text
//!     w_M = p falling (1 - t)^2, at least p kept mu        mu = (1 + (|x - c| / s)^2)^-2
//! ```
//!
//! In the end a marker counts by how near the fit has come to it, within a fraction `s` of the tolerance (Geman & McClure
//! 1987): one that is exact holds, one that is off lets go. How exactly they were placed they say themselves, by their
//! scatter ([`super::doubtful`]): `p` is one over its square, in tolerances, as in least squares of unequal precision
//! (Gauss 1823).
//!
//! Where they scatter by so much more than the tolerance that this does not explain it, the shapes differ by that much, as a
//! cartoon's do: the markers are trusted, and `E_I` holds against the step before in the place of rest, as a viscous fluid
//! does (Christensen, Rabbitt & Miller 1996), which lets an eye grow to any size and still does not let it fold.

use super::doubtful::FEWEST;
use super::lie::Lie;
use super::markers::PROPORTIONS;
use super::options::FitOptions;

/// Markers that are too few to tell are so many times more exact than the tolerance: surfaces far from all of them slide.
const FEW: f64 = 2.0;

/// Least scatter of markers: faces differ by more, and it is divided by.
const LEAST_SCATTER: f64 = 1e-4;

/// Markers that scatter by more tolerances than this are not off by what they may be: the shapes differ so much.
const EXPLAINED: f64 = 2.5;

/// How many times less than the tolerance their scatter is then taken to be.
const TRUSTED: f64 = 10.0;

/// See above.
pub struct Release {
    /// What `w_M` falls from, to 0 by the last step but one, with a square.
    pub falling: f64,
    /// What it comes to, times `mu`.
    pub kept: f64,
    /// `s`, in the target's unit coordinates.
    pub within: f64,
    /// Steps of the descent a look-up: with one the surface creeps, and keeps to where it was led.
    pub steps: usize,
    /// Whether the shapes differ by what the markers scatter.
    pub is_of_other_proportions: bool,
}

impl Release {
    /// Of the markers of `lie`.
    pub fn of(options: &FitOptions, lie: &Lie) -> Self {
        let (tolerance, scatter) = (options.marker_tolerance, lie.scatter);
        let is_of_other_proportions = (EXPLAINED * tolerance..PROPORTIONS).contains(&scatter);
        let told = (tolerance / scatter.max(LEAST_SCATTER)).max(1.0);
        let trust = if is_of_other_proportions { TRUSTED } else { told };
        if !options.modes.is_empty() || lie.by_curves {
            // By modes and by curves it lies where it belongs before, and is to keep to that. Whether curves lead astray is
            // measured by such fits ([`super::astray`]): in those that slide a cartoon's right ones seem to.
            return Self {
                falling: 1e3,
                kept: 2e3 * trust,
                within: 0.15 * tolerance * trust,
                steps: 1,
                is_of_other_proportions,
            };
        }
        // By markers alone it is to slide back from where those that are off have led it.
        let trust = if lie.markers.len() < FEWEST && !is_of_other_proportions { FEW } else { trust };
        let wide = if is_of_other_proportions { TRUSTED } else { 1.0 };
        Self {
            falling: 30.0 * trust.powi(2),
            kept: 500.0 * trust.powi(2),
            within: 0.3 * tolerance * wide,
            steps: 3,
            is_of_other_proportions,
        }
    }
}
