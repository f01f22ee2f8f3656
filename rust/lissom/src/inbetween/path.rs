//! `x(t)`: what every triangle asks for at time `t`, stitched.
//!
//! ```text
//!     s_te(t) = p(t) e(start) + q(t) R_t(1)^T e(end)
//! ```
//!
//! turned by `R_t(t)`; `p` and `q` are those of `stretch`.

use std::sync::Arc;

use rayon::prelude::*;

use super::clearance::Clearance;
use super::options::{InbetweenOptions, Rotation};
use super::relative::Relative;
use super::riders;
use super::screw::Screw;
use super::shapes::{Of, Shapes, Stretched, Targets};
use super::stretch::{self, Stretch, shares};
use super::turn::Turn;
use crate::geometry::rigid::size;
use crate::geometry::triangle::normal_and_area;
use crate::stitch::Volumes;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory};

/// Correlation of the folds at both ends, below the negative of which a component counts as mirrored.
const MIRRORED: f64 = 0.5;

/// Shapes whose widths differ by a smaller share are as wide: single precision tells no more of them.
const AS_WIDE: f64 = 1e-5;

/// Times solved as one block of right-hand sides: enough to share each pass over the factor, and
/// few enough to answer a cancellation at once.
const TIMES_AT_ONCE: usize = 8;

/// The path from one shape of a mesh to another, factored once and evaluated at any time.
///
/// The way back is the same path: `start` to `end` at `t` is `end` to `start` at `1 - t`.
#[derive(Debug)]
pub struct Inbetween {
    /// Both, in an order that does not depend on who is called start.
    pub(super) shapes: Shapes,
    pub(super) reversed: bool,
    options: InbetweenOptions,
    turns: Vec<Turn>,
    /// `R_t(1)`.
    ends: Vec<Mat3>,
    relative: Option<Relative>,
    /// Empty where stretches go in equal steps.
    stretches: Vec<Option<[f64; 2]>>,
    /// Triangles with a rotation of their own.
    turning: Vec<bool>,
    /// Of each floating component.
    screws: Vec<Screw>,
    volumes: Option<Volumes>,
    clearance: Option<Clearance>,
    warnings: Vec<String>,
}

impl Inbetween {
    /// Prepares the path from `start` to `end`, one position per vertex of `mesh`, in its own units.
    /// Only the triangles of `mesh` matter, not its positions.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for shapes of the wrong length, with values that are not finite, or all
    /// of whose points lie on one point or line; [`Error::SolveFailed`], [`Error::Cancelled`].
    pub fn new(
        mesh: Arc<Mesh>,
        start: &[Vec3],
        end: &[Vec3],
        options: InbetweenOptions,
        job: &Job,
    ) -> Result<Self> {
        // Rounding must not choose another path for the way back, so the order is settled first.
        let reversed = precedes(end, start);
        let mut named = [("start".to_owned(), start), ("end".to_owned(), end)];
        if reversed {
            named.reverse();
        }
        let shapes = Shapes::new(mesh.clone(), &named, job)?;
        let [a, b] = [&shapes.unit[0], &shapes.unit[1]];
        job.report(0.4, "rotations");
        let found = shapes.turns(1, options.rotation != Rotation::Shortest, job)?;
        let mut warnings = shapes.warnings.clone();
        let problem = "triangles that turn over against their neighbours between start and end";
        warnings.extend(Fault::at("end", problem, found.inverted).map(|fault| fault.to_string()));

        let firsts: Vec<usize> = mesh.components().members().iter().map(|m| m[0] as usize).collect();
        let problem = "parts that turn by half a turn, where either way round is as near, named by their first vertex; \
                       a shape half way tells which";
        let own = |v: &usize| !mesh.is_mirror_image(*v);
        let halves = found.halves.iter().map(|&c| firsts[c]).filter(own);
        warnings.extend(Fault::at("end", problem, halves).map(|fault| fault.to_string()));
        let problem = "components that are a mirror image of the start and cave in on the way, named by their first vertex";
        let turned = mirrored(&mesh, a, b).into_iter().map(|c| firsts[c]).filter(own);
        warnings.extend(Fault::at("end", problem, turned).map(|fault| fault.to_string()));
        let volumes = options.preserve_volume.then(|| Volumes::of(&mesh, a, b));
        let open = volumes.iter().flat_map(Volumes::open).map(|c| firsts[c]).filter(own);
        let problem = "open components, which have no volume to preserve, named by their first vertex";
        warnings.extend(Fault::at("preserve_volume", problem, open).map(|fault| fault.to_string()));
        let clearance = match (&options.clearance, &options.clearance_end) {
            (Some(obstacle), moved) => {
                Some(clearance(&mesh, obstacle, moved.as_deref(), [start, end], shapes.scale, job)?)
            }
            (None, Some(_)) => {
                let problem = "needs clearance, the surface that it moves";
                return Err(Error::InvalidValue(Fault::new("clearance_end", problem)));
            }
            (None, None) => None,
        };

        job.report(0.7, "turns");
        job.check()?;
        let ends: Vec<Mat3> = found.turns.par_iter().map(|turn| turn.at(1.0)).collect();
        let apart = shapes.apart(1);
        let means = mean_turns(&mesh, a, &found.turns);
        let screw = |vertices: &Vec<u32>| {
            let component = mesh.components().of_vertex(vertices[0] as usize);
            let pairs = vertices.iter().map(|&v| (a[v as usize], b[v as usize] + apart));
            Screw::of(pairs, component.map_or(Vec3::ZERO, |c| means[c]))
        };
        let mut screws: Vec<Screw> = shapes.stitcher.floating().iter().map(screw).collect();
        for part in &shapes.riders.parts {
            let back = riders::motion(&part.seat, b, a);
            let vertices = shapes.stitcher.floating()[part.floating].iter();
            let pairs = vertices.map(|&v| (a[v as usize], back.apply(b[v as usize])));
            let host = found.turns[part.seat.triangles[0] as usize].omega();
            screws[part.floating] = Screw::of(pairs, means[part.component] - host);
        }
        let relative = match options.rotation {
            Rotation::Relative => Some(Relative::new(&mesh, &ends, &found.roots, &found.links, job)?),
            Rotation::Consistent | Rotation::Shortest => None,
        };
        let stretches = match options.stretch {
            Stretch::Linear => Vec::new(),
            Stretch::Logarithmic => stretch::stretches(&mesh, &found.motions, a, b),
        };
        let turning = found.motions.iter().map(|motion| motion.rotation().is_some()).collect();
        job.report(1.0, "ready");
        Ok(Self {
            shapes,
            reversed,
            options,
            turns: found.turns,
            ends,
            relative,
            stretches,
            turning,
            screws,
            volumes,
            clearance,
            warnings,
        })
    }

    /// What is doubtful: slivers, triangles that turn over. Empty for two shapes that agree.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Positions at each of `times`, in the mesh's own units: exactly `start` at 0 and `end` at 1.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a time that is not within 0 and 1, [`Error::OutOfMemory`],
    /// [`Error::SolveFailed`] where positions overflow, [`Error::Cancelled`].
    pub fn at(&self, times: &[f64], job: &Job) -> Result<Vec<Vec<Vec3>>> {
        Self::check_times(times)?;
        // Once here, and once more for whoever takes them over.
        let bytes =
            2 * size_of::<Vec3>() as u128 * times.len() as u128 * self.shapes.stationary.len() as u128;
        memory::check("the in-betweens", bytes)?;
        let mut shapes = Vec::with_capacity(times.len());
        for chunk in times.chunks(TIMES_AT_ONCE) {
            job.report(shapes.len() as f64 / times.len() as f64, "in-betweens");
            let arcs = self.arcs(chunk, job)?;
            shapes
                .extend(chunk.par_iter().zip(arcs).map(|(&t, arc)| self.shape(t, &arc)).collect::<Vec<_>>());
        }
        let overflow = shapes.iter().enumerate().filter(|(_, x)| !x.iter().all(|p| p.is_finite()));
        match Fault::at("times", "positions beyond the range of numbers", overflow.map(|(i, _)| i)) {
            Some(fault) => Err(Error::SolveFailed(fault.to_string())),
            None => Ok(shapes),
        }
    }

    /// Refuses times that are not within 0 and 1.
    pub(super) fn check_times(times: &[f64]) -> Result<()> {
        let outside = times.iter().enumerate().filter(|(_, t)| !(0.0..=1.0).contains(*t));
        let fault = Fault::at("times", "not within 0 and 1", outside.map(|(i, _)| i));
        fault.map_or(Ok(()), |fault| Err(Error::InvalidValue(fault)))
    }

    /// The position on the straight line plus the arc's distance from it.
    pub(super) fn shape(&self, t: f64, arc: &[Vec3]) -> Vec<Vec3> {
        let [a, b] = [&self.shapes.given[0], &self.shapes.given[1]];
        let (start, end) = if self.reversed { (b, a) } else { (a, b) };
        if t == 0.0 {
            return start.clone();
        }
        if t == 1.0 {
            return end.clone();
        }
        let s = self.inner_time(t);
        let line = a.iter().zip(b).map(|(&p, &q)| p + (q - p) * s);
        line.zip(arc).map(|(p, &y)| p + y * self.shapes.scale).collect()
    }

    /// The time in the order in which the shapes are kept.
    fn inner_time(&self, t: f64) -> f64 {
        if self.reversed { 1.0 - t } else { t }
    }

    /// `y(t)` in unit coordinates, for a few times at once.
    pub(super) fn arcs(&self, times: &[f64], job: &Job) -> Result<Vec<Vec<Vec3>>> {
        let mut targets = Vec::with_capacity(times.len());
        for &t in times {
            job.check()?;
            targets.push(self.targets(self.inner_time(t), job)?);
        }
        let mut arcs = self.shapes.stitch(&targets, self.options.refinement, |t| self.turning[t], job)?;
        for ((&t, targets), y) in times.iter().zip(&targets).zip(&mut arcs) {
            if let Some(volumes) = &self.volumes {
                let (stitcher, wanted) = (&self.shapes.stitcher, volumes.at(self.inner_time(t)));
                let precondition = |gradient: &[Vec3]| stitcher.precondition(gradient);
                volumes.restore(stitcher.mesh(), &targets.line, y, &wanted, precondition);
                self.shapes.place(targets, y);
            }
            if let Some(clearance) = &self.clearance
                && t > 0.0
                && t < 1.0
            {
                clearance.keep(&self.shapes, t, y, |y| self.shape(t, y), job)?;
            }
        }
        Ok(arcs)
    }

    /// What every triangle asks for at time `t`.
    fn targets(&self, t: f64, job: &Job) -> Result<Targets<impl Stretched + '_>> {
        let changes = match &self.relative {
            Some(relative) => {
                let mut rotations = relative.at(t, &self.turns, job)?;
                rotations.par_iter_mut().for_each(|r| *r -= Mat3::IDENTITY);
                rotations
            }
            None => self.turns.par_iter().map(|turn| turn.at(t) - Mat3::IDENTITY).collect(),
        };
        let stretched = move |triangle: usize, of: Of| {
            let [start, end] = [0, 1].map(|shape| self.shapes.triangle(shape, triangle, of));
            let (p, q) = shares(self.stretches.get(triangle).copied().flatten(), t);
            let back = self.ends[triangle].transpose();
            let stretched = [0, 1, 2].map(|c| start[c] * p + back * end[c] * q);
            [stretched, [0, 1, 2].map(|c| stretched[c] - (start[c] * (1.0 - t) + end[c] * t))]
        };
        let line =
            self.shapes.unit[0].iter().zip(&self.shapes.unit[1]).map(|(&p, &q)| p + (q - p) * t).collect();
        let offsets = self.screws.iter().map(|screw| screw.at(t)).collect();
        Ok(Targets { stretched, changes, line, shares: vec![1.0 - t, t], offsets })
    }
}

/// What keeps a path from `ends[0]` to `ends[1]` out of an obstacle, whose vertices end where they are `moved` to.
fn clearance(
    mesh: &Mesh,
    obstacle: &Arc<Mesh>,
    moved: Option<&[Vec3]>,
    ends: [&[Vec3]; 2],
    scale: f64,
    job: &Job,
) -> Result<Clearance> {
    let path = match moved {
        Some(end) => {
            let path =
                Inbetween::new(obstacle.clone(), obstacle.vertices(), end, InbetweenOptions::default(), job);
            Some(path.map_err(|error| error.renamed("clearance_end"))?)
        }
        None => None,
    };
    let rest = obstacle.clone();
    let at = move |t: f64, job: &Job| match &path {
        Some(path) => Ok(path.at(&[t], job)?.remove(0)),
        None => Ok(rest.vertices().to_vec()),
    };
    Clearance::new(mesh, obstacle, Box::new(at), ends, scale, job)
}

/// The rotation vector of every component's triangles on the mean, weighted by area.
fn mean_turns(mesh: &Mesh, x: &[Vec3], turns: &[Turn]) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); mesh.components().count()];
    for (triangle, turn) in mesh.triangles().iter().zip(turns) {
        if let Some(c) = mesh.components().of_vertex(triangle[0] as usize) {
            let (_, area) = normal_and_area(triangle.map(|v| x[v as usize]));
            sums[c].0 += turn.omega() * area;
            sums[c].1 += area;
        }
    }
    sums.into_iter().map(|(sum, area)| if area > 0.0 { sum / area } else { Vec3::ZERO }).collect()
}

/// Components whose folds are turned inside out: the angles between their triangles, signed and weighted
/// by the edges, are opposite on the whole.
fn mirrored(mesh: &Mesh, a: &[Vec3], b: &[Vec3]) -> Vec<usize> {
    let triangles = mesh.triangles();
    let fold = |x: &[Vec3], edge: [u32; 2], sides: [u32; 2]| {
        let normal = |t: u32| normal_and_area(triangles[t as usize].map(|v| x[v as usize])).0;
        let [m, n] = sides.map(normal);
        m.cross(n).dot(x[edge[1] as usize] - x[edge[0] as usize])
    };
    let mut products = vec![[0.0; 3]; mesh.components().count()];
    for (e, &edge) in mesh.adjacency().edges().iter().enumerate() {
        if let ([p, q], Some(c)) =
            (mesh.adjacency().sides_of(e), mesh.components().of_vertex(edge[0] as usize))
        {
            let sides = [p.triangle, q.triangle];
            let (f, g) = (fold(a, edge, sides), fold(b, edge, sides));
            for (sum, term) in products[c].iter_mut().zip([f * g, f * f, g * g]) {
                *sum += term;
            }
        }
    }
    let opposite = |&(_, &[fg, ff, gg]): &(usize, &[f64; 3])| fg < -MIRRORED * (ff * gg).sqrt() && fg < 0.0;
    products.iter().enumerate().filter(opposite).map(|(c, _)| c).collect()
}

/// Whether `a` comes before `b`: the one that is wider, which it is however both lie, and of shapes as wide the one
/// that is less at the first number in which they differ.
fn precedes(a: &[Vec3], b: &[Vec3]) -> bool {
    let [p, q] = [a, b].map(|x| size(x.iter().copied()));
    if (p - q).abs() > AS_WIDE * p.max(q) {
        return p > q;
    }
    let differ = a.iter().zip(b).find(|(p, q)| p != q);
    differ.is_some_and(|(p, q)| p.to_array() < q.to_array())
}
