//! As-rigid-as-possible in-betweens of two shapes of one mesh.
//!
//! # The problem
//!
//! Between `start` and `end` every triangle turns by a rotation `R` and stretches by `S`, its gradient
//! being `Q = R S`. On the way it shall have turned by `R(t)`, a part of the way from `I` to `R`, and
//! stretched by `(1-t) I + t S` (Alexa, Cohen-Or & Levin 2000, As-Rigid-As-Possible Shape
//! Interpolation). Applied to an edge `e`, and with `S = R^T Q`, that is
//!
//! ```text
//!     c_te(t) = (1-t) R_t(t) e(start)  +  t R_t(t) R_t(1)^T e(end)
//! ```
//!
//! the edge at the start turned forward, blended with the edge at the end turned back: the same
//! seen from either end, defined for triangles without area, and exact at both ends. The
//! positions are stitched:
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - c_te(t) |^2
//! ```
//!
//! with `w_te` the mean of the half cotangents at both ends, which weighs by area at either.
//!
//! # The steps
//!
//! | file | |
//! |---|---|
//! | `rotations` | `R_t`: the polar decomposition of each triangle's gradient |
//! | `branches` | `R_t(t)`: which logarithm of `R_t`, so that neighbours turn together |
//! | `relative` | `R_t(t)` from the rotations between neighbours instead |
//! | `stretch` | `S(t)`: in equal steps or by equal factors |
//! | `path` | `x(t)`: all of these at a time |
//! | `elements` | the stitch, and rotations refitted to it |
//! | `drift` | where components go that nothing holds |
//! | `volume`, `clearance` | the volume kept, an obstacle respected |
//! | `keyframes` | the fewest times between which a straight line will do |
//! | `route` | a path through several shapes |
//! | `blend` | several shapes at once |
//!
//! Vertices in the same place at both ends stay there exactly; a connected component without such
//! a vertex turns about the axis of its rigid motion (`drift`).

mod blend;
mod branches;
mod clearance;
mod drift;
mod elements;
mod keyframes;
mod path;
mod relative;
mod rotations;
mod route;
mod stretch;
mod volume;

use std::sync::Arc;

use rayon::prelude::*;

use crate::geometry::frame::UnitFrame;
use crate::geometry::triangle::{TriangleGeometry, normal_and_area};
use crate::linear::REGULARIZED;
use crate::mesh::validate;
use crate::operators::hats_of;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};
use branches::{Neighbours, Turn};
use clearance::Clearance;
use drift::Drift;
use elements::{Elements, Hats};
use relative::Relative;
use volume::Volumes;

pub use blend::Blend;
pub use keyframes::Keyframes;
pub use route::Route;
pub use stretch::Stretch;

/// Correlation of the folds at both ends, below the negative of which a component counts as mirrored.
const MIRRORED: f64 = 0.5;

/// How the turn of a triangle is chosen among all that lead to the same rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rotation {
    /// Neighbours turn together: twists beyond half a turn, and several turns, come out whole.
    #[default]
    Consistent,
    /// The turns between neighbours, integrated over the whole mesh.
    Relative,
    /// Every triangle by at most half a turn.
    Shortest,
}

/// Options of [`Inbetween`].
#[derive(Debug, Clone, Default)]
pub struct InbetweenOptions {
    /// How turns are chosen.
    pub rotation: Rotation,
    /// How stretches go from start to end.
    pub stretch: Stretch,
    /// How many rounds of refitting the rotations to the stitched shape.
    pub refinement: usize,
    /// Whether closed components keep their volume, in equal steps from the start's to the end's.
    pub preserve_volume: bool,
    /// What no in-between may enter deeper than the ends do.
    pub clearance: Option<Obstacle>,
}

/// A closed surface in the same units, and where its vertices are at the end, if elsewhere.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// Where it is at the start.
    pub mesh: Arc<Mesh>,
    /// One position per vertex.
    pub end: Option<Vec<Vec3>>,
}

/// The path from one shape of a mesh to another, factored once and evaluated at any time.
///
/// The way back is the same path: `start` to `end` at `t` is `end` to `start` at `1 - t`.
#[derive(Debug)]
pub struct Inbetween {
    elements: Elements,
    options: InbetweenOptions,
    /// Both shapes in the mesh's own units, in an order that does not depend on who is called start.
    shapes: [Vec<Vec3>; 2],
    /// The same in unit coordinates.
    unit: [Vec<Vec3>; 2],
    reversed: bool,
    /// What a unit is inside, in the mesh's own units.
    scale: f64,
    /// Of each corner and both shapes: `sum w_te e` over the two edges of its triangle that meet there.
    hats: [Vec<Hats>; 2],
    turns: Vec<Turn>,
    /// `R_t(1)`.
    ends: Vec<Mat3>,
    relative: Option<Relative>,
    /// Empty where stretches go in equal steps.
    stretches: Vec<Option<[f64; 2]>>,
    /// Triangles with a rotation of their own.
    turning: Vec<bool>,
    still: Vec<bool>,
    /// Of each component afloat.
    drifts: Vec<Drift>,
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
        let frames = [shape_frame("start", &mesh, start)?, shape_frame("end", &mesh, end)?];
        let scale = frames[0].scale.max(frames[1].scale);
        job.report(0.0, "rotations");

        // Rounding must not choose another path for the way back, so the order is settled first.
        let reversed = precedes(end, start);
        let order = if reversed {
            [(end, frames[1]), (start, frames[0])]
        } else {
            [(start, frames[0]), (end, frames[1])]
        };
        let [a, b] = order.map(|(shape, frame)| -> Vec<Vec3> {
            shape.iter().map(|&p| (p - frame.center) / scale).collect()
        });
        let geometry = [&a, &b].map(|x| TriangleGeometry::of(x, mesh.triangles()));
        let weights: Vec<[f64; 3]> = geometry[0]
            .half_cotangents
            .iter()
            .zip(&geometry[1].half_cotangents)
            .map(|(u, v)| [0, 1, 2].map(|c| 0.5 * (u[c] + v[c])))
            .collect();
        let motions = rotations::motions(&mesh, &a, &b);
        job.check()?;

        let neighbours = Neighbours::of(&mesh, &motions);
        let still: Vec<bool> = start.iter().zip(end).map(|(p, q)| p == q).collect();
        job.report(0.2, "branches");
        let (turns, tree) = match options.rotation {
            Rotation::Shortest => (branches::shortest(&motions), Vec::new()),
            Rotation::Consistent | Rotation::Relative => {
                branches::consistent(&neighbours, &motions, &moved_corners(&mesh, &still), job)?
            }
        };

        let mut warnings = Vec::new();
        let mut say = |argument: &str, problem: &str, offenders: &mut dyn Iterator<Item = usize>| {
            let ids = offenders.map(|t| mesh.triangle_ids()[t] as usize);
            warnings.extend(Fault::at(argument, problem, ids).map(|fault| fault.to_string()));
        };
        let names = if reversed { ["end", "start"] } else { ["start", "end"] };
        for (name, shape) in names.into_iter().zip(&geometry) {
            let slivers = (0..motions.len()).filter(|&t| shape.mollified[t]);
            say(name, "triangles that are slivers or without area, mollified", &mut { slivers });
        }
        let problem = "triangles that turn over against their neighbours between start and end";
        say("end", problem, &mut neighbours.inverted(&motions));

        let components = mesh.components();
        let problem = "components that are a mirror image of the start and cave in on the way, named by their first vertex";
        let firsts = components.members();
        let turned = mirrored(&mesh, &a, &b).into_iter().map(|c| firsts[c][0] as usize);
        warnings.extend(Fault::at("end", problem, turned).map(|fault| fault.to_string()));

        let volumes = options.preserve_volume.then(|| Volumes::of(&mesh, &a, &b));
        let open = volumes.iter().flat_map(Volumes::open).map(|c| firsts[c][0] as usize);
        let problem = "open components, which have no volume to preserve, named by their first vertex";
        warnings.extend(Fault::at("preserve_volume", problem, open).map(|fault| fault.to_string()));
        let clearance = match &options.clearance {
            Some(Obstacle { mesh, end: moved }) => {
                Some(Clearance::new(mesh.clone(), moved.as_deref(), [start, end], scale, job)?)
            }
            None => None,
        };

        job.report(0.5, "factorization");
        job.check()?;
        let elements = Elements::new(mesh.clone(), &weights, &still, job)?;
        warnings.extend(elements.system.factor().is_regularized().then(|| REGULARIZED.into()));
        let ends: Vec<Mat3> = turns.par_iter().map(|turn| turn.at(1.0)).collect();
        let apart = (order[1].1.center - order[0].1.center) / scale;
        let drift = |vertices: &Vec<u32>| Drift::of(vertices, &a, &b, apart);
        let drifts = elements.afloat.iter().map(drift).collect();
        let relative = match options.rotation {
            Rotation::Relative => Some(Relative::new(&mesh, &ends, tree, job)?),
            Rotation::Consistent | Rotation::Shortest => None,
        };
        let stretches = match options.stretch {
            Stretch::Linear => Vec::new(),
            Stretch::Logarithmic => stretch::stretches(&mesh, &motions, &a, &b),
        };
        let turning = motions.iter().map(|motion| motion.rotation().is_some()).collect();
        let hats = [&a, &b].map(|x| {
            let corners = mesh.triangles().par_iter().map(|t| t.map(|v| x[v as usize]));
            corners.zip(&weights).map(|(corners, w)| hats_of(corners, *w)).collect()
        });
        let shapes = order.map(|(shape, _)| shape.to_vec());
        job.report(1.0, "ready");
        Ok(Self {
            elements,
            options,
            shapes,
            unit: [a, b],
            reversed,
            scale,
            hats,
            turns,
            ends,
            relative,
            stretches,
            turning,
            still,
            drifts,
            volumes,
            clearance,
            warnings,
        })
    }

    /// What is doubtful: slivers, triangles that turn over. Empty for two shapes that agree.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// How many corners of each triangle move.
fn moved_corners(mesh: &Mesh, still: &[bool]) -> Vec<u8> {
    let moved = |t: &[u32; 3]| t.iter().filter(|&&v| !still[v as usize]).count() as u8;
    mesh.triangles().iter().map(moved).collect()
}

/// Checks one of the shapes.
fn shape_frame(argument: &str, mesh: &Mesh, shape: &[Vec3]) -> Result<UnitFrame> {
    if shape.len() != mesh.vertices().len() {
        let (rows, n) = (shape.len(), mesh.vertices().len());
        let problem = format!("has {rows} rows, the mesh has {n} vertices");
        return Err(Error::InvalidValue(Fault::new(argument, problem)));
    }
    let bad = shape.iter().enumerate().filter(|(_, p)| !p.is_finite()).map(|(v, _)| v);
    if let Some(fault) = Fault::at(argument, "not finite", bad) {
        return Err(Error::InvalidValue(fault));
    }
    let whole = || -> Result<UnitFrame> {
        let frame = UnitFrame::of(shape, mesh.triangles())?;
        let unit: Vec<Vec3> = shape.iter().map(|&p| frame.to_unit(p)).collect();
        validate::spread(&unit, mesh.triangles())?;
        Ok(frame)
    };
    whole().map_err(|error| match error {
        Error::InvalidMesh(fault) => Error::InvalidValue(Fault { argument: argument.to_owned(), ..fault }),
        other => other,
    })
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

/// Whether `a` comes before `b` at the first number in which they differ.
fn precedes(a: &[Vec3], b: &[Vec3]) -> bool {
    let differ = a.iter().zip(b).find(|(p, q)| p != q);
    differ.is_some_and(|(p, q)| p.to_array() < q.to_array())
}

#[cfg(test)]
mod tests;
