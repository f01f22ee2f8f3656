//! Attributes: what the source's vertices bear, such as skin weights or colours, on the target's.
//!
//! ```text
//!     x_v = sum_c  b_vc  a_c            where v has an image, with the barycentric coordinates b
//!     sum_{w ~ v} (x_v - x_w) = 0       elsewhere in a component that has images
//! ```
//!
//! A vertex with an image ([`super::image`]) takes what is there; what is between them takes the harmonic
//! extension by the uniform Laplacian (Taubin 1995, A Signal Processing Approach to Fair Surface Design). Its weights
//! are positive, unlike cotangents, so that every value is a mean of given ones: weights of a skin stay between 0
//! and 1. A component without an image, such as lashes that the source has not, takes the values of the nearest
//! vertex that has one, so that it goes along as a whole with what is beside it.

use rayon::prelude::*;

use super::apply::Transfer;
use crate::geometry::surface::Surface;
use crate::linear::{ConstrainedSystem, Constraints};
use crate::operators::graph::graph_laplacian;
use crate::{Error, Fault, Job, Result, Vec3, memory};

/// Channels that one vector carries through a solve.
const LANES: usize = 3;

impl Transfer {
    /// Carries `values`, `channels` of each source vertex, one vertex after another, over to the target's vertices.
    ///
    /// Every result is a convex combination of the source's values. Of source vertices that are welded the values of
    /// the one that stands for them count.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for another number of values and values that are not finite,
    /// [`Error::InvalidConstraint`] where no target vertex has an image, as with pairs of triangles alone,
    /// [`Error::SolveFailed`], [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn attributes(&self, values: &[f64], channels: usize, job: &Job) -> Result<Vec<f64>> {
        job.report(0.0, "attributes");
        check_values(values, self.source.vertices().len(), channels, "vertices of the source")?;
        self.check_images()?;
        let n = self.target.vertices().len();
        // Rows and columns of it, and once more for whoever takes them over.
        memory::check("the attributes", 3 * size_of::<f64>() as u128 * n as u128 * channels as u128)?;
        let triangles = self.source.triangles();
        let mut found = vec![0.0; n * channels];
        found.par_chunks_mut(channels.max(1)).zip(&self.used.images).for_each(|(row, image)| {
            let Some(image) = image else { return };
            let corners = triangles[image.triangle as usize].map(|v| v as usize * channels);
            for (channel, value) in row.iter_mut().enumerate() {
                *value = clamped_mean(corners.map(|start| values[start + channel]), image.weights);
            }
        });
        job.check()?;
        self.extend(&mut found, channels, job)?;
        self.take_from_the_nearest(&mut found, channels);
        for (v, w) in self.target.welds() {
            found.copy_within(row(w as usize, channels), v as usize * channels);
        }
        job.report(1.0, "attributes");
        Ok(found)
    }

    /// Refused where nothing says where on the source the target lies.
    pub(super) fn check_images(&self) -> Result<()> {
        if self.used.images.iter().any(Option::is_some) {
            return Ok(());
        }
        let problem = "no vertex of the target lies on the source: attributes need a fit, not pairs alone";
        Err(Error::InvalidConstraint(Fault::new("fit", problem)))
    }

    /// Whether each component of the target has an image.
    fn imaged_components(&self) -> Vec<bool> {
        let components = self.target.components();
        let mut imaged = vec![false; components.count()];
        for v in (0..self.used.images.len()).filter(|&v| self.used.images[v].is_some()) {
            if let Some(component) = components.of_vertex(v) {
                imaged[component] = true;
            }
        }
        imaged
    }

    /// Fills the vertices without an image of components that have some.
    fn extend(&self, values: &mut [f64], channels: usize, job: &Job) -> Result<()> {
        let (components, images) = (self.target.components(), &self.used.images);
        let imaged = self.imaged_components();
        let is_open = |v: usize| images[v].is_none() && components.of_vertex(v).is_some_and(|c| imaged[c]);
        let n = images.len();
        if channels == 0 || !(0..n).any(is_open) {
            return Ok(());
        }
        let constraints = Constraints::hard(n, |v| !is_open(v));
        let system = ConstrainedSystem::new(&graph_laplacian(&self.target), constraints, job)?;
        let members = components.members();
        for first in (0..channels).step_by(LANES) {
            job.check()?;
            let lanes = first..channels.min(first + LANES);
            let vector = |v: usize| {
                let mut vector = Vec3::ZERO;
                lanes.clone().for_each(|c| vector[c - first] = values[v * channels + c]);
                vector
            };
            let mut field = [(0..n).map(vector).collect::<Vec<_>>()];
            system.extend(&mut field);
            let [mut field] = field;
            for part in members.iter().zip(&imaged).filter(|(_, imaged)| **imaged).map(|(part, _)| part) {
                // Rounding of the solve must not leave the range either, nor make a constant less of one.
                let given = part.iter().map(|&v| v as usize).filter(|&v| images[v].is_some());
                let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                let (low, high) = given.fold(start, |(a, b), v| (a.min(field[v]), b.max(field[v])));
                for v in part.iter().map(|&v| v as usize).filter(|&v| is_open(v)) {
                    field[v] = field[v].clamp(low, high);
                }
            }
            for v in (0..n).filter(|&v| is_open(v)) {
                lanes.clone().for_each(|c| values[v * channels + c] = field[v][c - first]);
            }
        }
        Ok(())
    }

    /// Fills the components without an image, and vertices of no component.
    fn take_from_the_nearest(&self, values: &mut [f64], channels: usize) {
        let imaged = self.imaged_components();
        let of_vertex = |v: usize| self.target.components().of_vertex(v);
        let given: Vec<usize> =
            (0..self.used.images.len()).filter(|&v| self.used.images[v].is_some()).collect();
        let left: Vec<usize> =
            (0..self.used.images.len()).filter(|&v| of_vertex(v).is_none_or(|c| !imaged[c])).collect();
        if left.is_empty() {
            return;
        }
        let rest = self.target.rest();
        let points = Surface::new(given.iter().map(|&v| [rest[v]; 3]).collect());
        let nearest = |&v: &usize| points.closest_centroid(rest[v]).map(|hit| (v, given[hit.triangle]));
        let found: Vec<_> = left.par_iter().filter_map(nearest).collect();
        for (v, from) in found {
            values.copy_within(row(from, channels), v * channels);
        }
    }
}

fn row(vertex: usize, channels: usize) -> std::ops::Range<usize> {
    vertex * channels..(vertex + 1) * channels
}

/// The mean of `values` with these weights, within their range to the last bit.
pub(super) fn clamped_mean(values: [f64; 3], weights: Vec3) -> f64 {
    let [a, b, c] = values;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    (a * weights.x + b * weights.y + c * weights.z).clamp(low, high)
}

/// Refuses values of another number than `channels` for each of `count`, or that are not finite.
pub(super) fn check_values(values: &[f64], count: usize, channels: usize, whose: &str) -> Result<()> {
    if values.len() != count * channels {
        let problem = format!("{} for {count} {whose} with {channels} each", values.len());
        return Err(Error::InvalidValue(Fault::new("values", problem)));
    }
    let rows = values.chunks(channels.max(1)).enumerate();
    let bad = rows.filter(|(_, row)| row.iter().any(|x| !x.is_finite())).map(|(v, _)| v);
    Fault::at("values", "not finite", bad).map_or(Ok(()), |fault| Err(Error::InvalidValue(fault)))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Mesh;
    use crate::transfer::testing::{bumpy_grid, grid};
    use crate::transfer::{Correspondence, SurfacePoint, TransferOptions};

    /// A grid onto itself, and a square of its own on the target; images but where `open`.
    fn transfer(open: impl Fn(usize) -> bool) -> Transfer {
        let source = bumpy_grid(6);
        let (mut vertices, mut triangles) = grid(6);
        vertices.extend([Vec3::Z * 0.5, Vec3::new(0.1, 0.0, 0.5), Vec3::new(0.0, 0.1, 0.5), Vec3::ONE * 2.0]);
        triangles.push([36, 37, 38]);
        let target = Mesh::new(vertices, triangles).unwrap();
        let on = |v: usize| {
            let corner = source.adjacency().corners_of(v)[0];
            let mut weights = Vec3::ZERO;
            weights[corner.corner as usize] = 1.0;
            SurfacePoint { triangle: corner.triangle, weights }
        };
        let images = (0..40).map(|v| (v < 36 && !open(v)).then(|| on(v))).collect();
        let pairs = (0..source.triangles().len() as u32).map(|t| [t, t]).collect();
        let matches = Correspondence { pairs, images, back_images: Vec::new(), ..Correspondence::default() };
        let options = TransferOptions::default();
        Transfer::new(Arc::new(source), Arc::new(target), &matches, options, &Job::default()).unwrap()
    }

    fn values(channels: usize) -> Vec<f64> {
        (0..36 * channels).map(|i| (i as f64 * 1.7).sin() * 10f64.powi((i % channels) as i32)).collect()
    }

    #[test]
    fn a_mesh_gives_itself_its_own_values_to_the_last_bit() {
        for channels in [1, 3, 5] {
            let values = values(channels);
            let found = transfer(|_| false).attributes(&values, channels, &Job::default()).unwrap();
            assert_eq!(found[..values.len()], values);
        }
    }

    #[test]
    fn what_is_open_is_the_mean_of_its_neighbours_and_within_their_range() {
        let open = |v: usize| (7..29).contains(&v) && v != 15;
        let transfer = transfer(open);
        let values = values(4);
        let found = transfer.attributes(&values, 4, &Job::default()).unwrap();
        let mut sums = vec![(0.0, 0.0); 36 * 4];
        for &[a, b] in transfer.target().adjacency().edges().iter().filter(|edge| edge[1] < 36) {
            for (v, w) in [(a, b), (b, a)] {
                for c in 0..4 {
                    let sum = &mut sums[v as usize * 4 + c];
                    *sum = (sum.0 + found[w as usize * 4 + c], sum.1 + 1.0);
                }
            }
        }
        for v in (0..36).filter(|&v| open(v)) {
            for c in 0..4 {
                let (sum, count) = sums[v * 4 + c];
                assert!((found[v * 4 + c] - sum / count).abs() < 1e-9 * 10f64.powi(c as i32));
            }
        }
        let constant = transfer.attributes(&[0.1; 36], 1, &Job::default()).unwrap();
        assert!(constant.iter().all(|&x| x == 0.1), "to the last bit");
    }

    #[test]
    fn row_12_and_30_what_nothing_matches_takes_from_the_nearest() {
        let transfer = transfer(|v| v == 0);
        let found = transfer.attributes(&values(2), 2, &Job::default()).unwrap();
        let rest = transfer.target().rest();
        for v in 36..40 {
            let nearest =
                (1..36).min_by(|&a, &b| rest[a].distance(rest[v]).total_cmp(&rest[b].distance(rest[v])));
            assert_eq!(found[row(v, 2)], found[row(nearest.unwrap(), 2)]);
        }
    }

    #[test]
    fn row_03_values_that_cannot_be_used() {
        let transfer = transfer(|_| false);
        let error = transfer.attributes(&[0.0; 35], 1, &Job::default()).unwrap_err().to_string();
        assert!(error.contains("values: 35 for 36 vertices of the source"), "{error}");
        let mut values = values(2);
        values[7] = f64::NAN;
        let error = transfer.attributes(&values, 2, &Job::default()).unwrap_err().to_string();
        assert!(error.contains("values: not finite (at 3; 1 in all)"), "{error}");
        let nowhere = super::tests::transfer(|_| true);
        let error = nowhere.attributes(&[0.0; 36], 1, &Job::default()).unwrap_err();
        assert!(matches!(error, Error::InvalidConstraint(_)), "{error}");
    }
}
