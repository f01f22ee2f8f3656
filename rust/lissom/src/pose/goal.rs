//! Where the handles ask the region to go: displacements of single vertices, and the motion of each handle as a whole.
//!
//! A matrix says of its rotation only what is left after whole turns. Those come from the caller, or from the
//! other handles ([`agree`]).

use std::f64::consts::{PI, TAU};

use crate::mesh::{Plane, UnitFrame};
use crate::rotation::{agree, exp, log, nearest_branch, nearest_rotation, polar};
use crate::{Mat3, Mat4, Vec3};

/// Where the handles ask the region to go, in unit coordinates of the region's mesh.
#[derive(Debug, Clone)]
pub struct Goal {
    /// Displacement of every vertex that is given or pulled; zero elsewhere.
    pub displacements: Vec<Vec3>,
    /// HandleMotion of every handle.
    pub handles: Vec<HandleMotion>,
    /// Whether the displacements are those of the handles' affine motions, and not of single points.
    pub affine: bool,
    /// The handles that the method may turn further, and the point that each turns about, where it goes.
    pub pivots: Vec<(usize, Vec3)>,
}

/// How a handle moves as a whole.
#[derive(Debug, Clone, Copy)]
pub struct HandleMotion {
    /// Rotation vector: axis times angle, with whole turns.
    pub rotation: Vec3,
    /// Whole turns about another axis, before `rotation`; zero where that tells all.
    pub whole_turns: Vec3,
    /// The linear part, `R S`.
    pub linear: Mat3,
    /// Displacement of the origin of unit coordinates.
    pub offset: Vec3,
}

impl HandleMotion {
    /// Displacement of a point.
    pub(super) fn displacement(&self, point: Vec3) -> Vec3 {
        self.linear * point + self.offset - point
    }

    /// With another rotation vector, and the same displacement of `centre`.
    pub(super) fn turned_about(self, centre: Vec3, rotation: Vec3) -> Self {
        let linear = exp(rotation) * polar(self.linear).1;
        Self { rotation, linear, offset: self.offset + (self.linear - linear) * centre, ..self }
    }

    /// In the mesh's own units.
    pub(super) fn matrix(&self, frame: UnitFrame) -> Mat4 {
        let translation = frame.center + self.offset * frame.scale - self.linear * frame.center;
        Mat4::from_mat3_translation(self.linear, translation)
    }
}

/// The motion of each handle from its matrix, rest to posed in the mesh's own units, and its whole turns, where given;
/// else rotations agree with each other, and where something is `anchored` at rest with that.
pub(super) fn motions(
    transforms: &[Mat4],
    turns: Option<&[Vec3]>,
    frame: UnitFrame,
    anchored: bool,
) -> Vec<HandleMotion> {
    let linear = |m: &Mat4| Mat3::from_mat4(*m);
    let mut rotations: Vec<Vec3> = transforms.iter().map(|m| log(nearest_rotation(linear(m)))).collect();
    let mut whole_turns = vec![Vec3::ZERO; transforms.len()];
    match turns {
        Some(turns) => {
            for ((rotation, whole), &turns) in rotations.iter_mut().zip(&mut whole_turns).zip(turns) {
                (*rotation, *whole) = with_turns(*rotation, turns);
            }
        }
        None => agree(&mut rotations, anchored),
    }
    let motion = |(m, (rotation, whole_turns)): (&Mat4, (Vec3, Vec3))| HandleMotion {
        rotation,
        whole_turns,
        linear: linear(m),
        offset: (m.transform_point3(frame.center) - frame.center) / frame.scale,
    };
    transforms.iter().zip(rotations.into_iter().zip(whole_turns)).map(motion).collect()
}

/// Splits a rotation that has done about `turns` into a rotation vector and whole turns before it. Near
/// whole turns a matrix says nothing of their axis, and a twist with a tilt has no vector of its own.
fn with_turns(own: Vec3, turns: Vec3) -> (Vec3, Vec3) {
    let nearest = nearest_branch(own, turns);
    if nearest.distance(turns) <= PI {
        return (nearest, Vec3::ZERO);
    }
    let whole = turns.normalize_or_zero() * (TAU * (turns.length() / TAU).round());
    (nearest_branch(own, turns - whole), whole)
}

/// The motion of the other side.
pub(super) fn image_of_matrix(m: Mat4, plane: &Plane) -> Mat4 {
    let mut mirror = Mat4::from_mat3(plane.matrix());
    mirror.w_axis = plane.image(Vec3::ZERO).extend(1.0);
    mirror * m * mirror
}

/// What of an affine motion is symmetric about a plane on which `centre` lies: turns about the normal, stretches that are
/// the same on both sides, and where the centre goes along the plane.
pub(super) fn symmetric(m: Mat4, plane: &Plane, centre: Vec3) -> Mat4 {
    if image_of_matrix(m, plane) == m {
        return m;
    }
    let (linear, mirror) = (Mat3::from_mat4(m), plane.matrix());
    let (turn, stretch) = polar(linear);
    let turn = log(turn);
    let linear_symmetric = exp(turn - plane.tangential(turn)) * ((stretch + mirror * stretch * mirror) * 0.5);
    let shift = plane.tangential((linear - Mat3::IDENTITY) * centre + m.w_axis.truncate());
    let mut made = Mat4::from_mat3(linear_symmetric);
    made.w_axis = (shift - (linear_symmetric - Mat3::IDENTITY) * centre).extend(1.0);
    made
}
