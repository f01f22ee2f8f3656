//! Fit: pull the source onto the target, then read off what belongs together.
//!
//! After Sumner & Popović 2004, section 4; what differs is said where it does.
//!
//! 0. Faces that look the wrong way are turned for the fit (`facing`).
//! 1. How the source *lies* on the target, by its markers and curves less the `doubtful` ones, or by the shapes alone
//!    (`marked`: `markers`, `curves`, `doubtful`, `lie`, [`super::alignment`]).
//! 2. *Registration*: an energy that keeps the change smooth (`energy`) and pulls to where the source ought to be
//!    (`pulls`, `look_up`), step by step (`registration`, `descent`), while the markers let go (`release`) or,
//!    where `proportions` differ, are followed; of a large source on a `coarse` one at first; once more where curves turn out
//!    to lead `astray`.
//! 3. *Diagnosis*: which triangles match, where vertices lie on the other mesh, and how good it is (`matching`,
//!    `images`, `component_pairs`, `diagnosis`).
//!
//! Meshes of the same triangles (`same`), and those that lie on each other as they are (`overlap`), go without 1 and 2.
//!
//! `correspond` goes through them in turn. A `side` is one of the two meshes, with what of it takes part.

mod astray;
mod coarse;
mod component_pairs;
mod correspond;
mod curves;
mod descent;
mod diagnosis;
mod doubtful;
mod energy;
mod facing;
mod images;
mod lie;
mod look_up;
mod marked;
mod markers;
mod matching;
mod morph;
mod options;
mod overlap;
mod proportions;
mod pulls;
mod registration;
mod release;
mod same;
mod side;
mod suggest;

pub use correspond::fit_correspondence;
pub use diagnosis::{DISTORTED, Fit, FitReport};
pub use doubtful::Doubtful;
pub use options::FitOptions;
pub use suggest::{Fitted, next_marker};
