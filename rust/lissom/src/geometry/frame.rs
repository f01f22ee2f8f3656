//! Unit coordinates.

use crate::{Error, Fault, Mat3, Result, Vec3};

/// The map between a mesh's own units and unit coordinates: box centred at 0, diagonal 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitFrame {
    /// Centre of the bounding box, in the mesh's own units.
    pub center: Vec3,
    /// Diagonal of the bounding box, in the mesh's own units.
    pub scale: f64,
}

impl UnitFrame {
    pub(crate) fn of(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self> {
        let used = triangles.iter().flatten().map(|&i| vertices[i as usize]);
        let (low, high) =
            used.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let extent = high * 0.5 - low * 0.5;
        let largest = extent.max_element();
        let scale = (extent / largest).length() * largest * 2.0;
        if largest == 0.0 {
            return Err(Error::InvalidMesh(Fault::new("vertices", "all points coincide")));
        }
        if !scale.is_finite() || !(1.0 / scale).is_finite() {
            return Err(Error::InvalidMesh(Fault::new(
                "vertices",
                "the size of the mesh is beyond the range of floating point numbers",
            )));
        }
        Ok(Self { center: low * 0.5 + high * 0.5, scale })
    }

    /// Points in the mesh's own units, turned about the centre.
    pub fn turned(self, turn: Mat3, points: &[Vec3]) -> Vec<Vec3> {
        points.iter().map(|&p| self.from_unit(turn * self.to_unit(p))).collect()
    }

    /// A point, from the mesh's own units to unit coordinates.
    pub fn to_unit(self, point: Vec3) -> Vec3 {
        (point - self.center) / self.scale
    }

    /// A point, from unit coordinates to the mesh's own units.
    pub fn from_unit(self, point: Vec3) -> Vec3 {
        point * self.scale + self.center
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_keep_huge_and_tiny_meshes_in_range() {
        for scale in [1e-300, 1e-6, 1.0, 1e20, 1e307] {
            let points = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            let frame = UnitFrame::of(&points, &[[0, 1, 2]]).unwrap();
            let unit = points.map(|p| frame.to_unit(p));
            assert!((unit[1].distance(unit[2]) - 1.0).abs() < 1e-12);
            let back = (frame.from_unit(unit[1]) - points[1]) / scale;
            assert!(back.length() <= 1e-12);
        }
    }
}
