//! Fit: pull the source onto the target, then read off which triangles belong together.

use std::time::Instant;

use super::astray::register_less_astray;
use super::diagnosis::{Fit, FitReport, conclude};
use super::facing::{INSIDE_OUT, wound_alike};
use super::marked::Marked;
use super::morph::{self, Morph};
use super::options::FitOptions;
use super::overlap::overlap;
use super::registration::Registered;
use super::same::same;
use super::side::{Placed, Side};
use crate::options::OptionSet;
use crate::{Error, Fault, Job, Mesh, Result};

/// Fits `source` to `target` by `markers`, pairs of a source vertex and a target vertex; by `None` it finds out itself
/// how the two lie on each other ([`crate::transfer::alignment`]).
///
/// Meshes of the same triangles need no marker: without any, each vertex belongs to its own like. Components
/// of the source without a marker are carried along with the marked ones beside them
/// before the closest points take over.
///
/// # Errors
///
/// [`crate::Error::InvalidConstraint`] for markers that cannot be used (an empty list, out of range, marked twice), curves
/// that are none, and `None` where the meshes have too little in common; [`crate::Error::InvalidValue`] for options out of
/// range, [`crate::Error::SolveFailed`], [`crate::Error::Cancelled`].
pub fn fit_correspondence(
    source: &Mesh,
    target: &Mesh,
    markers: Option<&[[u32; 2]]>,
    options: &FitOptions,
    job: &Job,
) -> Result<Fit> {
    let start = Instant::now();
    let doubts = |name: &str, mesh: &Mesh| -> Vec<String> {
        mesh.warnings().iter().map(|warning| format!("{name}: {warning}")).collect()
    };
    let mut warnings = [doubts("source", source), doubts("target", target)].concat();
    options.check()?;
    morph::check(&options.modes, source)?;
    if options.overlap && (markers.is_some() || !options.curves.is_empty()) {
        let problem = "given, but meshes that overlap lie where they are: leave one of the two out";
        return Err(Error::InvalidConstraint(Fault::new("markers", problem)));
    }
    if markers.is_none_or(<[_]>::is_empty)
        && options.curves.is_empty()
        && !options.overlap
        && source.triangles() == target.triangles()
        && source.rest().len() == target.rest().len()
    {
        job.check()?;
        let mut fit = same(source, target, warnings);
        (fit.rest, fit.coefficients) = Morph::of_same(source, target, &options.modes).told(source);
        return Ok(fit);
    }
    job.report(0.0, "fit");
    job.check()?;
    let ([from, onto], inside_out) = wound_alike(source, target, markers, options, job)?;
    if inside_out {
        warnings.push(INSIDE_OUT.into());
    }
    let mut fit = fit_wound(&from.mesh, &onto.mesh, markers, options, warnings, job)?;
    from.as_given(&mut fit.matches.images);
    onto.as_given(&mut fit.matches.back_images);
    fit.matches.inside_out = inside_out;
    fit.report.seconds = start.elapsed().as_secs_f64();
    job.report(1.0, "match");
    Ok(fit)
}

/// The fit of meshes of which each is wound alike, and one as the other.
fn fit_wound(
    source: &Mesh,
    target: &Mesh,
    markers: Option<&[[u32; 2]]>,
    options: &FitOptions,
    mut warnings: Vec<String>,
    job: &Job,
) -> Result<Fit> {
    let source_side = Side::new(source, "source_mask", &options.source_mask)?;
    let target_side = Side::new(target, "target_mask", &options.target_mask)?;
    let onto = Placed::new(&target_side, target.rest());
    if options.overlap {
        let report = FitReport { warnings, ..FitReport::default() };
        let mut fit = overlap(&source_side, &onto, options.match_distance, report, job)?;
        fit.rest = source.vertices().to_vec();
        return Ok(fit);
    }

    let Marked { mut lie, mut led_by } =
        Marked::of(&source_side, &onto, markers, options, &mut warnings, job)?;
    let mut morph = Morph::new(source, &options.modes, &lie);
    if !options.modes.is_empty() {
        morph.find(&source_side, &onto, &lie.markers, options.match_distance, job)?;
        (lie.turn, lie.size, lie.shift) = morph.lie();
    }
    let laid = source.reshaped(morph.turned());
    let source_side = source_side.of(&laid);
    let Registered { vertices: x, rounds } =
        register_less_astray(&source_side, &onto, &mut lie, &mut led_by, options, job)?;
    job.report(0.9, "match");
    let led = led_by.told(&x, markers, options.marker_tolerance);
    let doubtful = led.doubtful.iter().chain([&led.unmet, &led.reordered]).flatten();
    warnings.extend(doubtful.map(|doubtful| doubtful.warning.clone()));
    let report = FitReport { rounds, warnings, certainty: lie.certainty, ..FitReport::default() };
    let mut fit =
        conclude(&Placed::new(&source_side, &x), &onto, options.match_distance, report, false, job)?;
    fit.report.doubt_what_is_uncovered();
    (fit.rest, fit.coefficients) = morph.told(source);
    let within = options.match_distance * target.frame().scale;
    let lies_on = |v: usize| fit.distances[v] <= within;
    fit.matches.turn = lie.settled_turn(source, &x, lies_on, !options.modes.is_empty());
    fit.matches.curves = led.curves;
    let in_units = |off: Vec<f64>| off.into_iter().map(|off| off * target.frame().scale).collect();
    [fit.marker_distances, fit.curve_distances] = led.off.map(in_units);
    [fit.doubtful_markers, fit.doubtful_curves] = led.doubtful;
    (fit.unmet_curves, fit.reordered_curves) = (led.unmet, led.reordered);
    Ok(fit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::Vec3;
    use crate::transfer::testing::{bumpy_grid, grid, nosed_sphere};

    fn fit(source: &Mesh, target: &Mesh, markers: &[[u32; 2]]) -> Result<Fit> {
        fit_correspondence(source, target, Some(markers), &FitOptions::default(), &Job::default())
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
        let exact = FitOptions { marker_tolerance: 0.0, ..FitOptions::default() };
        for options in [FitOptions::default(), exact] {
            let fit =
                fit_correspondence(&source, &target, Some(&markers), &options, &Job::default()).unwrap();
            assert!(fit.report.distance_max_percent < 0.5, "{:?}", fit.report);
            assert_eq!(fit.report.unmatched_target_triangles, 0);
            assert_eq!(fit.report.flipped_triangles, 0);
            // They are at the nearest vertices of the target, a few tolerances off.
            let within = (4.0 * options.marker_tolerance).max(1e-12) * target.frame().scale;
            for (i, &[s, t]) in markers.iter().enumerate() {
                let gap = fit.fitted_vertices[s as usize].distance(target.vertices()[t as usize]);
                assert!(gap < within && (gap - fit.marker_distances[i]).abs() < 1e-12 * target.frame().scale);
            }
        }
    }

    /// Points of a sphere with a nose, of the same place as others of it, off by `amount`.
    fn off_by(amount: f64, of: &Mesh, step: usize) -> (Vec<[u32; 2]>, Vec<Vec3>) {
        let chosen = (0..of.vertices().len()).step_by(step);
        let points = chosen
            .clone()
            .map(|v| of.vertices()[v] + Vec3::new((7 * v) as f64, v as f64, 1.0).sin() * amount);
        (chosen.clone().map(|v| [v as u32, 0]).collect(), points.collect())
    }

    #[test]
    fn a_marker_that_disagrees_with_those_around_it_is_named_and_left_out() {
        let mesh = sphere(20, 30);
        let (markers, points) = off_by(0.01, &mesh, 13);
        for wrong in [3, 20, 40] {
            let mut points = points.clone();
            points[wrong] += Vec3::new(0.1, -0.15, 0.1);
            let options = FitOptions { points, ..FitOptions::default() };
            let fit = fit_correspondence(&mesh, &mesh, Some(&markers), &options, &Job::default()).unwrap();
            let doubted: Vec<u32> = fit.doubtful_markers.iter().map(|doubtful| doubtful.number).collect();
            assert_eq!(doubted, [wrong as u32]);
            let named = format!("number {wrong} (source vertex {})", markers[wrong][0]);
            assert!(fit.report.warnings.iter().any(|w| w.contains(&named)), "{:?}", fit.report.warnings);
            let off = fit.fitted_vertices.iter().zip(mesh.vertices()).map(|(a, b)| a.distance(*b));
            assert!(off.fold(0.0, f64::max) < 0.02, "the fit does not follow it");
        }
    }

    #[test]
    fn source_points_mark_what_no_vertex_is_at() {
        let (source, target) = (sphere(12, 20), sphere(23, 31));
        let triangles: Vec<[u32; 3]> = source.triangles().iter().copied().step_by(17).collect();
        let centre = |t: &[u32; 3]| t.iter().map(|&v| source.vertices()[v as usize]).sum::<Vec3>() / 3.0;
        let at: Vec<Vec3> = triangles.iter().map(centre).collect();
        let markers: Vec<[u32; 2]> = triangles.iter().map(|t| [t[0], 0]).collect();
        let options = FitOptions {
            points: at.clone(),
            source_points: at.clone(),
            marker_tolerance: 0.0,
            ..FitOptions::default()
        };
        let fit = fit_correspondence(&source, &target, Some(&markers), &options, &Job::default()).unwrap();
        for ((triangle, at), off) in triangles.iter().zip(&at).zip(&fit.marker_distances) {
            let place = triangle.iter().map(|&v| fit.fitted_vertices[v as usize]).sum::<Vec3>() / 3.0;
            assert!(place.distance(*at) < 1e-3 && (place.distance(*at) - off).abs() < 1e-9);
        }
    }

    #[test]
    fn a_turned_target_is_fitted_as_one_that_is_not() {
        let (source, upright) = (sphere(12, 20), sphere(23, 31));
        let markers = spread_markers(&source, &upright, 19);
        let turn = crate::rotation::exp(Vec3::new(0.7, -0.4, 1.1));
        let turned: Vec<Vec3> = upright.vertices().iter().map(|&v| turn * v).collect();
        let target = Mesh::new(turned, upright.triangles().to_vec()).unwrap();
        let [a, b] = [&upright, &target].map(|target| fit(&source, target, &markers).unwrap());
        assert!(a.matches.turn == crate::Mat3::IDENTITY);
        assert!(
            (b.matches.turn * turn.transpose() - crate::Mat3::IDENTITY)
                .to_cols_array()
                .iter()
                .all(|v| v.abs() < 0.05)
        );
        for (a, b) in a.fitted_vertices.iter().zip(&b.fitted_vertices) {
            assert!((turn * *a).distance(*b) < 0.01 * target.frame().scale);
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
        let exact = FitOptions { marker_tolerance: 0.0, ..FitOptions::default() };
        let fitted = |options: FitOptions| {
            fit_correspondence(&source, &target, Some(&markers), &options, &Job::default()).unwrap().report
        };
        // So many that are wrong let go where they may, and what is left is told of the turn.
        let released = fitted(FitOptions::default());
        assert!(released.warnings.iter().any(|w| w.contains("swapped")), "{:?}", released.warnings);
        let report = fitted(exact);
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
        let outcome = fit_correspondence(&mesh, &mesh, Some(&[[0, 0]]), &FitOptions::default(), &job);
        assert!(matches!(outcome, Err(Error::Cancelled)));
    }
}
