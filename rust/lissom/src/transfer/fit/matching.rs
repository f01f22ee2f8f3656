//! Matching: which source triangle belongs to which target triangle, many to many.
//!
//! Once the source is fitted, every triangle of either mesh is matched with the triangle of the
//! other whose centroid is nearest, among those that face the same way, if the surface is within
//! reach (Sumner & Popović 2004, section 4.3).
//!
//! A triangle whose component has a partner ([`super::component_pairs`]) within reach is matched there, although
//! another component may be nearer.

use super::component_pairs::{ComponentPairs, Overlap};
use super::side::Placed;
use crate::{Job, Result};

/// For each triangle, its match.
type Matches = Vec<Option<u32>>;

impl Placed<'_> {
    /// The match of every triangle in `other`; in the partner of its component where that is within
    /// reach. Those of `before` that lie there already stay.
    fn nearest(
        &self,
        other: &Placed,
        partner: &[Option<u32>],
        before: Option<&Matches>,
        reach: f64,
        job: &Job,
    ) -> Result<Matches> {
        job.in_batches(self.side.component.len(), |t| {
            if self.side.masked[t] {
                return None;
            }
            let (at, normal) = (self.surface.centroid(t), self.surface.normal(t));
            // Reach is measured to the surface, since centroids of large triangles are far from anything; where the nearest
            // is within reach all the same, so is the surface.
            let look = |part: Option<u32>| {
                let near = other.surface.closest_compatible_centroid_of(part, at, normal, reach);
                if near.is_some() {
                    return near;
                }
                let hit = other.surface.closest_compatible_point_of(part, at, normal, reach)?;
                let within = other.surface.centroid(hit.triangle).distance(at) * (1.0 + f64::EPSILON);
                other.surface.closest_compatible_centroid_of(part, at, normal, within).or(Some(hit))
            };
            let partner = partner[self.side.component[t] as usize];
            if let Some(before) = before {
                let is_of = |s: &u32| partner.is_none_or(|p| p == other.side.component[*s as usize]);
                if before[t].as_ref().is_none_or(is_of) {
                    return before[t];
                }
            }
            let hit = partner.and_then(|_| look(partner)).or_else(|| look(None));
            hit.map(|hit| hit.triangle as u32)
        })
    }
}

/// Pairs `(triangle of source, triangle of target)`, sorted, each once, among the triangles in use; and which
/// components are partners.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn match_triangles(
    source: &Placed,
    target: &Placed,
    reach: f64,
    job: &Job,
) -> Result<(Vec<[u32; 2]>, ComponentPairs)> {
    let counts = [source, target].map(|side| side.side.mesh.components().count());
    let mut partners = ComponentPairs::none(counts);
    let mut of_source = source.nearest(target, &partners.of_source, None, reach, job)?;
    let mut of_target = target.nearest(source, &partners.of_target, None, reach, job)?;
    if counts != [1, 1] {
        let mut overlap = Overlap::new(counts);
        for (s, t) in of_source.iter().enumerate().filter_map(|(s, t)| t.map(|t| (s, t as usize))) {
            overlap.add(source.side.component[s], target.side.component[t], source.side.mesh.areas()[s]);
        }
        for (t, s) in of_target.iter().enumerate().filter_map(|(t, s)| s.map(|s| (t, s as usize))) {
            overlap.add(source.side.component[s], target.side.component[t], target.side.mesh.areas()[t]);
        }
        partners = overlap.partners();
        of_source = source.nearest(target, &partners.of_source, Some(&of_source), reach, job)?;
        of_target = target.nearest(source, &partners.of_target, Some(&of_target), reach, job)?;
    }
    let forth = (0u32..).zip(&of_source).filter_map(|(s, t)| t.map(|t| [s, t]));
    let back = (0u32..).zip(&of_target).filter_map(|(t, s)| s.map(|s| [s, t]));
    let mut pairs: Vec<[u32; 2]> = forth.chain(back).collect();
    pairs.sort_unstable();
    pairs.dedup();
    Ok((pairs, partners))
}
