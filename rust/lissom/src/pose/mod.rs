//! Pose a mesh by handles: some vertices are moved, some stay, the rest follow, details intact.
//!
//! [`Pose`] prepares a region of interest and its handles once ([`region`]) and a method
//! ([`Method`], one a file); each solve turns the handles' motion into a [`Goal`] and hands it to the
//! method. Methods see a mesh that consists of the region alone, so none knows of anything outside.
//!
//! | file | method | chooses |
//! |---|---|---|
//! | [`arap`] | as rigid as possible | the rotations that fit the current shape best, again and again |

mod anderson;
pub mod arap;
mod harmonic;
mod region;

use std::sync::Arc;
use std::time::Instant;

pub use region::Region;

use crate::rotation::{log, nearest_rotation};
use crate::{Error, Fault, Job, Mat3, Mat4, Mesh, Result, Vec3};

/// Names of the methods, as in `lissom.POSE_METHODS`.
pub const METHODS: &[&str] = &["arap"];

/// How long an iterative method goes on, and from where.
#[derive(Debug, Clone, Copy)]
pub struct SolveOptions {
    /// Most iterations.
    pub max_iterations: usize,
    /// Stop when an iteration lowers the energy by less than this fraction of it.
    pub tolerance: f64,
    /// Start from the previous pose, where there is one, instead of the linear guess.
    pub warm_start: bool,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { max_iterations: 200, tolerance: 1e-6, warm_start: true }
    }
}

/// What a solve did.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// Iterations, 1 for linear methods.
    pub iterations: usize,
    /// The method's energy at the end, in unit coordinates.
    pub energy: f64,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// Time of the solve.
    pub seconds: f64,
    /// What is doubtful about the result.
    pub warnings: Vec<String>,
}

/// A posed mesh.
#[derive(Debug, Clone)]
pub struct Posed {
    /// All positions, in the mesh's own units.
    pub vertices: Vec<Vec3>,
    /// What the solve did.
    pub report: Report,
}

/// Where the handles ask the region to go, in unit coordinates of the region's mesh.
#[derive(Debug)]
pub struct Goal {
    /// Displacement of every vertex that is given; zero elsewhere.
    pub displacements: Vec<Vec3>,
    /// Rotation vector of every vertex that is given: its handle's rotation; zero elsewhere.
    pub rotations: Vec<Vec3>,
}

/// What a method makes of a goal.
#[derive(Debug)]
pub struct Solution {
    /// Displacement of every vertex of the region's mesh, in unit coordinates.
    pub displacements: Vec<Vec3>,
    /// Iterations done.
    pub iterations: usize,
    /// Energy at the end.
    pub energy: f64,
    /// Whether the tolerance was reached.
    pub converged: bool,
}

/// A way to pose a region. An instance is bound to one region, and keeps what it factored.
pub trait Method: Send + std::fmt::Debug {
    /// Moves the free vertices of `region` so that they follow `goal`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], and [`Error::SolveFailed`] where the linear algebra gives up.
    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution>;
}

/// A mesh with handles, ready to be posed.
#[derive(Debug)]
pub struct Pose {
    mesh: Arc<Mesh>,
    region: Region,
    method: Option<Box<dyn Method>>,
}

impl Pose {
    /// Binds `handles` (vertex indices, one list per handle) on `mesh`.
    ///
    /// `roi` lists the vertices that may move; `None` means all. Vertices outside it, and components
    /// without a handle, stay at rest. `method` is one of [`METHODS`].
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for no or empty handles, a vertex in two handles, indices out of
    /// range and an empty region; [`Error::InvalidValue`] for an unknown method;
    /// [`Error::SolveFailed`] where the system cannot be factored.
    pub fn new(mesh: Arc<Mesh>, handles: Vec<Vec<u32>>, roi: Option<&[u32]>, method: &str) -> Result<Self> {
        let region = Region::of(&mesh, handles, roi)?;
        let method: Option<Box<dyn Method>> = match method {
            _ if region.is_rigid() => None,
            "arap" => Some(Box::new(arap::Arap::new(&region)?)),
            other => {
                let problem = format!("no method named '{other}', there are {}", METHODS.join(", "));
                return Err(Error::InvalidValue(Fault::new("method", problem)));
            }
        };
        Ok(Self { mesh, region, method })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Number of handles.
    pub fn handle_count(&self) -> usize {
        self.region.handles().len()
    }

    /// Number of handle vertices, all handles together.
    pub fn handle_vertex_count(&self) -> usize {
        self.region.handles().iter().map(Vec::len).sum()
    }

    /// What is doubtful about the handles and the region.
    pub fn warnings(&self) -> &[String] {
        self.region.warnings()
    }

    /// Poses by one affine matrix per handle, rest to posed, in the mesh's own units.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for the wrong number of matrices and for values that are not
    /// finite; [`Error::SolveFailed`] on overflow; [`Error::Cancelled`].
    pub fn solve(&mut self, transforms: &[Mat4], options: &SolveOptions, job: &Job) -> Result<Posed> {
        let handles = self.handle_count();
        expect_count("transforms", "matrices", transforms.len(), handles, "handles")?;
        let broken = transforms.iter().enumerate().filter(|(_, m)| !m.is_finite()).map(|(h, _)| h);
        refuse("transforms", "not finite", broken)?;
        let projective = transforms.iter().enumerate();
        let projective = projective.filter(|(_, m)| m.row(3) != glam::DVec4::W).map(|(h, _)| h);
        refuse("transforms", "not affine: the last row must be 0 0 0 1", projective)?;
        let rest = self.mesh.vertices();
        let targets: Vec<Vec3> = (self.region.handles().iter().zip(transforms))
            .flat_map(|(handle, m)| handle.iter().map(|&v| m.transform_point3(rest[v as usize])))
            .collect();
        let rotations: Vec<Vec3> =
            transforms.iter().map(|m| log(nearest_rotation(Mat3::from_mat4(*m)))).collect();
        self.pose(&targets, &rotations, options, job)
    }

    /// Poses by one target per handle vertex, handles in order, in the mesh's own units.
    ///
    /// Each handle's rotation is estimated from its own vertices; handles too small for that take
    /// the rotation of all given vertices together.
    ///
    /// # Errors
    ///
    /// As [`Pose::solve`].
    pub fn solve_points(&mut self, targets: &[Vec3], options: &SolveOptions, job: &Job) -> Result<Posed> {
        expect_count("targets", "points", targets.len(), self.handle_vertex_count(), "handle vertices")?;
        let broken = targets.iter().enumerate().filter(|(_, p)| !p.is_finite()).map(|(i, _)| i);
        refuse("targets", "not finite", broken)?;
        let rotations = self.region.estimate_rotations(&self.mesh, targets);
        self.pose(targets, &rotations, options, job)
    }

    fn pose(
        &mut self,
        targets: &[Vec3],
        rotations: &[Vec3],
        options: &SolveOptions,
        job: &Job,
    ) -> Result<Posed> {
        if options.tolerance.is_nan() || options.tolerance < 0.0 {
            return Err(Error::InvalidValue(Fault::new("tolerance", "must be 0 or more")));
        }
        let begin = Instant::now();
        let mut report = Report { converged: true, warnings: self.warnings().to_vec(), ..Report::default() };
        let mut vertices = self.mesh.vertices().to_vec();
        if let Some(method) = &mut self.method {
            let goal = self.region.goal(&self.mesh, targets, rotations);
            let solution = method.solve(&self.region, &goal, options, job)?;
            self.region.write_back(&self.mesh, &solution.displacements, &mut vertices);
            report.iterations = solution.iterations;
            report.energy = solution.energy;
            report.converged = solution.converged;
            if !solution.converged {
                report.warnings.push(format!(
                    "not converged after {} iterations: raise max_iterations or tolerance",
                    solution.iterations
                ));
            }
        }
        for (&v, &target) in self.region.handles().iter().flatten().zip(targets) {
            vertices[v as usize] = target;
        }
        if let Some(v) = vertices.iter().position(|p| !p.is_finite()) {
            return Err(Error::SolveFailed(format!("vertex {v} overflows the range of numbers")));
        }
        report.seconds = begin.elapsed().as_secs_f64();
        Ok(Posed { vertices, report })
    }
}

fn expect_count(argument: &str, what: &str, given: usize, wanted: usize, of: &str) -> Result<()> {
    if given == wanted {
        return Ok(());
    }
    let problem = format!("{given} {what} for {wanted} {of}");
    Err(Error::InvalidConstraint(Fault::new(argument, problem)))
}

fn refuse(argument: &str, problem: &str, offenders: impl Iterator<Item = usize>) -> Result<()> {
    Fault::at(argument, problem, offenders).map_or(Ok(()), |fault| Err(Error::InvalidConstraint(fault)))
}
