//! Image: where a point of one mesh lies on the other, once that is fitted.
//!
//! A target triangle has an image on the source's surface, at rest and in every key, and changes as that
//! does; so keys come over vertex by vertex, however finely either mesh is cut. (Sumner & Popović 2004 pair whole
//! triangles by their centroids, which shifts every key by up to half a triangle.)

use super::symmetry::Twins;
use crate::geometry::triangle::interpolate;
use crate::{Mesh, Vec3};

/// A point of the source's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The source triangle, as the input of the mesh counts them.
    pub triangle: u32,
    /// How much each of its corners counts; they add up to 1.
    pub weights: Vec3,
}

/// The image of a vertex of the target, in use.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// The source triangle that it is on.
    pub triangle: u32,
    /// Its corners.
    pub corners: [u32; 3],
    /// How much each counts.
    pub weights: Vec3,
    /// On a source and a target that are symmetric, the twins of the corners of the image of its twin, and their
    /// weights: the mean of both is symmetric ([`super::symmetry`]).
    mirrored: Option<([u32; 3], Vec3)>,
}

impl Image {
    /// At a point of `source`.
    pub fn on(source: &Mesh, SurfacePoint { triangle, weights }: SurfacePoint) -> Self {
        Self { triangle, corners: source.triangles()[triangle as usize], weights, mirrored: None }
    }

    /// What values at the source's vertices are there.
    pub fn interpolate(&self, value: impl Fn(u32) -> Vec3) -> Vec3 {
        let of = |corners: [u32; 3], weights: Vec3| interpolate(corners.map(&value), weights);
        let own = of(self.corners, self.weights);
        self.mirrored.map_or(own, |(corners, weights)| (own + of(corners, weights)) * 0.5)
    }
}

/// `images` of the target's vertices that are the same left and right, where those of twins are complete.
pub fn mirrored(images: &[Option<Image>], twins: &Twins) -> Vec<Option<Image>> {
    let mirror = |(v, image): (usize, &Option<Image>)| {
        let image = (*image)?;
        let of_twin = || images[twins.vertices[1][v]? as usize];
        let mirrored = of_twin().and_then(|twin| {
            twins.of_corners(image.corners)?;
            Some((twins.of_corners(twin.corners)?, twin.weights))
        });
        Some(Image { mirrored, ..image })
    };
    images.iter().enumerate().map(mirror).collect()
}
