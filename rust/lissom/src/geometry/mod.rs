//! The ground floor: what is true of points, triangles and 3 x 3 matrices, whatever mesh they belong to.
//!
//! | file | |
//! |---|---|
//! | [`frame`] | units |
//! | [`triangle`] | areas, normals, cotangents |
//! | [`matrix`] | the algebra of 3 x 3 matrices |
//! | [`rows`], [`groups`] | items sorted by row; what hangs together |
//! | [`rigid`] | rigid and similarity maps between point sets |
//! | [`surface`] | closest points, barycentric coordinates |
//! | [`solid`] | inside and outside |

pub mod frame;
pub mod groups;
pub mod matrix;
pub mod rigid;
pub mod rows;
pub mod solid;
pub mod surface;
pub mod triangle;
