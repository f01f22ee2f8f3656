//! As-rigid-as-possible surface modelling (Sorkine & Alexa 2007), spokes and rims (Chao, Pinkall,
//! Sanan & Schröder 2010).
//!
//! ```text
//!     E(x) = min_R  sum_i  sum_{t at i}  sum_{e in t}  w_te | e(x) - R_i e(v) |^2
//! ```
//!
//! Each triangle of a cell adds `w |e(x)|^2 + w |e(v)|^2 - 2 tr(R_i^T T_t)` with the covariance
//! `T_t = sum_c x_c g_tc^T`, so the *local* step is the nearest rotation to `sum_{t at i} T_t`. For
//! fixed rotations `E` differs from the stitching energy of the targets `C_t = mean of R at the
//! corners of t` by a constant: the *global* step is one stitch. The sum over a triangle's edges is
//! never negative, whatever the sign of single cotangents, and so neither is the energy.
//!
//! Local and global steps alone converge slowly; Anderson acceleration with the energy as safeguard
//! (Peng, Deng, Zhang, Geng, Qin & Liu 2018, Anderson Acceleration for Geometry Optimization and
//! Physics Simulation) combines the last steps, and falls back to the plain one where the energy
//! would rise.

use rayon::prelude::*;

use super::anderson::Anderson;
use super::field;
use super::{Goal, Method, Region, Solution, SolveOptions};
use crate::operators::gradient::outer;
use crate::rotation::nearest_rotation;
use crate::stitch::Stitcher;
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// An energy below this fraction of that of the edges themselves is zero but for rounding.
const NOTHING: f64 = 1e-14;

/// Options of ARAP.
#[derive(Debug, Clone, Default)]
pub struct Options {}

/// ARAP bound to a region.
#[derive(Debug)]
pub struct Arap {
    stitcher: Stitcher,
    previous: Option<Vec<Mat3>>,
}

impl Arap {
    /// Factors the stitching system of the region.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where that fails.
    pub fn new(region: &Region, _options: &Options) -> Result<Self> {
        let stitcher = Stitcher::new(region.mesh(), region.constraints().clone())?;
        Ok(Self { stitcher, previous: None })
    }

    /// Targets to start from: the handles' rotations, spread as harmonic rotation vectors. Where all
    /// given vertices move by the same rigid motion, that motion.
    fn guess(&self, region: &Region, goal: &Goal) -> Vec<Mat3> {
        let mesh = region.mesh();
        corner_means(mesh, &field::rotations(self.stitcher.system(), region, goal))
    }
}

impl Method for Arap {
    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        let mesh = region.mesh();
        let stitch = |targets: &[Mat3]| {
            let mut displacements = goal.displacements.clone();
            self.stitcher.solve(mesh, targets, &mut displacements);
            displacements
        };
        let mut x = match &self.previous {
            Some(targets) if options.warm_start => stitch(targets),
            _ => stitch(&self.guess(region, goal)),
        };
        let mut fit = Fit::of(mesh, &x);
        let mut acceleration = Anderson::default();
        let (mut iterations, mut quiet) = (0, 0);
        while iterations < options.max_iterations && quiet < 2 {
            job.report(iterations as f64 / options.max_iterations as f64, "posing");
            job.check()?;
            let plain = stitch(&fit.targets);
            let before = fit.energy;
            x = acceleration.combine(&x, &plain);
            fit = Fit::of(mesh, &x);
            if fit.energy > before {
                x = plain;
                fit = Fit::of(mesh, &x);
            }
            iterations += 1;
            // One small step may be an accident of the acceleration, two are not.
            let small = before - fit.energy <= options.tolerance * fit.energy + NOTHING * fit.scale;
            quiet = if small { quiet + 1 } else { 0 };
        }
        self.previous = Some(fit.targets);
        let energy = Some(fit.energy.max(0.0));
        Ok(Solution { displacements: x, iterations, energy, converged: quiet == 2 })
    }
}

/// The local step: best rotations, as targets of the triangles, and the energy they leave.
struct Fit {
    targets: Vec<Mat3>,
    energy: f64,
    /// `sum_t sum_e w |e(x)|^2 + w |e(v)|^2`, which rounding of the energy is relative to.
    scale: f64,
}

impl Fit {
    fn of(mesh: &Mesh, displacements: &[Vec3]) -> Self {
        let rest = mesh.rest();
        let (covariances, sizes): (Vec<Mat3>, Vec<f64>) = (mesh.triangles().par_iter())
            .zip(mesh.half_cotangents())
            .with_min_len(512)
            .map(|(t, w)| {
                let v = t.map(|i| rest[i as usize]);
                let d = t.map(|i| displacements[i as usize]);
                let mut covariance = Mat3::ZERO;
                let mut size = 0.0;
                for (c, &weight) in w.iter().enumerate() {
                    let (j, k) = ((c + 1) % 3, (c + 2) % 3);
                    let old = v[k] - v[j];
                    let new = old + (d[k] - d[j]);
                    covariance += outer(new * weight, old);
                    size += weight * (new.length_squared() + old.length_squared());
                }
                (covariance, size)
            })
            .unzip();
        let (rotations, fits): (Vec<Mat3>, Vec<f64>) = (0..rest.len())
            .into_par_iter()
            .with_min_len(512)
            .map(|i| {
                let corners = mesh.adjacency().corners_of(i).iter();
                let cell = corners.fold(Mat3::ZERO, |sum, c| sum + covariances[c.triangle as usize]);
                let rotation = nearest_rotation(cell);
                let fit = rotation.x_axis.dot(cell.x_axis)
                    + rotation.y_axis.dot(cell.y_axis)
                    + rotation.z_axis.dot(cell.z_axis);
                (rotation, fit)
            })
            .unzip();
        // Summed in order, not by the threads, so that results repeat to the last bit.
        let scale = 3.0 * sizes.iter().sum::<f64>();
        let energy = scale - 2.0 * fits.iter().sum::<f64>();
        Self { targets: corner_means(mesh, &rotations), energy, scale }
    }
}

/// The mean of each triangle's three corner matrices.
fn corner_means(mesh: &Mesh, of_vertex: &[Mat3]) -> Vec<Mat3> {
    let mean = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| of_vertex[v as usize]);
        (a + b + c) * (1.0 / 3.0)
    };
    mesh.triangles().par_iter().with_min_len(512).map(mean).collect()
}
