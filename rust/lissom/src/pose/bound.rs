//! A mesh with handles, bound to a method: checks what comes in, solves, and writes back.

use std::sync::Arc;
use std::time::Instant;

use super::goal::{self, Goal};
use super::handles::{self, Handle};
use super::method::{CommonOptions, Method, Solution, SolveOptions};
use super::mirrored::Mirrored;
use super::own_turns::OwnTurns;
use super::region::Region;
use super::registry::MethodOptions;
use super::unheld::Followers;
use super::unwound::{Ways, turn_far};
use super::volume::KeptVolume;
use super::welding::Welding;
use crate::linear::{Factor, REGULARIZED};
use crate::options::OptionSet;
use crate::rotation::agree;
use crate::{Error, Fault, Job, Mat4, Mesh, Result, Vec3};

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
    /// The handles' matrices, those that turned by themselves turned; none of a pose by points.
    pub transforms: Vec<Mat4>,
    /// What the solve did.
    pub report: Report,
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
    /// The mesh with its mirror images, which is posed.
    whole: Arc<Mesh>,
    mirrored: Mirrored,
    welding: Welding,
    region: Region,
    method: Option<Box<dyn Method>>,
    volume: Option<KeptVolume>,
    followers: Followers,
    own_turns: OwnTurns,
    /// Made when a handle first turns far.
    ways: Option<Ways>,
    info: Info,
    warnings: Vec<String>,
}

impl Pose {
    /// Binds `handles` on `mesh`.
    ///
    /// `roi` lists the vertices that may move; `None` means all. Vertices outside it stay at rest; components without a
    /// handle do as [`CommonOptions::unheld`] says.
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
        common: &CommonOptions,
        method: &MethodOptions,
        job: &Job,
    ) -> Result<Self> {
        let begin = Instant::now();
        job.report(0.0, "region");
        roi.map(|roi| handles::membership(mesh.vertices().len(), roi)).transpose()?;
        let (mirrored, whole, handles) = Mirrored::of(mesh.clone(), handles, common)?;
        let (welding, welded) = Welding::of(&whole, handles);
        let roi = roi.map(|roi| mirrored.region(roi.iter().map(|&v| whole.representative(v)).collect()));
        let hold = common.hold();
        let region =
            Region::of(&whole, mirrored.symmetry(), welded, roi.as_deref(), hold, method.is_solid())?;
        job.report(0.1, "matrix");
        job.check()?;
        let method = if region.is_rigid() { None } else { Some(method.bind(&region, job)?) };
        let keeps = common.preserve_volume && method.is_some();
        let volume = if keeps { Some(KeptVolume::of(&whole, &region, job)?) } else { None };
        let followers = Followers::of(&whole, region.handles(), roi.as_deref(), common.unheld);
        let mut info = Info::default();
        let mut warnings = region.warnings().to_vec();
        warnings.extend_from_slice(followers.warnings());
        warnings.extend(mirrored.warning());
        warnings.extend(volume.as_ref().and_then(|volume| volume.warning(&whole)));
        let systems = method.iter().flat_map(|m| m.systems()).chain(volume.as_ref().map(KeptVolume::system));
        let factors: Vec<&Factor> = systems.map(|s| s.factor()).collect();
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
        let own_turns = OwnTurns::of(&whole, welding.handles());
        Ok(Self {
            mesh,
            whole,
            mirrored,
            welding,
            region,
            method,
            volume,
            followers,
            own_turns,
            ways: None,
            info,
            warnings,
        })
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
        self.mirrored.given().len()
    }

    /// Number of handle vertices, all handles together.
    pub fn handle_vertex_count(&self) -> usize {
        self.mirrored.given().iter().map(|handle| handle.vertices.len()).sum()
    }

    /// What is doubtful about the mesh, the handles, the region and the system.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Poses by one affine matrix per handle, rest to posed, in the mesh's own units.
    ///
    /// `turns`, one rotation vector per handle, says by how many whole turns each matrix rotates: the
    /// matrix's own rotation is taken on the branch nearest to it; turns about another axis come first,
    /// about axes of the rest pose. Without, rotations are taken on branches that agree with each other
    /// ([`agree`]).
    ///
    /// The handles `by_itself` turn about their centres as suits where all handles go, from the turn that they had in
    /// the last solve on or, in the first one and without `warm_start`, from that of their matrix.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for the wrong number of matrices or vectors, for values that are
    /// not finite and for numbers that are no handle's; [`Error::SolveFailed`] on overflow; [`Error::Cancelled`].
    pub fn solve(
        &mut self,
        transforms: &[Mat4],
        turns: Option<&[Vec3]>,
        by_itself: &[u32],
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
        options.check()?;
        let free = self.mirrored.all_of(&self.own_turns.free(by_itself, handles)?);
        let begin = Instant::now();
        let frame = self.whole.frame();
        let (leading, turns) = self.mirrored.lead(transforms, turns);
        let mut transforms = self.mirrored.transforms(&leading);
        let motions = goal::motions(&leading, turns.as_deref(), frame, self.region.is_anchored());
        let mut motions = self.mirrored.motions(&motions, frame);
        let mut pivots = Vec::new();
        if let Some(method) = self.method.as_ref().filter(|_| !free.is_empty()) {
            let how = (options.warm_start, method.turns_handles());
            self.own_turns.agree(&self.region, &free, &mut motions, how, job)?;
            motions = self.mirrored.symmetrise_motions(&motions, self.own_turns.centres(), frame);
            free.iter().for_each(|&h| transforms[h] = motions[h].matrix(frame));
            if method.turns_handles() {
                pivots = self.own_turns.pivots(&free, &motions);
            }
        }
        let (mut targets, mut own) = self.targets(&transforms);
        let goal = Goal { pivots, ..self.region.goal(&self.whole, &own, motions.clone(), true) };
        let solution = self.follow(&goal, options, job)?;
        if let Some(solution) = solution.as_ref().filter(|solution| !solution.turns.is_empty()) {
            self.own_turns.turn(&goal, &solution.turns, &mut motions);
            motions = self.mirrored.symmetrise_motions(&motions, self.own_turns.centres(), frame);
            free.iter().for_each(|&h| transforms[h] = motions[h].matrix(frame));
            (targets, own) = self.targets(&transforms);
        }
        transforms.truncate(handles);
        let mut unwound = Vec::new();
        if let Some(solution) = solution.as_ref().filter(|_| turn_far(&motions)) {
            let ways = self.ways.get_or_insert_with(|| Ways::of(&self.region));
            unwound = ways.warnings(&self.region, &motions, &solution.displacements, handles);
        }
        let mut posed = Posed { transforms, ..self.posed(&targets, &own, solution, begin)? };
        posed.report.warnings.extend(unwound);
        self.keep(job)?;
        self.own_turns.note(&free, &motions);
        Ok(posed)
    }

    /// What was cancelled or failed leaves the last pose to go on from.
    fn keep(&mut self, job: &Job) -> Result<()> {
        job.finish()?;
        self.method.iter_mut().for_each(|method| method.keep());
        Ok(())
    }

    /// Where matrices take the vertices of all handles, and those that are distinct.
    fn targets(&self, transforms: &[Mat4]) -> (Vec<Vec3>, Vec<Vec3>) {
        let rest = self.whole.vertices();
        let handles = self.welding.handles();
        let mut targets: Vec<Vec3> = (handles.iter().zip(transforms))
            .flat_map(|(handle, m)| handle.vertices.iter().map(|&v| m.transform_point3(rest[v as usize])))
            .collect();
        self.mirrored.symmetrise_targets(&self.whole, handles, &mut targets);
        let own = self.welding.distinct_targets(&self.whole, &targets);
        (targets, own)
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
        let mut targets = self.mirrored.targets(&self.whole, self.welding.handles(), targets);
        self.mirrored.symmetrise_targets(&self.whole, self.welding.handles(), &mut targets);
        let own = self.welding.distinct_targets(&self.whole, &targets);
        self.welding.expect_joined(&self.whole, &targets, &own)?;
        let motions = self.region.estimate_motions(&self.whole, &own);
        let mut motions = self.mirrored.leading(&motions);
        let mut rotations: Vec<Vec3> = motions.iter().map(|m| m.rotation).collect();
        agree(&mut rotations, self.region.is_anchored());
        motions.iter_mut().zip(rotations).for_each(|(m, rotation)| m.rotation = rotation);
        let motions = self.mirrored.motions(&motions, self.whole.frame());
        options.check()?;
        let begin = Instant::now();
        let goal = self.region.goal(&self.whole, &own, motions, false);
        let solution = self.follow(&goal, options, job)?;
        let posed = self.posed(&targets, &own, solution, begin)?;
        self.keep(job)?;
        Ok(posed)
    }

    fn follow(&mut self, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Option<Solution>> {
        self.method.as_mut().map(|method| method.solve(&self.region, goal, options, job)).transpose()
    }

    /// `targets` are those of the handles as given, `own` those of the region's.
    fn posed(
        &self,
        targets: &[Vec3],
        own: &[Vec3],
        solution: Option<Solution>,
        begin: Instant,
    ) -> Result<Posed> {
        let mut report = Report { converged: true, warnings: self.warnings().to_vec(), ..Report::default() };
        let mut vertices = self.whole.vertices().to_vec();
        if let Some(solution) = solution {
            self.region.write_back(&self.whole, &solution.displacements, &mut vertices);
            report.iterations = solution.iterations;
            report.energy = solution.energy;
            report.converged = solution.converged;
            report.warnings.extend(solution.warning());
        }
        let put = |vertices: &mut [Vec3]| {
            self.mirrored.symmetrise(&self.whole, vertices);
            self.welding.put(&self.whole, targets, own, vertices, |v| self.region.is_given(v));
        };
        put(&mut vertices);
        if let Some(volume) = &self.volume {
            volume.restore(&self.whole, &self.region, &mut vertices);
            put(&mut vertices);
        }
        self.followers.carry(&self.whole, &mut vertices);
        put(&mut vertices);
        vertices.truncate(self.mesh.vertices().len());
        if let Some(v) = vertices.iter().position(|p| !p.is_finite()) {
            return Err(Error::SolveFailed(format!("vertex {v} overflows the range of numbers")));
        }
        report.seconds = begin.elapsed().as_secs_f64();
        Ok(Posed { vertices, transforms: Vec::new(), report })
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
