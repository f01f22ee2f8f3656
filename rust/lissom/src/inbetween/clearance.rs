//! Clearance: no in-between deeper in an obstacle than the ends are.
//!
//! The *depth* of a vertex is its distance to the surface of the obstacle where it is inside, and zero outside. A vertex may be as deep
//! as at the deeper of its two ends. Those that are deeper are brought back to that depth by the shortest way and
//! held; all others follow by
//!
//! ```text
//!     L d = 0,        d given at the held vertices
//! ```
//!
//! which is the stitch under these constraints; until no vertex offends. A correction begins at zero where a vertex
//! begins to offend, so the path stays continuous in time.

use rayon::prelude::*;

use super::shapes::Shapes;
use crate::geometry::bodies::Bodies;
use crate::linear::{ConstrainedSystem, Constraints};
use crate::{Error, Fault, Job, Mesh, Result, Vec3};

/// Rounds of holding what offends.
const ROUNDS: usize = 30;

/// Depth beyond what is allowed, as a fraction of the size of the mesh, that offends nobody.
const NOTHING: f64 = 1e-9;

/// Where the vertices of an obstacle are at a time.
type Trajectory = Box<dyn Fn(f64, &Job) -> Result<Vec<Vec3>> + Send + Sync>;

/// The obstacle, and how deep each vertex may be in it.
pub(super) struct Clearance {
    triangles: Vec<[u32; 3]>,
    at: Trajectory,
    allowed: Vec<f64>,
    offence: f64,
}

impl std::fmt::Debug for Clearance {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Clearance from {} triangles", self.triangles.len())
    }
}

impl Clearance {
    /// `at` says where the vertices of `obstacle` are, `ends` are the two shapes.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for an obstacle with a border, and those of `at`.
    pub fn new(obstacle: &Mesh, at: Trajectory, ends: [&[Vec3]; 2], scale: f64, job: &Job) -> Result<Self> {
        let adjacency = obstacle.adjacency();
        let open = adjacency.edges().iter().enumerate();
        let open = open.filter(|(e, _)| adjacency.sides_of(*e).len() < 2).map(|(_, edge)| edge[0] as usize);
        if let Some(fault) = Fault::at("clearance", "not closed, has vertices on a border", open) {
            return Err(Error::InvalidValue(fault));
        }
        let triangles = obstacle.outward_triangles();
        let mut new = Self { triangles, at, allowed: vec![0.0; ends[0].len()], offence: NOTHING * scale };
        for (t, shape) in [0.0, 1.0].into_iter().zip(ends) {
            let bodies = new.bodies(t, job)?;
            let depths: Vec<f64> =
                shape.par_iter().map(|&p| bodies.deepest(p).map_or(0.0, |hit| hit.0)).collect();
            new.allowed.iter_mut().zip(depths).for_each(|(a, d)| *a = a.max(d));
        }
        Ok(new)
    }

    /// The obstacle where it is at time `t`.
    fn bodies(&self, t: f64, job: &Job) -> Result<Bodies> {
        Ok(Bodies::parts(&(self.at)(t, job)?, &self.triangles))
    }

    /// Moves `y` so that no vertex of the shape is too deep at time `t`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], [`Error::SolveFailed`].
    pub fn keep(
        &self,
        shapes: &Shapes,
        t: f64,
        y: &mut [Vec3],
        shape: impl Fn(&[Vec3]) -> Vec<Vec3>,
        job: &Job,
    ) -> Result<()> {
        let stationary = |v: usize| shapes.stationary[v];
        let bodies = self.bodies(t, job)?;
        let mesh = &**shapes.mesh();
        let from = y.to_vec();
        let mut held: Vec<Option<Vec3>> = vec![None; y.len()];
        for _ in 0..ROUNDS {
            job.check()?;
            let x = shape(y);
            let offending = |v: usize| {
                if stationary(v) || mesh.representative(v as u32) != v as u32 {
                    return None;
                }
                let (depth, nearest) = bodies.deepest(x[v])?;
                let allowed = self.allowed[v];
                (depth > allowed + self.offence)
                    .then(|| (v, nearest + (x[v] - nearest) * (allowed / depth) - x[v]))
            };
            let offenders: Vec<(usize, Vec3)> = (0..y.len()).into_par_iter().filter_map(offending).collect();
            if offenders.is_empty() {
                return Ok(());
            }
            for (v, back) in offenders {
                held[v] = Some(y[v] + back / shapes.scale - from[v]);
            }
            // Components that nobody in offends stay as they are.
            let mut touched = vec![false; mesh.components().count()];
            let component = |v: usize| mesh.components().of_vertex(v);
            for v in (0..y.len()).filter(|&v| held[v].is_some()) {
                if let Some(c) = component(v) {
                    touched[c] = true;
                }
            }
            let fixed =
                |v: usize| held[v].is_some() || stationary(v) || component(v).is_none_or(|c| !touched[c]);
            let mut given = [held.iter().map(|d| d.unwrap_or_default()).collect::<Vec<Vec3>>()];
            let constraints = Constraints::hard(y.len(), fixed);
            if !constraints.free().is_empty() {
                let system = ConstrainedSystem::new(shapes.stitcher.matrix(), constraints, job)?;
                system.solve::<Vec<Vec3>>(&[], &mut given);
            }
            for (v, &d) in given[0].iter().enumerate() {
                y[v] = from[v] + d;
            }
            mesh.follow(y);
        }
        Ok(())
    }
}
