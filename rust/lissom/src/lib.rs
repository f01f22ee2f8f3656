//! Pose, transfer and interpolate triangle meshes: choose a target per element, then stitch.
//!
//! # The problem
//!
//! A mesh has rest positions `v` (n vertices) and triangles `t` (m of them). Each job wants new
//! positions `x` and goes about it in the same two steps:
//!
//! 1. **choose** a target transformation `C_t` (3 x 3) for every triangle;
//! 2. **stitch**: find the positions whose gradients match the targets best,
//!
//! ```text
//!     min_x  sum_t  area_t | grad_t x - C_t (I - n n^T) |_F^2     under constraints on x
//! ```
//!
//! which is one sparse symmetric positive definite system, factored once and solved for many
//! right-hand sides ([`stitch`]). The jobs differ in how they choose:
//!
//! | job | chooses |
//! |---|---|
//! | [`pose`] | rotations that fit the current shape best, or fields spread from the handles |
//! | [`transfer`] | the gradients of the matched source triangles |
//! | [`inbetween`] | the gradients on the arc between two shapes |
//!
//! # Notation
//!
//! | | |
//! |---|---|
//! | `v_i`, `x_i`, `d_i` | rest position, new position, displacement `x_i - v_i` |
//! | `e(x)` | an edge vector `x_j - x_i` |
//! | `w_te` | half the cotangent opposite edge `e` in triangle `t` |
//! | `g_tc` | `area_t grad phi_c`: the scaled gradient of the hat function of corner `c` |
//! | `Q_t` | deformation gradient of triangle `t`, completed along the normal |
//! | `R`, `S` | rotation and stretch of a polar decomposition `Q = R S` |
//! | `L` | cotangent Laplacian, positive semidefinite: `L_ij = -sum_t w_te` |
//!
//! # Units
//!
//! Callers speak in the mesh's own units. Inside, everything is computed in *unit coordinates*, in
//! which the bounding box is centred at 0 and its diagonal is 1 ([`mesh::UnitFrame`]), so that every
//! tolerance is relative and neither huge nor tiny coordinates lose accuracy.
//!
//! # Modules
//!
//! From the ground up: [`matrix`] and [`rotation`] are the algebra of 3 x 3 matrices, [`geometry`] what is true of
//! points and triangles, whatever mesh they belong to. [`mesh`] (validated once), completed by its mirror images ([`symmetry`]), feeds [`operators`]; [`linear`] holds
//! constraints and the factorization; [`stitch`] joins the two; [`pose`], [`transfer`] and [`inbetween`] choose, by
//! their [`options`]. [`riding`] is how loose parts go with what they sit on, [`strain_limits`] keep edges from growing long, [`picture`] makes flat meshes of drawings.
//! [`job`] is progress and cancellation, [`memory`] refuses what does not fit.

#![forbid(unsafe_code)]

pub mod error;
pub mod geometry;
pub mod inbetween;
pub mod job;
pub mod linear;
pub mod matrix;
pub mod memory;
pub mod mesh;
pub mod operators;
pub mod options;
pub mod picture;
pub mod pose;
pub mod riding;
pub mod rotation;
pub mod stitch;
pub mod strain_limits;
pub mod symmetry;
pub mod transfer;

pub use error::{Error, Fault, Result};
pub use job::Job;
pub use mesh::Mesh;

/// A point or vector.
pub type Vec3 = glam::DVec3;
/// A quaternion.
pub type Quat = glam::DQuat;
/// A 3 x 3 matrix, column major.
pub type Mat3 = glam::DMat3;
/// A 4 x 4 matrix that acts on homogeneous column vectors.
pub type Mat4 = glam::DMat4;
