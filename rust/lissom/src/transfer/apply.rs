//! Apply: carry the source's keys over to the target.
//!
//! ```text
//!     min_x  sum_t  w_t | grad_t x - C_t (I - n n^T) |^2
//! ```
//!
//! with `C_t` from the matched source triangles ([`super::choose`]), solved by the stitcher, all keys
//! and coordinates as right-hand sides of one factorization; then every component is put in its
//! place ([`super::place`]). Displacements are solved for, so a key that moves nothing moves nothing.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::anchor::Anchors;
use super::choose::{Chooser, SourceKey};
use super::closing::{Closing, Moving, Ways};
use super::correspondence::Correspondence;
use super::options::{TransferOptions, Unmatched, Weighting};
use super::place::Placer;
use super::rims::Rims;
use super::scale::Scaling;
use super::sizes::Sizes;
use crate::linear::{Constraints, REGULARIZED};
use crate::options::OptionSet;
use crate::stitch::{Owners, Reference, Stitcher, Weights};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory};

/// Keys solved together, between two looks at the job.
const KEYS_AT_ONCE: usize = 8;

/// Triangles below this fraction of the mean area count as having it, where weights are per pair.
const LEAST_AREA: f64 = 1e-3;

/// What a triangle that nothing is known of weighs against others: it follows them and must not hold them, as the
/// bag behind the lips would if the source has none.
const UNMATCHED: f64 = 0.01;

/// Longest `l`: it still says where a component is.
const LONGEST: f64 = 1e3;

/// Keys carried over.
#[derive(Debug, Clone)]
pub struct Transferred {
    /// (k) sets of target positions in the target's units.
    pub poses: Vec<Vec<Vec3>>,
    /// How long all of it took.
    pub time: Duration,
    /// How long of it the back-substitution took, which no way of transfer with this system can do without.
    pub solve_time: Duration,
}

/// A prepared transfer from one mesh to another: everything that does not depend on the key.
pub struct Transfer {
    /// Turned to face as the target does, ...
    pub(super) source: Arc<Mesh>,
    /// ... by this, as its poses are when they come in.
    turn: Mat3,
    pub(super) target: Arc<Mesh>,
    /// As the triangles in use count.
    pub(super) used: Correspondence,
    pub(super) chooser: Chooser,
    pub(super) anchors: Anchors,
    pub(super) scaling: Scaling,
    pub(super) placer: Placer,
    pub(super) closing: Option<Closing>,
    /// What can come together, once it is asked for.
    rims: OnceLock<Rims>,
    stitcher: Stitcher,
    /// `w_t` over the area of the triangle.
    pub(super) weights: Vec<f64>,
    /// How many times their length edges get at most, unless the source's do ([`super::tears`]).
    pub(super) stretch: f64,
    warnings: Vec<String>,
}

impl Transfer {
    /// Prepares to carry shapes from `source` to `target`, whose places belong together as `matches` says.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for no pairs or indices out of range, [`Error::SolveFailed`],
    /// [`Error::Cancelled`].
    pub fn new(
        source: Arc<Mesh>,
        target: Arc<Mesh>,
        matches: &Correspondence,
        options: TransferOptions,
        job: &Job,
    ) -> Result<Self> {
        job.report(0.0, "prepare");
        options.check()?;
        let used = matches.in_use(&source, &target)?;
        let turn = matches.turn;
        let source = if turn == Mat3::IDENTITY { source } else { Arc::new(source.turned(turn)) };
        let chooser = Chooser::new(&source, &target, &used, options.frames)?;
        job.check()?;
        let weights = weights(&target, &chooser, options.weighting);
        let sizes = Sizes::new(&source, &target, options.scale, matches.overlap);
        let anchors = Anchors::new(&target, &chooser, &weights, options.anchor.min(LONGEST), sizes);
        let constraints = Constraints::hard(target.rest().len(), |_| false).with_soft(anchors.soft());
        let scaled = Weights::Scaled(&weights);
        let stitcher = Stitcher::new(target.clone(), Owners::Triangles, scaled, None, constraints, job)?;
        job.check()?;
        let policy = options.unmatched;
        let placer = Placer::new(&source, &target, stitcher.matrix(), &chooser, &anchors, policy, sizes);
        let scaling = Scaling::new(&target, &anchors, &placer, sizes);
        let closing = options.contact.then(Closing::default);
        let problem = match policy {
            Unmatched::Follow => "components without a match follow the nearest matched surface rigidly",
            Unmatched::Rest => "components without a match stay at rest",
        };
        let fault = Fault::at("pairs", problem, placer.unmatched());
        let regularized = stitcher.system().factor().is_regularized().then(|| REGULARIZED.into());
        let warnings = fault.map(|fault| fault.to_string()).into_iter().chain(regularized).collect();
        job.report(1.0, "prepare");
        Ok(Self {
            source,
            turn,
            target,
            used,
            chooser,
            anchors,
            scaling,
            placer,
            closing,
            rims: OnceLock::new(),
            stitcher,
            weights,
            stretch: options.stretch,
            warnings,
        })
    }

    /// What is doubtful about the matches.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The mesh that keys come from.
    pub fn source(&self) -> &Arc<Mesh> {
        &self.source
    }

    /// The mesh that keys go to.
    pub fn target(&self) -> &Arc<Mesh> {
        &self.target
    }

    /// Carries `poses` over: (k) sets of source positions in the source's units become (k) sets of
    /// target positions in the target's units.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for poses of another size than the source or with values that are not
    /// finite, [`Error::SolveFailed`] where the result is out of range, [`Error::Cancelled`].
    pub fn apply(&self, poses: &[Vec<Vec3>], job: &Job) -> Result<Transferred> {
        let start = Instant::now();
        check("poses", poses, &self.source, "source")?;
        // Once here, and once more for whoever takes them over.
        let bytes =
            2 * size_of::<Vec3>() as u128 * poses.len() as u128 * self.target.vertices().len() as u128;
        memory::check("the keys", bytes)?;
        let mut results = Vec::with_capacity(poses.len());
        let mut solve_time = Duration::ZERO;
        for block in poses.chunks(KEYS_AT_ONCE) {
            job.report(results.len() as f64 / poses.len() as f64, "transfer");
            job.check()?;
            let (positions, solving) = self.apply_block(block, job)?;
            results.extend(positions);
            solve_time += solving;
        }
        job.report(1.0, "transfer");
        Ok(Transferred { poses: results, time: start.elapsed(), solve_time })
    }

    /// A pose of the source as it was given, as one of the source that is turned.
    pub(super) fn turned<'a>(&self, pose: &'a [Vec3]) -> Cow<'a, [Vec3]> {
        match self.turn == Mat3::IDENTITY {
            true => Cow::Borrowed(pose),
            false => Cow::Owned(self.source.frame().turned(self.turn, pose)),
        }
    }

    fn apply_block(&self, poses: &[Vec<Vec3>], job: &Job) -> Result<(Vec<Vec<Vec3>>, Duration)> {
        let n = self.target.vertices().len();
        let rims = self.closing.as_ref().map(|_| self.rims());
        let (keys, (rhs, mut given)): (Vec<_>, (Vec<_>, Vec<_>)) = poses
            .par_iter()
            .map(|pose| {
                let key = SourceKey::of(&self.source, &self.turned(pose));
                let moved = self.chooser.displacements(&key);
                let (changes, moves) = self.changes(&key, &moved);
                let rhs = self.stitcher.divergence(Reference::Rest, &changes);
                let mut given = vec![Vec3::ZERO; n];
                for (v, to) in self.anchors.targets(&self.target, &self.chooser, &moved) {
                    given[v as usize] = to;
                }
                let contacts = rims.map_or(Vec::new(), |rims| self.ways().contacts(rims, &key, false));
                ((Moving { key, moved, moves, contacts }, changes), (rhs, given))
            })
            .unzip();
        job.check()?;
        if let (Some(closing), Some(rims)) = (&self.closing, rims)
            && keys.iter().any(|(key, _)| !key.contacts.is_empty())
        {
            closing.prepare(&self.ways(), rims, self.stitcher.matrix(), job)?;
        }
        let start = Instant::now();
        self.stitcher.system().solve(&rhs, &mut given);
        let solving = start.elapsed();
        job.check()?;
        let positions =
            keys.par_iter().zip(given).map(|((moving, changes), found)| self.finish(moving, changes, found));
        Ok((positions.collect::<Result<_>>()?, solving))
    }

    /// Of every target triangle what is asked of it, `C - I` ([`super::choose`], [`super::scale`]), and whether it moves.
    pub(super) fn changes(&self, key: &SourceKey, moved: &[Vec3]) -> (Vec<Mat3>, Vec<bool>) {
        let (mut changes, moves) = self.chooser.changes(&self.target, key, moved);
        self.scaling.apply(&self.target, &self.chooser, &self.anchors, moved, &mut changes);
        (changes, moves)
    }

    /// What contacts are looked for and closed by.
    pub(super) fn ways(&self) -> Ways<'_> {
        let Self { source, target, used, chooser, anchors, placer, .. } = self;
        Ways { source, target, used, chooser, anchors, placer }
    }

    /// The rims of source and target; whoever asks first finds them, so not from within parallel work.
    pub(super) fn rims(&self) -> &Rims {
        self.rims.get_or_init(|| self.ways().rims())
    }

    /// From displacements in unit coordinates, up to a translation, to positions.
    fn finish(&self, moving: &Moving, changes: &[Mat3], mut displacements: Vec<Vec3>) -> Result<Vec<Vec3>> {
        let Moving { key, moves, contacts, .. } = moving;
        let mut asked = Vec::new();
        match self.closing.as_ref().and_then(Closing::prepared) {
            Some(prepared) if !contacts.is_empty() => {
                (displacements, asked) = prepared.close(&self.ways(), moving, &displacements);
            }
            _ => self.placer.place(&self.target, &self.chooser, key, moves, &mut displacements),
        }
        self.mend_tears(&moving.key, changes, &asked, &mut displacements);
        self.target.follow(&mut displacements);
        let scale = self.target.frame().scale;
        let positions: Vec<Vec3> =
            self.target.vertices().iter().zip(displacements).map(|(&v, d)| v + d * scale).collect();
        if positions.iter().all(|p| p.is_finite()) {
            Ok(positions)
        } else {
            Err(Error::SolveFailed("the result is beyond the range of floating point numbers".into()))
        }
    }
}

/// Refuses sets of positions of another size than `mesh`, which the error calls `whose`, or that are not finite.
pub(super) fn check(name: &str, poses: &[Vec<Vec3>], mesh: &Mesh, whose: &str) -> Result<()> {
    let n = mesh.vertices().len();
    let fault = |(k, pose): (usize, &Vec<Vec3>)| {
        if pose.len() == n {
            let bad = pose.iter().enumerate().filter(|(_, p)| !p.is_finite()).map(|(v, _)| v);
            Fault::at(format!("{name}[{k}]"), "not finite", bad)
        } else {
            let problem = format!("has {} vertices, the {whose} has {n}", pose.len());
            Some(Fault::new(format!("{name}[{k}]"), problem))
        }
    };
    match poses.par_iter().enumerate().find_map_first(fault) {
        Some(fault) => Err(Error::InvalidValue(fault)),
        None => Ok(()),
    }
}

/// `w_t` over the area of each triangle, as the stitcher already weighs by area.
fn weights(target: &Mesh, chooser: &Chooser, weighting: Weighting) -> Vec<f64> {
    let areas = target.areas();
    let mean = target.area() / areas.len() as f64;
    let trusted = |t: usize| if chooser.has_target(t) { 1.0 } else { UNMATCHED };
    let per_pair = |(t, &area): (usize, &f64)| {
        chooser.matches(t).len().max(1) as f64 * mean / area.max(LEAST_AREA * mean)
    };
    match weighting {
        Weighting::Area => (0..areas.len()).map(trusted).collect(),
        Weighting::Pairs => areas.iter().enumerate().map(per_pair).collect(),
    }
}

#[cfg(test)]
mod tests;
