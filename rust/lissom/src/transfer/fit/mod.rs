//! Fit.

mod component_pairs;
mod correspond;
mod descent;
mod diagnosis;
mod doubtful;
mod energy;
mod images;
mod lie;
mod look_up;
mod markers;
mod matching;
mod options;
mod pulls;
mod registration;
mod side;

pub use correspond::fit_correspondence;
pub use diagnosis::{Fit, FitReport, STRETCHED};
pub use options::FitOptions;
