//! Look-up: what of the two surfaces is closest to each other, and how much that counts.
//!
//! A vertex is pulled to the tangent plane of its closest compatible point, and the place of the source that a
//! target vertex has closest to it likewise, so that thin rims meet from both sides. What has no counterpart must
//! pull nothing: a pull fades with its distance `d` by `1 / (1 + (d / s)^2)` (Cauchy's weights), ends at a reach
//! that shrinks from step to step, and does not count where the closest point is on a border, beyond which the
//! other mesh just ends. Where both end and little else tells what slides along the surfaces, border is pulled to border,
//! weakly, as either may be cut anywhere. Where another part of the source is nearer to that point, as the lips are to what the bag
//! behind them would be drawn to, that part has it: a pull counts by the square of how much nearer it is.

use super::component_pairs::{ComponentPairs, Overlap};
use super::pulls::Pull;
use super::side::{Placed, Side};
use crate::geometry::surface::Hit;
use crate::geometry::triangle::vertex_normals;
use crate::operators::mass::lumped_mass;
use crate::{Job, Result, Vec3};

/// `s`, a fraction of the reach.
const FADING: f64 = 0.25;

/// Weight across the normal, a fraction of that along it: enough to settle what else could slide for ever.
const ACROSS: f64 = 0.005;

/// Distances that make no difference between what is nearer, in unit coordinates.
const NEAR: f64 = 0.002;

/// Weight of border to border, a fraction of that of the surfaces: a cartoon's face is off by up to 1.6 % of the diagonal in
/// place of 3.4 where both are cut alike, and by no more than before where one is cut two to five rings further in.
const BORDERS: f64 = 0.1;

/// Vertices of the target that are asked for each of the source: with fewer, a coarse source misses what is thin.
const ENOUGH: usize = 4;

/// Vertices of a component that are asked where it lies; all know much the same.
const ASKED: usize = 2000;

/// Where the pulls come from.
pub struct LookUp<'a> {
    source: &'a Side<'a>,
    target: &'a Placed<'a>,
    partners: ComponentPairs,
    /// How much further away a partner may be than the nearest surface.
    detour: f64,
    /// Whether borders are pulled to borders.
    borders: bool,
}

impl<'a> LookUp<'a> {
    /// Between `source`, wherever it is, and `target`; with or without `borders`.
    pub fn new(source: &'a Side<'a>, target: &'a Placed<'a>, detour: f64, borders: bool) -> Self {
        let counts = [source, target.side].map(|side| side.mesh.components().count());
        Self { source, target, partners: ComponentPairs::none(counts), detour, borders }
    }

    /// Finds out which components belong together, from the vertices at `x`, and returns how far these are from
    /// the target at the lower quartile: half of the source may have no counterpart.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn find_partners(&mut self, x: &[Vec3], job: &Job) -> Result<f64> {
        let components = self.source.mesh.components();
        let normals = vertex_normals(self.source.mesh.triangles(), x);
        let open = |v: &u32| !self.source.masked_vertex[*v as usize];
        let members: Vec<Vec<u32>> =
            components.members().iter().map(|m| m.iter().copied().filter(open).collect()).collect();
        let every = |m: &Vec<u32>| m.len().div_ceil(ASKED).max(1);
        let asked: Vec<(usize, usize, usize)> = members
            .iter()
            .enumerate()
            .flat_map(|(c, m)| m.iter().step_by(every(m)).map(move |&v| (v as usize, c, every(m))))
            .collect();
        let found = job.in_batches(asked.len(), |i| {
            let (v, component, stands_for) = asked[i];
            let hit = self.target.closest(x[v], normals[v], f64::INFINITY, None, 0.0)?;
            Some((v, component, stands_for, hit))
        })?;
        let counts = [components.count(), self.target.side.mesh.components().count()];
        if counts != [1, 1] {
            let mass = lumped_mass(self.source.mesh);
            let mut overlap = Overlap::new(counts);
            for (v, component, stands_for, hit) in found.iter().flatten() {
                let mass = mass[*v] * *stands_for as f64;
                overlap.add(*component as u32, self.target.side.component[hit.triangle], mass);
            }
            self.partners = overlap.partners();
        }
        let mut distances: Vec<(f64, usize)> =
            found.iter().flatten().map(|(_, _, stands_for, hit)| (hit.distance, *stands_for)).collect();
        distances.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let quarter = distances.iter().map(|(_, stands_for)| stands_for).sum::<usize>() / 4;
        let mut passed = 0;
        let lower = distances.iter().find(|(_, stands_for)| {
            passed += stands_for;
            passed > quarter
        });
        Ok(lower.map_or(0.0, |(distance, _)| *distance))
    }

    /// The pulls of the source's vertices, by at most `weight` and within `reach`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn forth(&self, source: &Placed, weight: f64, reach: f64, job: &Job) -> Result<Vec<Pull>> {
        let (target, x, normals) = (self.target, source.positions, &source.normals);
        let pull = |v: usize| {
            let component = self.source.mesh.components().of_vertex(v)?;
            if self.source.masked_vertex[v] {
                return None;
            }
            let partner = self.partners.of_source[component];
            let hit = target.closest(x[v], normals[v], reach, partner, self.detour)?;
            let normal = target.normal(hit.triangle, hit.weights);
            if target.side.is_on_border(hit.triangle, hit.weights) {
                let both = self.borders && self.source.is_border(v);
                let weight = BORDERS * fading(&hit, weight, reach);
                return both.then(|| to_border([v as u32; 3], Vec3::X, x[v], hit.point, weight));
            }
            let taken = source.closest(hit.point, normal, hit.distance, None, 0.0)?.distance;
            let share = ((taken + NEAR) / (hit.distance + NEAR)).min(1.0).powi(2);
            let along = share * fading(&hit, weight, reach);
            Some(plane([v as u32; 3], Vec3::X, hit.point, normal, along))
        };
        Ok(job.in_batches(x.len(), pull)?.into_iter().flatten().collect())
    }

    /// The pulls by the target's vertices, in all at most as many as the source's: of a target of many more, some
    /// here and there speak for those beside them.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn back(&self, source: &Placed, weight: f64, reach: f64, job: &Job) -> Result<Vec<Pull>> {
        let (target, mesh) = (self.target.side, self.target.side.mesh);
        let every = (mesh.vertices().len() / (ENOUGH * source.positions.len().max(1))).max(1);
        let asked = mesh.vertices().len() / every;
        let weight = weight * (source.positions.len() as f64 / asked as f64).min(1.0);
        let pull = |k: usize| {
            let v = k * every + scattered(k, every);
            let component = mesh.components().of_vertex(v)?;
            if target.masked_vertex[v] || (target.is_border(v) && !self.borders) {
                return None;
            }
            let (point, normal) = (self.target.positions[v], self.target.normals[v].normalize_or_zero());
            let hit =
                source.closest(point, normal, reach, self.partners.of_target[component], self.detour)?;
            let corners = self.source.mesh.triangles()[hit.triangle];
            let weight = fading(&hit, weight, reach);
            match [target.is_border(v), self.source.is_on_border(hit.triangle, hit.weights)] {
                [false, false] => Some(plane(corners, hit.weights, point, normal, weight)),
                [true, true] => Some(to_border(corners, hit.weights, hit.point, point, BORDERS * weight)),
                _ => None,
            }
        };
        Ok(job.in_batches(asked, pull)?.into_iter().flatten().collect())
    }
}

/// Which one of every so many is asked the `k`th time: by no rule that rows of a grid could follow too (Knuth 1973, The
/// Art of Computer Programming, section 6.4, multiplicative hashing).
fn scattered(k: usize, every: usize) -> usize {
    ((k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize % every
}

fn fading(hit: &Hit, weight: f64, reach: f64) -> f64 {
    weight / (1.0 + (hit.distance / (FADING * reach)).powi(2))
}

/// From `place` beyond a border, or before it, onto it.
fn to_border(corners: [u32; 3], weights: Vec3, place: Vec3, border: Vec3, along: f64) -> Pull {
    plane(corners, weights, border, (place - border).normalize_or_zero(), along)
}

fn plane(corners: [u32; 3], weights: Vec3, goal: Vec3, normal: Vec3, along: f64) -> Pull {
    Pull { corners, weights, goal, normal, along, across: along * ACROSS }
}
