//! The ground floor: what is true of points, triangles and 3 x 3 matrices, whatever mesh they belong to.
//!
//! | file | |
//! |---|---|
//! | [`frame`] | units |
//! | [`triangle`] | areas, normals, cotangents |
//! | [`matrix`] | the algebra of 3 x 3 matrices |
//! | [`rigid`] | rigid and similarity maps between point sets |
//! | [`surface`] | closest points, sides, barycentric coordinates |

pub mod frame;
pub mod matrix;
pub mod rigid;
pub mod surface;
pub mod triangle;
