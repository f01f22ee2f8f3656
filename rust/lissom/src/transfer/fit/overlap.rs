//! Overlap: meshes that lie on each other as they are, such as clothes on a body or high detail on low.
//!
//! Nothing is moved: each vertex belongs to the closest point of the other mesh that faces its way, if it is one
//! within reach that can be trusted, after R. Abdrashitov, K. Raichstat, J. Monsen, D. Hill 2023, Robust Skin Weights
//! Transfer via Weight Inpainting. The inside of what has a thickness goes with its outside. What has none follows its
//! surroundings, as everywhere.

use super::diagnosis::{Fit, FitReport, conclude};
use super::side::{Placed, Side};
use crate::geometry::surface::Hit;
use crate::transfer::image::SurfacePoint;
use crate::{Error, Fault, Job, Result, Vec3};

/// Meshes of which both are covered to a lower percentage by the other do not lie on each other, and are refused; ...
const LEAST_PERCENT: f64 = 5.0;

/// ... to a lower one, it is said.
const FEW_PERCENT: f64 = 50.0;

/// From so many percent of the target's vertices on it is said that they face away from what they lie on.
const AWAY_PERCENT: f64 = 10.0;

/// What belongs together of `source` and `onto` where they lie, without any deformation.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] where they do not lie on each other, [`Error::Cancelled`].
pub fn overlap(source: &Side, onto: &Placed, reach: f64, report: FitReport, job: &Job) -> Result<Fit> {
    let (of, to) = (source.mesh.frame(), onto.side.mesh.frame());
    let x: Vec<Vec3> = source.mesh.rest().iter().map(|&p| to.to_unit(of.from_unit(p))).collect();
    let placed = Placed::new(source, &x);
    let mut fit = conclude(&placed, onto, reach, report, true, job)?;
    let away = percent_away(&placed, onto, &fit.matches.images, reach, job)?;
    if away >= AWAY_PERCENT {
        fit.report.warnings.push(format!(
            "overlap: {away:.0} % of the target lie on the source, face away from it and match nothing: flip faces that \
             point inwards, or raise the match distance beyond the thickness of clothes"
        ));
    }
    let [of_source, of_target] =
        [fit.report.unmatched_source_percent, fit.report.unmatched_target_percent].map(|open| 100.0 - open);
    let covered = of_source.max(of_target);
    let said = format!(
        "{of_source:.0} % of the source and {of_target:.0} % of the target lie on the other within {reach:.3} of the \
         target's diagonal"
    );
    if covered < LEAST_PERCENT {
        let problem = format!("{said}: move the meshes onto each other, or do without it");
        return Err(Error::InvalidConstraint(Fault::new("overlap", problem)));
    }
    if covered < FEW_PERCENT {
        fit.report.warnings.push(format!("overlap: {said}: look whether the meshes lie where they should"));
    }
    fit.report.certainty = 1.0;
    fit.matches.overlap = true;
    Ok(fit)
}

/// How many of the target's vertices, in percent, have no image though the source is within reach.
fn percent_away(
    source: &Placed,
    target: &Placed,
    images: &[Option<SurfacePoint>],
    reach: f64,
    job: &Job,
) -> Result<f64> {
    let is_away = |v: usize| {
        let is_alone = images[v].is_none() && !target.side.masked_vertex[v];
        let hit = is_alone.then(|| source.surface.closest_point_within(target.positions[v], reach)).flatten();
        let faces = |hit: Hit| source.normal(hit.triangle, hit.weights).dot(target.normals[v]);
        hit.is_some_and(|hit| faces(hit) < 0.0)
    };
    let away = job.in_batches(images.len(), |v| u32::from(is_away(v)))?;
    Ok(100.0 * f64::from(away.into_iter().sum::<u32>()) / images.len().max(1) as f64)
}
