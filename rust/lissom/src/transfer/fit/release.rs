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
//! Where the shapes differ by so much that a fit that lets go loses what the markers say, as of a cartoon ([`super::proportions`]),
//! they are followed instead, and `E_I` holds against the step before in the place of rest, as a viscous fluid does
//! (Christensen, Rabbitt & Miller 1996), which lets an eye grow to any size and still does not let it fold.

use super::doubtful::FEWEST;
use super::lie::Lie;
use super::markers::LEADING;
use super::options::FitOptions;

/// Markers that are too few to tell are so many times more exact than the tolerance: surfaces far from all of them slide.
const FEW: f64 = 2.0;

/// Least scatter of markers: faces differ by more, and it is divided by.
const LEAST_SCATTER: f64 = 1e-4;

/// How many times less than the tolerance they are off where they are followed.
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
    /// Whether `E_I` holds against the step before.
    pub is_viscous: bool,
    /// Whether borders are drawn together ([`super::look_up`]).
    pub borders: bool,
}

impl Release {
    /// Of the markers of `lie`, which may be off.
    pub fn letting_go(options: &FitOptions, lie: &Lie) -> Self {
        let tolerance = options.marker_tolerance;
        let told = (tolerance / lie.scatter.max(LEAST_SCATTER)).max(1.0);
        let points = lie.markers.iter().filter(|m| !m.is_of_curve()).count();
        if !options.modes.is_empty() || (lie.by_curves && points < LEADING) {
            // By modes and by curves it lies where it belongs before, and is to keep to that. Whether curves lead astray is
            // measured by such fits ([`super::astray`]): in those that slide a cartoon's right ones seem to.
            return Self {
                falling: 1e3,
                kept: 2e3 * told,
                within: 0.15 * tolerance * told,
                steps: 1,
                is_viscous: false,
                borders: false,
            };
        }
        Self::sliding(if points < FEWEST { FEW } else { told }, tolerance)
    }

    /// Of markers that are to be followed.
    pub fn following(options: &FitOptions) -> Self {
        Self { is_viscous: true, ..Self::sliding(TRUSTED, TRUSTED * options.marker_tolerance) }
    }

    /// By markers that lead enough by themselves it is to slide back from where those that are off have led it.
    fn sliding(trust: f64, tolerance: f64) -> Self {
        Self {
            falling: 30.0 * trust.powi(2),
            kept: 500.0 * trust.powi(2),
            within: 0.3 * tolerance,
            steps: 3,
            is_viscous: false,
            borders: false,
        }
    }
}
