//! Touching: where surfaces around the rims of openings meet in a key ([`super::rims`]).
//!
//! Which place of a lid comes to lie on which of the other is seen where they do: a blink takes the upper lid to the
//! side. There both are as near on the target, by its size, as they are on the source.

use rayon::prelude::*;

use super::choose::SourceKey;
use super::contact::Contact;
use super::correspondence::Correspondence;
use crate::geometry::surface::Surface;
use crate::geometry::triangle::interpolate;
use crate::mesh::Paths;
use crate::{Mesh, Vec3};

/// Surfaces are in contact within this fraction of the source's diagonal ...
const REACH: f64 = 0.005;

/// ... where they face each other, by the cosine between their normals, ...
const OPPOSED: f64 = -0.3;

/// ... and have come closer to each other than this fraction of their distance at rest, ...
const CLOSED: f64 = 0.7;

/// ... and by this fraction of the source's diagonal. What slides along another surface, as lips do, is as near
/// to it at rest, if elsewhere.
const APPROACH: f64 = 0.003;

/// As far from rims, along edges and as a fraction of the source's diagonal, something touches: the corners of an eye are
/// too narrow to be an opening.
const AROUND: f64 = 0.02;

/// What `values` at the source's vertices are at a place: the corners of a triangle, and what each counts.
pub fn at_place(&(corners, weights): &([u32; 3], Vec3), values: &[Vec3]) -> Vec3 {
    interpolate(corners.map(|v| values[v as usize]), weights)
}

/// The target vertices of a place of the source, and what each counts; `None` where that is unknown, or not on the
/// component of `vertex`.
pub fn across(
    target: &Mesh,
    matches: &Correspondence,
    vertex: u32,
    (corners, weights): ([u32; 3], Vec3),
) -> Option<Vec<(u32, f64)>> {
    let component = |v: u32| target.components().of_vertex(v as usize);
    let mut place = Vec::with_capacity(9);
    for (k, corner) in corners.into_iter().enumerate() {
        let back = matches.back_images[corner as usize]?;
        let of_corner = target.triangles()[back.triangle as usize];
        place.extend((0..3).map(|i| (of_corner[i], weights[k] * back.weights[i])));
    }
    let own = component(vertex)?;
    place.iter().all(|&(w, _)| component(w) == Some(own)).then_some(place)
}

/// What can touch.
pub struct Touching {
    /// Source triangles around the rims.
    triangles: Vec<[u32; 3]>,
    at_rest: Surface,
    /// Target vertices with their image among these triangles, and its weights there.
    vertices: Vec<(u32, u32, Vec3)>,
}

impl Touching {
    /// Around `rims`, vertices of the source with these `paths`.
    pub fn new(
        source: &Mesh,
        target: &Mesh,
        matches: &Correspondence,
        paths: &Paths,
        rims: impl Iterator<Item = u32>,
    ) -> Self {
        let mut distances = vec![f64::INFINITY; source.rest().len()];
        paths.shorten(&mut distances, rims.map(|v| (v, 0.0)), AROUND, |_| {});
        let is_near = |t: &[u32; 3]| t.iter().all(|&v| distances[v as usize] <= AROUND);
        let mut slots = vec![None; source.triangles().len()];
        let mut triangles = Vec::new();
        for (t, corners) in source.triangles().iter().enumerate() {
            if is_near(corners) {
                slots[t] = Some(triangles.len() as u32);
                triangles.push(*corners);
            }
        }
        let slot = |v: u32| {
            let image = (*matches.images.get(v as usize)?)?;
            Some((v, slots[image.triangle as usize]?, image.weights))
        };
        let vertices = (0..target.rest().len() as u32).filter_map(slot).collect();
        Self { at_rest: Surface::of(&triangles, source.rest()), triangles, vertices }
    }

    /// Vertices that touch something in a key, which count by `weight`; `size` is that of the target over that of the
    /// source, for each component of the target.
    pub fn contacts(
        &self,
        source: &Mesh,
        target: &Mesh,
        matches: &Correspondence,
        key: &SourceKey,
        size: impl Fn(usize) -> f64 + Sync,
        weight: f64,
    ) -> Vec<(u32, Contact)> {
        let moved = |t: &[u32; 3]| t.map(|v| source.rest()[v as usize] + key.displacement[v as usize]);
        let surface = Surface::new(self.triangles.iter().map(moved).collect());
        let contact = |&(v, own, weights): &(u32, u32, Vec3)| {
            let corners = self.triangles[own as usize];
            let by = at_place(&(corners, weights), &key.displacement);
            if by == Vec3::ZERO {
                return None;
            }
            let at_rest = at_place(&(corners, weights), source.rest());
            let at = at_rest + by;
            let normal = surface.normal(own as usize);
            let accept = |t: usize| surface.normal(t).dot(normal) < OPPOSED;
            let hit = surface.closest_compatible_point_on(at, -normal, REACH, accept)?;
            let normal = self.at_rest.normal(own as usize);
            let near = (hit.distance / CLOSED).max(hit.distance + APPROACH);
            let accept = |t: usize| self.at_rest.normal(t).dot(normal) < OPPOSED;
            if self.at_rest.closest_compatible_point_on(at_rest, -normal, near, accept).is_some() {
                return None;
            }
            let place = across(target, matches, v, (self.triangles[hit.triangle], hit.weights))?;
            let gap = (hit.point - at) * size(target.components().of_vertex(v as usize)?);
            Some((v, Contact::across(target, v, place, gap, weight)))
        };
        self.vertices.par_iter().filter_map(contact).collect()
    }
}
