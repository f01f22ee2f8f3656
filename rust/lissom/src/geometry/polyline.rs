//! Polylines: paths of points by arc length. A loop ends with its first point.

use crate::Vec3;

/// Points one after another.
pub struct Polyline {
    points: Vec<Vec3>,
    lengths: Vec<f64>,
}

impl Polyline {
    /// Through these points, at least one.
    pub fn new(points: Vec<Vec3>) -> Self {
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        Self { points, lengths }
    }

    /// Its points.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The arc length at each of them.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// All of its length.
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The segment at an arc length, by its first point, and the fraction of it that lies before.
    pub fn place(&self, length: f64) -> (usize, f64) {
        let last = self.points.len().saturating_sub(2);
        let segment = self.lengths.partition_point(|&l| l <= length).saturating_sub(1).min(last);
        let Some(&end) = self.lengths.get(segment + 1) else { return (segment, 0.0) };
        let within = end - self.lengths[segment];
        let fraction = if within > 0.0 { (length - self.lengths[segment]) / within } else { 0.0 };
        (segment, fraction.clamp(0.0, 1.0))
    }

    /// The point at an arc length.
    pub fn at(&self, length: f64) -> Vec3 {
        let (segment, fraction) = self.place(length);
        let next = self.points[(segment + 1).min(self.points.len() - 1)];
        self.points[segment].lerp(next, fraction)
    }

    /// The arc length of the point that is closest to `point`, and how far it is.
    pub fn closest(&self, point: Vec3) -> (f64, f64) {
        let on = |(i, pair): (usize, &[Vec3])| {
            let along = pair[1] - pair[0];
            let fraction = (point - pair[0]).dot(along) / along.length_squared();
            let fraction = if fraction > 0.0 { fraction.min(1.0) } else { 0.0 };
            let length = self.lengths[i] + fraction * (self.lengths[i + 1] - self.lengths[i]);
            (length, pair[0].lerp(pair[1], fraction).distance(point))
        };
        let nearest = self.points.windows(2).enumerate().map(on).min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.unwrap_or((0.0, self.points[0].distance(point)))
    }

    /// Its centroid.
    pub fn centroid(&self) -> Vec3 {
        if self.length() == 0.0 {
            return self.points[0];
        }
        let middle = |pair: &[Vec3]| (pair[0] + pair[1]) * (0.5 * pair[0].distance(pair[1]));
        self.points.windows(2).map(middle).sum::<Vec3>() / self.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_told_by_length() {
        let path = Polyline::new([(0.0, 0.0), (3.0, 0.0), (3.0, 0.0), (3.0, 1.0)].map(point).to_vec());
        assert_eq!((path.length(), path.place(1.5), path.place(9.0)), (4.0, (0, 0.5), (2, 1.0)));
        assert_eq!((path.place(-1.0), path.place(3.0)), ((0, 0.0), (2, 0.0)));
        assert_eq!((path.at(3.5), path.at(4.0)), (point((3.0, 0.5)), point((3.0, 1.0))));
        assert_eq!(path.closest(point((4.0, 0.25))), (3.25, 1.0));
        assert_eq!(path.centroid(), point((1.875, 0.125)));
    }

    fn point((x, y): (f64, f64)) -> Vec3 {
        Vec3::new(x, y, 0.0)
    }
}
