//! Shapes of one mesh, prepared for paths and blends between them; and what their triangles ask for, stitched.
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - R_t s_te |^2
//! ```
//!
//! with the stretched edges `s_te` and the rotations `R_t` that a path or a blend chooses, and for `w_te` the mean of
//! the shapes' half cotangents. The unknown is `y = x - line`, how far the result lies off the straight blend of the
//! shapes. Where nothing turns `y` is zero to the last bit.
//!
//! *Refinement* keeps `s` and refits the rotations to what came out (`refit`).

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::branches::{self, Branches};
use super::neighbours::Neighbours;
use super::refit::refit;
use super::riders::Riders;
use super::rotations::{self, TriangleMotion};
use super::turn::Turn;
use crate::geometry::frame::UnitFrame;
use crate::geometry::triangle::TriangleGeometry;
use crate::linear::{Constraints, REGULARIZED};
use crate::mesh::validate;
use crate::operators::hat_gradients_at;
use crate::stitch::{HatGradients, Owners, Reference, Stitcher, Weights};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};

/// What single precision and a few steps of computing in it leave, as a fraction of the largest coordinate: vertices
/// that move by less are still. Far from the origin, at most [`UNSEEN`] of the size.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;
const UNSEEN: f64 = 1e-3;

/// Shapes of one mesh and the stitch between them.
#[derive(Debug)]
pub(super) struct Shapes {
    pub stitcher: Stitcher,
    /// In the mesh's own units.
    pub given: Vec<Vec<Vec3>>,
    /// In unit coordinates: all share a scale, each has its own origin.
    pub unit: Vec<Vec<Vec3>>,
    /// The origins of unit coordinates, in the mesh's own units, and what a unit is there.
    origins: Vec<Vec3>,
    pub scale: f64,
    /// Vertices that are in the same place in all shapes, to single precision.
    pub stationary: Vec<bool>,
    pub riders: Riders,
    /// Vertices that move by no more are still, and a path that is no farther off its straight line is straight.
    pub rounding: f64,
    hats: Vec<Vec<HatGradients>>,
    /// Slivers.
    pub warnings: Vec<String>,
}

/// What every triangle does from the first shape to another.
pub(super) struct Turns {
    pub motions: Vec<TriangleMotion>,
    pub turns: Vec<Turn>,
    /// The triangles that the others' turns were chosen from.
    pub roots: Vec<u32>,
    /// From the hosts of parts that ride to these: where their turns were chosen from.
    pub links: Vec<[u32; 2]>,
    /// Those that turn over, as the input of the mesh counts them.
    pub inverted: Vec<usize>,
    /// Components that turn by half a turn, for which the other way round is as near.
    pub halves: Vec<usize>,
}

/// What is known of a triangle in a shape.
#[derive(Debug, Clone, Copy)]
pub(super) enum Of {
    Hats,
    Corners,
}

/// The hats of a triangle's stretched edges, or its stretched corners, and those less the ones on the straight line.
pub(super) trait Stretched: Fn(usize, Of) -> [[Vec3; 3]; 2] + Sync + Send {}

impl<F: Fn(usize, Of) -> [[Vec3; 3]; 2] + Sync + Send> Stretched for F {}

/// What one shape to be stitched asks for.
pub(super) struct Targets<F> {
    /// [`Stretched`]
    pub stretched: F,
    /// `R_t - I`.
    pub changes: Vec<Mat3>,
    /// The straight blend of the shapes, in unit coordinates, and the share of each.
    pub line: Vec<Vec3>,
    pub shares: Vec<f64>,
    /// Of each floating component, where its centroid is off the straight line, seen from where it rides; none of them
    /// where empty.
    pub offsets: Vec<Vec3>,
}

impl Shapes {
    /// Prepares `shapes` with the names that the caller knows them by, one position per vertex of `mesh` each.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for shapes of the wrong length, with values that are not finite, or all of whose
    /// points lie on one point or line; [`Error::SolveFailed`], [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn new(mesh: Arc<Mesh>, shapes: &[(String, &[Vec3])], job: &Job) -> Result<Self> {
        job.report(0.0, "shapes");
        let frames = shapes.iter().map(|(name, shape)| shape_frame(name, &mesh, shape));
        let frames: Vec<UnitFrame> = frames.collect::<Result<_>>()?;
        let scale = frames.iter().map(|frame| frame.scale).fold(0.0, f64::max);
        let unit: Vec<Vec<Vec3>> = (shapes.iter().zip(&frames))
            .map(|((_, shape), frame)| shape.iter().map(|&p| (p - frame.center) / scale).collect())
            .collect();
        let share = 1.0 / shapes.len() as f64;
        let mut weights = vec![[0.0; 3]; mesh.triangles().len()];
        let mut warnings = Vec::new();
        for ((name, _), shape) in shapes.iter().zip(&unit) {
            job.check()?;
            let geometry = TriangleGeometry::of(shape, mesh.triangles());
            for (sum, w) in weights.iter_mut().zip(&geometry.half_cotangents) {
                (0..3).for_each(|c| sum[c] += share * w[c]);
            }
            let slivers = mesh.triangle_ids().iter().zip(&geometry.mollified).filter(|(_, flat)| **flat);
            // A mirror image is named as what it is the image of.
            let slivers: BTreeSet<usize> = slivers.map(|(&id, _)| id as usize).collect();
            let problem = "triangles that are slivers or without area, mollified";
            let fault = Fault::at(name, problem, slivers);
            warnings.extend(fault.map(|fault| fault.to_string()));
        }
        let hats = unit.iter().map(|x| hat_gradients_at(&mesh, &weights, x)).collect();
        let corners = mesh.triangles().iter().flatten();
        let coordinates = shapes
            .iter()
            .flat_map(|(_, shape)| corners.clone().map(|&v| shape[v as usize].abs().max_element()));
        let rounding = (ROUNDING * coordinates.fold(scale, f64::max)).min(UNSEEN * scale);
        let stationary: Vec<bool> = (0..mesh.rest().len())
            .map(|v| shapes.iter().all(|(_, shape)| shape[v].distance(shapes[0].1[v]) <= rounding))
            .collect();
        let constraints = Constraints::hard(stationary.len(), |v| stationary[v]);
        let weights = Weights::Corners(&weights);
        let stitcher = Stitcher::new(mesh, Owners::Triangles, weights, None, constraints, job)?;
        let riders = Riders::of(stitcher.mesh(), &unit, stitcher.floating(), &stationary);
        warnings.extend(stitcher.system().factor().is_regularized().then(|| REGULARIZED.into()));
        Ok(Self {
            stitcher,
            given: shapes.iter().map(|(_, shape)| shape.to_vec()).collect(),
            unit,
            origins: frames.iter().map(|frame| frame.center).collect(),
            scale,
            stationary,
            riders,
            rounding,
            hats,
            warnings,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        self.stitcher.mesh()
    }

    /// The hats, or the corners, of a triangle in one of the shapes.
    pub fn triangle(&self, shape: usize, triangle: usize, of: Of) -> [Vec3; 3] {
        match of {
            Of::Hats => self.hats[shape][triangle],
            Of::Corners => self.mesh().triangles()[triangle].map(|v| self.unit[shape][v as usize]),
        }
    }

    /// How far the origin of unit coordinates goes from the first shape to another, in these units.
    pub fn apart(&self, shape: usize) -> Vec3 {
        (self.origins[shape] - self.origins[0]) / self.scale
    }

    /// How triangles turn from the first shape to another: so that neighbours agree or, where that is not targets for,
    /// each the short way.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`].
    pub fn turns(&self, shape: usize, agree: bool, job: &Job) -> Result<Turns> {
        let mesh = &**self.mesh();
        let moves =
            |v: &&u32| self.given[0][**v as usize].distance(self.given[shape][**v as usize]) > self.rounding;
        let moved: Vec<u8> = mesh.triangles().iter().map(|t| t.iter().filter(moves).count() as u8).collect();
        let mut motions = rotations::motions(mesh, &self.unit[0], &self.unit[shape]);
        for (motion, _) in motions.iter_mut().zip(&moved).filter(|(_, moved)| **moved == 0) {
            *motion = TriangleMotion::Turns(Mat3::IDENTITY);
        }
        job.check()?;
        let neighbours = Neighbours::of(mesh, &motions);
        let drifts = self.drifts(shape);
        let drift = |t: usize| {
            let component = mesh.components().of_vertex(mesh.triangles()[t][0] as usize);
            component.map_or(Vec3::ZERO, |c| drifts[c])
        };
        let leaves = |t: usize, beside: usize, turned: Mat3| {
            let apart = |x: &[Vec3]| {
                let [p, q] =
                    [t, beside].map(|t| mesh.triangles()[t].iter().map(|&v| x[v as usize]).sum::<Vec3>());
                (p - q) / 3.0
            };
            apart(&self.unit[shape]) - turned * apart(&self.unit[0])
        };
        let Branches { turns, roots, links, halves } = if agree {
            let links = self.riders.links(mesh, self.stitcher.floating());
            branches::consistent(&neighbours, &motions, &moved, &links, drift, leaves, job)?
        } else {
            Branches { turns: branches::shortest(&motions, drift), ..Branches::default() }
        };
        let ids = neighbours.inverted(&motions).map(|t| mesh.triangle_ids()[t] as usize);
        let ids: BTreeSet<usize> = ids.collect();
        let halves = halves.iter().map(|&t| mesh.triangles()[t as usize][0] as usize);
        let halves = halves.filter_map(|v| mesh.components().of_vertex(v)).collect();
        Ok(Turns { inverted: ids.into_iter().collect(), motions, turns, roots, links, halves })
    }

    /// How far the centroid of every component goes from the first shape to another, or that of what it rides on.
    fn drifts(&self, shape: usize) -> Vec<Vec3> {
        let drift = |vertices: Vec<u32>| {
            let moved = |&v: &u32| self.unit[shape][v as usize] - self.unit[0][v as usize];
            self.apart(shape) + vertices.iter().map(moved).sum::<Vec3>() / vertices.len() as f64
        };
        let mut drifts: Vec<Vec3> = self.mesh().components().members().into_iter().map(drift).collect();
        for part in &self.riders.parts {
            drifts[part.component] = drifts[part.seat.component];
        }
        drifts
    }

    /// `y` of everything targets for, in unit coordinates, after `rounds` of refitting the rotations where they
    /// `may_turn`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`].
    pub fn stitch<F: Stretched>(
        &self,
        targets: &[Targets<F>],
        rounds: usize,
        may_turn: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Vec<Vec<Vec3>>> {
        let mut rhs = Vec::with_capacity(targets.len());
        for targets in targets {
            job.check()?;
            rhs.push(targets.divergence(&self.stitcher, &targets.changes));
        }
        let mut shapes = vec![vec![Vec3::ZERO; self.stationary.len()]; targets.len()];
        self.stitcher.system().solve(&rhs, &mut shapes);
        for _ in 0..rounds {
            for ((targets, y), rhs) in targets.iter().zip(&shapes).zip(&mut rhs) {
                job.check()?;
                *rhs = targets.divergence(&self.stitcher, &self.refitted(targets, y, &may_turn));
            }
            self.stitcher.system().solve(&rhs, &mut shapes);
        }
        for (targets, y) in targets.iter().zip(&mut shapes) {
            self.place(targets, y);
        }
        Ok(shapes)
    }

    /// `R_t - I` refitted to the shape `y`.
    fn refitted<F: Stretched>(
        &self,
        targets: &Targets<F>,
        y: &[Vec3],
        may_turn: impl Fn(usize) -> bool + Sync,
    ) -> Vec<Mat3> {
        let x: Vec<Vec3> = targets.line.iter().zip(y).map(|(&line, &y)| line + y).collect();
        let hats = |t: usize| (targets.stretched)(t, Of::Hats);
        let reference = Reference::Edges { hats: &hats, base: &targets.line };
        let found = self.stitcher.covariances(reference, &x);
        let change = |(t, found): (usize, Mat3)| {
            let asked = targets.changes[t];
            if !may_turn(t) || found == Mat3::ZERO {
                return asked;
            }
            let [corners, hats] = [Of::Corners, Of::Hats].map(|of| (targets.stretched)(t, of)[0]);
            refit(Mat3::IDENTITY + asked, corners, hats, found) - Mat3::IDENTITY
        };
        found.into_par_iter().enumerate().map(change).collect()
    }

    /// Moves every floating component so that its centroid is off its straight line by its offset, what rides with its
    /// seat, and welded vertices with those that they are welded to.
    pub fn place<F>(&self, targets: &Targets<F>, y: &mut [Vec3]) {
        let (floating, offsets) = (self.stitcher.floating(), &targets.offsets);
        for (k, vertices) in floating.iter().enumerate() {
            let sum: Vec3 = vertices.iter().map(|&v| y[v as usize]).sum();
            let off = sum / vertices.len() as f64 - offsets.get(k).copied().unwrap_or_default();
            for &v in vertices {
                y[v as usize] -= off;
            }
        }
        self.riders.place(floating, &self.unit, &targets.shares, offsets, &targets.line, y);
        self.mesh().follow(y);
    }
}

impl<F: Stretched> Targets<F> {
    fn divergence(&self, stitcher: &Stitcher, changes: &[Mat3]) -> Vec<Vec3> {
        let hats = |t: usize| (self.stretched)(t, Of::Hats);
        stitcher.divergence(Reference::Edges { hats: &hats, base: &self.line }, changes)
    }
}

/// Checks one of the shapes.
pub(super) fn shape_frame(argument: &str, mesh: &Mesh, shape: &[Vec3]) -> Result<UnitFrame> {
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
        validate::refuse_collinear(&unit, mesh.triangles())?;
        Ok(frame)
    };
    whole().map_err(|error| error.renamed(argument))
}
