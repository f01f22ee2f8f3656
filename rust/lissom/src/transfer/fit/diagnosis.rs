//! Diagnosis: which triangles belong together once the source is on the target, and how well it went.

use rayon::prelude::*;

use super::doubtful::Doubtful;
use super::images;
use super::matching::match_triangles;
use super::side::Placed;
use crate::geometry::rigid;
use crate::geometry::surface::{Hit, Surface};
use crate::geometry::triangle::interpolate;
use crate::operators::gradient::singular_values;
use crate::transfer::correspondence::Correspondence;
use crate::transfer::image::SurfacePoint;
use crate::{Error, Job, Mesh, Result, Vec3};

/// A vertex is stuck on the wrong side when the nearest point that faces its way is further away
/// than the nearest point of all by this fraction of the diagonal: thin sheets have both sides close.
const FLIPPED: f64 = 0.01;

/// A triangle is reported as distorted from here on: three times as long as the usual one, or a third as wide.
pub const DISTORTED: f64 = 3.0;

/// In percent: meshes of which more than this has no counterpart, on either side, are hardly of the same thing. Of one
/// side alone it says nothing: a face is a small part of a body.
const UNCOVERED: f64 = 50.0;

/// A source that has been pulled onto a target.
#[derive(Debug, Clone, Default)]
pub struct Fit {
    /// What belongs together.
    pub matches: Correspondence,
    /// The source's vertices on the target, in the target's units.
    pub fitted_vertices: Vec<Vec3>,
    /// The source's vertices at rest as the one that the target looks like has them, in the source's units: its own
    /// without modes.
    pub rest: Vec<Vec3>,
    /// How much of each mode that is.
    pub coefficients: Vec<f64>,
    /// How far each of them is from the target's surface that faces its way, in the target's units; not a number
    /// where nothing does, and for masked vertices.
    pub distances: Vec<f64>,
    /// How far each target vertex is from its image, likewise.
    pub image_distances: Vec<f64>,
    /// How much each source triangle, as its input counts them, is longer or narrower than the usual one.
    pub distortion: Vec<f64>,
    /// The source triangles that face against the target where they lie.
    pub flipped: Vec<u32>,
    /// How far each marker's place on the fitted source is from where it was marked, in the target's units.
    pub marker_distances: Vec<f64>,
    /// Markers that lie where the others do not put them.
    pub doubtful_markers: Vec<Doubtful>,
    /// How far the vertices of each curve on the fitted source are from that of the target, in the target's units, at the
    /// mean.
    pub curve_distances: Vec<f64>,
    /// Curves that lie where markers and other curves do not put them.
    pub doubtful_curves: Vec<Doubtful>,
    /// Curves that were followed and are not met.
    pub unmet_curves: Vec<Doubtful>,
    /// Curves on which the markers come in another order than on the target.
    pub reordered_curves: Vec<Doubtful>,
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
    /// Fitted triangles whose distortion is more than [`DISTORTED`].
    pub distorted_triangles: usize,
    /// Source triangles without a match.
    pub unmatched_source_triangles: usize,
    /// Target triangles without a match.
    pub unmatched_target_triangles: usize,
    /// Their share of the source's area, in percent.
    pub unmatched_source_percent: f64,
    /// Their share of the target's area, in percent.
    pub unmatched_target_percent: f64,
    /// How sure it is that the meshes lie on each other as they were laid, 0-1; 1 by markers and where they overlap, less
    /// where little of either has a counterpart.
    pub certainty: f64,
    /// Rounds of closest points.
    pub rounds: usize,
    /// Wall clock time.
    pub seconds: f64,
    /// What is doubtful.
    pub warnings: Vec<String>,
}

impl FitReport {
    /// Doubts meshes that were laid on each other and of which little has a counterpart.
    pub fn doubt_what_is_uncovered(&mut self) {
        let (one, other) = (self.unmatched_source_percent, self.unmatched_target_percent);
        let uncovered = one.min(other);
        if uncovered <= UNCOVERED {
            return;
        }
        self.certainty *= (100.0 - one.max(other)) / (100.0 - UNCOVERED);
        // Where it is all of either, the fit has failed, and that is said.
        if uncovered < 100.0 {
            self.warnings.push(format!(
                "{uncovered:.0} % of either mesh has no counterpart on the other: they have little in common, or do not lie \
                 on each other; look at the fit and the markers"
            ));
        }
    }
}

/// Matches the triangles and takes stock. Where the meshes `overlap` nothing was moved, so that nothing has folded.
pub fn conclude(
    fitted: &Placed,
    onto: &Placed,
    match_distance: f64,
    mut report: FitReport,
    overlap: bool,
    job: &Job,
) -> Result<Fit> {
    let (source, target, x) = (fitted.side.mesh, onto.side.mesh, fitted.positions);
    let frame = target.frame();
    let closest = |v: usize| {
        let masked = fitted.side.masked_vertex[v];
        (!masked).then(|| onto.closest(x[v], fitted.normals[v], f64::INFINITY, None, 0.0)).flatten()
    };
    let hits: Vec<Option<Hit>> = job.in_batches(x.len(), closest)?;
    let found = || hits.iter().flatten().map(|h| h.distance);
    let mean = found().sum::<f64>() / found().count().max(1) as f64;
    let largest = found().fold(0.0, f64::max);
    (report.distance_mean, report.distance_max) = (mean * frame.scale, largest * frame.scale);
    (report.distance_mean_percent, report.distance_max_percent) = (100.0 * mean, 100.0 * largest);

    let flipped = if overlap { Vec::new() } else { flipped(fitted, onto, match_distance) };
    report.flipped_triangles = flipped.len();
    let distortions = distortions(source, x);
    report.distorted_triangles = distortions.iter().filter(|&&s| s > DISTORTED).count();
    if report.flipped_triangles > 0 {
        report.warnings.push(format!(
            "{} of {} fitted triangles face against the target, which folds them; show the fit to see where",
            report.flipped_triangles,
            source.triangles().len()
        ));
    }

    let (pairs, partners) = match_triangles(fitted, onto, match_distance, job)?;
    let find = if overlap { images::images_of_overlap } else { images::images };
    let images = find(fitted, onto, &partners.of_target, match_distance, job)?;
    let back_images = find(onto, fitted, &partners.of_source, match_distance, job)?;
    for (side, mesh) in [source, target].into_iter().enumerate() {
        let mut matched = vec![false; mesh.triangles().len()];
        for pair in &pairs {
            matched[pair[side] as usize] = true;
        }
        if overlap {
            let images = [&back_images, &images][side];
            let lies = |t: &[u32; 3]| t.iter().all(|&v| images[v as usize].is_some());
            matched.iter_mut().zip(mesh.triangles()).for_each(|(matched, t)| *matched |= lies(t));
        }
        let count = matched.iter().filter(|m| !**m).count();
        let unmatched = mesh.areas().iter().zip(&matched).filter(|(_, m)| !**m);
        let percent = 100.0 * unmatched.fold(0.0, |sum, (a, _)| sum + a) / mesh.area();
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
            interpolate(corners, image.weights).distance(p) * frame.scale
        }
        None => f64::NAN,
    };
    let mut image_distances: Vec<f64> = images.iter().zip(target.rest()).map(from_image).collect();
    target.follow(&mut image_distances);
    let mut distortion = vec![1.0; source.input_triangles()];
    for (&id, s) in source.triangle_ids().iter().zip(distortions) {
        distortion[id as usize] = s;
    }
    let matches = Correspondence {
        pairs: pairs.iter().map(given).collect(),
        images: as_given(images, source, target),
        back_images: as_given(back_images, target, source),
        ..Correspondence::default()
    };
    let flipped = flipped.into_iter().map(|t| source.triangle_ids()[t]).collect();
    Ok(Fit {
        matches,
        fitted_vertices,
        distances,
        image_distances,
        distortion,
        flipped,
        report,
        ..Fit::default()
    })
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
fn distortions(source: &Mesh, x: &[Vec3]) -> Vec<f64> {
    let rest = source.rest();
    let values: Vec<[f64; 2]> = (source.triangles().par_iter())
        .map(|t| singular_values(t.map(|v| rest[v as usize]), t.map(|v| x[v as usize])))
        .collect();
    let mut sizes: Vec<f64> = values.iter().map(|[a, b]| (a * b).sqrt()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    values.iter().map(|[a, b]| (a / usual).max(usual / b.max(f64::MIN_POSITIVE))).collect()
}

/// Fitted triangles whose place on the target faces the other way. Linings, as those of lids and sockets, lie so close
/// to what they line that they face the wrong way wherever the target has none: they are at rest as they are here.
fn flipped(source: &Placed, onto: &Placed, reach: f64) -> Vec<usize> {
    let fitted = &source.surface;
    // What is masked matches nothing, but may well be what a triangle faces.
    let whole = || Surface::of(onto.side.mesh.triangles(), onto.positions);
    let whole = onto.side.masked.contains(&true).then(whole);
    let target = whole.as_ref().unwrap_or(&onto.surface);
    let against = |t: usize| {
        if source.side.masked[t] {
            return None;
        }
        let (centroid, normal) = (fitted.centroid(t), fitted.normal(t));
        let nearest = target.closest_point_within(centroid, reach)?;
        if target.normal(nearest.triangle).dot(normal) > 0.0 {
            return None;
        }
        let reach = nearest.distance + FLIPPED;
        let compatible = target.closest_compatible_point_on(centroid, normal, reach, |_| true);
        compatible.is_none().then_some((t, nearest.distance))
    };
    let found: Vec<(usize, f64)> =
        (0..source.side.mesh.triangles().len()).into_par_iter().filter_map(against).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let mesh = source.side.mesh;
    let at_rest = Surface::of(mesh.triangles(), mesh.rest());
    let size = rigid::size_ratio(source.positions.iter().copied(), mesh.rest().iter().copied());
    let lining = |&(t, distance): &(usize, f64)| {
        let (centroid, normal) = (at_rest.centroid(t), at_rest.normal(t));
        at_rest
            .closest_compatible_point_on(centroid, -normal, (distance + FLIPPED) / size, |_| true)
            .is_some()
    };
    found.into_par_iter().filter(|found| !lining(found)).map(|(t, _)| t).collect()
}
