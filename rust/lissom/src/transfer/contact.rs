//! Contact: where the source's surfaces come together in a key, the same places of the target do.
//!
//! ```text
//!     min_c  c^T A c  +  sum_j k_j | (B d + B c)_j - r_j |^2         k_j = m_j / h^2
//! ```
//!
//! `d` is what stitching has found. `A` is its matrix with every vertex held by `m_v / l^2`, so that the
//! correction `c` fades within `l`: lids that close do not tilt the mouth. Row `j` of `B` takes the displacement of a target vertex from
//! that of the place which meets it, `r_j` is what brings the two as close as the source's places come, and `m_j`
//! is the area around the vertex. With `K = diag(k_j)` the minimum is `c = A^-1 B^T K^1/2 y` where
//! `(K^1/2 B A^-1 B^T K^1/2 + I) y = K^1/2 (r - B d)`: conjugate gradients on as many unknowns as there are
//! contacts, one back-substitution of the factor each.

use rayon::prelude::*;

use super::choose::SourceKey;
use super::correspondence::Correspondence;
use crate::geometry::surface::Surface;
use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::{Job, Mesh, Result, Vec3};

/// Surfaces are in contact within this fraction of the source's diagonal ...
const REACH: f64 = 0.005;

/// ... where they face each other, by the cosine between their normals, ...
const OPPOSED: f64 = -0.3;

/// ... and have come closer to each other than this fraction of their distance at rest, ...
const CLOSED: f64 = 0.7;

/// ... and by this fraction of the source's diagonal. What slides along another surface, as lips do, is as near
/// to it at rest, if elsewhere.
const APPROACH: f64 = 0.003;

/// `h`, a fraction of the target's diagonal: contacts are met where they go on for longer than this, and what
/// changes from vertex to vertex is left to the stitching.
const SMOOTH: f64 = 0.006;

/// `l`, a fraction of the target's diagonal.
const LOCAL: f64 = 0.05;

/// The contacts are met to this fraction of what was missing, or for so many back-substitutions.
const MET: f64 = 1e-2;
const ITERATIONS: usize = 60;

/// A target vertex, and the place of the target that meets it.
#[derive(Debug, Clone)]
pub struct Contact {
    vertex: u32,
    /// Target vertices and what each counts there; they add up to 1. None for a fixed point.
    place: Vec<(u32, f64)>,
    /// From vertex to place once the key is on, in the target's unit coordinates.
    gap: Vec3,
    /// `k^1/2`.
    pull: f64,
}

impl Contact {
    /// A pull of a vertex to a point in the target's unit coordinates.
    pub fn with_point(target: &Mesh, vertex: u32, point: Vec3) -> Self {
        Self { vertex, place: Vec::new(), gap: -point, pull: pull(target, vertex) }
    }

    /// The vertices that meet.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.place.iter().map(|&(v, _)| v).chain([self.vertex])
    }

    /// How much of a lid or lip the vertex makes up: the side of the square of its area, in unit coordinates.
    pub fn length(&self) -> f64 {
        self.pull * SMOOTH
    }

    /// From vertex to place, where the target's vertices have `values`.
    fn difference(&self, values: &[Vec3]) -> Vec3 {
        let there: Vec3 = self.place.iter().map(|&(v, weight)| values[v as usize] * weight).sum();
        there - values[self.vertex as usize]
    }

    /// How far the two have to come together, and how much of it is left with `displacements`, in unit coordinates.
    pub fn closing(&self, target: &Mesh, displacements: &[Vec3]) -> (f64, f64) {
        let at_rest = self.difference(target.rest());
        let left = (at_rest + self.difference(displacements)).length() - self.gap.length();
        ((at_rest.length() - self.gap.length()).max(0.0), left.max(0.0))
    }
}

/// The contacts of one key, within components of the target: lids and lips. `moved` are the displacements of the
/// images of the target's vertices, `size` is that of the target over that of the source, for each component of
/// the target.
pub fn contacts(
    source: &Mesh,
    target: &Mesh,
    matches: &Correspondence,
    key: &SourceKey,
    moved: &[Vec3],
    size: impl Fn(usize) -> f64 + Sync,
) -> Vec<Contact> {
    let (rest, faces) = (source.rest(), source.triangles());
    let posed: Vec<Vec3> = rest.iter().zip(&key.displacement).map(|(&p, &d)| p + d).collect();
    let [surface_at_rest, surface] = [rest, &posed[..]].map(|p| Surface::of(faces, p));
    let component = |v: u32| target.components().of_vertex(v as usize);
    let contact = |v: usize| {
        let image = matches.images[v]?;
        if moved[v] == Vec3::ZERO {
            return None;
        }
        let corners = faces[image.triangle as usize];
        let [at_rest, at] = [rest, &posed[..]].map(|p| image.blend(corners.map(|v| p[v as usize])));
        let normal = surface.normal(image.triangle as usize);
        let accept = |t: usize| surface.normal(t).dot(normal) < OPPOSED;
        let hit = surface.closest_compatible_point_on(at, -normal, REACH, accept)?;
        let there = faces[hit.triangle];
        let normal = source.normals()[image.triangle as usize];
        let near = (hit.distance / CLOSED).max(hit.distance + APPROACH);
        let accept = |t: usize| source.normals()[t].dot(normal) < OPPOSED;
        if surface_at_rest.closest_compatible_point_on(at_rest, -normal, near, accept).is_some() {
            return None;
        }
        let mut place = Vec::with_capacity(9);
        for (k, &corner) in there.iter().enumerate() {
            let back = matches.back_images[corner as usize]?;
            let of_corner = target.triangles()[back.triangle as usize];
            place.extend((0..3).map(|i| (of_corner[i], hit.weights[k] * back.weights[i])));
        }
        let own = component(v as u32);
        if place.iter().any(|&(w, _)| component(w) != own) {
            return None;
        }
        let gap = (hit.point - at) * size(own?);
        Some(Contact { vertex: v as u32, place, gap, pull: pull(target, v as u32) })
    };
    (0..moved.len()).into_par_iter().filter_map(contact).collect()
}

fn mass(target: &Mesh, vertex: u32) -> f64 {
    let around = target.adjacency().corners_of(vertex as usize).iter();
    around.map(|c| target.areas()[c.triangle as usize]).sum::<f64>() / 3.0
}

fn pull(target: &Mesh, vertex: u32) -> f64 {
    mass(target, vertex).sqrt() / SMOOTH
}

/// `A`, from the matrix that stitching has.
///
/// # Errors
///
/// As [`ConstrainedSystem::new`].
pub fn system(target: &Mesh, stitching: &SymmetricMatrix, job: &Job) -> Result<ConstrainedSystem> {
    let within = |v: u32| target.components().of_vertex(v as usize).is_some();
    let count = target.rest().len();
    let held = (0..count as u32).filter(|&v| within(v));
    let soft = held.map(|v| (v, mass(target, v).max(f64::MIN_POSITIVE) / (LOCAL * LOCAL)));
    let constraints = Constraints::hard(count, |v| !within(v as u32)).with_soft(soft);
    ConstrainedSystem::new(stitching, constraints, job)
}

/// Corrects `displacements` by as much as the contacts ask for; `system` is `A`.
pub fn close(target: &Mesh, system: &ConstrainedSystem, contacts: &[Contact], displacements: &mut [Vec3]) {
    let response = |y: &[Vec3]| {
        let mut sums = vec![Vec3::ZERO; displacements.len()];
        for (contact, &y) in contacts.iter().zip(y) {
            let y = y * contact.pull;
            contact.place.iter().for_each(|&(v, weight)| sums[v as usize] += y * weight);
            sums[contact.vertex as usize] -= y;
        }
        let mut x = [vec![Vec3::ZERO; displacements.len()]];
        system.solve(&[sums], &mut x);
        let [x] = x;
        x
    };
    let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let missing = |c: &Contact| c.gap - c.difference(target.rest()) - c.difference(displacements);
    let mut residual: Vec<Vec3> = contacts.iter().map(|c| missing(c) * c.pull).collect();
    let mut direction = residual.clone();
    let mut correction = vec![Vec3::ZERO; displacements.len()];
    let mut left = dot(&residual, &residual);
    let enough = left * MET * MET;
    for _ in 0..ITERATIONS {
        if left <= enough || left == 0.0 {
            break;
        }
        let answer = response(&direction);
        let image: Vec<Vec3> = (contacts.iter().zip(&direction))
            .map(|(contact, &y)| contact.difference(&answer) * contact.pull + y)
            .collect();
        let step = left / dot(&direction, &image);
        residual.iter_mut().zip(&image).for_each(|(r, &q)| *r -= q * step);
        correction.iter_mut().zip(&answer).for_each(|(c, &a)| *c += a * step);
        let next = dot(&residual, &residual);
        direction.iter_mut().zip(&residual).for_each(|(d, &r)| *d = r + *d * (next / left));
        left = next;
    }
    displacements.iter_mut().zip(correction).for_each(|(d, c)| *d += c);
}
