//! Image: where a point of one mesh lies on the other, once that is fitted.
//!
//! A target triangle has an image on the source's surface, at rest and in every key, and changes as that
//! does; so keys come over vertex by vertex, however finely either mesh is cut. (Sumner & Popović 2004 pair whole
//! triangles by their centroids, which shifts every key by up to half a triangle.)

use crate::Vec3;

/// A point of the source's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The source triangle, as the input of the mesh counts them.
    pub triangle: u32,
    /// How much each of its corners counts; they add up to 1.
    pub weights: Vec3,
}

impl SurfacePoint {
    /// What `values` at the corners of the triangle are at this point.
    pub fn blend(&self, values: [Vec3; 3]) -> Vec3 {
        values[0] * self.weights.x + values[1] * self.weights.y + values[2] * self.weights.z
    }
}
