//! The ground floor: what is true of points and triangles, whatever mesh they belong to.
//!
//! | file | |
//! |---|---|
//! | [`frame`] | units |
//! | [`triangle`] | areas, normals, cotangents |
//! | [`rows`], [`groups`] | items sorted by row; what hangs together |
//! | [`rigid`] | rigid and similarity maps between point sets |
//! | [`polyline`] | paths and loops by arc length |
//! | [`plane`] | mirror images and twins |
//! | [`surface`], [`tree`], [`ray`] | closest points, barycentric coordinates, exits of rays; and how they are found |
//! | [`exposure`] | how much of the space in front of a surface is open |
//! | [`cut`] | the cheapest cut of a graph |
//! | [`boxes`] | which of many a point is near |
//! | [`body`], [`bodies`] | inside and outside; how deep |

pub mod bodies;
pub mod body;
pub mod boxes;
pub mod cut;
pub mod exposure;
pub mod frame;
pub mod groups;
pub mod plane;
pub mod polyline;
mod ray;
pub mod rigid;
pub mod rows;
pub mod surface;
mod tree;
pub mod triangle;
