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

use super::shapes::{Of, Shapes, Targets};
use super::turn::Turn;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory, rotation};

/// Several shapes of a mesh, factored once and combined at any weights.
#[derive(Debug)]
pub struct Blend {
    /// `start` and then the shapes.
    shapes: Shapes,
    /// Rotation vectors of each shape but the first.
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
        let bytes = size_of::<Vec3>() as u128 * (2 * n + 4 * m) * (shapes.len() + 1) as u128;
        memory::check("the shapes to blend", bytes)?;
        let mut named = vec![("start".to_owned(), start)];
        named.extend(shapes.iter().enumerate().map(|(k, shape)| (format!("shapes[{k}]"), shape.as_slice())));
        let shapes = Shapes::new(mesh, &named, job)?;
        let mut turning = vec![true; shapes.mesh().triangles().len()];
        let (mut turns, mut warnings) = (Vec::new(), shapes.warnings.clone());
        for k in 1..named.len() {
            job.report(0.5 + 0.5 * k as f64 / named.len() as f64, "rotations");
            job.check()?;
            let found = shapes.turns(k, true, job)?;
            let vector = |turn: &Turn| rotation::nearest_branch(rotation::log(turn.at(1.0)), turn.omega());
            turns.push(found.turns.par_iter().map(vector).collect());
            turning.iter_mut().zip(&found.motions).for_each(|(turns, m)| *turns &= m.rotation().is_some());
            let problem = "triangles that turn over against their neighbours between start and this shape";
            let fault = Fault::at(named[k].0.as_str(), problem, found.inverted);
            warnings.extend(fault.map(|fault| fault.to_string()));
        }
        job.report(1.0, "ready");
        Ok(Self { shapes, turns, turning, refinement, warnings })
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
            [] => return Ok(self.shapes.given[0].clone()),
            [(k, 1.0)] => return Ok(self.shapes.given[k + 1].clone()),
            _ => {}
        }
        let turn = |t: usize| rotation::exp(used.iter().map(|&(k, a)| self.turns[k][t] * a).sum());
        let change = |t: usize| turn(t) - Mat3::IDENTITY;
        let changes: Vec<Mat3> = (0..self.turning.len()).into_par_iter().map(change).collect();
        let stretched = |t: usize, of: Of| -> [[Vec3; 3]; 2] {
            let start = self.shapes.triangle(0, t, of);
            let (mut stretched, mut line) = (start, start);
            for &(k, a) in &used {
                let back = rotation::exp(self.turns[k][t]).transpose();
                let shape = self.shapes.triangle(k + 1, t, of);
                for c in 0..3 {
                    stretched[c] += (back * shape[c] - start[c]) * a;
                    line[c] += (shape[c] - start[c]) * a;
                }
            }
            [stretched, [0, 1, 2].map(|c| stretched[c] - line[c])]
        };
        let sum = |shapes: &[Vec<Vec3>]| -> Vec<Vec3> {
            let at = |v: usize| {
                used.iter().fold(shapes[0][v], |x, &(k, a)| x + (shapes[k + 1][v] - shapes[0][v]) * a)
            };
            (0..shapes[0].len()).map(at).collect()
        };
        let shares = [&[1.0 - weights.iter().sum::<f64>()], weights].concat();
        let targets =
            [Targets { stretched, changes, line: sum(&self.shapes.unit), shares, offsets: Vec::new() }];
        let y = self.shapes.stitch(&targets, self.refinement, |t| self.turning[t], job)?.remove(0);
        let x: Vec<Vec3> =
            sum(&self.shapes.given).iter().zip(y).map(|(&x, y)| x + y * self.shapes.scale).collect();
        if x.iter().all(|p| p.is_finite()) {
            return Ok(x);
        }
        Err(Error::SolveFailed("weights: positions beyond the range of numbers".into()))
    }
}
