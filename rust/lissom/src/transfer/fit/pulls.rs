//! Pulls: points of the source that ought to be somewhere, or on some plane.
//!
//! ```text
//!     E_P(x) = sum_p  r_p^T P_p r_p        r_p = sum_c w_c x_c - c_p        P = along n n^T + across (1 - n n^T)
//! ```
//!
//! Distances to the closest *point* hold the surface where it is and make it creep; distances to the plane
//! through that point leave it free to slide (Chen & Medioni 1992, Object Modelling by Registration of Multiple
//! Range Images).

use crate::Vec3;
use crate::geometry::triangle::interpolate;

/// One of them.
#[derive(Debug, Clone, Copy)]
pub struct Pull {
    /// Corners of the source's triangle, ...
    pub corners: [u32; 3],
    /// ... and what each counts.
    pub weights: Vec3,
    /// `c`
    pub goal: Vec3,
    /// `n`, of unit length.
    pub normal: Vec3,
    /// Weight along the normal.
    pub along: f64,
    /// Weight across it.
    pub across: f64,
}

impl Pull {
    /// To a point, alike in all directions.
    pub fn to_point(corners: [u32; 3], weights: Vec3, goal: Vec3, weight: f64) -> Self {
        Self { corners, weights, goal, normal: Vec3::ZERO, along: weight, across: weight }
    }

    /// `P r`
    fn times(&self, r: Vec3) -> Vec3 {
        r * self.across + self.normal * (self.normal.dot(r) * (self.along - self.across))
    }

    /// `sum_c w_c x_c`
    pub fn place(&self, x: &[Vec3]) -> Vec3 {
        interpolate(self.corners.map(|v| x[v as usize]), self.weights)
    }

    /// `P` as directions, and how much each counts.
    pub fn directions(&self) -> [(Vec3, f64); 4] {
        let [x, y, z] = Vec3::AXES.map(|axis| (axis, self.across));
        [(self.normal, self.along - self.across), x, y, z]
    }

    fn add(&self, value: Vec3, to: &mut [Vec3]) {
        (0..3).for_each(|k| to[self.corners[k] as usize] += value * self.weights[k]);
    }
}

/// Adds half the gradient of `E_P` at `x` to `to`.
pub fn add_gradient(pulls: &[Pull], x: &[Vec3], to: &mut [Vec3]) {
    pulls.iter().for_each(|pull| pull.add(pull.times(pull.place(x) - pull.goal), to));
}

/// Adds half the Hessian of `E_P` times `d` to `to`.
pub fn add_curvature(pulls: &[Pull], d: &[Vec3], to: &mut [Vec3]) {
    pulls.iter().for_each(|pull| pull.add(pull.times(pull.place(d)), to));
}

/// Of each of `n` vertices the mean of `P` over the directions, with the corners of a triangle apart: the
/// weights of an energy that the three axes do not share.
pub fn uncoupled(pulls: &[Pull], n: usize) -> Vec<f64> {
    let mut diagonal = vec![0.0; n];
    for pull in pulls {
        let mean =
            if pull.normal == Vec3::ZERO { pull.along } else { (pull.along + 2.0 * pull.across) / 3.0 };
        (0..3).for_each(|k| diagonal[pull.corners[k] as usize] += mean * pull.weights[k]);
    }
    diagonal
}
