//! Pose a mesh by handles: some vertices are moved, some stay, the rest follow, details intact.
//!
//! [`Pose`] prepares a region of interest and its handles once ([`region`]) and a method
//! ([`Method`], one a file); each solve turns the handles' motion into a [`Goal`] and hands it to the
//! method. Methods see a mesh that consists of the region alone, so none knows of anything outside.
//!
//! | file | chooses |
//! |---|---|
//! | [`laplacian`] | the rest pose's Laplacian coordinates, as they are |
//! | [`laplacian_fitted`] | the same, turned and scaled for each vertex as its neighbours move |
//! | [`rotation_invariant`] | frames that differ from their neighbours' as they did at rest |
//! | [`thin_shell`] | no detail: the displacement stretches and bends least |
//! | [`poisson`] | the handles' rotations and stretches, blended by smooth weights |
//! | [`multiresolution`] | how a smoothed base moves, by any other method |
//! | [`arap`] | the rotations that fit the current shape best, again and again |

pub mod arap;
mod field;
pub mod laplacian;
pub mod laplacian_fitted;
pub(crate) mod lbfgs;
pub mod multiresolution;
pub mod poisson;
mod region;
mod responses;
pub mod rotation_invariant;
pub mod thin_shell;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::time::Instant;

pub use region::Region;
pub use responses::{Linear, Response};

use crate::linear::{ConstrainedSystem, Factor, REGULARIZED};
use crate::rotation::{agree, log, nearest_branch, nearest_rotation};
use crate::{Error, Fault, Job, Mat3, Mat4, Mesh, Result, Vec3};

/// Names of the methods, as in `lissom.POSE_METHODS`.
pub const METHODS: &[&str] = &[
    "laplacian",
    "laplacian_fitted",
    "rotation_invariant",
    "thin_shell",
    "poisson",
    "multiresolution",
    "arap",
];

/// Welded vertices may be asked to go this far apart, as a fraction of the diagonal.
const TORN: f64 = 1e-6;

/// A method and its options; one of [`METHODS`] each.
#[derive(Debug, Clone)]
pub enum MethodOptions {
    /// [`laplacian`]
    Laplacian(laplacian::Options),
    /// [`laplacian_fitted`]
    LaplacianFitted(laplacian_fitted::Options),
    /// [`thin_shell`]
    ThinShell(thin_shell::Options),
    /// [`rotation_invariant`]
    RotationInvariant(rotation_invariant::Options),
    /// [`poisson`]
    Poisson(poisson::Options),
    /// [`multiresolution`]
    Multiresolution(multiresolution::Options),
    /// [`arap`]
    Arap(arap::Options),
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self::Arap(arap::Options::default())
    }
}

impl MethodOptions {
    fn bind(&self, region: &Region, job: &Job) -> Result<Box<dyn Method>> {
        Ok(match self {
            Self::Laplacian(options) => {
                Box::new(Linear::new(laplacian::Laplacian::new(region, options, job)?))
            }
            Self::LaplacianFitted(options) => {
                Box::new(Linear::new(laplacian_fitted::LaplacianFitted::new(region, options, job)?))
            }
            Self::ThinShell(options) => {
                Box::new(Linear::new(thin_shell::ThinShell::new(region, options, job)?))
            }
            Self::RotationInvariant(options) => rotation_invariant::bind(region, options, job)?,
            Self::Poisson(options) => Box::new(poisson::Poisson::new(region, options, job)?),
            Self::Multiresolution(options) => {
                Box::new(multiresolution::Multiresolution::new(region, options, job)?)
            }
            Self::Arap(options) => Box::new(arap::Arap::new(region, options, job)?),
        })
    }
}

/// Vertices that move together.
#[derive(Debug, Clone)]
pub struct Handle {
    /// The vertices.
    pub vertices: Vec<u32>,
    /// How much each belongs to the handle, above 0 and at most 1; `None` where all do wholly. A vertex
    /// of membership `m < 1` stays free, and is pulled with the weight `m / (1 - m)`.
    pub membership: Option<Vec<f64>>,
}

impl From<Vec<u32>> for Handle {
    fn from(vertices: Vec<u32>) -> Self {
        Self { vertices, membership: None }
    }
}

/// How the handles hold their vertices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Hold {
    /// Exactly: they are eliminated.
    #[default]
    Hard,
    /// With this weight, squared in the energy (thesis 2.2, equation 2-4).
    Soft(f64),
}

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
    /// The energy at the end, in unit coordinates; `None` for linear methods.
    pub energy: Option<f64>,
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
#[derive(Debug, Clone)]
pub struct Goal {
    /// Displacement of every vertex that is given or pulled; zero elsewhere.
    pub displacements: Vec<Vec3>,
    /// Motion of every handle.
    pub handles: Vec<Motion>,
    /// Whether the displacements are those of the handles' affine motions, and not of single points.
    pub affine: bool,
}

/// How a handle moves as a whole.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Rotation vector: axis times angle, with whole turns.
    pub rotation: Vec3,
    /// Whole turns about another axis, before `rotation`; zero where that tells all.
    pub whole_turns: Vec3,
    /// The linear part, `R S`.
    pub linear: Mat3,
    /// Displacement of the origin of unit coordinates.
    pub offset: Vec3,
}

/// What a method makes of a goal.
#[derive(Debug)]
pub struct Solution {
    /// Displacement of every vertex of the region's mesh, in unit coordinates.
    pub displacements: Vec<Vec3>,
    /// Iterations done.
    pub iterations: usize,
    /// Energy at the end, of iterative methods.
    pub energy: Option<f64>,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// The fraction of the energy by which the last iteration lowered it.
    pub residual: f64,
}

impl Solution {
    /// What a method that does not iterate found.
    pub(crate) fn direct(displacements: Vec<Vec3>) -> Self {
        Self { displacements, iterations: 1, energy: None, converged: true, residual: 0.0 }
    }
}

/// A way to pose a region. An instance is bound to one region, and keeps what it factored.
pub trait Method: Send + std::fmt::Debug {
    /// Moves the free vertices of `region` so that they follow `goal`.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], and [`Error::SolveFailed`] where the linear algebra gives up.
    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution>;

    /// What it factored, to solve by.
    fn systems(&self) -> Vec<&ConstrainedSystem>;
}

/// What binding a pose made; all systems of its method together.
#[derive(Debug, Clone, Copy, Default)]
pub struct Info {
    /// Unknowns.
    pub unknowns: usize,
    /// Values in the factors, zeros that fill up blocks included.
    pub nonzeros: usize,
    /// Bytes of the factors, indices included.
    pub bytes: usize,
    /// Time of binding.
    pub seconds: f64,
}

/// A mesh with handles, ready to be posed.
#[derive(Debug)]
pub struct Pose {
    mesh: Arc<Mesh>,
    /// The handles, as given.
    handles: Vec<Handle>,
    /// Of all their vertices, those that stand for the ones that are welded to the same; their places.
    distinct: Vec<usize>,
    region: Region,
    method: Option<Box<dyn Method>>,
    info: Info,
    warnings: Vec<String>,
}

impl Pose {
    /// Binds `handles` on `mesh`.
    ///
    /// `roi` lists the vertices that may move; `None` means all. Vertices outside it, and components
    /// without a handle, stay at rest.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for no or empty handles, a vertex in two handles, indices out of
    /// range, membership outside (0, 1] and an empty region; [`Error::InvalidValue`] for options out of
    /// their range; [`Error::SolveFailed`] where the system cannot be factored; [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn new(
        mesh: Arc<Mesh>,
        handles: Vec<Handle>,
        roi: Option<&[u32]>,
        hold: Hold,
        method: &MethodOptions,
        job: &Job,
    ) -> Result<Self> {
        let begin = Instant::now();
        job.report(0.0, "region");
        let (distinct, welded) = weld(&mesh, &handles);
        let roi = roi.map(|roi| roi.iter().map(|&v| mesh.representative(v)).collect::<Vec<_>>());
        let region = Region::of(&mesh, welded, roi.as_deref(), hold)?;
        job.report(0.1, "matrix");
        job.check()?;
        let method = if region.is_rigid() { None } else { Some(method.bind(&region, job)?) };
        let mut info = Info::default();
        let mut warnings = region.warnings().to_vec();
        let factors: Vec<&Factor> = method.iter().flat_map(|m| m.systems()).map(|s| s.factor()).collect();
        for factor in &factors {
            info.unknowns += factor.size();
            info.nonzeros += factor.nonzeros();
            info.bytes += factor.bytes();
        }
        if factors.iter().any(|factor| factor.is_regularized()) {
            warnings.push(REGULARIZED.into());
        }
        info.seconds = begin.elapsed().as_secs_f64();
        job.report(1.0, "ready");
        Ok(Self { mesh, handles, distinct, region, method, info, warnings })
    }

    /// What binding made.
    pub fn info(&self) -> Info {
        self.info
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Number of handles.
    pub fn handle_count(&self) -> usize {
        self.handles.len()
    }

    /// Number of handle vertices, all handles together.
    pub fn handle_vertex_count(&self) -> usize {
        self.handles.iter().map(|h| h.vertices.len()).sum()
    }

    /// What is doubtful about the mesh, the handles, the region and the system.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Poses by one affine matrix per handle, rest to posed, in the mesh's own units.
    ///
    /// `turns`, one rotation vector per handle, says by how many whole turns each matrix rotates: the
    /// matrix's own rotation is lifted to the branch nearest to it; turns about another axis come first,
    /// about axes of the rest pose. Without, rotations are lifted to branches that agree with each other
    /// ([`agree`]).
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for the wrong number of matrices or vectors and for values that are
    /// not finite; [`Error::SolveFailed`] on overflow; [`Error::Cancelled`].
    pub fn solve(
        &mut self,
        transforms: &[Mat4],
        turns: Option<&[Vec3]>,
        options: &SolveOptions,
        job: &Job,
    ) -> Result<Posed> {
        let handles = self.handle_count();
        expect_count("transforms", "matrices", transforms.len(), handles, "handles")?;
        let broken = transforms.iter().enumerate().filter(|(_, m)| !m.is_finite()).map(|(h, _)| h);
        refuse("transforms", "not finite", broken)?;
        let projective = transforms.iter().enumerate();
        let projective = projective.filter(|(_, m)| m.row(3) != glam::DVec4::W).map(|(h, _)| h);
        refuse("transforms", "not affine: the last row must be 0 0 0 1", projective)?;
        if let Some(turns) = turns {
            expect_count("turns", "rotation vectors", turns.len(), handles, "handles")?;
            let broken = turns.iter().enumerate().filter(|(_, r)| !r.is_finite()).map(|(h, _)| h);
            refuse("turns", "not finite", broken)?;
        }
        let rest = self.mesh.vertices();
        let targets: Vec<Vec3> = (self.handles.iter().zip(transforms))
            .flat_map(|(handle, m)| handle.vertices.iter().map(|&v| m.transform_point3(rest[v as usize])))
            .collect();
        let frame = self.mesh.frame();
        let linear = |m: &Mat4| Mat3::from_mat4(*m);
        let mut rotations: Vec<Vec3> = transforms.iter().map(|m| log(nearest_rotation(linear(m)))).collect();
        let mut whole_turns = vec![Vec3::ZERO; handles];
        match turns {
            Some(turns) => {
                for h in 0..handles {
                    (rotations[h], whole_turns[h]) = with_turns(rotations[h], turns[h]);
                }
            }
            None => agree(&mut rotations, self.region.is_anchored()),
        }
        let rotations = rotations.into_iter().zip(whole_turns);
        let motions = transforms.iter().zip(rotations).map(|(m, (rotation, whole_turns))| Motion {
            rotation,
            whole_turns,
            linear: linear(m),
            offset: (m.transform_point3(frame.center) - frame.center) / frame.scale,
        });
        let own = self.of_region(&targets);
        let goal = self.region.goal(&self.mesh, &own, motions.collect(), true);
        self.pose(&targets, &own, &goal, options, job)
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
        let own = self.of_region(targets);
        self.expect_joined(targets, &own)?;
        let mut motions = self.region.estimate_motions(&self.mesh, &own);
        let mut rotations: Vec<Vec3> = motions.iter().map(|m| m.rotation).collect();
        agree(&mut rotations, self.region.is_anchored());
        motions.iter_mut().zip(rotations).for_each(|(m, rotation)| m.rotation = rotation);
        let goal = self.region.goal(&self.mesh, &own, motions, false);
        self.pose(targets, &own, &goal, options, job)
    }

    /// The targets of the region's handle vertices, from those of the handles as given.
    fn of_region(&self, targets: &[Vec3]) -> Vec<Vec3> {
        let given: Vec<u32> = self.handles.iter().flat_map(|h| &h.vertices).copied().collect();
        let own = |&place: &usize| {
            self.beside(given[place], self.mesh.representative(given[place]), targets[place])
        };
        self.distinct.iter().map(own).collect()
    }

    /// Where `to` goes when `from`, which it is welded to, goes to `target`.
    fn beside(&self, from: u32, to: u32, target: Vec3) -> Vec3 {
        let offset = self.mesh.vertices()[to as usize] - self.mesh.vertices()[from as usize];
        if offset == Vec3::ZERO { target } else { target + offset }
    }

    /// Refuses targets that tear welded vertices apart.
    fn expect_joined(&self, targets: &[Vec3], own: &[Vec3]) -> Result<()> {
        let place: HashMap<u32, Vec3> = self
            .region
            .handles()
            .iter()
            .flat_map(|h| h.vertices.iter().copied())
            .zip(own.iter().copied())
            .collect();
        let torn = self.handles.iter().flat_map(|h| &h.vertices).zip(targets).enumerate().filter(
            |(_, (v, target))| {
                let w = self.mesh.representative(**v);
                let apart = self.beside(w, **v, place[&w]).distance(**target);
                let seam = self.mesh.vertices()[**v as usize].distance(self.mesh.vertices()[w as usize]);
                apart > TORN * self.mesh.frame().scale + 3.0 * seam
            },
        );
        refuse("targets", "vertices that are welded together go apart", torn.map(|(i, _)| i))
    }

    /// `targets` are those of the handles as given, `own` those of the region's.
    fn pose(
        &mut self,
        targets: &[Vec3],
        own: &[Vec3],
        goal: &Goal,
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
            let solution = method.solve(&self.region, goal, options, job)?;
            self.region.write_back(&self.mesh, &solution.displacements, &mut vertices);
            report.iterations = solution.iterations;
            report.energy = solution.energy;
            report.converged = solution.converged;
            if !solution.converged {
                let last = match solution.residual.is_finite() {
                    true => {
                        format!(", the last of which lowered the energy by {:.1e} of it", solution.residual)
                    }
                    false => String::new(),
                };
                report.warnings.push(format!(
                    "not converged after {} iterations{last}: raise max_iterations or tolerance",
                    solution.iterations
                ));
            }
        }
        let mesh = &self.mesh;
        let handled = self.region.handles().iter().flat_map(|h| &h.vertices);
        for (&v, &target) in handled.zip(own).filter(|(v, _)| self.region.is_given(**v)) {
            vertices[v as usize] = target;
        }
        for (v, w) in mesh.welds() {
            vertices[v as usize] = self.beside(w, v, vertices[w as usize]);
        }
        let handled = self.handles.iter().flat_map(|h| &h.vertices);
        for (&v, &target) in handled.zip(targets) {
            if self.region.is_given(mesh.representative(v)) {
                vertices[v as usize] = target;
            }
        }
        if let Some(v) = vertices.iter().position(|p| !p.is_finite()) {
            return Err(Error::SolveFailed(format!("vertex {v} overflows the range of numbers")));
        }
        report.seconds = begin.elapsed().as_secs_f64();
        Ok(Posed { vertices, report })
    }
}

/// The handles on the vertices that theirs are welded to, each named once, and which of all theirs these are.
fn weld(mesh: &Mesh, handles: &[Handle]) -> (Vec<usize>, Vec<Handle>) {
    let (mut distinct, mut start) = (Vec::new(), 0);
    let mut welded = handles.to_vec();
    for handle in &mut welded {
        let mut first = HashMap::new();
        // A vertex given twice is a mistake, which is not hidden here.
        let stays = |&v: &u32| *first.entry(mesh.representative(v)).or_insert(v) == v;
        let stays: Vec<bool> = handle.vertices.iter().map(stays).collect();
        distinct.extend((start..).zip(&stays).filter(|(_, stays)| **stays).map(|(place, _)| place));
        start += stays.len();
        let kept = |i: usize| stays.get(i).is_none_or(|stays| *stays);
        let mut places = 0..;
        handle.vertices.retain(|_| places.next().is_some_and(kept));
        handle.vertices.iter_mut().for_each(|v| *v = mesh.representative(*v));
        if let Some(membership) = &mut handle.membership
            && membership.len() == stays.len()
        {
            let mut places = 0..;
            membership.retain(|_| places.next().is_some_and(kept));
        }
    }
    (distinct, welded)
}

/// Splits a rotation that has done about `turns` into a rotation vector and whole turns before it. Near
/// whole turns a matrix says nothing of their axis, and a twist with a tilt has no vector of its own.
fn with_turns(own: Vec3, turns: Vec3) -> (Vec3, Vec3) {
    let lifted = nearest_branch(own, turns);
    if lifted.distance(turns) <= PI {
        return (lifted, Vec3::ZERO);
    }
    let whole = turns.normalize_or_zero() * (TAU * (turns.length() / TAU).round());
    (nearest_branch(own, turns - whole), whole)
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
