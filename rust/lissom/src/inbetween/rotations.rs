//! The rotation of each triangle between two shapes: `Q = R S` by polar decomposition.
//!
//! Some triangles have none of their own: those without area at either end, and those that turn over
//! in a sheet that stays flat. The rotation that a surface in space gives the latter, half a turn
//! about an axis in the plane, would lift the sheet out of its plane.

use rayon::prelude::*;

use crate::geometry::triangle::normal_and_area;
use crate::operators::gradient::triangle_gradient;
use crate::{Mat3, Mesh, Vec3, rotation};

/// A triangle has no normal worth the name where its height is below this fraction of its longest
/// edge: single precision gives coordinates to 1e-7.
const NO_AREA: f64 = 1e-7;

/// A component is flat where its vertices lie within this fraction of its extent of a plane: what
/// single precision leaves of a plane.
const PLANAR: f64 = 1e-6;

/// What a triangle does between the two shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TriangleMotion {
    /// It turns by this rotation, and stretches.
    Turns(Mat3),
    /// It has no area at one end at least.
    Collapsed,
    /// It turns over within a sheet that is flat at both ends.
    Inverted,
}

impl TriangleMotion {
    pub fn rotation(self) -> Option<Mat3> {
        match self {
            Self::Turns(r) => Some(r),
            Self::Collapsed | Self::Inverted => None,
        }
    }
}

/// The motion of every triangle from `start` to `end`, given in units that share a scale.
pub(super) fn motions(mesh: &Mesh, start: &[Vec3], end: &[Vec3]) -> Vec<TriangleMotion> {
    let members = mesh.components().members();
    let sheets = [sheet_normals(mesh, &members, start), sheet_normals(mesh, &members, end)];
    mesh.triangles()
        .par_iter()
        .map(|t| {
            let [a, b] = [start, end].map(|x| t.map(|v| x[v as usize]));
            if has_no_area(a) || has_no_area(b) {
                return TriangleMotion::Collapsed;
            }
            let component = mesh.components().of_vertex(t[0] as usize);
            let sheet = component.and_then(|c| Some((sheets[0][c]?, sheets[1][c]?)));
            if let Some((m, n)) = sheet
                && (normal_and_area(a).0.dot(m) > 0.0) != (normal_and_area(b).0.dot(n) > 0.0)
            {
                return TriangleMotion::Inverted;
            }
            TriangleMotion::Turns(rotation::nearest_rotation(triangle_gradient(a, b)))
        })
        .collect()
}

fn has_no_area([a, b, c]: [Vec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() <= NO_AREA * longest
}

/// Of each component, the normal of the plane that it lies in; `None` where it is not flat.
fn sheet_normals(mesh: &Mesh, members: &[Vec<u32>], x: &[Vec3]) -> Vec<Option<Vec3>> {
    let mut normals = vec![Vec3::ZERO; members.len()];
    for t in mesh.triangles() {
        if let Some(component) = mesh.components().of_vertex(t[0] as usize) {
            let [a, b, c] = t.map(|v| x[v as usize]);
            normals[component] += (b - a).cross(c - a);
        }
    }
    let flat = |(normal, vertices): (Vec3, &Vec<u32>)| {
        let normal = normal.try_normalize()?;
        let points = || vertices.iter().map(|&v| x[v as usize]);
        let (low, high) =
            points().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let heights = points().map(|p| (p - low).dot(normal));
        let (least, most) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        (most - least <= PLANAR * (high - low).length()).then_some(normal)
    };
    normals.into_iter().zip(members).map(flat).collect()
}
