//! Transfer: the shapes of one mesh carried over to another of different topology.
//!
//! # The problem
//!
//! Given are a source with posed shapes, a target, and a few markers: pairs of a source vertex and a
//! target vertex that belong together. Wanted is, for every shape of the source, the like shape of
//! the target (R. W. Sumner, J. Popović, Deformation Transfer for Triangle Meshes, ACM Transactions on
//! Graphics 23(3), 2004).
//!
//! 1. **Fit** ([`fit`]): the source is pulled onto the target, led by markers or by the shapes alone, as smoothly as
//!    it goes. Triangles that come to lie on each other belong together (`matching`). This takes no key
//!    and is done once.
//! 2. **Apply** ([`apply`]): each target triangle is asked to change as its matches do (`choose`), the
//!    target is stitched ([`crate::stitch`]), and its components are put in their place (`place`).
//!
//! 3. **Learn** ([`learn`](mod@learn)): keys that an artist has corrected since teach the others.
//!
//! By the same images come weights, colours and UV maps over ([`attributes`], [`corners`]).
//!
//! # Notation
//!
//! | | |
//! |---|---|
//! | `Q_s`, `C_t` | gradient of a source triangle, target matrix of a target triangle |
//! | `E_S`, `E_I`, `E_C` | smoothness, identity and closest-point terms of the fit, with weights `w` |
//! | `c_v` | closest compatible point: the nearest whose normal is within 90 degrees (`closest`) |
//! | image | where a target vertex lies on the fitted source (`image`) |
//! | stationary | a triangle whose vertices a key does not move; a vertex of none but such matches |

pub mod alignment;
mod anchor;
pub mod apply;
pub mod attributes;
mod choose;
mod closing;
pub mod contact;
pub mod corners;
mod correspondence;
pub mod fit;
mod frames;
mod image;
pub mod learn;
mod obstacle;
mod opening;
mod options;
mod place;
pub mod quality;
mod ridges;
mod rims;
mod scale;
mod sizes;
mod symmetry;
mod tears;
#[cfg(test)]
mod testing;
mod touching;
mod verdict;

pub use apply::{Transfer, Transferred};
pub use correspondence::Correspondence;
pub use fit::{Doubtful, Fit, FitOptions, FitReport, Fitted, fit_correspondence, next_marker};
pub use image::SurfacePoint;
pub use learn::{Corrected, Learned, learn};
pub use options::{Frames, LearnOptions, Scale, TransferOptions, Unmatched, Weighting};
pub use quality::KeyQuality;
pub use verdict::Verdict;
