//! What is flat and asked to stay in its plane turns in its plane.
//!
//! ```text
//!     R_i = exp(a n),      a = atan2( axial(S) . n,  tr S - n . S n )      nearest to the covariance S
//! ```
//!
//! with the plane's normal `n`. In space the rotation nearest to a flat cell that is pressed inside out is a half turn
//! about an axis in the plane: it fits the flipped cell exactly, and so the flip stays.

use super::goal::{Goal, HandleMotion};
use super::region::Region;
use crate::matrix::{axial, trace};
use crate::rotation::nearest_rotation;
use crate::{Mat3, Quat, Vec3};

/// What is out of the plane by no more, in unit coordinates, is in it: keys and drawings are in single precision.
const FLAT: f64 = 1e-6;

/// The turns that a pose may be made of: those about one axis, or all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turns {
    normal: Option<Vec3>,
}

impl Turns {
    /// Those in the plane where every triangle of the region lies along one, and every handle moves along it.
    pub fn of(region: &Region, goal: &Goal) -> Self {
        let mesh = region.mesh();
        let largest = (0..mesh.areas().len()).max_by(|&a, &b| mesh.areas()[a].total_cmp(&mesh.areas()[b]));
        let flat = largest.map(|t| mesh.normals()[t]).filter(|&n| {
            let level = |v: Vec3| v.dot(n).abs() <= FLAT;
            let turns = |turn: Vec3| turn.reject_from_normalized(n).length() <= FLAT;
            let stays = |m: &HandleMotion| turns(m.rotation) && turns(m.whole_turns);
            let edges = |[a, b, c]: &[u32; 3]| [(*a, *b), (*a, *c)];
            let rest = |v: u32| mesh.rest()[v as usize];
            mesh.triangles().iter().flat_map(edges).all(|(a, b)| level(rest(b) - rest(a)))
                && goal.displacements.iter().all(|&d| level(d))
                && goal.handles.iter().all(stays)
        });
        Self { normal: flat }
    }

    /// All.
    pub fn free() -> Self {
        Self { normal: None }
    }

    /// Whether they are those about one axis.
    pub fn are_flat(self) -> bool {
        self.normal.is_some()
    }

    /// The one nearest to a matrix.
    pub fn nearest(self, m: Mat3) -> Mat3 {
        let Some(n) = self.normal else { return nearest_rotation(m) };
        let angle = axial(m).dot(n).atan2(trace(m) - n.dot(m * n));
        if angle.is_finite() { Mat3::from_axis_angle(n, angle) } else { Mat3::IDENTITY }
    }

    /// Those nearest to rotations.
    pub fn keep(self, rotations: &mut [Quat]) {
        let Some(n) = self.normal else { return };
        for q in rotations {
            let along = n * n.dot(Vec3::new(q.x, q.y, q.z));
            let twist = Quat::from_xyzw(along.x, along.y, along.z, q.w);
            *q = if twist.length_squared() > 0.0 { twist.normalize() } else { Quat::IDENTITY };
        }
    }

    /// What of small turns is among them.
    pub fn project(self, turns: &mut [Vec3]) {
        if let Some(n) = self.normal {
            turns.iter_mut().for_each(|turn| *turn = n * n.dot(*turn));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_in_the_plane_do_not_leave_it() {
        let turns = Turns { normal: Some(Vec3::Z) };
        let own = Mat3::from_axis_angle(Vec3::Z, 2.5);
        let stretched = own * Mat3::from_diagonal(Vec3::new(2.0, 0.5, 0.0));
        assert!((turns.nearest(stretched) - own).to_cols_array().iter().all(|x| x.abs() < 1e-14));
        let flipped = turns.nearest(Mat3::from_diagonal(Vec3::new(1.0, -0.5, 0.0)));
        assert!((flipped - Mat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-14));
        assert!(turns.nearest(Mat3::ZERO).is_finite());
        let mut rotations = [
            Quat::from_axis_angle(Vec3::X, 0.3) * Quat::from_axis_angle(Vec3::Z, 1.0),
            Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        ];
        turns.keep(&mut rotations);
        assert!(rotations[0].x == 0.0 && rotations[0].y == 0.0 && rotations[1] == Quat::IDENTITY);
    }
}
