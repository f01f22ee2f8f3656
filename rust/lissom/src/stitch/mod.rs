//! Stitch: from target matrices to positions. What every chooser shares.
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - C_te s_te |^2      x given at fixed vertices
//! ```
//!
//! Choosers differ in who owns the matrices ([`Owners`]) and in the edges `s` that these act on ([`Reference`]):
//! those of the rest pose, or others. With `w_te` half the cotangent opposite the edge and a matrix per triangle
//! this *is* `sum_t area_t |grad_t x - C_t (I - n n^T)|^2` (Botsch, Sumner, Pauly & Gross 2006, Deformation Transfer
//! for Detail-Preserving Surface Editing): the fourth vertices of Sumner & Popović (2004) drop out exactly.
//!
//! *Global step.* The unknown is the displacement `d` from a base, in most cases the rest pose. The normal equations
//! are `L d = div (C - I)`, so where nothing is asked for, nothing moves, to the last bit. All matrices here are
//! such *changes* `C - I`.
//!
//! *Local step.* For given positions the energy is `const - 2 sum C : cov(x)`, where the covariances are the adjoint
//! of the divergence, `<div C, x> = sum C : cov(x)`. The best rotations are those nearest to them.
//!
//! Both are steps down the same energy, which [`refine()`] takes with an eye on the last ones; either the shape is what
//! it moves, or the rotations of the vertices.

mod differences;
mod fans;
mod lbfgs;
mod refine;
mod stitcher;
mod targets;
mod triangles;
mod turns;
mod vectors;
mod volume;

pub use differences::Differences;
pub use refine::{Descent, Refined, Stop, refine};
pub use stitcher::Stitcher;
pub use targets::{HatGradients, Local, Owners, Reference, Weights, edge_weights};
pub use turns::{AtRest, Turning, turned, turned_less};
pub use volume::Volumes;
