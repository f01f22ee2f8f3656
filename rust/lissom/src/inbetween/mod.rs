//! As-rigid-as-possible in-betweens of two shapes of one mesh.
//!
//! # The problem
//!
//! Between `start` and `end` every triangle turns by a rotation `R` and stretches by `S`, its gradient
//! being `Q = R S`. On the way it shall have turned by `R(t)`, a part of the way from `I` to `R`, and
//! stretched by `(1-t) I + t S` (Alexa, Cohen-Or & Levin 2000, As-Rigid-As-Possible Shape
//! Interpolation). Applied to an edge `e`, and with `S = R^T Q`, that is
//!
//! ```text
//!     c_te(t) = (1-t) R_t(t) e(start)  +  t R_t(t) R_t(1)^T e(end)
//! ```
//!
//! the edge at the start turned forward, blended with the edge at the end turned back: the same
//! seen from either end, defined for triangles without area, and exact at both ends. The
//! positions are stitched:
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - c_te(t) |^2
//! ```
//!
//! with `w_te` the mean of the half cotangents at both ends, which weighs by area at either.
//!
//! # The steps
//!
//! | file | |
//! |---|---|
//! | `rotations` | `R_t`: the polar decomposition of each triangle's gradient |
//! | `turn` | one rotation over time: its axis, whole turns, half a turn |
//! | `neighbours` | the dual graph: how far triangles turn against those beside them |
//! | `branches` | `R_t(t)`: which logarithm of `R_t`, so that neighbours turn together |
//! | `relative` | `R_t(t)` from the rotations between neighbours instead |
//! | `stretch` | `S(t)`: in equal steps or by equal factors |
//! | `shapes` | the shapes, prepared; what their triangles ask for stitched |
//! | `refit` | rotations fitted to the shape that came out |
//! | `path` | `x(t)`: all of these at a time |
//! | `screw` | where components go that nothing holds |
//! | `riders` | and those that sit on others: with them |
//! | `volume`, `clearance` | the volume kept, an obstacle respected |
//! | `keyframes` | the fewest times between which a straight line will do |
//! | `route` | a path through several shapes |
//! | `blend` | several shapes at once |
//!
//! Vertices in the same place at both ends stay there exactly, those that single precision moves go straight;
//! a connected component without such a vertex turns about the axis of its rigid motion (`screw`), or rides on a larger
//! one that it keeps its place on (`riders`).

mod blend;
mod branches;
mod clearance;
mod keyframes;
mod neighbours;
mod options;
mod path;
mod refit;
mod relative;
mod riders;
mod rotations;
mod route;
mod sampled;
mod screw;
mod shapes;
mod stretch;
mod turn;

pub use blend::Blend;
pub use keyframes::Keyframes;
pub use options::{BlendOptions, InbetweenOptions, Rotation};
pub use path::Inbetween;
pub use route::Route;
pub use stretch::Stretch;

#[cfg(test)]
mod tests;
