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
//! Both steps are sums over the edges at a vertex. With `m_ij` for what the cell of `i` makes of the position
//! of its neighbour `j`, the covariance of a cell is `C_i = sum_j (x_j - x_i) m_ij^T`, and the energy is
//! quadratic in `x` but for `-2 sum_i R_i : C_i`.
//!
//! Two terms may join. `rotation_smoothing` adds `a area sum_ij w_ij |R_i - R_j|^2` (Levi & Gotsman 2015,
//! Smooth Rotation Enhanced As-Rigid-As-Possible Mesh Animation), which makes a surface bend like a solid.
//! `smoothness` blends to `(1 - l) E + l h^2 sum_i |(L x)_i - R_i (L v)_i|^2 / m_i` (Oehri, Herholz &
//! Sorkine-Hornung 2025, Higher Order Continuity for Smooth As-Rigid-As-Possible Shape Modeling), with
//! the rotations still fitted to edges, so that a single moved vertex pulls without a spike. They leave the
//! unit of length open; the factor [`BENDING`] times the region's area makes `l` mean the same for every mesh.
//!
//! Local and global steps alone are descent along `-K^-1` times the gradient, `K` being the matrix of the
//! global step, and converge slowly. The last steps tell more of the curvature: [`Lbfgs`] in that metric (Liu,
//! Bouaziz & Kavan 2017, Quasi-Newton Methods for Real-Time Simulation of Hyperelastic Materials).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::field::{self, inverse_mass};
use super::goal::Goal;
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use crate::geometry::matrix::{dot, outer};
use crate::linear::{Columns, ConstrainedSystem, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::rotation::nearest_rotation;
use crate::stitch::lbfgs::{self, Lbfgs};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};

/// An energy below this fraction of that of the edges themselves is zero but for rounding.
const NOTHING: f64 = 1e-14;

/// Lengths tried along a direction before the plain step is taken instead.
const TRIALS: usize = 4;

/// The part of the decrease that the slope promises which a step must bring (Armijo 1966).
const ENOUGH: f64 = 1e-4;

/// Spread rotations are a start where they bring the energy below this fraction of that without.
const CLEARLY: f64 = 0.8;

/// What the bending term of `smoothness` is worth, relative to the area of the region: at `l = 1/2` it
/// rules over distances below a tenth of the region's size.
const BENDING: f64 = 0.01;

/// Vertices that a thread takes at once.
const GRAIN: usize = 1024;

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
    spokes: Spokes,
    system: ConstrainedSystem,
    /// `a` times the region's area.
    rotation_smoothing: f64,
    smoothness: Option<Smoothness>,
    previous: Option<Vec<Mat3>>,
}

/// The edges at each vertex, one after another.
#[derive(Debug)]
struct Spokes {
    start: Vec<u32>,
    spokes: Vec<Spoke>,
    /// In how many cells an edge of a triangle is.
    cells: f64,
    /// `sum_j m_ij`.
    total: Vec<Vec3>,
    /// The weighted size of all edges at rest.
    size: f64,
}

/// An edge from `i`, as `i` sees it.
#[derive(Debug, Clone, Copy, Default)]
struct Spoke {
    neighbour: u32,
    weight: f64,
    /// `m_ij`: what the cell of `i` makes of the neighbour's position.
    own: Vec3,
    /// `m_ji`: what the neighbour's cell makes of the position of `i`.
    neighbours: Vec3,
}

/// The Laplacian's rows over the square root of the cells' areas, and what they make of the rest pose.
#[derive(Debug)]
struct Smoothness {
    rows: Vec<Vec<(u32, f64)>>,
    factor: Vec<f64>,
    rest: Vec<Vec3>,
}

/// A shape and the outcome of its local step.
struct Fit {
    displacements: Vec<Vec3>,
    rotations: Vec<Mat3>,
    energy: f64,
    /// The weighted size of all edges, which rounding of the energy is relative to.
    scale: f64,
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
        let spokes = Spokes::of(mesh, options.cells);
        let mut matrix = SymmetricMatrix::laplacian(n, spokes.edges());
        let smoothness = (options.smoothness > 0.0).then(|| Smoothness::of(mesh));
        if let Some(smoothness) = &smoothness {
            let rows = smoothness.factor.iter().copied().zip(smoothness.rows.iter().map(Vec::as_slice));
            let bending = SymmetricMatrix::normal(n, rows);
            matrix = matrix.combine(1.0 - options.smoothness, &bending, options.smoothness);
        }
        let system = ConstrainedSystem::new(&matrix, region.constraints().clone(), job)?;
        let rotation_smoothing = options.rotation_smoothing * mesh.areas().iter().sum::<f64>();
        let options = options.clone();
        Ok(Self { options, spokes, system, rotation_smoothing, smoothness, previous: None })
    }

    /// The better of two shapes to start from: stitched to the handles' rotations, spread as harmonic rotation
    /// vectors, which is exact where all given vertices move by one rigid motion; or to the rotations that
    /// fit where only the handles move, which bends nothing that may stay straight. Which of them leads to
    /// the lower minimum shows only at the end. Where both are about equal, rotations are not what the pose is
    /// about, and the second leads lower.
    fn start(&self, region: &Region, goal: &Goal) -> Fit {
        let mesh = region.mesh();
        let from = |rotations: &[Mat3]| {
            let x = self.stitch(goal, &goal.displacements, rotations);
            self.fit(mesh, goal, x, rotations)
        };
        let spread = from(&field::rotations(&self.system, region, goal));
        // More than half a turn is in the spread rotations alone.
        if goal.handles.iter().any(|m| m.whole_turns != Vec3::ZERO || m.rotation.length() > PI) {
            return spread;
        }
        let identity = vec![Mat3::IDENTITY; mesh.rest().len()];
        let rest = from(&self.fit(mesh, goal, goal.displacements.clone(), &identity).rotations);
        if spread.energy <= CLEARLY * rest.energy { spread } else { rest }
    }

    /// The global step from any displacements: where the gradient for fixed rotations is zero.
    fn stitch(&self, goal: &Goal, displacements: &[Vec3], rotations: &[Mat3]) -> Vec<Vec3> {
        moved(displacements, &self.lift(&self.gradient(goal, displacements, rotations)), -1.0)
    }

    /// `K^-1` of a gradient.
    fn lift(&self, gradient: &[Vec3]) -> Vec<Vec3> {
        let mut x = Columns::zeros(gradient.len(), 3);
        self.system.solve(&Columns::from_vectors(gradient), &mut x);
        x.vectors(0)
    }

    /// The gradient by the displacements, for fixed rotations, over twice the cells that an edge is in.
    fn gradient(&self, goal: &Goal, displacements: &[Vec3], rotations: &[Mat3]) -> Vec<Vec3> {
        let share = 1.0 - self.options.smoothness;
        let constraints = self.system.constraints();
        let at = |i: usize| {
            if constraints.slot(i as u32).is_none() {
                return Vec3::ZERO;
            }
            // Rotations less the identity, so that what does not move asks for exactly nothing.
            let turn = |i: usize| rotations[i] - Mat3::IDENTITY;
            let (mut stretch, mut turned) = (Vec3::ZERO, turn(i) * self.spokes.total[i]);
            for spoke in self.spokes.at(i) {
                let j = spoke.neighbour as usize;
                stretch += (displacements[i] - displacements[j]) * spoke.weight;
                turned -= turn(j) * spoke.neighbours;
            }
            (stretch + turned * (1.0 / self.spokes.cells)) * share
        };
        let mut gradient: Vec<Vec3> =
            (0..displacements.len()).into_par_iter().with_min_len(GRAIN).map(at).collect();
        if let Some(smoothness) = &self.smoothness {
            smoothness.add_gradient(displacements, rotations, self.options.smoothness, &mut gradient);
        }
        for &(v, weight) in constraints.soft().iter().filter(|(v, _)| constraints.slot(*v).is_some()) {
            let v = v as usize;
            gradient[v] += (displacements[v] - goal.displacements[v]) * weight;
        }
        gradient
    }

    /// The local step: the best rotations, from the last ones where they are smoothed, and the energy.
    fn fit(&self, mesh: &Mesh, goal: &Goal, displacements: Vec<Vec3>, last: &[Mat3]) -> Fit {
        let posed = moved(mesh.rest(), &displacements, 1.0);
        let smoothing = self.rotation_smoothing;
        let at = |i: usize| {
            let (mut cell, mut size) = (Mat3::ZERO, 0.0);
            for spoke in self.spokes.at(i) {
                let edge = posed[spoke.neighbour as usize] - posed[i];
                cell += outer(edge, spoke.own);
                size += spoke.weight * edge.length_squared();
            }
            let mut pulled = cell;
            if smoothing > 0.0 {
                for spoke in self.spokes.at(i) {
                    pulled += last[spoke.neighbour as usize] * (2.0 * smoothing * spoke.weight.max(0.0));
                }
            }
            let rotation = nearest_rotation(pulled);
            // Each edge is seen from both its ends.
            (rotation, (0.5 * self.spokes.cells * size, 2.0 * dot(rotation, cell)))
        };
        let (rotations, parts): (Vec<Mat3>, Vec<(f64, f64)>) =
            (0..posed.len()).into_par_iter().with_min_len(GRAIN).map(at).unzip();
        // Summed in order, not by the threads, so that results repeat to the last bit.
        let scale = self.spokes.size + parts.iter().map(|part| part.0).sum::<f64>();
        let rigidity = scale - parts.iter().map(|part| part.1).sum::<f64>();
        let apart = if smoothing > 0.0 { smoothing * self.spokes.disagreement(&rotations) } else { 0.0 };
        let missed = |&(v, weight): &(u32, f64)| {
            weight * displacements[v as usize].distance_squared(goal.displacements[v as usize])
        };
        let pulls: f64 = self.system.constraints().soft().iter().map(missed).sum();
        let share = self.options.smoothness;
        let bending = self.smoothness.as_ref().map_or(0.0, |s| s.energy(&displacements, &rotations));
        // The global step weighs an edge once, the energy once for every cell that it is in.
        let energy = (1.0 - share) * rigidity + self.spokes.cells * (share * bending + pulls) + apart;
        Fit { displacements, rotations, energy, scale }
    }

    /// The first of some lengths of a step along `direction` that lowers the energy well enough; each is where
    /// the parabola through what is known has its minimum.
    fn search(
        &self,
        mesh: &Mesh,
        goal: &Goal,
        from: &Fit,
        direction: &[Vec3],
        slope: f64,
    ) -> Option<(Fit, f64)> {
        let mut length = 1.0;
        for _ in 0..TRIALS {
            let next = self.fit(mesh, goal, moved(&from.displacements, direction, length), &from.rotations);
            let change = next.energy - from.energy;
            if change <= ENOUGH * length * slope.min(0.0) + NOTHING * next.scale {
                return Some((next, length));
            }
            if !change.is_finite() {
                return None;
            }
            let lowest = -slope * length * length / (2.0 * (change - slope * length));
            length = lowest.clamp(0.1 * length, 0.5 * length);
        }
        None
    }
}

impl Method for Arap {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![&self.system]
    }

    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        let mesh = region.mesh();
        let mut fit = match self.previous.take() {
            Some(rotations) if options.warm_start => {
                let x = self.stitch(goal, &goal.displacements, &rotations);
                self.fit(mesh, goal, x, &rotations)
            }
            _ => self.start(region, goal),
        };
        let mut memory = Lbfgs::default();
        let (mut iterations, mut quiet, mut residual, mut length) = (0, 0, f64::INFINITY, 1.0);
        // Targets out of range are told by whoever sees the result.
        while iterations < options.max_iterations && quiet < 2 && fit.energy.is_finite() {
            job.report(iterations as f64 / options.max_iterations as f64, "posing");
            job.check()?;
            let gradient = self.gradient(goal, &fit.displacements, &fit.rotations);
            let lifted = self.lift(&gradient);
            let direction = memory.direction(&gradient, &lifted, length);
            let slope = 2.0 * self.spokes.cells * lbfgs::dot(&gradient, &direction);
            let next = match self.search(mesh, goal, &fit, &direction, slope) {
                Some((next, found)) => {
                    length = found;
                    next
                }
                None => {
                    memory = Lbfgs::default();
                    self.fit(mesh, goal, moved(&fit.displacements, &lifted, -1.0), &fit.rotations)
                }
            };
            iterations += 1;
            // One small step may be an accident of the model, two are not.
            let gain = fit.energy - next.energy;
            let small = gain <= options.tolerance * next.energy + NOTHING * next.scale;
            quiet = if small { quiet + 1 } else { 0 };
            residual = gain / next.energy;
            fit = next;
        }
        self.previous = Some(fit.rotations);
        let energy = Some(fit.energy.max(0.0));
        Ok(Solution { displacements: fit.displacements, iterations, energy, converged: quiet == 2, residual })
    }
}

impl Spokes {
    fn of(mesh: &Mesh, cells: Cells) -> Self {
        let (rest, adjacency, triangles) = (mesh.rest(), mesh.adjacency(), mesh.triangles());
        let count = match cells {
            Cells::SpokesAndRims => 3.0,
            Cells::Spokes => 2.0,
        };
        // In each triangle, the differential coordinates of its corners: what its edges ask of them.
        let coordinates: Vec<[Vec3; 3]> = (triangles.par_iter().zip(mesh.half_cotangents()))
            .map(|(t, w)| {
                let v = t.map(|i| rest[i as usize]);
                let edge = |c: usize| (v[(c + 2) % 3] - v[(c + 1) % 3]) * w[c];
                let [bc, ca, ab] = [edge(0), edge(1), edge(2)];
                [ca - ab, ab - bc, bc - ca]
            })
            .collect();
        let mut size = 0.0;
        let edges: Vec<(f64, [Vec3; 2])> = (adjacency.edges().iter().enumerate())
            .map(|(e, ends)| {
                let (mut weight, mut asked) = (0.0, [Vec3::ZERO; 2]);
                for side in adjacency.sides_of(e) {
                    let t = side.triangle as usize;
                    for (corner, &v) in triangles[t].iter().enumerate() {
                        match ends.iter().position(|&end| end == v) {
                            Some(end) => asked[end] += coordinates[t][corner],
                            None => weight += mesh.half_cotangents()[t][corner],
                        }
                    }
                }
                let along = rest[ends[1] as usize] - rest[ends[0] as usize];
                if cells == Cells::Spokes {
                    weight = weight.max(0.0);
                    asked = [along * -weight, along * weight];
                }
                size += count * weight * along.length_squared();
                (weight, asked)
            })
            .collect();
        let mut start = vec![0u32; rest.len() + 1];
        for &v in adjacency.edges().iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..rest.len() {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut spokes = vec![Spoke::default(); 2 * edges.len()];
        let mut total = vec![Vec3::ZERO; rest.len()];
        for (&[a, b], &(weight, [at_a, at_b])) in adjacency.edges().iter().zip(&edges) {
            for (from, neighbour, own, neighbours) in [(a, b, at_b, at_a), (b, a, at_a, at_b)] {
                spokes[next[from as usize] as usize] = Spoke { neighbour, weight, own, neighbours };
                next[from as usize] += 1;
                total[from as usize] += own;
            }
        }
        Self { start, spokes, cells: count, total, size }
    }

    fn at(&self, vertex: usize) -> &[Spoke] {
        &self.spokes[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }

    fn edges(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        let at = |i: u32| self.at(i as usize).iter().map(move |s| (i, s.neighbour, s.weight));
        (0..self.total.len() as u32).flat_map(at).filter(|(i, j, _)| i < j)
    }

    /// `sum_ij w_ij |R_i - R_j|^2`.
    fn disagreement(&self, rotations: &[Mat3]) -> f64 {
        let apart = |(i, j, w): (u32, u32, f64)| {
            w.max(0.0) * (6.0 - 2.0 * dot(rotations[i as usize], rotations[j as usize]))
        };
        2.0 * self.edges().map(apart).sum::<f64>()
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

    /// Adds the gradient of `l/2 sum_i f_i |(L d)_i - (R_i - I) (L v)_i|^2`.
    fn add_gradient(&self, displacements: &[Vec3], rotations: &[Mat3], amount: f64, gradient: &mut [Vec3]) {
        for (i, row) in self.rows.iter().enumerate() {
            let bend = self.bend(i, displacements, rotations) * (amount * self.factor[i]);
            for &(j, value) in row {
                gradient[j as usize] += bend * value;
            }
        }
    }
    fn energy(&self, displacements: &[Vec3], rotations: &[Mat3]) -> f64 {
        let part = |i: usize| self.factor[i] * self.bend(i, displacements, rotations).length_squared();
        (0..self.rows.len()).map(part).sum()
    }

    fn bend(&self, i: usize, displacements: &[Vec3], rotations: &[Mat3]) -> Vec3 {
        combination(&self.rows[i], displacements) + self.rest[i] - rotations[i] * self.rest[i]
    }
}

fn moved(from: &[Vec3], direction: &[Vec3], length: f64) -> Vec<Vec3> {
    let along = |(x, d): (&Vec3, &Vec3)| *x + *d * length;
    from.par_iter().zip(direction).with_min_len(4096).map(along).collect()
}

fn combination(row: &[(u32, f64)], vectors: &[Vec3]) -> Vec3 {
    row.iter().fold(Vec3::ZERO, |sum, &(j, value)| sum + vectors[j as usize] * value)
}
