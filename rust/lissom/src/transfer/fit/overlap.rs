//! Overlap: meshes that lie on each other as they are, such as clothes on a body or high detail on low.
//!
//! Nothing is moved: each vertex belongs to the closest point of the other mesh that faces its way, if it is one
//! within reach that can be trusted, after R. Abdrashitov, K. Raichstat, J. Monsen, D. Hill 2023, Robust Skin Weights
//! Transfer via Weight Inpainting. What has none follows its surroundings, as everywhere.

use super::diagnosis::{Fit, FitReport, conclude};
use super::side::{Placed, Side};
use crate::{Error, Fault, Job, Result, Vec3};

/// Meshes of which both are covered to a lower percentage by the other do not lie on each other, and are refused; ...
const LEAST_PERCENT: f64 = 5.0;

/// ... to a lower one, it is said.
const FEW_PERCENT: f64 = 50.0;

/// What belongs together of `source` and `onto` where they lie, without any deformation.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] where they do not lie on each other, [`Error::Cancelled`].
pub fn overlap(source: &Side, onto: &Placed, reach: f64, report: FitReport, job: &Job) -> Result<Fit> {
    let (of, to) = (source.mesh.frame(), onto.side.mesh.frame());
    let x: Vec<Vec3> = source.mesh.rest().iter().map(|&p| to.to_unit(of.from_unit(p))).collect();
    let mut fit = conclude(&Placed::new(source, &x), onto, reach, report, true, job)?;
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
