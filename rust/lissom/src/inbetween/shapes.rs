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
//! *Refinement* keeps `s` and takes both as unknown, positions and rotations: the local and global steps of
//! [`crate::stitch`].

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::branches::{self, Neighbours, TreeEdge};
use super::rotations::{self, TriangleMotion};
use super::turn::Turn;
use crate::geometry::frame::UnitFrame;
use crate::geometry::triangle::TriangleGeometry;
use crate::linear::{Constraints, REGULARIZED};
use crate::mesh::validate;
use crate::operators::hat_gradients_at;
use crate::rotation::nearest_rotation;
use crate::stitch::{Descent, HatGradients, Local, Owners, Reference, Stitcher, Stop, Weights, refine};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};

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
    /// Vertices that are in the same place in all shapes.
    pub stationary: Vec<bool>,
    hats: Vec<Vec<HatGradients>>,
    /// Slivers.
    pub warnings: Vec<String>,
}

/// What every triangle does from the first shape to another.
pub(super) struct Turns {
    pub motions: Vec<TriangleMotion>,
    pub turns: Vec<Turn>,
    /// The walk over the triangles that has chosen them.
    pub tree: Vec<TreeEdge>,
    /// Those that turn over, as the input of the mesh counts them.
    pub inverted: Vec<usize>,
    /// Components that turn by half a turn, for which the other way round is as near.
    pub halves: Vec<usize>,
}

/// What one shape to be stitched asks for.
pub(super) struct Targets<F> {
    /// The hats of a triangle's stretched edges, and those less the ones on the straight line.
    pub hats: F,
    /// `R_t - I`.
    pub changes: Vec<Mat3>,
    /// The straight blend of the shapes, in unit coordinates.
    pub line: Vec<Vec3>,
    /// Of each floating component, where its centroid is off the straight line; none of them where empty.
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
        let stationary: Vec<bool> = (0..mesh.rest().len())
            .map(|v| shapes.iter().all(|(_, shape)| shape[v] == shapes[0].1[v]))
            .collect();
        let constraints = Constraints::hard(stationary.len(), |v| stationary[v]);
        let weights = Weights::Corners(&weights);
        let stitcher = Stitcher::new(mesh, Owners::Triangles, weights, None, constraints, job)?;
        warnings.extend(stitcher.system().factor().is_regularized().then(|| REGULARIZED.into()));
        Ok(Self {
            stitcher,
            given: shapes.iter().map(|(_, shape)| shape.to_vec()).collect(),
            unit,
            origins: frames.iter().map(|frame| frame.center).collect(),
            scale,
            stationary,
            hats,
            warnings,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        self.stitcher.mesh()
    }

    /// The hats of a triangle in one of the shapes.
    pub fn hats(&self, shape: usize, triangle: usize) -> HatGradients {
        self.hats[shape][triangle]
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
        let motions = rotations::motions(mesh, &self.unit[0], &self.unit[shape]);
        job.check()?;
        let neighbours = Neighbours::of(mesh, &motions);
        let drifts = self.drifts(shape);
        let drift = |t: usize| {
            let component = mesh.components().of_vertex(mesh.triangles()[t][0] as usize);
            component.map_or(Vec3::ZERO, |c| drifts[c])
        };
        let (turns, tree, halves) = if agree {
            let moves = |v: &&u32| self.given[0][**v as usize] != self.given[shape][**v as usize];
            let moved = mesh.triangles().iter().map(|t| t.iter().filter(moves).count() as u8);
            branches::consistent(&neighbours, &motions, &moved.collect::<Vec<_>>(), drift, job)?
        } else {
            (branches::shortest(&motions, drift), Vec::new(), Vec::new())
        };
        let ids = neighbours.inverted(&motions).map(|t| mesh.triangle_ids()[t] as usize);
        let ids: BTreeSet<usize> = ids.collect();
        let halves = halves.iter().map(|&t| mesh.triangles()[t as usize][0] as usize);
        let halves = halves.filter_map(|v| mesh.components().of_vertex(v)).collect();
        Ok(Turns { inverted: ids.into_iter().collect(), motions, turns, tree, halves })
    }

    /// How far the centroid of every component goes from the first shape to another.
    fn drifts(&self, shape: usize) -> Vec<Vec3> {
        let drift = |vertices: Vec<u32>| {
            let moved = |&v: &u32| self.unit[shape][v as usize] - self.unit[0][v as usize];
            self.apart(shape) + vertices.iter().map(moved).sum::<Vec3>() / vertices.len() as f64
        };
        self.mesh().components().members().into_iter().map(drift).collect()
    }

    /// `y` of everything targets for, in unit coordinates, after `rounds` of refitting the rotations where they
    /// `may_turn`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`].
    pub fn stitch<F: Fn(usize) -> [HatGradients; 2] + Sync + Send>(
        &self,
        targets: &[Targets<F>],
        rounds: usize,
        may_turn: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Vec<Vec<Vec3>>> {
        let mut rhs = Vec::with_capacity(targets.len());
        for targets in targets {
            job.check()?;
            rhs.push(self.stitcher.divergence(targets.reference(), &targets.changes));
        }
        let mut shapes = vec![vec![Vec3::ZERO; self.stationary.len()]; targets.len()];
        self.stitcher.system().solve(&rhs, &mut shapes);
        targets.par_iter().zip(&mut shapes).try_for_each(|(targets, y)| {
            if rounds > 0 {
                let refit = Refit { stitcher: &self.stitcher, targets, may_turn: &may_turn };
                let start = refit.fit(std::mem::take(y));
                // The last step is the plain one, which needs no look at where it leads.
                let stop = Stop { max_iterations: rounds - 1, tolerance: 0.0 };
                let refined = refine(&refit, start, stop, |_| job.check())?.point;
                let [_, step] = refit.gradient(&refined);
                *y = refined.0.iter().zip(step).map(|(&y, step)| y - step).collect();
            }
            self.centre(&targets.offsets, y);
            Ok(())
        })?;
        Ok(shapes)
    }

    /// Moves every floating component so that its centroid is off its straight line by its offset, and welded
    /// vertices with those that they are welded to.
    pub fn centre(&self, offsets: &[Vec3], y: &mut [Vec3]) {
        for (k, vertices) in self.stitcher.floating().iter().enumerate() {
            let sum: Vec3 = vertices.iter().map(|&v| y[v as usize]).sum();
            let off = sum / vertices.len() as f64 - offsets.get(k).copied().unwrap_or_default();
            for &v in vertices {
                y[v as usize] -= off;
            }
        }
        self.mesh().follow(y);
    }
}

impl<F: Fn(usize) -> [HatGradients; 2] + Sync> Targets<F> {
    fn reference(&self) -> Reference<'_> {
        Reference::Edges { hats: &self.hats, base: &self.line }
    }
}

/// Rotations refitted to the stitched shape (Sorkine & Alexa 2007, As-Rigid-As-Possible Surface Modeling).
struct Refit<'a, F, M> {
    stitcher: &'a Stitcher,
    targets: &'a Targets<F>,
    may_turn: &'a M,
}

impl<F: Fn(usize) -> [HatGradients; 2] + Sync, M: Fn(usize) -> bool + Sync> Refit<'_, F, M> {
    /// The displacements with the targets that fit them best.
    fn fit(&self, displacements: Vec<Vec3>) -> (Vec<Vec3>, Local) {
        let pick = |t: usize, covariance: Mat3| {
            let turns = covariance != Mat3::ZERO && (self.may_turn)(t);
            if turns { nearest_rotation(covariance) } else { Mat3::IDENTITY + self.targets.changes[t] }
        };
        let local = self.stitcher.local_step(self.targets.reference(), &displacements, pick);
        (displacements, local)
    }
}

impl<F: Fn(usize) -> [HatGradients; 2] + Sync, M: Fn(usize) -> bool + Sync> Descent for Refit<'_, F, M> {
    type Point = (Vec<Vec3>, Local);

    fn energy(&self, (_, local): &Self::Point) -> (f64, f64) {
        (local.energy, local.size)
    }

    fn gradient(&self, (displacements, local): &Self::Point) -> [Vec<Vec3>; 2] {
        // Nothing is pulled here, only held.
        let gradient = self.stitcher.gradient(self.targets.reference(), &local.changes, displacements, &[]);
        let preconditioned = self.stitcher.precondition(&gradient);
        [gradient, preconditioned]
    }

    fn moved(&self, (from, _): &Self::Point, direction: &[Vec3], length: f64) -> Self::Point {
        self.fit(from.iter().zip(direction).map(|(&y, &d)| y + d * length).collect())
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
