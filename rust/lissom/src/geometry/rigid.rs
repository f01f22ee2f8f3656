//! Rigid and similarity maps that carry a part along with what lies beside it.

use crate::geometry::matrix::outer;
use crate::{Mat3, Vec3, rotation};

/// `p -> center_to + linear (p - center_from)`.
#[derive(Debug, Clone, Copy)]
pub struct Carry {
    linear: Mat3,
    from: Vec3,
    to: Vec3,
}

impl Carry {
    /// The rotation and translation that take `from` to `to` best, in least squares (Kabsch 1976).
    pub fn rigid(from: &[Vec3], to: &[Vec3]) -> Self {
        Self::fit(from, to, false)
    }

    /// The same with a uniform scale (Umeyama 1991).
    pub fn similar(from: &[Vec3], to: &[Vec3]) -> Self {
        Self::fit(from, to, true)
    }

    fn fit(from: &[Vec3], to: &[Vec3], scaled: bool) -> Self {
        let centre = |points: &[Vec3]| points.iter().sum::<Vec3>() / points.len().max(1) as f64;
        let (a, b) = (centre(from), centre(to));
        let covariance: Mat3 = from.iter().zip(to).map(|(&p, &q)| outer(q - b, p - a)).sum();
        let turn = rotation::nearest_rotation(covariance);
        let spread: f64 = from.iter().map(|&p| (p - a).length_squared()).sum();
        let along = turn.transpose() * covariance;
        let scale = (along.x_axis.x + along.y_axis.y + along.z_axis.z) / spread;
        let scale = if scaled && scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        Self { linear: turn * scale, from: a, to: b }
    }

    /// The linear part.
    pub fn linear(&self) -> Mat3 {
        self.linear
    }

    /// Where a point goes.
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.to + self.linear * (point - self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_recovered() {
        let turn = rotation::exp(Vec3::new(0.3, -1.2, 0.5));
        let from: Vec<Vec3> =
            [(0.0, 0.0, 0.0), (1.0, 0.2, 0.0), (0.1, 1.5, 0.3), (-0.4, 0.2, 0.9)].map(Vec3::from).to_vec();
        let map = |s: f64| move |p: &Vec3| turn * *p * s + Vec3::new(1.0, 2.0, 3.0);
        for (carry, scale) in [
            (Carry::similar(&from, &from.iter().map(map(2.5)).collect::<Vec<_>>()), 2.5),
            (Carry::rigid(&from, &from.iter().map(map(1.0)).collect::<Vec<_>>()), 1.0),
        ] {
            let point = Vec3::new(0.7, -0.1, 2.0);
            assert!((carry.apply(point) - map(scale)(&point)).length() < 1e-12);
        }
    }
}
