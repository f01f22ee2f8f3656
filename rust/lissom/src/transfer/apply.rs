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
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::anchor::Anchors;
use super::choose::{Chooser, SourceKey};
use super::contact::{self, Contact};
use super::correspondence::Correspondence;
use super::obstacle::{Least, Obstacles};
use super::options::{TransferOptions, Unmatched, Weighting};
use super::place::Placer;
use super::scale::Scaling;
use super::sizes::Sizes;
use crate::linear::{ConstrainedSystem, Constraints, REGULARIZED};
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

/// How often what is missing to stay out of solids is asked for.
const ASKED: usize = 10;

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
    scaling: Scaling,
    pub(super) placer: Placer,
    closing: Option<Closing>,
    stitcher: Stitcher,
    /// `w_t` over the area of the triangle.
    pub(super) weights: Vec<f64>,
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
        let chooser = Chooser::new(&source, &target, &used.pairs, &used.images, options.frames)?;
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
        let closing = match options.contact {
            true => Some(Closing {
                system: contact::system(&target, stitcher.matrix(), job)?,
                obstacles: Obstacles::of(&target),
                of_source: Obstacles::of(&source),
            }),
            false => None,
        };
        let policy = match policy {
            Unmatched::Follow => "they follow the nearest matched surface rigidly",
            Unmatched::Rest => "they stay at rest",
        };
        let problem = format!("components of the target without a match; {policy}");
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
            stitcher,
            weights,
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
        let (keys, (rhs, mut given)): (Vec<Moving>, (Vec<_>, Vec<_>)) = poses
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
                (Moving { key, moved, moves }, (rhs, given))
            })
            .unzip();
        job.check()?;
        let start = Instant::now();
        self.stitcher.system().solve(&rhs, &mut given);
        let solving = start.elapsed();
        job.check()?;
        let positions = keys.par_iter().zip(given).map(|(moving, found)| self.finish(moving, found));
        Ok((positions.collect::<Result<_>>()?, solving))
    }

    /// Of every target triangle what is asked of it, `C - I` ([`super::choose`], [`super::scale`]), and whether it moves.
    pub(super) fn changes(&self, key: &SourceKey, moved: &[Vec3]) -> (Vec<Mat3>, Vec<bool>) {
        let (mut changes, moves) = self.chooser.changes(&self.target, key, moved);
        self.scaling.apply(&self.target, &self.chooser, &self.anchors, moved, &mut changes);
        (changes, moves)
    }

    /// Whether places that come together on the source are made to on the target.
    pub(super) fn closes_contacts(&self) -> bool {
        self.closing.is_some()
    }

    /// What comes together in a key.
    pub(super) fn contacts(&self, key: &SourceKey, moved: &[Vec3]) -> Vec<Contact> {
        let size = |component| self.anchors.size(component);
        contact::contacts(&self.source, &self.target, &self.used, key, moved, size)
    }

    /// The displacements, placed, with contacts closed and nothing pushed into solids.
    fn close(
        &self,
        Closing { system, obstacles, of_source }: &Closing,
        Moving { key, moved, moves }: &Moving,
        stitched: Vec<Vec3>,
    ) -> Vec<Vec3> {
        let with = |contacts: &[Contact]| {
            let mut displacements = stitched.clone();
            contact::close(&self.target, system, contacts, &mut displacements);
            self.placer.place(&self.target, &self.chooser, key, moves, &mut displacements);
            displacements
        };
        let contacts = self.contacts(key, moved);
        let mut displacements = with(&contacts);
        let Some(obstacles) = obstacles else { return displacements };
        let least = match of_source {
            Some(solids) => self.as_far_as_on_the_source(solids, key, moved),
            None => {
                let mut least = vec![Least::Travelled; displacements.len()];
                let met = contacts.iter().flat_map(Contact::vertices);
                met.for_each(|v| least[v as usize] = Least::Outside(f64::INFINITY));
                least
            }
        };
        let mut points: BTreeMap<u32, Vec3> = BTreeMap::new();
        for _ in 0..ASKED {
            let short = obstacles.short(&self.target, &least, &displacements);
            if short.is_empty() {
                break;
            }
            for (v, by) in short {
                let at = self.target.rest()[v as usize] + displacements[v as usize];
                *points.entry(v).or_insert(at) += by;
            }
            let pulls = points.iter().map(|(&v, &point)| Contact::with_point(&self.target, v, point));
            displacements = with(&contacts.iter().cloned().chain(pulls).collect::<Vec<_>>());
        }
        displacements
    }

    /// How far outside of solids the images of the target's vertices are.
    fn as_far_as_on_the_source(&self, solids: &Obstacles, key: &SourceKey, moved: &[Vec3]) -> Vec<Least> {
        let image = |(v, &moved): (usize, &Vec3)| {
            let at = self.chooser.image(v)? + moved;
            let triangle = self.used.images.get(v).copied().flatten()?.triangle;
            Some((self.source.triangles()[triangle as usize][0], at))
        };
        let images: Vec<_> = moved.iter().enumerate().map(image).collect();
        let outside = solids.outside(&self.source, &key.displacement, &images);
        let size = |v: usize| self.target.components().of_vertex(v).map(|c| self.anchors.size(c));
        let least = |v: usize| match images[v].and(size(v)) {
            Some(size) => Least::Outside(outside[v].map_or(f64::INFINITY, |outside| outside * size)),
            None => Least::Travelled,
        };
        (0..moved.len()).map(least).collect()
    }

    /// From displacements in unit coordinates, up to a translation, to positions.
    fn finish(&self, moving: &Moving, mut displacements: Vec<Vec3>) -> Result<Vec<Vec3>> {
        if let Some(closing) = &self.closing {
            displacements = self.close(closing, moving, displacements);
        } else {
            let Moving { key, moves, .. } = moving;
            self.placer.place(&self.target, &self.chooser, key, moves, &mut displacements);
        }
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

/// What contact needs besides.
struct Closing {
    system: ConstrainedSystem,
    /// What is in the way on the target, and on the source.
    obstacles: Option<Obstacles>,
    of_source: Option<Obstacles>,
}

/// A key on its way.
struct Moving<'a> {
    key: SourceKey<'a>,
    /// Displacements of the images of the target's vertices.
    moved: Vec<Vec3>,
    /// Whether each of its triangles moves.
    moves: Vec<bool>,
}

/// `w_t` over the area of each triangle, as the stitcher already weighs by area.
fn weights(target: &Mesh, chooser: &Chooser, weighting: Weighting) -> Vec<f64> {
    let areas = target.areas();
    let mean = areas.iter().sum::<f64>() / areas.len() as f64;
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
mod tests {
    use super::*;
    use crate::rotation;
    use crate::transfer::testing::{bumpy_grid, grid, nosed_sphere};
    use crate::transfer::{FitOptions, fit_correspondence};

    fn prepare(source: Mesh, target: Mesh, pairs: &[[u32; 2]], options: TransferOptions) -> Transfer {
        let matches = Correspondence::of_pairs(pairs.to_vec());
        Transfer::new(Arc::new(source), Arc::new(target), &matches, options, &Job::default()).unwrap()
    }

    fn both_weightings() -> [TransferOptions; 2] {
        [Weighting::Pairs, Weighting::Area]
            .map(|weighting| TransferOptions { weighting, ..Default::default() })
    }

    /// Two spheres with noses, of different triangles and size, and what belongs together.
    fn spheres() -> (Mesh, Mesh, Vec<[u32; 2]>) {
        let (vertices, triangles) = nosed_sphere(12, 20);
        let source = Mesh::new(vertices, triangles).unwrap();
        let (vertices, triangles) = nosed_sphere(15, 28);
        let target = Mesh::new(vertices.iter().map(|&v| v * 40.0 + Vec3::X).collect(), triangles).unwrap();
        // The poles, and both ends of the x axis at the equator's nearest ring.
        let ring = |rings: usize, around: usize, j: usize| (1 + (rings / 2) * around + j) as u32;
        let markers = [
            [0, 0],
            [241, 421],
            [ring(12, 20, 0), ring(15, 28, 0)],
            [ring(12, 20, 5), ring(15, 28, 7)],
            [ring(12, 20, 10), ring(15, 28, 14)],
            [ring(12, 20, 15), ring(15, 28, 21)],
        ];
        let fit =
            fit_correspondence(&source, &target, Some(&markers), &FitOptions::default(), &Job::default());
        (source, target, fit.unwrap().matches.pairs)
    }

    fn posed(mesh: &Mesh, map: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
        mesh.vertices().iter().map(|&v| map(v)).collect()
    }

    #[test]
    fn row_31_a_key_that_moves_nothing_moves_nothing() {
        let (source, target, pairs) = spheres();
        let rest = source.vertices().to_vec();
        for options in both_weightings() {
            let transfer = prepare(copy(&source), copy(&target), &pairs, options);
            let result = transfer.apply(std::slice::from_ref(&rest), &Job::default()).unwrap().poses;
            assert_eq!(result[0], target.vertices(), "to the last bit");
        }
    }

    fn copy(mesh: &Mesh) -> Mesh {
        Mesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).unwrap()
    }

    #[test]
    fn similarities_of_the_source_are_reproduced_on_other_triangles() {
        let (source, target, pairs) = spheres();
        let turn = rotation::exp(Vec3::new(0.4, -1.9, 0.8));
        let similarity = |p: Vec3| turn * p * 1.3 + Vec3::new(2.0, 3.0, -1.0);
        let shift = Vec3::new(0.5, 0.25, -0.125);
        let poses = [posed(&source, similarity), posed(&source, |p| p + shift)];
        for options in both_weightings() {
            let transfer = prepare(copy(&source), copy(&target), &pairs, options);
            let results = transfer.apply(&poses, &Job::default()).unwrap().poses;
            let scale = target.frame().scale;
            for &[i, j] in target.adjacency().edges() {
                let edge = |x: &[Vec3]| x[j as usize] - x[i as usize];
                let expected = turn * edge(target.vertices()) * 1.3;
                assert!((edge(&results[0]) - expected).length() < 1e-9 * scale);
            }
            // The target is 40 times as large, and moves as much further.
            for (moved, rest) in results[1].iter().zip(target.vertices()) {
                assert!((*moved - *rest - shift * 40.0).length() < 0.02 * 40.0 * shift.length());
                let like_the_first = results[1][0] - target.vertices()[0];
                assert!((*moved - *rest - like_the_first).length() < 1e-9 * scale);
            }
        }
    }

    #[test]
    fn a_mesh_gives_itself_its_own_keys() {
        let mesh = bumpy_grid(10);
        let same: Vec<[u32; 2]> = (0..mesh.triangles().len() as u32).map(|t| [t, t]).collect();
        let everywhere = posed(&mesh, |p| p + Vec3::new(0.1 * p.y, (3.0 * p.x).sin() * 0.2, 0.3 * p.x * p.y));
        let partly = posed(&mesh, |p| p + Vec3::Z * 0.2 * (p.x - 0.5).max(0.0));
        for options in both_weightings() {
            let transfer = prepare(copy(&mesh), copy(&mesh), &same, options);
            let results =
                transfer.apply(&[everywhere.clone(), partly.clone()], &Job::default()).unwrap().poses;
            for (result, pose) in results.iter().zip([&everywhere, &partly]) {
                for (a, b) in result.iter().zip(pose) {
                    assert!((*a - *b).length() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn what_does_not_move_on_the_source_stays_put_exactly() {
        let (source, target, pairs) = spheres();
        let pose = posed(&source, |p| if p.x > 0.6 { p + Vec3::new(p.x - 0.6, 0.0, 0.3) } else { p });
        for options in both_weightings() {
            let transfer = prepare(copy(&source), copy(&target), &pairs, options);
            let result =
                transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
            let moved = |v: usize| result[v] != target.vertices()[v];
            let behind = |v: usize| target.vertices()[v].x < 1.0;
            assert!((0..result.len()).filter(|&v| behind(v)).all(|v| !moved(v)));
            assert!((0..result.len()).any(|v| (result[v] - target.vertices()[v]).length() > 10.0));
        }
    }

    #[test]
    fn unmatched_triangles_continue_what_is_around_them() {
        // A turn about the z axis is known on all triangles but a few, and goes on there.
        let mesh = bumpy_grid(10);
        let pairs: Vec<[u32; 2]> =
            (0..mesh.triangles().len() as u32).filter(|t| !(60..72).contains(t)).map(|t| [t, t]).collect();
        let turn = rotation::exp(Vec3::Z * 1.2);
        let pose = posed(&mesh, |p| turn * p);
        let transfer = prepare(copy(&mesh), copy(&mesh), &pairs, TransferOptions::default());
        let result = transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
        for (a, b) in result.iter().zip(&pose) {
            assert!((*a - *b).length() < 1e-6);
        }
    }

    #[test]
    fn row_30_a_component_without_a_match_follows_rigidly_or_rests() {
        let (mut vertices, mut triangles) = grid(6);
        let source = bumpy_grid(6);
        let pairs: Vec<[u32; 2]> = (0..triangles.len() as u32).map(|t| [t, t]).collect();
        let (ball, faces) = nosed_sphere(4, 6);
        vertices.extend(ball.iter().map(|&p| p * 0.1 + Vec3::new(0.5, 0.5, 0.4)));
        triangles.extend(faces.iter().map(|t| t.map(|v| v + 36)));
        let target = Mesh::new(vertices, triangles).unwrap();
        let turn = rotation::exp(Vec3::new(0.5, 0.2, -0.9));
        let pose = posed(&source, |p| turn * p + Vec3::X);
        for (unmatched, text) in [(Unmatched::Follow, "rigidly"), (Unmatched::Rest, "at rest")] {
            let options = TransferOptions { unmatched, ..Default::default() };
            let transfer = prepare(copy(&source), copy(&target), &pairs, options);
            assert!(transfer.warnings()[0].contains(text) && transfer.warnings()[0].contains("1 in all"));
            let result =
                transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
            for (&moved, &rest) in result.iter().zip(target.vertices()).skip(36) {
                let expected = if unmatched == Unmatched::Rest { rest } else { turn * rest + Vec3::X };
                assert!((moved - expected).length() < 1e-8);
            }
        }
    }

    #[test]
    fn row_40_a_cancelled_job_stops() {
        let mesh = bumpy_grid(4);
        let pose = mesh.vertices().to_vec();
        let transfer = prepare(copy(&mesh), mesh, &[[0, 0]], TransferOptions::default());
        let job = Job::default();
        job.cancel();
        assert!(matches!(transfer.apply(&[pose], &job), Err(Error::Cancelled)));
    }
}
