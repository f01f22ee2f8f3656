//! Contact: where openings of the source close in a key, those of the target do ([`super::rims`]).
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

use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::mesh::Paths;
use crate::{Job, Mesh, Result, Vec3};

/// `h`, a fraction of the target's diagonal: contacts are met where they go on for longer than this, and what
/// changes from vertex to vertex is left to the stitching.
const SMOOTH: f64 = 0.003;

/// `l`, a fraction of the target's diagonal.
const LOCAL: f64 = 0.05;

/// So many times that from what can meet, along edges, nothing is corrected any more.
const FADED: f64 = 2.0;

/// The contacts are met to this fraction of what was missing, or for so many back-substitutions.
const MET: f64 = 0.03;
const ITERATIONS: usize = 60;

/// A target vertex, and the place of the target that meets it.
#[derive(Debug, Clone)]
pub struct Contact {
    vertex: u32,
    /// Target vertices and what each counts there; they add up to 1. None for a fixed point.
    place: Vec<(u32, f64)>,
    /// From vertex to place once the key is on, in the target's unit coordinates.
    gap: Vec3,
    /// The direction from vertex to place at rest; zero for a fixed point.
    way: Vec3,
    /// How much of a lid or lip the vertex makes up: the side of the square of its area, in unit coordinates.
    length: f64,
    /// `k^1/2`.
    pull: f64,
}

impl Contact {
    /// A pull of a vertex to a point in the target's unit coordinates.
    pub fn with_point(target: &Mesh, vertex: u32, point: Vec3) -> Self {
        Self::new(target, vertex, Vec::new(), -point, 1.0)
    }

    /// A vertex and a place that are to be `gap` apart once the key is on, which counts by `weight`.
    pub fn across(target: &Mesh, vertex: u32, place: Vec<(u32, f64)>, gap: Vec3, weight: f64) -> Self {
        let mut contact = Self::new(target, vertex, place, gap, weight);
        contact.way = contact.difference(target.rest()).normalize_or_zero();
        contact
    }

    fn new(target: &Mesh, vertex: u32, place: Vec<(u32, f64)>, gap: Vec3, weight: f64) -> Self {
        let length = mass(target, vertex).sqrt();
        Self { vertex, place, gap, way: Vec3::ZERO, length, pull: length * weight.sqrt() / SMOOTH }
    }

    /// The vertices that meet.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.place.iter().map(|&(v, _)| v).chain([self.vertex])
    }

    /// How much of a lid or lip the vertex makes up.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// From vertex to place, where the target's vertices have `values`.
    fn difference(&self, values: &[Vec3]) -> Vec3 {
        let there: Vec3 = self.place.iter().map(|&(v, weight)| values[v as usize] * weight).sum();
        there - values[self.vertex as usize]
    }

    /// How far the two have to come together, and how much of it is left with `displacements`, along the way from one
    /// to the other at rest: less than nothing where they have gone too far. In unit coordinates.
    pub fn closing(&self, target: &Mesh, displacements: &[Vec3]) -> (f64, f64) {
        let asked = (self.difference(target.rest()) - self.gap).dot(self.way);
        (asked, asked + self.difference(displacements).dot(self.way))
    }
}

/// The area of a vertex, in unit coordinates.
pub fn mass(target: &Mesh, vertex: u32) -> f64 {
    let around = target.adjacency().corners_of(vertex as usize).iter();
    around.map(|c| target.areas()[c.triangle as usize]).sum::<f64>() / 3.0
}

/// `A`, from the matrix that stitching has, around `meeting`, vertices of the target that can meet something.
///
/// # Errors
///
/// As [`ConstrainedSystem::new`].
pub fn system(
    target: &Mesh,
    stitching: &SymmetricMatrix,
    meeting: &[u32],
    job: &Job,
) -> Result<ConstrainedSystem> {
    let mut distances = vec![f64::INFINITY; target.rest().len()];
    let paths = Paths::new(target.adjacency(), target.rest(), 0.0);
    paths.shorten(&mut distances, meeting.iter().map(|&v| (v, 0.0)), FADED * LOCAL, |_| {});
    let within = |v: u32| distances[v as usize].is_finite();
    let count = target.rest().len();
    let held = (0..count as u32).filter(|&v| within(v));
    let soft = held.map(|v| (v, mass(target, v).max(f64::MIN_POSITIVE) / (LOCAL * LOCAL)));
    let constraints = Constraints::hard(count, |v| !within(v as u32)).with_soft(soft);
    ConstrainedSystem::new(stitching, constraints, job)
}

/// Corrects `displacements` by as much as the contacts ask for; `system` is `A`, and `y` what was found for as many of
/// the contacts as were there before.
pub fn close(
    target: &Mesh,
    system: &ConstrainedSystem,
    contacts: &[Contact],
    y: &mut Vec<Vec3>,
    displacements: &mut [Vec3],
) {
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
    let image = |answer: &[Vec3], y: &[Vec3]| -> Vec<Vec3> {
        let pairs = contacts.iter().zip(y);
        pairs.map(|(contact, &y)| contact.difference(answer) * contact.pull + y).collect()
    };
    let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let missing = |c: &Contact| c.gap - c.difference(target.rest()) - c.difference(displacements);
    let mut residual: Vec<Vec3> = contacts.iter().map(|c| missing(c) * c.pull).collect();
    let enough = dot(&residual, &residual) * MET * MET;
    let mut correction = vec![Vec3::ZERO; displacements.len()];
    let known = !y.is_empty();
    y.resize(contacts.len(), Vec3::ZERO);
    if known {
        correction = response(y);
        residual.iter_mut().zip(image(&correction, y)).for_each(|(r, q)| *r -= q);
    }
    let mut direction = residual.clone();
    let mut left = dot(&residual, &residual);
    for _ in 0..ITERATIONS {
        if left <= enough || left == 0.0 {
            break;
        }
        let answer = response(&direction);
        let image = image(&answer, &direction);
        let step = left / dot(&direction, &image);
        residual.iter_mut().zip(&image).for_each(|(r, &q)| *r -= q * step);
        correction.iter_mut().zip(&answer).for_each(|(c, &a)| *c += a * step);
        y.iter_mut().zip(&direction).for_each(|(y, &d)| *y += d * step);
        let next = dot(&residual, &residual);
        direction.iter_mut().zip(&residual).for_each(|(d, &r)| *d = r + *d * (next / left));
        left = next;
    }
    displacements.iter_mut().zip(correction).for_each(|(d, c)| *d += c);
}
