//! Clearance: no in-between closer to an obstacle, or deeper in it, than the ends are.
//!
//! The *height* of a vertex is its distance from the surface of the obstacle, negative inside. A vertex may be as low as at
//! the lower of its two ends, and where it is high at both, so high that triangles between such vertices do not dip into
//! a round obstacle. Those that are lower are brought back to that height by the shortest way and held; all others
//! follow by
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

/// Height that a vertex keeps where both ends have more, over its longest edge: a regular triangle of edges `e` dips by
/// `e^2 / 6r` into a ball of radius `r`, and is no larger than that.
const KEPT: f64 = 1.0 / 6.0;

/// What a vertex may be lower than it should, as a fraction of the size of the mesh, and offend nobody.
const NOTHING: f64 = 1e-9;

/// Where the vertices of an obstacle are at a time.
type Trajectory = Box<dyn Fn(f64, &Job) -> Result<Vec<Vec3>> + Send + Sync>;

/// The obstacle, and how low each vertex may be.
pub(super) struct Clearance {
    triangles: Vec<[u32; 3]>,
    at: Trajectory,
    lowest: Vec<f64>,
    offence: f64,
}

impl std::fmt::Debug for Clearance {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Clearance from {} triangles", self.triangles.len())
    }
}

impl Clearance {
    /// `at` says where the vertices of `obstacle` are, `ends` are the two shapes of `mesh`.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for an obstacle with a border, and those of `at`.
    pub fn new(
        mesh: &Mesh,
        obstacle: &Mesh,
        at: Trajectory,
        ends: [&[Vec3]; 2],
        scale: f64,
        job: &Job,
    ) -> Result<Self> {
        let adjacency = obstacle.adjacency();
        let open = adjacency.edges().iter().enumerate();
        let open = open.filter(|(e, _)| adjacency.sides_of(*e).len() < 2).map(|(_, edge)| edge[0] as usize);
        if let Some(fault) = Fault::at("clearance", "not closed, has vertices on a border", open) {
            return Err(Error::InvalidValue(fault));
        }
        let triangles = obstacle.outward_triangles();
        let lowest = kept(mesh, ends);
        let mut new = Self { triangles, at, lowest, offence: NOTHING * scale };
        for (t, shape) in [0.0, 1.0].into_iter().zip(ends) {
            let bodies = new.bodies(t, job)?;
            let lower = |(lowest, &p): (&mut f64, &Vec3)| {
                *lowest = bodies.side(p, *lowest).map_or(*lowest, |side| side.signed_distance);
            };
            new.lowest.par_iter_mut().zip(shape).for_each(lower);
        }
        Ok(new)
    }

    /// The obstacle where it is at time `t`.
    fn bodies(&self, t: f64, job: &Job) -> Result<Bodies> {
        Ok(Bodies::parts(&(self.at)(t, job)?, &self.triangles))
    }

    /// Moves `y` so that no vertex of the shape is too low at time `t`.
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
                let lowest = self.lowest[v];
                let side = bodies.side(x[v], lowest - self.offence)?;
                let away = x[v] - side.hit.point;
                let out = (away * side.signed_distance.signum()).try_normalize().unwrap_or(side.out);
                Some((v, out * lowest - away))
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

/// The height that each vertex keeps where both ends have more.
fn kept(mesh: &Mesh, ends: [&[Vec3]; 2]) -> Vec<f64> {
    let mut kept = vec![0.0f64; ends[0].len()];
    for &[a, b] in mesh.adjacency().edges() {
        let [a, b] = [a, b].map(|v| v as usize);
        let long = ends.map(|x| x[a].distance(x[b])).into_iter().fold(0.0, f64::max);
        for v in [a, b] {
            kept[v] = kept[v].max(KEPT * long);
        }
    }
    kept
}
