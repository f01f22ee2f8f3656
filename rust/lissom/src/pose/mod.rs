//! Pose a mesh by handles: some vertices are moved, some stay, the rest follow, details intact.
//!
//! [`Pose`] (`bound`) prepares a region of interest and its handles once (`region`, `handles`) and a method
//! ([`Method`], one a file; `registry` knows them by name); each solve turns the handles' motion into a [`Goal`]
//! (`goal`, `welding`, `mirrored`) and hands it to the method. Methods see a mesh that consists of the region alone, so none
//! knows of anything outside; what nobody holds follows afterwards (`unheld`), and
//! whole turns that it did not make are told (`unwound`).
//!
//! | file | chooses |
//! |---|---|
//! | [`laplacian`] | the rest pose's Laplacian coordinates, as they are |
//! | [`laplacian_fitted`] | the same, turned and scaled for each vertex as its neighbours move |
//! | [`laplacian_rotated`] | the same, turned as a first pose by [`laplacian`] says |
//! | [`rotation_invariant`] | frames that differ from their neighbours' as they did at rest |
//! | [`thin_shell`] | no detail: the displacement stretches and bends least |
//! | [`poisson`] | the handles' rotations and stretches, blended by smooth weights |
//! | [`multiresolution`] | how a smoothed base moves, by any other method |
//! | [`arap`] | the rotations that fit the current shape best, again and again |
//!
//! Handles may turn by themselves (`own_turns`): `agree` finds turns that suit all methods, and `lever` makes them
//! unknowns of `arap`. `following` spares it a solve where handles move on.

mod agree;
pub mod arap;
mod arap_descent;
mod bound;
mod field;
mod flat;
mod following;
mod goal;
mod handles;
pub mod laplacian;
pub mod laplacian_fitted;
pub mod laplacian_rotated;
mod lever;
mod method;
mod mirrored;
pub mod multiresolution;
mod own_turns;
pub mod poisson;
mod region;
mod registry;
mod responses;
mod rods;
pub mod rotation_invariant;
mod smoothing;
pub mod thin_shell;
mod unheld;
mod unwound;
mod volume;
mod welding;

pub use bound::{Info, Pose, Posed, Report};
pub use goal::{Goal, HandleMotion};
pub use handles::{Handle, Hold};
pub use method::{CommonOptions, Holding, Method, Solution, SolveOptions};
pub use region::Region;
pub use registry::{METHODS, MethodOptions};
pub use responses::{Linear, Response};
pub use unheld::Unheld;
