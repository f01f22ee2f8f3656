//! Registration: the source pulled onto the target, as smoothly as it goes, by markers and by the surfaces.
//!
//! ```text
//!     E_S(x) + E_I(x)  +  w_M sum_m mu_m |x_m - c_m|^2  +  w_C E_P(x)
//! ```
//!
//! ([`super::energy`], [`super::pulls`]). At first `w_C = 0` and the markers are all but exact. Then `w_C` rises from 1
//! to [`FitOptions::closest`] while `w_M` falls: markers say what belongs together, but the hand that placed them is
//! less exact than the surface (Sumner & Popović 2004 keep them exact, and [`FitOptions::marker_tolerance`] 0 does). In
//! the end a marker counts by how near the fit has come to it ([`super::release`]).
//!
//! The weights are for a target of diagonal 10, whatever the units of the meshes.

use std::ops::Range;

use rayon::prelude::*;

use super::coarse::Coarse;
use super::descent::Descent;
use super::energy::{Energy, TermWeights};
use super::lie::Lie;
use super::look_up::LookUp;
use super::markers::Marker;
use super::options::FitOptions;
use super::proportions::{self, root_mean_square};
use super::pulls::{self, Pull};
use super::release::Release;
use super::side::{Placed, Side};
use crate::geometry::rigid::Alignment;
use crate::geometry::surface::Surface;
use crate::linear::Factor;
use crate::{Job, Mesh, Result, Vec3};

/// The target's diagonal squared in the units that the weights are meant for; here it is 1.
const DIAGONAL_SQUARED: f64 = 100.0;

/// `w_M` while `w_C = 0`; ...
const MARKED: f64 = 1e4;

/// The markers' weight where they are exact but not at vertices.
const EXACT: f64 = 1e6;

/// Solves for markers alone: at vertices one is exact, points of triangles take more.
const SOLVES: usize = 8;

/// Reach of the closest points, as fractions of the target's diagonal: at the first step and at the last ...
const REACH: [f64; 2] = [0.1, 0.02];

/// ... but not below so many times what a quarter of the vertices is off by at most; no counterpart is further away than
/// this.
const QUARTILES: f64 = 4.0;
const FARTHEST: f64 = 0.5;

/// From this fraction of the steps on, closest points are looked up from both sides, and of the whole source; before, a
/// coarse one will do.
const BOTH_SIDES: f64 = 0.7;

/// Until then more rounds are made while the last one has moved vertices by more than this at the root mean square, in the
/// target's unit coordinates, up to so many times as many: what few markers leave to the surfaces takes longer, and a
/// mouth may be pulled tight while it is still beside the target's.
const SETTLED: f64 = 3e-4;
const MOST_ROUNDS: usize = 2;
/// So many lead everywhere, and further rounds would change next to nothing.
const LED: usize = 13;

/// Markers are met within so many tolerances, at the root mean square: exact ones on people are within 0.17.
const MET: f64 = 0.2;

/// The mean of a plane's weights over the directions, times this, is the metric: measured, 0.9 converges fastest.
const METRIC: f64 = 0.9;

/// What nothing pulls must not make the matrix singular, relative to `w_C`.
const LEAST: f64 = 1e-6;

/// What a registration comes to.
pub struct Registered {
    /// The vertices of the source, once turned, on the target, in the target's unit coordinates.
    pub vertices: Vec<Vec3>,
    /// How many rounds it took.
    pub rounds: usize,
}

/// Registers by the markers of `lie`; `progress` is what of a job that is. Where a fit lets go of them, it is seen whether
/// one that follows is better ([`super::proportions`]).
///
/// # Errors
///
/// [`crate::Error::SolveFailed`], [`crate::Error::Cancelled`].
pub fn register(
    source: &Side,
    target: &Placed,
    lie: &Lie,
    options: &FitOptions,
    progress: Range<f64>,
    job: &Job,
) -> Result<Registered> {
    let markers = &lie.markers;
    let with = |release: &Release, progress: &Range<f64>| {
        Part { source, target, lie, markers, release, stands_for: 1.0, options, progress, job }.registered()
    };
    if options.marker_tolerance == 0.0 {
        return with(&Release::following(options), &progress);
    }
    let middle = 0.5 * (progress.start + progress.end);
    let free = with(&Release::letting_go(options, lie), &(progress.start..middle))?;
    if off(lie, &free.vertices) < MET * options.marker_tolerance {
        return Ok(free);
    }
    let following = Release { borders: true, ..Release::following(options) };
    let led = with(&following, &(middle..progress.end))?;
    let rounds = free.rounds + led.rounds;
    let fits = [&free, &led].map(|fit| fit.vertices.as_slice());
    let is_better = proportions::differ(fits, source, target, lie, options.match_distance, job)?;
    Ok(Registered { rounds, ..if is_better { led } else { free } })
}

/// How far markers are from where they belong, at the root mean square; 0 for curves, which do not let go.
fn off(lie: &Lie, x: &[Vec3]) -> f64 {
    let points = lie.markers.iter().filter(|m| !m.is_of_curve());
    root_mean_square(points.map(|m| m.off(x).powi(2)))
}

/// The source, or a coarse one, on its way to the target.
#[derive(Clone, Copy)]
struct Part<'a> {
    source: &'a Side<'a>,
    target: &'a Placed<'a>,
    lie: &'a Lie,
    markers: &'a [Marker],
    release: &'a Release,
    /// How many triangles of the source there are for one of it.
    stands_for: f64,
    options: &'a FitOptions,
    progress: &'a Range<f64>,
    job: &'a Job,
}

impl<'a> Part<'a> {
    /// It on the target.
    fn registered(&self) -> Result<Registered> {
        let from_both_sides = (0..self.options.steps).find(|&step| self.options.share_of(step) >= BOTH_SIDES);
        let coarse_steps = from_both_sides.unwrap_or(self.options.steps);
        let coarse = if coarse_steps > 0 { Coarse::of(self.source, &self.lie.markers) } else { None };
        let (mut energy, mut u, done, mut rounds);
        match &coarse {
            Some(coarse) => {
                (energy, u, rounds) = self.begin_on(coarse, coarse_steps)?;
                done = coarse_steps;
            }
            None => {
                (energy, u) = self.begin()?;
                self.follow_markers(&energy, &mut u)?;
                (done, rounds) = (0, 0);
            }
        }
        rounds += self.pull(&mut energy, &mut u, done..self.options.steps)?;
        u.truncate(self.source.mesh.vertices().len());
        Ok(Registered { vertices: u, rounds })
    }

    /// The energy, and the source at rest where it lies on the target.
    fn begin(&self) -> Result<(Energy<'a>, Vec<Vec3>)> {
        let (mesh, options) = (self.source.mesh, self.options);
        let (n, components) = (mesh.vertices().len(), mesh.components());
        let mut fixed = vec![None; n];
        let exact = options.marker_tolerance == 0.0;
        for marker in self.markers.iter().filter(|m| exact && m.is_vertex()) {
            fixed[marker.corners[0] as usize] = Some(marker.goal);
        }
        let identity = options.identity * self.stands_for;
        let weights = TermWeights { smoothness: options.smoothness, identity };
        // Vertices in no face have no energy: they stay where they are.
        let is_fixed = |v: usize| fixed[v].is_some() || components.of_vertex(v).is_none();
        let energy = Energy::new(mesh, self.lie.size, weights, is_fixed)?;
        let mut u = energy.rest();
        u[..n].iter_mut().for_each(|x| *x += self.lie.shift);
        u.iter_mut().zip(&fixed).for_each(|(x, goal)| *x = goal.unwrap_or(*x));
        self.job.check()?;
        Ok((energy, u))
    }

    /// The same where a coarse source has come in so many steps, which the whole one follows: its vertices are markers. With
    /// the rounds that took.
    fn begin_on(&self, coarse: &Coarse, steps: usize) -> Result<(Energy<'a>, Vec<Vec3>, usize)> {
        let side = coarse.side(self.source)?;
        let on = Part { source: &side, markers: &coarse.markers, stands_for: coarse.stands_for, ..*self };
        let places = || -> Result<_> {
            let (mut energy, mut u) = on.begin()?;
            on.follow_markers(&energy, &mut u)?;
            let rounds = on.pull(&mut energy, &mut u, 0..steps)?;
            Ok((u, rounds))
        };
        let markers = |places: &[Vec3]| -> Vec<Marker> {
            let marker = |(&v, &goal): (&u32, &Vec3)| Marker::at_vertex(self.source.mesh, v, goal);
            coarse.vertices.iter().zip(places).map(marker).collect()
        };
        // A factorization keeps one core busy, and this one does not depend on where the markers lead.
        let lead = || -> Result<_> {
            let (energy, u) = self.begin()?;
            let lead = Lead::new(&energy, &markers(coarse.mesh.rest()))?;
            Ok((energy, u, lead))
        };
        let (lead, places) = rayon::join(lead, places);
        let ((energy, mut u, lead), (places, rounds)) = (lead?, places?);
        lead.go(&energy, &markers(&places), &mut u);
        Ok((energy, u, rounds))
    }

    /// `w_C = 0`
    fn follow_markers(&self, energy: &Energy, u: &mut [Vec3]) -> Result<()> {
        if !self.markers.is_empty() {
            Lead::new(energy, self.markers)?.go(energy, self.markers, u);
        }
        Ok(())
    }

    /// `w_C` as it rises in these steps; how many rounds that takes.
    fn pull(&self, energy: &mut Energy, u: &mut [Vec3], steps: Range<usize>) -> Result<usize> {
        let Self { source, target, markers, release, options, job, .. } = *self;
        let n = source.mesh.vertices().len();
        let exact = options.marker_tolerance == 0.0;
        let are_led = markers.iter().filter(|m| !m.is_of_curve()).count() >= LED;
        let mut look_up = LookUp::new(source, target, options.match_distance, release.borders);
        let total = options.steps * options.rounds;
        let mut surface = None;
        let mut made = 0;
        for step in steps {
            let fraction = options.share_of(step);
            let pull = self.stands_for * options.closest.powf(fraction);
            let off = look_up.find_partners(&u[..n], job)?;
            let reach = (REACH[0] * (REACH[1] / REACH[0]).powf(fraction)).max(QUARTILES * off).min(FARTHEST);
            let left = 1.0 - step as f64 / (options.steps.max(3) - 2) as f64;
            let falling = release.falling * left.max(0.0).powi(2);
            if release.is_viscous {
                energy.refer(u);
            }
            let mut descent = None;
            let both_sides = fraction >= BOTH_SIDES;
            let most = if both_sides || are_led { 1 } else { MOST_ROUNDS };
            let mut before = u[..n].to_vec();
            for round in 0..options.rounds * most {
                if round >= options.rounds && moved(&before, u) < SETTLED {
                    break;
                }
                before.copy_from_slice(&u[..n]);
                made += 1;
                let placed = Placed::again(source, &u[..n], surface.take());
                let mut pulls = look_up.forth(&placed, pull * DIAGONAL_SQUARED, reach, job)?;
                if both_sides {
                    pulls.extend(look_up.back(&placed, pull * DIAGONAL_SQUARED, reach, job)?);
                }
                surface = Some(placed.surface);
                pulls.extend(markers.iter().map(|m| {
                    let weight = falling.max(release.kept * m.share(u, release.within));
                    m.pull(if exact { EXACT } else { weight } * DIAGONAL_SQUARED)
                }));
                if descent.is_none() {
                    let mut metric = pulls::uncoupled(&pulls, n);
                    metric.iter_mut().for_each(|d| *d = (*d * METRIC).max(LEAST * pull));
                    descent = Some(Descent::new(energy, energy.factor(&metric)?));
                }
                job.check()?;
                descent.iter_mut().for_each(|descent| descent.go(&pulls, u, release.steps));
                let done = step * options.rounds + (round + 1).min(options.rounds);
                let Range { start, end } = *self.progress;
                job.report(start + (end - start) * done as f64 / total as f64, "fit");
            }
        }
        Ok(made)
    }
}

/// How far these have moved, at the root mean square.
fn moved(before: &[Vec3], x: &[Vec3]) -> f64 {
    root_mean_square(before.iter().zip(x).map(|(a, b)| a.distance_squared(*b)))
}

/// How markers alone lead. Components without any are held at rest, which costs them nothing, and carried.
struct Lead {
    /// Which components are marked.
    marked: Vec<bool>,
    factor: Factor,
}

impl Lead {
    /// By these markers, wherever to.
    fn new(energy: &Energy, markers: &[Marker]) -> Result<Self> {
        let components = energy.mesh().components();
        let mut marked = vec![false; components.count()];
        for marker in markers {
            marked[components.of_vertex(marker.corners[0] as usize).unwrap_or_default()] = true;
        }
        let n = energy.mesh().vertices().len();
        let pulls = Self::pulls(&marked, energy, markers, &energy.rest());
        Ok(Self { factor: energy.factor(&pulls::uncoupled(&pulls, n))?, marked })
    }

    /// To where the same markers belong.
    fn go(self, energy: &Energy, markers: &[Marker], u: &mut [Vec3]) {
        let pulls = Self::pulls(&self.marked, energy, markers, u);
        let at_vertices = markers.iter().all(Marker::is_vertex);
        Descent::new(energy, self.factor).go(&pulls, u, if at_vertices { 1 } else { SOLVES });
        let n = energy.mesh().vertices().len();
        carry_unmarked(energy.mesh(), &self.marked, &mut u[..n]);
    }

    fn pulls(marked: &[bool], energy: &Energy, markers: &[Marker], u: &[Vec3]) -> Vec<Pull> {
        let components = energy.mesh().components();
        let held = |v: &usize| components.of_vertex(*v).is_some_and(|c| !marked[c]);
        let n = energy.mesh().vertices().len();
        let hold = (0..n).filter(held).map(|v| Pull::to_point([v as u32; 3], Vec3::X, u[v], 1.0));
        hold.chain(markers.iter().map(|m| m.pull(MARKED * DIAGONAL_SQUARED))).collect()
    }
}

/// Moves every component without a marker as the marked surface beside it has moved.
fn carry_unmarked(source: &Mesh, marked: &[bool], x: &mut [Vec3]) {
    if marked.iter().all(|&m| m) {
        return;
    }
    let components = source.components();
    let is_marked = |v: u32| components.of_vertex(v as usize).is_some_and(|c| marked[c]);
    let anchors: Vec<[u32; 3]> = source.triangles().iter().copied().filter(|t| is_marked(t[0])).collect();
    let surface = Surface::new(anchors.iter().map(|t| t.map(|v| source.rest()[v as usize])).collect());
    for (members, _) in components.members().iter().zip(marked).filter(|(_, marked)| !**marked) {
        let beside = members.par_iter().filter_map(|&v| surface.closest_point(source.rest()[v as usize]));
        let mut beside: Vec<u32> = beside.flat_map_iter(|hit| anchors[hit.triangle]).collect();
        beside.sort_unstable();
        beside.dedup();
        let carry =
            Alignment::of(beside.iter().map(|&v| (source.rest()[v as usize], x[v as usize]))).similar();
        for &v in members {
            x[v as usize] = carry.apply(source.rest()[v as usize]);
        }
    }
}
