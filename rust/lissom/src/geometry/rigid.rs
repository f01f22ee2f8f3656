//! The rotation, rigid or similarity map that takes one set of points to another best, in least squares.
//!
//! With the points about their centroids, `K = sum q p^T`, the rotation is the one nearest to `K` (Kabsch 1976)
//! and the scale `tr(R^T K) / sum |p|^2` (Umeyama 1991).

use crate::matrix::{outer, trace};
use crate::{Mat3, Vec3, rotation};

/// Points span a plane when the second singular value of their covariance exceeds this
/// fraction of the first.
const SPANNED: f64 = 1e-6;

/// Ratios of sizes beyond this factor, either way, are those of points in one place.
const MOST_SCALED: f64 = 1e3;

/// What two sets of points, pair by pair, say of the map between them.
#[derive(Debug, Clone, Copy)]
pub struct Alignment {
    from: Vec3,
    to: Vec3,
    /// `K`.
    covariance: Mat3,
    /// `sum p p^T`.
    scatter: Mat3,
    /// `sum |q|^2`.
    to_squares: f64,
}

impl Alignment {
    /// Of pairs `(p, q)`, the first of which is to go to the second.
    pub fn of(pairs: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> Self {
        let (from, to) = (centroid(pairs.clone().map(|(p, _)| p)), centroid(pairs.clone().map(|(_, q)| q)));
        let (mut covariance, mut scatter, mut to_squares) = (Mat3::ZERO, Mat3::ZERO, 0.0);
        for (p, q) in pairs {
            let (p, q) = (p - from, q - to);
            covariance += outer(q, p);
            scatter += outer(p, p);
            to_squares += q.length_squared();
        }
        Self { from, to, covariance, scatter, to_squares }
    }

    /// The best rotation about the centroids.
    pub fn rotation(&self) -> Mat3 {
        rotation::nearest_rotation(self.covariance)
    }

    /// Whether the first points are on no line, so that there is one best rotation.
    pub fn is_determined(&self) -> bool {
        spans_a_plane(self.scatter)
    }

    /// How much of both sets the rotation accounts for: 1 where they are congruent.
    pub fn correlation(&self) -> f64 {
        trace(self.rotation().transpose() * self.covariance) / (trace(self.scatter) * self.to_squares).sqrt()
    }

    /// The centroids.
    pub fn centroids(&self) -> (Vec3, Vec3) {
        (self.from, self.to)
    }

    /// The best rotation and translation.
    pub fn rigid(&self) -> Similarity {
        Similarity { linear: self.rotation(), from: self.from, to: self.to }
    }

    /// The best rotation, translation and uniform scale; no scale where the points do not tell.
    pub fn similar(&self) -> Similarity {
        let rotation = self.rotation();
        let scale = trace(rotation.transpose() * self.covariance) / trace(self.scatter);
        let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        Similarity { linear: rotation * scale, from: self.from, to: self.to }
    }
}

/// `p -> to + linear (p - from)`.
#[derive(Debug, Clone, Copy)]
pub struct Similarity {
    linear: Mat3,
    from: Vec3,
    to: Vec3,
}

impl Similarity {
    /// The map by its linear part, a rotation times a scale, and a point and where that goes.
    pub fn new(linear: Mat3, from: Vec3, to: Vec3) -> Self {
        Self { linear, from, to }
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

/// The mean of some points; zero where there is none.
pub fn centroid(points: impl Iterator<Item = Vec3>) -> Vec3 {
    let (sum, count) = points.fold((Vec3::ZERO, 0.0f64), |(sum, count), p| (sum + p, count + 1.0));
    sum / count.max(1.0)
}

/// Root mean square distance of some points from their centroid.
pub fn size(points: impl Iterator<Item = Vec3> + Clone) -> f64 {
    let centre = centroid(points.clone());
    let squares = points.clone().map(|p| p.distance_squared(centre)).sum::<f64>();
    (squares / points.count().max(1) as f64).sqrt()
}

/// The [`size`] of some points over that of others; 1 where either are in one place.
pub fn size_ratio(
    points: impl Iterator<Item = Vec3> + Clone,
    over: impl Iterator<Item = Vec3> + Clone,
) -> f64 {
    let ratio = size(points) / size(over);
    if ratio > 1.0 / MOST_SCALED && ratio < MOST_SCALED { ratio } else { 1.0 }
}

/// Whether points of this covariance are on no line.
pub fn spans_a_plane(covariance: Mat3) -> bool {
    // The sum of the principal 2 x 2 minors of the covariance is s1 s2 + s1 s3 + s2 s3.
    let [x, y, z] = [covariance.x_axis, covariance.y_axis, covariance.z_axis];
    let trace = trace(covariance);
    let second = 0.5 * (trace * trace - x.length_squared() - y.length_squared() - z.length_squared());
    second > SPANNED * SPANNED * trace * trace
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_recovered() {
        let turn = rotation::exp(Vec3::new(0.3, -1.2, 0.5));
        let from = [(0.0, 0.0, 0.0), (1.0, 0.2, 0.0), (0.1, 1.5, 0.3), (-0.4, 0.2, 0.9)].map(Vec3::from);
        let map = |s: f64| move |p: Vec3| turn * p * s + Vec3::new(1.0, 2.0, 3.0);
        let pairs = |s: f64| Alignment::of(from.into_iter().map(move |p| (p, map(s)(p))));
        for (found, scale) in [(pairs(2.5).similar(), 2.5), (pairs(1.0).rigid(), 1.0)] {
            let point = Vec3::new(0.7, -0.1, 2.0);
            assert!((found.apply(point) - map(scale)(point)).length() < 1e-12);
        }
        assert!((pairs(2.5).correlation() - 1.0).abs() < 1e-12);
        assert!((size_ratio(from.into_iter().map(map(2.5)), from.into_iter()) - 2.5).abs() < 1e-12);
    }

    #[test]
    fn points_on_a_line_leave_the_turn_about_it_open() {
        let line = |offset: Vec3| {
            Alignment::of(
                (0..5).map(move |k| (Vec3::X * f64::from(k) + offset * f64::from(k % 2), Vec3::ZERO)),
            )
        };
        assert!(!line(Vec3::ZERO).is_determined());
        assert!(line(Vec3::Y * 1e-2).is_determined());
        assert_eq!(size_ratio([Vec3::X; 3].into_iter(), [Vec3::X, Vec3::Y].into_iter()), 1.0);
    }
}
