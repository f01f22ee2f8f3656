//! Blend: several shapes of one mesh at once, as rigidly as possible.
//!
//! From `start` to shape `k` every triangle turns by the rotation vector `w_k` and stretches by `S_k`. At weights `a_k` it
//! shall turn and stretch by the combination
//!
//! ```text
//!     R = exp( sum_k a_k w_k ),        S = I + sum_k a_k (S_k - I)
//! ```
//!
//! (compare Sumner, Zwicker, Gotsman & Popović 2005, Mesh-Based Inverse Kinematics), and the result is stitched. Shapes that
//! turn the same part add their turns up, where adding offsets would collapse it. It is `start` where all weights are
//! zero, shape `k` where that weight is one and the others zero.

use std::sync::Arc;

use rayon::prelude::*;

use super::branches::{self, Neighbours};
use super::elements::{Asked, Elements, Hats};
use super::{moved_corners, rotations, shape_frame};
use crate::geometry::triangle::TriangleGeometry;
use crate::linear::REGULARIZED;
use crate::operators::hats_of;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory, rotation};

/// Several shapes of a mesh, factored once and combined at any weights.
#[derive(Debug)]
pub struct Blend {
    elements: Elements,
    /// `start` and then the shapes, in the mesh's own units and in unit coordinates.
    shapes: Vec<Vec<Vec3>>,
    unit: Vec<Vec<Vec3>>,
    scale: f64,
    weights: Vec<[f64; 3]>,
    /// Rotation vectors of each shape.
    turns: Vec<Vec<Vec3>>,
    turning: Vec<bool>,
    refinement: usize,
    warnings: Vec<String>,
}

impl Blend {
    /// Prepares to blend `shapes`, one position per vertex of `mesh` each, with `refinement` rounds of refitting.
    ///
    /// # Errors
    ///
    /// As [`super::Inbetween::new`]; [`Error::OutOfMemory`].
    pub fn new(
        mesh: Arc<Mesh>,
        start: &[Vec3],
        shapes: &[Vec<Vec3>],
        refinement: usize,
        job: &Job,
    ) -> Result<Self> {
        let (n, m) = (mesh.vertices().len() as u128, mesh.triangles().len() as u128);
        memory::check("the shapes to blend", size_of::<Vec3>() as u128 * (2 * n + m) * shapes.len() as u128)?;
        let mut frames = vec![shape_frame("start", &mesh, start)?];
        for (k, shape) in shapes.iter().enumerate() {
            frames.push(shape_frame(&format!("shapes[{k}]"), &mesh, shape)?);
        }
        let scale = frames.iter().map(|frame| frame.scale).fold(0.0, f64::max);
        let shapes: Vec<Vec<Vec3>> = std::iter::once(start.to_vec()).chain(shapes.iter().cloned()).collect();
        let unit: Vec<Vec<Vec3>> = (shapes.iter().zip(&frames))
            .map(|(shape, frame)| shape.iter().map(|&p| (p - frame.center) / scale).collect())
            .collect();
        let mut weights = vec![[0.0; 3]; mesh.triangles().len()];
        let (mut turns, mut turning, mut warnings) = (Vec::new(), vec![true; weights.len()], Vec::new());
        for (k, shape) in unit.iter().enumerate() {
            job.report(k as f64 / unit.len() as f64, "rotations");
            job.check()?;
            let share = 1.0 / unit.len() as f64;
            for (sum, w) in
                weights.iter_mut().zip(TriangleGeometry::of(shape, mesh.triangles()).half_cotangents)
            {
                (0..3).for_each(|c| sum[c] += share * w[c]);
            }
            if k == 0 {
                continue;
            }
            let motions = rotations::motions(&mesh, &unit[0], shape);
            let neighbours = Neighbours::of(&mesh, &motions);
            let still: Vec<bool> = shapes[0].iter().zip(&shapes[k]).map(|(p, q)| p == q).collect();
            let (found, _) = branches::consistent(&neighbours, &motions, &moved_corners(&mesh, &still), job)?;
            turns.push(
                (found.par_iter())
                    .map(|turn| rotation::nearest_branch(rotation::log(turn.at(1.0)), turn.omega()))
                    .collect(),
            );
            turning.iter_mut().zip(&motions).for_each(|(turns, m)| *turns &= m.rotation().is_some());
            let ids = neighbours.inverted(&motions).map(|t| mesh.triangle_ids()[t] as usize);
            let problem = "triangles that turn over against their neighbours between start and this shape";
            let fault = Fault::at(format!("shapes[{}]", k - 1), problem, ids);
            warnings.extend(fault.map(|fault| fault.to_string()));
        }
        let still: Vec<bool> =
            (0..start.len()).map(|v| shapes.iter().all(|shape| shape[v] == start[v])).collect();
        let elements = Elements::new(mesh, &weights, &still, job)?;
        warnings.extend(elements.system.factor().is_regularized().then(|| REGULARIZED.into()));
        job.report(1.0, "ready");
        Ok(Self { elements, shapes, unit, scale, weights, turns, turning, refinement, warnings })
    }

    /// What is doubtful: triangles that turn over.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Positions at the given weights, one per shape, in the mesh's own units. Weights may be any numbers.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for weights that are not finite or of another number, [`Error::SolveFailed`] where positions
    /// overflow, [`Error::Cancelled`].
    pub fn at(&self, weights: &[f64], job: &Job) -> Result<Vec<Vec3>> {
        if weights.len() != self.turns.len() {
            let problem = format!("has {} values, there are {} shapes", weights.len(), self.turns.len());
            return Err(Error::InvalidValue(Fault::new("weights", problem)));
        }
        let bad = weights.iter().enumerate().filter(|(_, a)| !a.is_finite()).map(|(k, _)| k);
        if let Some(fault) = Fault::at("weights", "not finite", bad) {
            return Err(Error::InvalidValue(fault));
        }
        let used: Vec<(usize, f64)> =
            weights.iter().copied().enumerate().filter(|(_, a)| *a != 0.0).collect();
        match used[..] {
            [] => return Ok(self.shapes[0].clone()),
            [(k, 1.0)] => return Ok(self.shapes[k + 1].clone()),
            _ => {}
        }
        let turn = |t: usize| rotation::exp(used.iter().map(|&(k, a)| self.turns[k][t] * a).sum());
        let rotations: Vec<Mat3> = (0..self.weights.len()).into_par_iter().map(turn).collect();
        let hats = |t: usize| -> (Hats, Hats) {
            let of = |shape: &[Vec3]| {
                hats_of(self.elements.mesh.triangles()[t].map(|v| shape[v as usize]), self.weights[t])
            };
            let start = of(&self.unit[0]);
            let (mut stretched, mut line) = (start, start);
            for &(k, a) in &used {
                let back = rotation::exp(self.turns[k][t]).transpose();
                let shape = of(&self.unit[k + 1]);
                for c in 0..3 {
                    stretched[c] += (back * shape[c] - start[c]) * a;
                    line[c] += (shape[c] - start[c]) * a;
                }
            }
            (stretched, line)
        };
        let sum = |shapes: &[Vec<Vec3>]| -> Vec<Vec3> {
            let at = |v: usize| {
                used.iter().fold(shapes[0][v], |x, &(k, a)| x + (shapes[k + 1][v] - shapes[0][v]) * a)
            };
            (0..shapes[0].len()).map(at).collect()
        };
        let asked = [Asked { hats, rotations, line: sum(&self.unit), drift: Vec::new() }];
        let y = self.elements.stitch(&asked, self.refinement, |t| self.turning[t], job)?.remove(0);
        let x: Vec<Vec3> = sum(&self.shapes).iter().zip(y).map(|(&x, y)| x + y * self.scale).collect();
        if x.iter().all(|p| p.is_finite()) {
            return Ok(x);
        }
        Err(Error::SolveFailed("weights: positions beyond the range of numbers".into()))
    }
}
