//! Fit: pull the source onto the target, then read off which triangles belong together.
//!
//! Sumner & Popović 2004, section 4: minimise
//!
//! ```text
//!     w_S E_S + w_I E_I + w_C sum_v |x_v - c_v|^2      markers given exactly
//! ```
//!
//! ([`super::energy`]) for the source's vertices `x`, first with `w_C = 0`, then with `w_C` raised from 1
//! to [`FitOptions::closest`], where `c_v` is the target's closest compatible point to `x_v`. As `c`
//! depends on `x`, each weight takes several rounds of look-up and solve, an iteration like that of
//! closest-point registration: the pull along the surface makes it creep, so that each round starts
//! from `x` extrapolated by its last step. The factor serves all rounds of a weight.
//!
//! `E_C` weighs a squared length against squared gradients. The weights are for a target of diagonal
//! 10, whatever the units of the meshes.

use std::time::Instant;

use rayon::prelude::*;

use super::component_pairs::{ComponentPairs, Overlap, triangle_components};
use super::correspondence::Correspondence;
use super::energy::{Energy, TermWeights};
use super::image::{self, SurfacePoint};
use super::markers::{self, Marker};
use super::matching;
use crate::geometry::rigid::Alignment;
use crate::geometry::surface::{Hit, Surface};
use crate::geometry::triangle::{normal_and_area, vertex_normals};
use crate::operators::gradient::triangle_gradient;
use crate::operators::mass::lumped_mass;
use crate::options::{OptionSet, options};
use crate::{Error, Fault, Job, Mesh, Result, Vec3};

/// The target's diagonal in the units that the weights are meant for; here it is 1.
const DIAGONAL: f64 = 10.0;

/// How far each round is extrapolated, in steps of the one before. Measured on cat to lion: the
/// distance left by six weights of four rounds falls by a ninth against 0; 1 gains little more.
const EXTRAPOLATION: f64 = 0.8;

/// A vertex is stuck on the wrong side when the nearest point that faces its way is further away
/// than the nearest point of all by this fraction of the diagonal: thin sheets have both sides close.
const FLIPPED: f64 = 0.01;

/// A triangle is reported as stretched from here on: three times as long as the usual one, or a third as wide.
pub const STRETCHED: f64 = 3.0;

/// Vertices looked up between two looks at the job.
const BATCH: usize = 4096;

/// Most weights, and most rounds at each; far beyond what anything gains from.
const MOST_ROUNDS: f64 = 1000.0;

options! {
    /// Options of the fit: `w_S`, `w_I` and the largest `w_C`, and how it goes about it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FitOptions {
        /// Where on the target the source vertex of each marker belongs, where that is not at its vertices;
        /// a marker's target vertex then only names it.
        pub points: Vec<Vec3> = Vec::new() => unit("the target's units"),
        /// How much neighbouring triangles must change alike.
        pub smoothness: f64 = 1.0 => above(0.0),
        /// How much triangles must keep their shape and orientation.
        pub identity: f64 = 0.001 => above(0.0),
        /// How tightly the source is pulled onto the target in the end. Less for a target of quite other
        /// proportions, such as a cartoon's: 50 or so keeps the source from folding there.
        pub closest: f64 = 5000.0 => at_least(1.0),
        /// How many pulls it takes from 1 to the tightest, each of which costs a factorization.
        pub steps: usize = 6 => at_least(1.0) at_most(MOST_ROUNDS),
        /// Rounds of closest points at each pull.
        pub rounds: usize = 4 => at_least(1.0) at_most(MOST_ROUNDS),
        /// How far the centre of a triangle may be from the other surface to be matched there.
        pub match_distance: f64 = 0.02 => above(0.0) unit("of the target's diagonal"),
        /// Vertices of the source that match nothing: the inside of a mouth, eye sockets.
        pub source_mask: Vec<u32> = Vec::new(),
        /// Vertices of the target that match nothing.
        pub target_mask: Vec<u32> = Vec::new(),
    }
}

impl FitOptions {
    /// `w_C` of each step, without the first, which is 0.
    fn pulls(&self) -> impl Iterator<Item = f64> {
        let last = (self.steps.max(2) - 1) as f64;
        let (closest, steps) = (self.closest, self.steps);
        (0..steps).map(move |i| if steps == 1 { closest } else { closest.powf(i as f64 / last) })
    }
}

/// A source that has been pulled onto a target.
#[derive(Debug, Clone)]
pub struct Fit {
    /// What belongs together.
    pub matches: Correspondence,
    /// The source's vertices on the target, in the target's units.
    pub fitted_vertices: Vec<Vec3>,
    /// How far each of them is from the target's surface that faces its way, in the target's units; not a number
    /// where nothing does, and for masked vertices.
    pub distances: Vec<f64>,
    /// How far each target vertex is from its image, likewise.
    pub image_distances: Vec<f64>,
    /// How much each source triangle, as its input counts them, is longer or narrower than the usual one.
    pub stretch: Vec<f64>,
    /// The source triangles that face against the target where they lie.
    pub flipped: Vec<u32>,
    /// How well it went.
    pub report: FitReport,
}

/// What a fit says about itself.
#[derive(Debug, Clone, Default)]
pub struct FitReport {
    /// Mean distance of the fitted vertices to the target, in the target's units.
    pub distance_mean: f64,
    /// Largest distance of a fitted vertex to the target, in the target's units.
    pub distance_max: f64,
    /// The mean distance in percent of the target's diagonal.
    pub distance_mean_percent: f64,
    /// The largest distance in percent of the target's diagonal.
    pub distance_max_percent: f64,
    /// Fitted triangles that face against the target where they lie.
    pub flipped_triangles: usize,
    /// Fitted triangles that are stretched along one direction, or squeezed, by more than [`STRETCHED`].
    pub stretched_triangles: usize,
    /// Source triangles without a match.
    pub unmatched_source_triangles: usize,
    /// Target triangles without a match.
    pub unmatched_target_triangles: usize,
    /// Their share of the source's area, in percent.
    pub unmatched_source_percent: f64,
    /// Their share of the target's area, in percent.
    pub unmatched_target_percent: f64,
    /// Rounds of closest points.
    pub rounds: usize,
    /// Wall clock time.
    pub seconds: f64,
    /// What is doubtful.
    pub warnings: Vec<String>,
}

/// Fits `source` to `target` by `markers`, pairs of a source vertex and a target vertex.
///
/// Meshes of the same triangles need no marker: without any, each vertex belongs to its own like. Components
/// of the source without a marker are carried along with the marked ones beside them
/// before the closest points take over.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for markers that cannot be used (none, out of range, marked twice),
/// [`Error::InvalidValue`] for options out of range, [`Error::SolveFailed`], [`Error::Cancelled`].
pub fn fit_correspondence(
    source: &Mesh,
    target: &Mesh,
    markers: &[[u32; 2]],
    options: &FitOptions,
    job: &Job,
) -> Result<Fit> {
    let start = Instant::now();
    let doubts = |name: &str, mesh: &Mesh| -> Vec<String> {
        mesh.warnings().iter().map(|warning| format!("{name}: {warning}")).collect()
    };
    let mut warnings = [doubts("source", source), doubts("target", target)].concat();
    options.check()?;
    let markers = &markers
        .iter()
        .map(|&[s, t]| [source.representative(s), target.representative(t)])
        .collect::<Vec<_>>();
    if markers.is_empty()
        && source.triangles() == target.triangles()
        && source.rest().len() == target.rest().len()
    {
        job.check()?;
        return Ok(same(source, target, warnings));
    }
    let points: Vec<Vec3> = options.points.iter().map(|&p| target.frame().to_unit(p)).collect();
    let markers = markers::check(source, target, markers, &points, &mut warnings)?;
    let onto = Onto::new(source, target, options)?;
    job.report(0.0, "fit");
    job.check()?;

    let (x, rounds) = pull(source, target, &markers, options, &onto, job)?;
    job.report(0.9, "match");
    let report = FitReport { rounds, warnings, ..FitReport::default() };
    let mut fit = conclude(source, target, &x, &onto, options, report, job)?;
    fit.report.seconds = start.elapsed().as_secs_f64();
    job.report(1.0, "match");
    Ok(fit)
}

/// The fit of a mesh onto one of the same vertices and triangles: each belongs to its own like.
fn same(source: &Mesh, target: &Mesh, warnings: Vec<String>) -> Fit {
    let ids = |(&s, &t): (&u32, &u32)| [s, t];
    let pairs = source.triangle_ids().iter().zip(target.triangle_ids()).map(ids).collect();
    let corners = |mesh: &Mesh| {
        let mut images = vec![None; mesh.vertices().len()];
        for (t, &triangle) in mesh.triangles().iter().zip(mesh.triangle_ids()) {
            for (corner, &v) in t.iter().enumerate() {
                images[v as usize] = Some(SurfacePoint { triangle, weights: Vec3::AXES[corner] });
            }
        }
        mesh.follow(&mut images);
        images
    };
    let (images, back_images) = (corners(source), corners(target));
    let n = images.len();
    Fit {
        matches: Correspondence { pairs, images, back_images },
        fitted_vertices: target.vertices().to_vec(),
        distances: vec![0.0; n],
        image_distances: vec![0.0; n],
        stretch: vec![1.0; source.input_triangles()],
        flipped: Vec::new(),
        report: FitReport { warnings, ..FitReport::default() },
    }
}

/// The source's vertices on the target, in the target's unit coordinates, and the rounds it took.
fn pull(
    source: &Mesh,
    target: &Mesh,
    markers: &[Marker],
    options: &FitOptions,
    onto: &Onto,
    job: &Job,
) -> Result<(Vec<Vec3>, usize)> {
    let size = markers::size_ratio(markers);
    let components = source.components();
    let mut x: Vec<Vec3> = source.rest().iter().map(|&v| v * size).collect();
    let mut fixed = vec![None; x.len()];
    let mut marked = vec![false; components.count()];
    for marker in markers {
        let v = marker.vertex as usize;
        (fixed[v], x[v]) = (Some(marker.goal), marker.goal);
        marked[components.of_vertex(v).unwrap_or_default()] = true;
    }
    // Vertices in no face have no energy: they stay where they are.
    for v in 0..x.len() {
        if components.of_vertex(v).is_none() {
            fixed[v] = Some(x[v]);
        }
    }
    let weights = TermWeights { smoothness: options.smoothness, identity: options.identity };
    let energy = Energy::new(source, size, weights, &fixed)?;
    job.check()?;

    // w_C = 0. Components without markers are held at rest, which costs them nothing, and carried.
    let held = |v: usize| components.of_vertex(v).is_some_and(|c| !marked[c]);
    let hold: Vec<f64> = (0..x.len()).map(|v| if held(v) { 1.0 } else { 0.0 }).collect();
    let rest = x.clone();
    energy.minimise(&energy.factor(&hold)?, &hold, &rest, &mut x);
    carry_unmarked(source, &marked, &mut x);

    let mut look_up = LookUp::new(source, target, onto, options.match_distance);
    let total = options.steps * options.rounds;
    let mut rounds = 0;
    for weight in options.pulls() {
        let mut before: Option<Vec<Vec3>> = None;
        let mut factored = None;
        look_up.find_partners(&x, job)?;
        for _ in 0..options.rounds {
            let from: Vec<Vec3> = match &before {
                Some(before) => x.iter().zip(before).map(|(&x, &b)| x + (x - b) * EXTRAPOLATION).collect(),
                None => x.clone(),
            };
            let hits = look_up.closest_points(&from, job)?;
            let points: Vec<Vec3> = hits.iter().zip(&from).map(|(h, &x)| h.map_or(x, |h| h.point)).collect();
            let (pull, factor) = match &factored {
                Some(factored) => factored,
                None => {
                    let weight = weight * DIAGONAL * DIAGONAL;
                    let pulled = |h: &Option<Hit>| if h.is_some() { weight } else { 1e-6 * weight };
                    let pull: Vec<f64> = hits.iter().map(pulled).collect();
                    let factor = energy.factor(&pull)?;
                    factored.insert((pull, factor))
                }
            };
            job.check()?;
            before = Some(x.clone());
            energy.minimise(factor, pull, &points, &mut x);
            rounds += 1;
            job.report(0.1 + 0.8 * rounds as f64 / total as f64, "fit");
        }
    }
    Ok((x, rounds))
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

/// The surface to fit onto, and what matches nothing.
struct Onto {
    surface: Surface,
    masked_source: Vec<bool>,
    masked_target: Vec<bool>,
    masked_triangles: Vec<bool>,
}

impl Onto {
    fn new(source: &Mesh, target: &Mesh, options: &FitOptions) -> Result<Self> {
        let flags = |name: &str, mesh: &Mesh, mask: &[u32]| {
            let n = mesh.vertices().len();
            let outside = (0..mask.len()).filter(|&i| mask[i] as usize >= n);
            if let Some(fault) = Fault::at(name, format!("vertex out of range, the mesh has {n}"), outside) {
                return Err(Error::InvalidConstraint(fault));
            }
            let mut flags = vec![false; n];
            mask.iter().for_each(|&v| flags[mesh.representative(v) as usize] = true);
            Ok(flags)
        };
        let masked_source = flags("source_mask", source, &options.source_mask)?;
        let masked_target = flags("target_mask", target, &options.target_mask)?;
        let masked_triangles = matching::masked_triangles(target, &masked_target);
        let surface = Surface::of(target.triangles(), target.rest());
        Ok(Self { surface, masked_source, masked_target, masked_triangles })
    }
}

/// Looks up closest compatible points, on the partner of each component where it has one.
struct LookUp<'a> {
    source: &'a Mesh,
    target: &'a Mesh,
    onto: &'a Onto,
    component: Vec<u32>,
    partners: ComponentPairs,
    /// How much further away the partner may be than the nearest surface.
    detour: f64,
}

impl<'a> LookUp<'a> {
    fn new(source: &'a Mesh, target: &'a Mesh, onto: &'a Onto, detour: f64) -> Self {
        let partners = ComponentPairs::none([source.components().count(), target.components().count()]);
        Self { source, target, onto, component: triangle_components(target), partners, detour }
    }

    /// Finds out which components belong together, from the vertices at `x`.
    fn find_partners(&mut self, x: &[Vec3], job: &Job) -> Result<()> {
        let counts = [self.source.components().count(), self.target.components().count()];
        self.partners = ComponentPairs::none(counts);
        if counts == [1, 1] {
            return Ok(());
        }
        let mass = lumped_mass(self.source);
        let mut overlap = Overlap::new(counts);
        for (v, hit) in self.closest_points(x, job)?.iter().enumerate() {
            if let (Some(hit), Some(c)) = (hit, self.source.components().of_vertex(v)) {
                overlap.add(c as u32, self.component[hit.triangle], mass[v]);
            }
        }
        self.partners = overlap.partners();
        Ok(())
    }

    /// The closest compatible point of every vertex; `None` where nothing faces its way.
    fn closest_points(&self, x: &[Vec3], job: &Job) -> Result<Vec<Option<Hit>>> {
        let normals = vertex_normals(self.source.triangles(), x);
        let closest = |v: usize| {
            if self.onto.masked_source[v] {
                return None;
            }
            let open = |t: usize| !self.onto.masked_triangles[t];
            let any = self.onto.surface.closest_compatible_point_on(x[v], normals[v], f64::INFINITY, open)?;
            let partner = self.source.components().of_vertex(v).and_then(|c| self.partners.of_source[c]);
            match partner {
                Some(partner) if self.component[any.triangle] != partner => {
                    let reach = any.distance + self.detour;
                    let accept = |t: usize| self.component[t] == partner && open(t);
                    self.onto
                        .surface
                        .closest_compatible_point_on(x[v], normals[v], reach, accept)
                        .or(Some(any))
                }
                _ => Some(any),
            }
        };
        let mut hits = Vec::with_capacity(x.len());
        for start in (0..x.len()).step_by(BATCH) {
            job.check()?;
            hits.par_extend((start..x.len().min(start + BATCH)).into_par_iter().map(closest));
        }
        Ok(hits)
    }
}

/// Matches the triangles and takes stock.
fn conclude(
    source: &Mesh,
    target: &Mesh,
    x: &[Vec3],
    onto: &Onto,
    options: &FitOptions,
    mut report: FitReport,
    job: &Job,
) -> Result<Fit> {
    let frame = target.frame();
    let hits = LookUp::new(source, target, onto, 0.0).closest_points(x, job)?;
    let found = || hits.iter().flatten().map(|h| h.distance);
    let mean = found().sum::<f64>() / found().count().max(1) as f64;
    let largest = found().fold(0.0, f64::max);
    (report.distance_mean, report.distance_max) = (mean * frame.scale, largest * frame.scale);
    (report.distance_mean_percent, report.distance_max_percent) = (100.0 * mean, 100.0 * largest);

    let fitted = Surface::of(source.triangles(), x);
    let sides = [
        matching::FittedMesh::new(source, x, &fitted, &onto.masked_source),
        matching::FittedMesh::new(target, target.rest(), &onto.surface, &onto.masked_target),
    ];
    let flipped = flipped(&sides[0], &onto.surface);
    report.flipped_triangles = flipped.len();
    let stretches = stretches(source, x);
    report.stretched_triangles = stretches.iter().filter(|&&s| s > STRETCHED).count();
    if report.flipped_triangles > 0 {
        report.warnings.push(format!(
            "{} of {} fitted triangles face against the target; look for markers that are swapped or out \
             of place",
            report.flipped_triangles,
            source.triangles().len()
        ));
    }

    let (pairs, partners) = matching::match_triangles(&sides[0], &sides[1], options.match_distance, job)?;
    let reach = options.match_distance;
    let images = image::images(&sides[0], &sides[1], &partners.of_target, reach, job)?;
    let back_images = image::images(&sides[1], &sides[0], &partners.of_source, reach, job)?;
    for (side, mesh) in [source, target].into_iter().enumerate() {
        let mut matched = vec![false; mesh.triangles().len()];
        for pair in &pairs {
            matched[pair[side] as usize] = true;
        }
        let count = matched.iter().filter(|m| !**m).count();
        let unmatched = mesh.areas().iter().zip(&matched).filter(|(_, m)| !**m);
        let percent = 100.0 * unmatched.fold(0.0, |sum, (a, _)| sum + a) / mesh.areas().iter().sum::<f64>();
        if side == 0 {
            (report.unmatched_source_triangles, report.unmatched_source_percent) = (count, percent);
        } else {
            (report.unmatched_target_triangles, report.unmatched_target_percent) = (count, percent);
        }
    }
    if pairs.is_empty() {
        report.warnings.push("no triangle of the source has a match: the fit has failed".into());
    }
    let given = |&[s, t]: &[u32; 2]| [source.triangle_ids()[s as usize], target.triangle_ids()[t as usize]];
    let mut fitted_vertices: Vec<Vec3> = x.iter().map(|&p| frame.from_unit(p)).collect();
    source.follow(&mut fitted_vertices);
    if fitted_vertices.iter().any(|p| !p.is_finite()) {
        return Err(Error::SolveFailed("the fit left the range of floating point numbers".into()));
    }
    let mut distances: Vec<f64> =
        hits.iter().map(|h| h.map_or(f64::NAN, |h| h.distance * frame.scale)).collect();
    source.follow(&mut distances);
    let from_image = |(image, &p): (&Option<SurfacePoint>, &Vec3)| match image {
        Some(image) => {
            let corners = source.triangles()[image.triangle as usize].map(|v| x[v as usize]);
            image.blend(corners).distance(p) * frame.scale
        }
        None => f64::NAN,
    };
    let mut image_distances: Vec<f64> = images.iter().zip(target.rest()).map(from_image).collect();
    target.follow(&mut image_distances);
    let mut stretch = vec![1.0; source.input_triangles()];
    for (&id, s) in source.triangle_ids().iter().zip(stretches) {
        stretch[id as usize] = s;
    }
    let matches = Correspondence {
        pairs: pairs.iter().map(given).collect(),
        images: as_given(images, source, target),
        back_images: as_given(back_images, target, source),
    };
    let flipped = flipped.into_iter().map(|t| source.triangle_ids()[t]).collect();
    Ok(Fit { matches, fitted_vertices, distances, image_distances, stretch, flipped, report })
}

/// Images of the vertices of `of` on `on` as the inputs of the meshes count.
fn as_given(mut images: Vec<Option<SurfacePoint>>, on: &Mesh, of: &Mesh) -> Vec<Option<SurfacePoint>> {
    of.follow(&mut images);
    for image in images.iter_mut().flatten() {
        image.triangle = on.triangle_ids()[image.triangle as usize];
    }
    images
}

/// How much longer or narrower than the usual triangle each one of `source` is at `x`.
fn stretches(source: &Mesh, x: &[Vec3]) -> Vec<f64> {
    let rest = source.rest();
    let values: Vec<[f64; 2]> = (source.triangles().par_iter())
        .map(|t| singular_values(t.map(|v| rest[v as usize]), t.map(|v| x[v as usize])))
        .collect();
    let mut sizes: Vec<f64> = values.iter().map(|[a, b]| (a * b).sqrt()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    values.iter().map(|[a, b]| (a / usual).max(usual / b.max(f64::MIN_POSITIVE))).collect()
}

/// Both singular values of the map from triangle `rest` to `posed`, the larger first.
fn singular_values(rest: [Vec3; 3], posed: [Vec3; 3]) -> [f64; 2] {
    let (normal, _) = normal_and_area(rest);
    let gradient = triangle_gradient(rest, posed);
    let a = normal.any_orthonormal_vector();
    let (fa, fb) = (gradient * a, gradient * normal.cross(a));
    // Sum of their squares, and their product.
    let (squares, product) = (fa.length_squared() + fb.length_squared(), fa.cross(fb).length());
    let (plus, minus) = ((squares + 2.0 * product).sqrt(), (squares - 2.0 * product).max(0.0).sqrt());
    [0.5 * (plus + minus), 0.5 * (plus - minus)]
}

/// Fitted triangles whose place on the target faces the other way.
fn flipped(source: &matching::FittedMesh, target: &Surface) -> Vec<usize> {
    let fitted = source.surface();
    let is_flipped = |t: &usize| {
        if source.is_masked(*t) {
            return false;
        }
        let (centroid, normal) = (fitted.centroid(*t), fitted.normals()[*t]);
        let Some(nearest) = target.closest_point(centroid) else { return false };
        if target.normals()[nearest.triangle].dot(normal) > 0.0 {
            return false;
        }
        let compatible = target.closest_compatible_point(centroid, normal);
        compatible.is_none_or(|hit| hit.distance > nearest.distance + FLIPPED)
    };
    (0..fitted.normals().len()).into_par_iter().filter(is_flipped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::testing::{bumpy_grid, grid, nosed_sphere};

    fn fit(source: &Mesh, target: &Mesh, markers: &[[u32; 2]]) -> Result<Fit> {
        fit_correspondence(source, target, markers, &FitOptions::default(), &Job::default())
    }

    fn sphere(rings: usize, around: usize) -> Mesh {
        let (vertices, triangles) = nosed_sphere(rings, around);
        Mesh::new(vertices, triangles).unwrap()
    }

    /// The vertices of `target` that are nearest to a few well spread ones of `source`.
    fn spread_markers(source: &Mesh, target: &Mesh, step: usize) -> Vec<[u32; 2]> {
        let nearest = |p: Vec3| {
            let distance = |v: &usize| target.vertices()[*v].distance(p);
            (0..target.vertices().len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap() as u32
        };
        let mut markers: Vec<[u32; 2]> = (0..source.vertices().len())
            .step_by(step)
            .map(|v| [v as u32, nearest(source.vertices()[v])])
            .collect();
        markers.sort_unstable_by_key(|m| m[1]);
        markers.dedup_by_key(|m| m[1]);
        markers
    }

    #[test]
    fn a_mesh_fits_itself_exactly() {
        let mesh = bumpy_grid(12);
        let fit = fit(&mesh, &mesh, &[[0, 0], [11, 11], [132, 132], [70, 70]]).unwrap();
        for (a, b) in fit.fitted_vertices.iter().zip(mesh.vertices()) {
            assert!((*a - *b).length() < 1e-8);
        }
        let same: Vec<[u32; 2]> = (0..mesh.triangles().len() as u32).map(|t| [t, t]).collect();
        assert_eq!(fit.matches.pairs, same);
        assert!(fit.report.distance_max < 1e-8 && fit.report.warnings.is_empty());
    }

    #[test]
    fn a_coarse_surface_is_pulled_onto_a_fine_one_of_another_size_and_place() {
        let source = sphere(12, 20);
        let (vertices, triangles) = nosed_sphere(23, 31);
        let markers = spread_markers(&source, &Mesh::new(vertices.clone(), triangles.clone()).unwrap(), 19);
        let moved = |v: &Vec3| *v * 7.0 + Vec3::new(100.0, -40.0, 3.0);
        let target = Mesh::new(vertices.iter().map(moved).collect(), triangles).unwrap();
        let fit = fit(&source, &target, &markers).unwrap();
        assert!(fit.report.distance_max_percent < 0.5, "{:?}", fit.report);
        assert_eq!(fit.report.unmatched_target_triangles, 0);
        assert_eq!(fit.report.flipped_triangles, 0);
        for [s, t] in markers {
            let gap = fit.fitted_vertices[s as usize].distance(target.vertices()[t as usize]);
            assert!(gap < 1e-12 * target.frame().scale, "markers are exact");
        }
    }

    #[test]
    fn row_29_swapped_sides_are_told_with_the_count() {
        let (source, target) = (sphere(12, 20), sphere(14, 24));
        let mut markers = spread_markers(&source, &target, 19);
        // Mirror in y: left and right change places.
        let mirrored = |v: u32| {
            let p = target.vertices()[v as usize] * Vec3::new(1.0, -1.0, 1.0);
            let distance = |v: &u32| target.vertices()[*v as usize].distance(p);
            (0..target.vertices().len() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        };
        for marker in &mut markers {
            marker[1] = mirrored(marker[1]);
        }
        let report = fit(&source, &target, &markers).unwrap().report;
        assert!(report.flipped_triangles > 0);
        let told = format!("{} of {} fitted triangles", report.flipped_triangles, source.triangles().len());
        assert!(report.warnings.iter().any(|w| w.contains(&told)), "{:?}", report.warnings);
    }

    #[test]
    fn loose_parts_without_markers_are_carried_along() {
        // A ball beside the grid, in both meshes; only the grid is marked.
        let part = |n: usize, around: usize, map: &dyn Fn(Vec3) -> Vec3| {
            let (mut vertices, mut triangles) = grid(n);
            let (ball, faces) = nosed_sphere(6, around);
            let first = vertices.len() as u32;
            vertices.extend(ball.iter().map(|&p| p * 0.1 + Vec3::new(0.5, 0.5, 0.4)));
            triangles.extend(faces.iter().map(|t| t.map(|v| v + first)));
            Mesh::new(vertices.into_iter().map(map).collect(), triangles).unwrap()
        };
        let map = |p: Vec3| Vec3::new(1.1 * p.x, 0.9 * p.y, p.z) * 30.0 + Vec3::splat(5.0);
        let (source, target) = (part(9, 8, &|p| p), part(17, 11, &map));
        let markers = [[0, 0], [8, 16], [40, 144], [72, 272], [80, 288]];
        let fit = fit(&source, &target, &markers).unwrap();
        let (first, faces) = (81, 2 * 8 * 8);
        for v in first..source.vertices().len() {
            let gap = fit.fitted_vertices[v].distance(map(source.vertices()[v]));
            assert!(gap < 0.02 * target.frame().scale, "vertex {v} is off by {gap}");
        }
        let across = fit.matches.pairs.iter().filter(|p| (p[0] < faces) != (p[1] < 2 * 16 * 16)).count();
        assert_eq!(across, 0, "no pair joins the ball to the grid");
    }

    #[test]
    fn row_40_a_cancelled_job_stops() {
        let (mesh, job) = (bumpy_grid(5), Job::default());
        job.cancel();
        let outcome = fit_correspondence(&mesh, &mesh, &[[0, 0]], &FitOptions::default(), &job);
        assert!(matches!(outcome, Err(Error::Cancelled)));
    }
}
