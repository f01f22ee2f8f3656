//! Matching: which source triangle belongs to which target triangle, many to many.
//!
//! Once the source is fitted, every triangle of either mesh is matched with the triangle of the
//! other whose centroid is nearest, among those that face the same way and lie within reach (Sumner
//! & Popović 2004, section 4.3).

use rayon::prelude::*;

use super::closest::Surface;
use crate::{Job, Result};

/// Triangles looked up between two looks at the job.
const BATCH: usize = 4096;

/// Pairs `(triangle of source, triangle of target)`, sorted, each once, as the surfaces count them.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn match_triangles(source: &Surface, target: &Surface, reach: f64, job: &Job) -> Result<Vec<[u32; 2]>> {
    let mut pairs: Vec<[u32; 2]> =
        nearest(source, target, reach, job)?.into_iter().map(|[s, t]| [s, t]).collect();
    pairs.extend(nearest(target, source, reach, job)?.into_iter().map(|[t, s]| [s, t]));
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}

/// For each triangle of `from` that has a match in `to`: itself and its match.
fn nearest(from: &Surface, to: &Surface, reach: f64, job: &Job) -> Result<Vec<[u32; 2]>> {
    let count = from.normals().len();
    let mut found = Vec::with_capacity(count);
    for start in (0..count).step_by(BATCH) {
        job.check()?;
        let batch = (start..count.min(start + BATCH)).into_par_iter().filter_map(|t| {
            let hit = to.closest_compatible_centroid(from.centroid(t), from.normals()[t], reach)?;
            Some([t as u32, hit.triangle as u32])
        });
        found.par_extend(batch);
    }
    Ok(found)
}
