//! Sparse symmetric systems: constraints, factorization, reuse.
//!
//! [`SymmetricMatrix`] -> [`Symbolic`] (the order of elimination, reusable for every matrix of the
//! same pattern) -> [`Factor`] -> solve for any number of right-hand sides.
//! [`ConstrainedSystem`] puts hard and soft constraints around it. A [`SplitMatrix`] keeps rows apart whose products
//! would fill it.

mod apart;
mod columns;
mod constraints;
pub mod dense;
mod factor;
mod lanes;
mod matrix;
mod normal;
mod schedule;
mod substitution;
mod system;

pub use apart::{SplitMatrix, long_rows};
pub use constraints::Constraints;
pub use factor::{Factor, REGULARIZED, Symbolic};
pub use lanes::{Lanes, add_scaled, add_scaled_squares};
pub use matrix::SymmetricMatrix;
pub use normal::NormalEquations;
pub use system::ConstrainedSystem;
