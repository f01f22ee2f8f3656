//! Clearance: no in-between deeper in an obstacle than the ends are.
//!
//! The *depth* of a vertex is its distance to the surface of the obstacle where it is inside, by the winding number
//! (Jacobson, Kavan & Sorkine-Hornung 2013, Robust Inside-Outside Segmentation), and zero outside. A vertex may be as deep
//! as at the deeper of its two ends. Those that are deeper are brought back to that depth by the shortest way and
//! held; all others follow by
//!
//! ```text
//!     L d = 0,        d given at the held vertices
//! ```
//!
//! which is the stitch under these constraints; until no vertex offends. A correction begins at zero where a vertex
//! begins to offend, so the path stays continuous in time.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::{Inbetween, InbetweenOptions, Rotation};
use crate::geometry::surface::Surface;
use crate::linear::{Columns, ConstrainedSystem, Constraints};
use crate::{Error, Fault, Job, Mesh, Result, Vec3};
use std::sync::Arc;

/// Rounds of holding what offends.
const ROUNDS: usize = 30;

/// Depth beyond what is allowed, as a fraction of the size of the mesh, that offends nobody.
const NOTHING: f64 = 1e-9;

/// The obstacle, and how deep each vertex may be in it.
#[derive(Debug)]
pub(super) struct Clearance {
    obstacle: Arc<Mesh>,
    /// Its own path, where it moves.
    path: Option<Box<Inbetween>>,
    allowed: Vec<f64>,
    offence: f64,
}

impl Clearance {
    /// `ends` are the two shapes, `moved` where the obstacle is at the end, if not where it was.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for an obstacle with a border, and as [`Inbetween::new`] for its end.
    pub fn new(
        obstacle: Arc<Mesh>,
        moved: Option<&[Vec3]>,
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
        let path = match moved {
            Some(moved) => {
                let options = InbetweenOptions { rotation: Rotation::Consistent, ..Default::default() };
                let path = Inbetween::new(obstacle.clone(), obstacle.vertices(), moved, options, job);
                Some(Box::new(path.map_err(renamed)?))
            }
            None => None,
        };
        let mut new = Self { obstacle, path, allowed: Vec::new(), offence: NOTHING * scale };
        let mut allowed = vec![0.0f64; ends[0].len()];
        for (t, shape) in [0.0, 1.0].into_iter().zip(ends) {
            let surface = Surroundings::of(&new.obstacle, &new.at(t, job)?);
            let depths: Vec<f64> =
                shape.par_iter().map(|&p| surface.depth(p).map_or(0.0, |hit| hit.0)).collect();
            allowed.iter_mut().zip(depths).for_each(|(a, d)| *a = a.max(d));
        }
        new.allowed = allowed;
        Ok(new)
    }

    /// Where the obstacle is at time `t`.
    fn at(&self, t: f64, job: &Job) -> Result<Vec<Vec3>> {
        match &self.path {
            Some(path) => Ok(path.at(&[t], job)?.remove(0)),
            None => Ok(self.obstacle.vertices().to_vec()),
        }
    }

    /// Moves `y` so that no vertex of `path` is too deep at time `t`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], [`Error::SolveFailed`].
    pub fn keep(&self, path: &Inbetween, t: f64, y: &mut [Vec3], job: &Job) -> Result<()> {
        let (elements, still) = (&path.elements, |v: usize| path.still[v]);
        let surface = Surroundings::of(&self.obstacle, &self.at(t, job)?);
        let mesh = &*elements.mesh;
        let from = y.to_vec();
        let mut held: Vec<Option<Vec3>> = vec![None; y.len()];
        for _ in 0..ROUNDS {
            job.check()?;
            let x = path.shape(t, y);
            let offending = |v: usize| {
                if held[v].is_some() || still(v) || mesh.representative(v as u32) != v as u32 {
                    return None;
                }
                let (depth, nearest) = surface.depth(x[v])?;
                let allowed = self.allowed[v];
                (depth > allowed + self.offence)
                    .then(|| (v, nearest + (x[v] - nearest) * (allowed / depth) - x[v]))
            };
            let offenders: Vec<(usize, Vec3)> = (0..y.len()).into_par_iter().filter_map(offending).collect();
            if offenders.is_empty() {
                return Ok(());
            }
            for (v, back) in offenders {
                held[v] = Some(y[v] + back / path.scale - from[v]);
            }
            // Components that nobody in offends stay as they are.
            let mut touched = vec![false; mesh.components().count()];
            let component = |v: usize| mesh.components().of_vertex(v);
            for v in (0..y.len()).filter(|&v| held[v].is_some()) {
                if let Some(c) = component(v) {
                    touched[c] = true;
                }
            }
            let fixed = |v: usize| held[v].is_some() || still(v) || component(v).is_none_or(|c| !touched[c]);
            let mut given = Columns::zeros(y.len(), 3);
            for (v, d) in held.iter().enumerate() {
                if let Some(d) = d {
                    given.set_vector(0, v, *d);
                }
            }
            let constraints = Constraints::hard(y.len(), fixed);
            if !constraints.free().is_empty() {
                let system = ConstrainedSystem::new(&elements.laplacian, constraints, job)?;
                system.solve(&Columns::zeros(y.len(), 3), &mut given);
            }
            for (v, d) in given.vectors(0).into_iter().enumerate() {
                y[v] = from[v] + d;
            }
            mesh.follow(y);
        }
        Ok(())
    }
}

/// The fault of the obstacle's end by the caller's name for it.
fn renamed(error: Error) -> Error {
    match error {
        Error::InvalidValue(fault) => {
            Error::InvalidValue(Fault { argument: "clearance_end".to_owned(), ..fault })
        }
        other => other,
    }
}

/// The obstacle in one place.
struct Surroundings {
    surface: Surface,
    corners: Vec<[Vec3; 3]>,
    low: Vec3,
    high: Vec3,
}

impl Surroundings {
    fn of(mesh: &Mesh, positions: &[Vec3]) -> Self {
        let corners: Vec<[Vec3; 3]> =
            mesh.triangles().iter().map(|t| t.map(|v| positions[v as usize])).collect();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &p in corners.iter().flatten() {
            (low, high) = (low.min(p), high.max(p));
        }
        Self { surface: Surface::of(mesh, positions), corners, low, high }
    }

    /// How deep a point is inside, and the nearest point of the surface; `None` outside.
    fn depth(&self, p: Vec3) -> Option<(f64, Vec3)> {
        if p.cmplt(self.low).any() || p.cmpgt(self.high).any() {
            return None;
        }
        // Van Oosterom & Strackee 1983, The Solid Angle of a Plane Triangle: half of it each.
        let half: f64 = (self.corners.iter())
            .map(|corners| {
                let [a, b, c] = corners.map(|x| x - p);
                let [m, n, o] = [a, b, c].map(Vec3::length);
                let below = m * n * o + a.dot(b) * o + b.dot(c) * m + c.dot(a) * n;
                a.dot(b.cross(c)).atan2(below)
            })
            .sum();
        if half.abs() < PI {
            return None;
        }
        self.surface.closest_point(p).map(|hit| (hit.distance, hit.point))
    }
}
