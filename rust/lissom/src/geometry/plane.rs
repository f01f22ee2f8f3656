//! Planes, mirror images across them, and points that are each other's.

use rayon::prelude::*;

use super::surface::Surface;
use crate::matrix::outer;
use crate::{Error, Fault, Mat3, Result, Vec3};

/// Normals are at right angles where the cosine between them is below this.
const RIGHT_ANGLE: f64 = 1e-6;

/// A plane that mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point on it.
    pub point: Vec3,
    /// Its unit normal.
    pub normal: Vec3,
}

impl Plane {
    /// A plane by a point and a normal of any length; `None` where they are not finite or there is no direction.
    pub fn new(point: Vec3, normal: Vec3) -> Option<Self> {
        let largest = normal.abs().max_element();
        // Quotients, so that a normal along an axis is that to the last bit.
        let normal = normal / largest;
        let plane = Self { point, normal: normal / normal.length() };
        (largest > 0.0 && point.is_finite() && plane.normal.is_finite()).then_some(plane)
    }

    /// The plane through the origin across an axis.
    pub fn across(axis: usize) -> Self {
        Self { point: Vec3::ZERO, normal: Vec3::AXES[axis] }
    }

    /// How far a point is on the normal's side.
    pub fn height(&self, point: Vec3) -> f64 {
        self.normal.dot(point - self.point)
    }

    /// The mirror image of a point.
    pub fn image(&self, point: Vec3) -> Vec3 {
        point - self.normal * (2.0 * self.height(point))
    }

    /// The mirror image of a vector.
    pub fn reflect(&self, vector: Vec3) -> Vec3 {
        vector - self.normal * (2.0 * self.normal.dot(vector))
    }

    /// The part of a vector along the plane.
    pub fn tangential(&self, vector: Vec3) -> Vec3 {
        vector - self.normal * self.normal.dot(vector)
    }

    /// [`Plane::reflect`] as a matrix.
    pub fn matrix(&self) -> Mat3 {
        Mat3::IDENTITY - outer(self.normal, self.normal) * 2.0
    }
}

/// Refuses planes that are not at right angles to each other: mirrored in turn they would not give the same few images.
///
/// # Errors
///
/// [`Error::InvalidValue`], which names the argument and the first plane that is not.
pub fn expect_perpendicular(argument: &str, planes: &[Plane]) -> Result<()> {
    let askew = |&k: &usize| planes[..k].iter().any(|p| p.normal.dot(planes[k].normal).abs() > RIGHT_ANGLE);
    let problem = "planes must be at right angles to each other";
    let fault = Fault::at(argument, problem, (1..planes.len()).filter(askew));
    fault.map_or(Ok(()), |fault| Err(Error::InvalidValue(fault)))
}

/// Points to be looked up by [`nearest`].
pub fn tree(points: &[Vec3]) -> Surface {
    Surface::new(points.iter().map(|&p| [p; 3]).collect())
}

/// The point of a [`tree`] that is nearest to another, within a distance.
pub fn nearest(tree: &Surface, point: Vec3, within: f64) -> Option<usize> {
    tree.closest_centroid(point).filter(|hit| hit.distance <= within).map(|hit| hit.triangle)
}

/// For each of the points of a [`tree`] its *twin*: the nearest to its mirror image, within a distance, and the other way
/// round. A point on the plane is its own.
pub fn twins(tree: &Surface, points: &[Vec3], plane: &Plane, within: f64) -> Vec<Option<u32>> {
    let found: Vec<Option<usize>> =
        points.par_iter().map(|&p| nearest(tree, plane.image(p), within)).collect();
    let mutual = |(i, twin): (usize, &Option<usize>)| twin.filter(|&j| found[j] == Some(i)).map(|j| j as u32);
    found.iter().enumerate().map(mutual).collect()
}
