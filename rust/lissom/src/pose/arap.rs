//! As-rigid-as-possible surface modelling (Sorkine & Alexa 2007).
//!
//! ```text
//!     E(x) = min_R  sum_i  sum_{e in cell i}  w_te | e(x) - R_i e(v) |^2
//! ```
//!
//! A cell is all edges of the triangles at `i`, [`Cells::SpokesAndRims`] (Chao, Pinkall, Sanan & Schröder
//! 2010), or only those that end in `i`, [`Cells::Spokes`]. The *local* step takes for `R_i` the rotation
//! nearest to the cell's covariance `sum w e(x) e(v)^T`. The *global* step stitches: for fixed rotations
//! every edge of every triangle has as its target the mean over the cells it is in,
//!
//! ```text
//!     C_te = (R_i + R_j + R_k) / 3    or, for spokes,    (R_j + R_k) / 2      for the edge from j to k
//! ```
//!
//! With spokes and rims the sum over a triangle is never negative, whatever the sign of single
//! cotangents; spokes alone need negative edge weights cut off.
//!
//! Two terms may join. `rotation_smoothing` adds `a area sum_ij w_ij |R_i - R_j|^2` (Levi & Gotsman 2015,
//! Smooth Rotation Enhanced As-Rigid-As-Possible Mesh Animation), which makes a surface bend like a solid.
//! `smoothness` blends to `(1 - l) E + l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i` (Oehri, Herholz &
//! Sorkine-Hornung 2025, Higher Order Continuity for Smooth As-Rigid-As-Possible Shape Modeling), with
//! the rotations still fitted to edges, so that a single moved vertex pulls without a spike. They leave the
//! unit of length open; the factor [`BENDING`] times the region's area makes `l` mean the same for every mesh.
//!
//! Local and global steps alone converge slowly; Anderson acceleration with the energy as safeguard
//! (Peng, Deng, Zhang, Geng, Qin & Liu 2018, Anderson Acceleration for Geometry Optimization and
//! Physics Simulation) combines the last steps, and falls back to the plain one where the energy
//! would rise.

use rayon::prelude::*;

use super::anderson::Anderson;
use super::field::{self, inverse_mass};
use super::{Goal, Method, Region, Solution, SolveOptions};
use crate::linear::{Columns, ConstrainedSystem, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::gradient::outer;
use crate::rotation::nearest_rotation;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};

/// An energy below this fraction of that of the edges themselves is zero but for rounding.
const NOTHING: f64 = 1e-14;

/// What the bending term of `smoothness` is worth, relative to the area of the region: at `l = 1/2` it
/// rules over distances below a tenth of the region's size.
const BENDING: f64 = 0.01;

/// Which edges a vertex's rotation is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cells {
    /// All edges of the triangles at the vertex.
    #[default]
    SpokesAndRims,
    /// The edges that end in the vertex.
    Spokes,
}

/// Options of ARAP.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Which edges a vertex's rotation is fitted to.
    pub cells: Cells,
    /// `a`, 0 or more: how much neighbours' rotations must agree.
    pub rotation_smoothing: f64,
    /// `l`, from 0 to below 1: how much curvature counts against edges.
    pub smoothness: f64,
}

/// ARAP bound to a region.
#[derive(Debug)]
pub struct Arap {
    options: Options,
    /// Of each triangle, the weight of the edge opposite each corner.
    weights: Vec<[f64; 3]>,
    system: ConstrainedSystem,
    rotation_smoothing: Option<RotationSmoothing>,
    smoothness: Option<Smoothness>,
    previous: Option<Vec<Mat3>>,
}

/// `a area w_ij` for the neighbours of each vertex.
#[derive(Debug)]
struct RotationSmoothing(Vec<Vec<(u32, f64)>>);

/// The Laplacian's rows over the square root of the cells' areas, and what they make of the rest pose.
#[derive(Debug)]
struct Smoothness {
    rows: Vec<Vec<(u32, f64)>>,
    factor: Vec<f64>,
    rest: Vec<Vec3>,
}

impl Arap {
    /// Factors the system of the global step.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for options out of their range, [`Error::SolveFailed`] where the system
    /// cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let invalid = |name: &str, problem: &str| Err(Error::InvalidValue(Fault::new(name, problem)));
        if !(options.rotation_smoothing >= 0.0 && options.rotation_smoothing.is_finite()) {
            return invalid("rotation_smoothing", "must be 0 or more");
        }
        if !(0.0..1.0).contains(&options.smoothness) {
            return invalid("smoothness", "must be from 0 to below 1");
        }
        let mesh = region.mesh();
        let n = mesh.rest().len();
        let weights = match options.cells {
            Cells::SpokesAndRims => mesh.half_cotangents().to_vec(),
            Cells::Spokes => without_negative_edges(mesh),
        };
        let edges = mesh.triangles().iter().zip(&weights);
        let edges = edges.flat_map(|(&[a, b, c], w)| [(b, c, w[0]), (c, a, w[1]), (a, b, w[2])]);
        let mut matrix = SymmetricMatrix::laplacian(n, edges);
        let smoothness = (options.smoothness > 0.0).then(|| Smoothness::of(mesh));
        if let Some(smoothness) = &smoothness {
            let rows = smoothness.factor.iter().copied().zip(smoothness.rows.iter().map(Vec::as_slice));
            let bending = SymmetricMatrix::normal(n, rows);
            matrix = matrix.combine(1.0 - options.smoothness, &bending, options.smoothness);
        }
        let system = ConstrainedSystem::new(&matrix, region.constraints().clone(), job)?;
        let smoothing = options.rotation_smoothing;
        let rotation_smoothing = (smoothing > 0.0).then(|| RotationSmoothing::of(mesh, smoothing));
        let options = options.clone();
        Ok(Self { options, weights, system, rotation_smoothing, smoothness, previous: None })
    }

    /// Rotations to start from: the handles', spread as harmonic rotation vectors. Where all given
    /// vertices move by the same rigid motion, that motion.
    fn guess(&self, region: &Region, goal: &Goal) -> Vec<Mat3> {
        field::rotations(&self.system, region, goal)
    }

    /// The global step: displacements for fixed rotations.
    fn stitch(&self, mesh: &Mesh, goal: &Goal, rotations: &[Mat3]) -> Vec<Vec3> {
        let rest = mesh.rest();
        let spokes = self.options.cells == Cells::Spokes;
        let share = 1.0 - self.options.smoothness;
        // What each triangle asks of each of its corners.
        let asked: Vec<[Vec3; 3]> = (mesh.triangles().par_iter())
            .zip(&self.weights)
            .with_min_len(512)
            .map(|(t, w)| {
                let v = t.map(|i| rest[i as usize]);
                let r = t.map(|i| rotations[i as usize]);
                let mean = (r[0] + r[1] + r[2]) * (1.0 / 3.0) - Mat3::IDENTITY;
                let edge = |c: usize| {
                    let (j, k) = ((c + 1) % 3, (c + 2) % 3);
                    let target = if spokes { (r[j] + r[k]) * 0.5 - Mat3::IDENTITY } else { mean };
                    target * ((v[k] - v[j]) * (w[c] * share))
                };
                let [bc, ca, ab] = [edge(0), edge(1), edge(2)];
                [ca - ab, ab - bc, bc - ca]
            })
            .collect();
        let sum = |i: usize| {
            let corners = mesh.adjacency().corners_of(i).iter();
            corners.fold(Vec3::ZERO, |b, c| b + asked[c.triangle as usize][usize::from(c.corner)])
        };
        let mut rhs: Vec<Vec3> = (0..rest.len()).into_par_iter().with_min_len(1024).map(sum).collect();
        if let Some(smoothness) = &self.smoothness {
            smoothness.ask(rotations, self.options.smoothness, &mut rhs);
        }
        let mut x = Columns::from_vectors(&goal.displacements);
        self.system.solve(&Columns::from_vectors(&rhs), &mut x);
        x.vectors(0)
    }

    /// The local step: the best rotations, from the last ones where they are smoothed, and the energy.
    fn fit(&self, mesh: &Mesh, displacements: &[Vec3], last: &[Mat3]) -> Fit {
        let rest = mesh.rest();
        let spokes = self.options.cells == Cells::Spokes;
        // Of each triangle: the covariance of all its edges, or for spokes of the two at each corner.
        let (covariances, sizes): (Vec<[Mat3; 3]>, Vec<f64>) = (mesh.triangles().par_iter())
            .zip(&self.weights)
            .with_min_len(512)
            .map(|(t, w)| {
                let v = t.map(|i| rest[i as usize]);
                let d = t.map(|i| displacements[i as usize]);
                let mut size = 0.0;
                let e = [0, 1, 2].map(|c| {
                    let (j, k) = ((c + 1) % 3, (c + 2) % 3);
                    let old = v[k] - v[j];
                    let new = old + (d[k] - d[j]);
                    size += w[c] * (new.length_squared() + old.length_squared());
                    outer(new * w[c], old)
                });
                let all = e[0] + e[1] + e[2];
                (if spokes { [all - e[0], all - e[1], all - e[2]] } else { [all; 3] }, size)
            })
            .unzip();
        let (rotations, fits): (Vec<Mat3>, Vec<f64>) = (0..rest.len())
            .into_par_iter()
            .with_min_len(512)
            .map(|i| {
                let corners = mesh.adjacency().corners_of(i).iter();
                let mut cell = corners
                    .fold(Mat3::ZERO, |sum, c| sum + covariances[c.triangle as usize][usize::from(c.corner)]);
                let fitted = cell;
                if let Some(RotationSmoothing(neighbours)) = &self.rotation_smoothing {
                    for &(j, w) in &neighbours[i] {
                        cell += last[j as usize] * (2.0 * w);
                    }
                }
                let rotation = nearest_rotation(cell);
                (rotation, 2.0 * dot(rotation, fitted))
            })
            .unzip();
        // Summed in order, not by the threads, so that results repeat to the last bit.
        let scale = if spokes { 2.0 } else { 3.0 } * sizes.iter().sum::<f64>();
        let rigidity = scale - fits.iter().sum::<f64>();
        let bending = self.smoothness.as_ref().map_or(0.0, |s| s.energy(displacements, &rotations));
        let share = self.options.smoothness;
        // The global step weighs an edge once, the energy once for every cell that it is in.
        let cells = if spokes { 2.0 } else { 3.0 };
        let apart = self.rotation_smoothing.as_ref().map_or(0.0, |s| s.energy(&rotations));
        Fit { energy: (1.0 - share) * rigidity + share * cells * bending + apart, rotations, scale }
    }
}

/// The outcome of a local step.
struct Fit {
    rotations: Vec<Mat3>,
    energy: f64,
    /// The weighted size of all edges, which rounding of the energy is relative to.
    scale: f64,
}

impl Method for Arap {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![&self.system]
    }

    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        let mesh = region.mesh();
        let start = match self.previous.take() {
            Some(rotations) if options.warm_start => rotations,
            _ => self.guess(region, goal),
        };
        let mut x = self.stitch(mesh, goal, &start);
        let mut fit = self.fit(mesh, &x, &start);
        let mut acceleration = Anderson::default();
        let (mut iterations, mut quiet, mut residual) = (0, 0, f64::INFINITY);
        while iterations < options.max_iterations && quiet < 2 {
            job.report(iterations as f64 / options.max_iterations as f64, "posing");
            job.check()?;
            let plain = self.stitch(mesh, goal, &fit.rotations);
            let before = fit;
            x = acceleration.combine(&x, &plain);
            fit = self.fit(mesh, &x, &before.rotations);
            if fit.energy > before.energy {
                x = plain;
                fit = self.fit(mesh, &x, &before.rotations);
            }
            iterations += 1;
            // One small step may be an accident of the acceleration, two are not.
            let gain = before.energy - fit.energy;
            let small = gain <= options.tolerance * fit.energy + NOTHING * fit.scale;
            quiet = if small { quiet + 1 } else { 0 };
            residual = gain / fit.energy;
        }
        self.previous = Some(fit.rotations);
        let energy = Some(fit.energy.max(0.0));
        Ok(Solution { displacements: x, iterations, energy, converged: quiet == 2, residual })
    }
}

impl RotationSmoothing {
    fn of(mesh: &Mesh, amount: f64) -> Self {
        let area: f64 = mesh.areas().iter().sum();
        let rows = cotangent_laplacian(mesh).rows().into_iter().enumerate();
        let weight = |(j, value): (u32, f64)| (j, (-value * amount * area).max(0.0));
        let others = |(i, row): (usize, Vec<(u32, f64)>)| {
            row.into_iter().filter(|&(j, _)| j as usize != i).map(weight).collect()
        };
        Self(rows.map(others).collect())
    }

    fn energy(&self, rotations: &[Mat3]) -> f64 {
        let apart = |(i, row): (usize, &Vec<(u32, f64)>)| {
            row.iter().map(|&(j, w)| w * (6.0 - 2.0 * dot(rotations[i], rotations[j as usize]))).sum::<f64>()
        };
        self.0.iter().enumerate().map(apart).sum()
    }
}

impl Smoothness {
    fn of(mesh: &Mesh) -> Self {
        let inverse = inverse_mass(mesh);
        let unit = BENDING * mesh.areas().iter().sum::<f64>();
        let rows = cotangent_laplacian(mesh).rows();
        let rest = rows.iter().map(|row| combination(row, mesh.rest())).collect();
        Self { rows, factor: inverse.into_iter().map(|m| m * unit).collect(), rest }
    }

    /// Adds what `l sum_i f_i |(L d)_i - (R_i - I) (L v)_i|^2` asks for.
    fn ask(&self, rotations: &[Mat3], amount: f64, rhs: &mut [Vec3]) {
        for (i, row) in self.rows.iter().enumerate() {
            let turned = (rotations[i] * self.rest[i] - self.rest[i]) * (amount * self.factor[i]);
            for &(j, value) in row {
                rhs[j as usize] += turned * value;
            }
        }
    }

    fn energy(&self, displacements: &[Vec3], rotations: &[Mat3]) -> f64 {
        let part = |i: usize| {
            let bend = combination(&self.rows[i], displacements) + self.rest[i] - rotations[i] * self.rest[i];
            self.factor[i] * bend.length_squared()
        };
        (0..self.rows.len()).map(part).sum()
    }
}

fn combination(row: &[(u32, f64)], vectors: &[Vec3]) -> Vec3 {
    row.iter().fold(Vec3::ZERO, |sum, &(j, value)| sum + vectors[j as usize] * value)
}

/// `tr(a^T b)`.
fn dot(a: Mat3, b: Mat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

/// Half the cotangents, but zero on edges whose two together are negative, and else shared evenly.
fn without_negative_edges(mesh: &Mesh) -> Vec<[f64; 3]> {
    let (adjacency, triangles) = (mesh.adjacency(), mesh.triangles());
    let mut weights = mesh.half_cotangents().to_vec();
    for (e, ends) in adjacency.edges().iter().enumerate() {
        let sides = adjacency.sides_of(e);
        let opposite = |t: usize| (0..3).find(|&c| !ends.contains(&triangles[t][c])).unwrap_or(0);
        let sum: f64 = sides.iter().map(|s| s.triangle as usize).map(|t| weights[t][opposite(t)]).sum();
        for side in sides {
            let t = side.triangle as usize;
            weights[t][opposite(t)] = sum.max(0.0) / sides.len() as f64;
        }
    }
    weights
}
