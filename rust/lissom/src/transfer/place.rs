//! Place: the translation that stitching leaves open, one connected component at a time.
//!
//! * Vertices whose matches do not move stay put exactly. Stitching moves them a little, since
//!   targets rarely fit together; the error is taken out, and smoothed over a few rings around them
//!   by the same Laplacian, so that no step shows.
//! * A component with images is where its anchors put it ([`super::anchor`]).
//! * Any other without such a vertex follows the centroid of its matches: the displacement of the
//!   matched source triangles, times the size of the component over that of its matches or at its own size
//!   ([`super::scale`]).
//! * A component without any match follows the nearest matched surface rigidly, or stays.

use super::anchor::Anchors;
use super::choose::{Chooser, SourceKey};
use super::options::Unmatched;
use super::sizes::Sizes;
use crate::geometry::rigid::{self, Alignment};
use crate::geometry::rows::Rows;
use crate::geometry::surface::Surface;
use crate::linear::SymmetricMatrix;
use crate::{Mesh, Vec3};

/// Rings around the vertices at rest over which their error is smoothed out.
const RINGS: u32 = 8;

/// Times that the error is smoothed, forth and back.
const SWEEPS: usize = 2;

/// What is needed to place the components of a target.
pub struct Placer {
    parts: Vec<PlacedComponent>,
    /// Full rows of the stitching matrix, for the smoothing.
    rows: Rows<(u32, f64)>,
}

struct PlacedComponent {
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    /// Size of the component over the size of its matches, both in unit coordinates.
    size: f64,
    /// What the displacements of its matches are multiplied with.
    gain: f64,
    /// Whether anchors say where it goes.
    anchored: bool,
    /// For a component without matches: the vertices of the nearest matched surface.
    beside: Option<Vec<u32>>,
}

impl Placer {
    /// Prepares the components of `target`, whose stitching matrix is `matrix`; `sizes` as [`super::scale`] has them.
    pub fn new(
        source: &Mesh,
        target: &Mesh,
        matrix: &SymmetricMatrix,
        chooser: &Chooser,
        anchors: &Anchors,
        unmatched: Unmatched,
        sizes: Sizes,
    ) -> Self {
        let mut parts: Vec<PlacedComponent> = target
            .components()
            .members()
            .into_iter()
            .enumerate()
            .map(|(c, vertices)| {
                let anchored = anchors.hold(c);
                let triangles = Vec::new();
                PlacedComponent { vertices, triangles, size: 1.0, gain: 1.0, anchored, beside: None }
            })
            .collect();
        for (t, corners) in (0u32..).zip(target.triangles()) {
            if let Some(part) = target.components().of_vertex(corners[0] as usize) {
                parts[part].triangles.push(t);
            }
        }
        for part in &mut parts {
            part.size = sizes.size(part.size_ratio(source, target, chooser));
            part.gain = sizes.gain(part.size);
        }
        let mut placer = Self { parts, rows: matrix.rows() };
        placer.find_neighbours(target, chooser, unmatched);
        placer
    }

    /// Size of a component over that of its matches, in unit coordinates.
    pub fn size(&self, component: usize) -> f64 {
        self.parts[component].size
    }

    /// Components without a match, by number.
    pub fn unmatched(&self) -> impl Iterator<Item = usize> {
        self.parts.iter().enumerate().filter(|(_, part)| part.beside.is_some()).map(|(c, _)| c)
    }

    fn find_neighbours(&mut self, target: &Mesh, chooser: &Chooser, unmatched: Unmatched) {
        let has_match = |part: &PlacedComponent| {
            part.anchored || part.triangles.iter().any(|&t| chooser.has_target(t as usize))
        };
        let corners = |t: &u32| target.triangles()[*t as usize];
        let matched: Vec<[u32; 3]> = self
            .parts
            .iter()
            .filter(|p| has_match(p))
            .flat_map(|p| p.triangles.iter().map(corners))
            .collect();
        let surface = Surface::new(matched.iter().map(|t| t.map(|v| target.rest()[v as usize])).collect());
        for part in self.parts.iter_mut().filter(|part| !has_match(part)) {
            let mut beside = Vec::new();
            if unmatched == Unmatched::Follow {
                let nearest = |&v: &u32| surface.closest_point(target.rest()[v as usize]);
                beside =
                    part.vertices.iter().filter_map(nearest).flat_map(|hit| matched[hit.triangle]).collect();
                beside.sort_unstable();
                beside.dedup();
            }
            part.beside = Some(beside);
        }
    }

    /// Fixes the translations of `displacements`, which stitching has found up to one per component.
    pub fn place(
        &self,
        target: &Mesh,
        chooser: &Chooser,
        key: &SourceKey,
        moves: &[bool],
        displacements: &mut [Vec3],
    ) {
        let mut at_rest = vec![false; displacements.len()];
        let found = self.parts.iter().filter(|part| part.beside.is_none());
        found.flat_map(|part| &part.vertices).for_each(|&v| at_rest[v as usize] = true);
        for (corners, _) in target.triangles().iter().zip(moves).filter(|(_, moves)| **moves) {
            corners.iter().for_each(|&v| at_rest[v as usize] = false);
        }
        let mut all_stationary = Vec::new();
        for part in self.parts.iter().filter(|part| part.beside.is_none()) {
            let stationary: Vec<u32> =
                part.vertices.iter().copied().filter(|&v| at_rest[v as usize]).collect();
            let shift = if part.anchored {
                Vec3::ZERO
            } else if stationary.is_empty() {
                part.centroid_shift(target, chooser, key, displacements)
            } else {
                stationary.iter().map(|&v| -displacements[v as usize]).sum::<Vec3>() / stationary.len() as f64
            };
            for &v in &part.vertices {
                displacements[v as usize] += shift;
            }
            all_stationary.extend(stationary);
        }
        self.settle(&all_stationary, &at_rest, displacements);
        for part in &self.parts {
            if let Some(beside) = &part.beside {
                part.follow(target, beside, displacements);
            }
        }
    }

    /// Puts the vertices at rest exactly there and smooths what that does to their surroundings: a correction
    /// `z` that fades out over a few rings, and there comes near `L z = 0` by sweeps from ring to ring. They
    /// take steps out first, and steps are all that must not show.
    fn settle(&self, stationary: &[u32], at_rest: &[bool], displacements: &mut [Vec3]) {
        let band = self.band(stationary, at_rest);
        let mut z = vec![Vec3::ZERO; displacements.len()];
        for &v in stationary {
            z[v as usize] = -displacements[v as usize];
        }
        let mut known = at_rest.to_vec();
        for (ring, rim) in (1..).zip(&band) {
            let left = f64::from(RINGS + 1 - ring) / f64::from(RINGS + 2 - ring);
            for &v in rim {
                let before = self.row(v).iter().filter(|(w, _)| known[*w as usize]);
                let (sum, count) =
                    before.fold((Vec3::ZERO, 0.0), |(sum, n), &(w, _)| (sum + z[w as usize], n + 1.0));
                z[v as usize] = sum * (left / count);
            }
            rim.iter().for_each(|&v| known[v as usize] = true);
        }
        for _ in 0..SWEEPS {
            band.iter().chain(band.iter().rev()).for_each(|rim| self.sweep(rim, &mut z));
        }
        for &v in band.iter().flatten() {
            displacements[v as usize] += z[v as usize];
        }
        for &v in stationary {
            displacements[v as usize] = Vec3::ZERO;
        }
    }

    /// Solves `(L z)_v = 0` for `z_v` of each vertex of a ring, all from what is around them before: in turn
    /// they would depend on their order, and left and right come out different.
    fn sweep(&self, rim: &[u32], z: &mut [Vec3]) {
        let solve = |&v: &u32| {
            let (mut sum, mut own) = (Vec3::ZERO, 0.0);
            for &(w, l) in self.row(v) {
                if w == v {
                    own = l;
                } else {
                    sum += z[w as usize] * l;
                }
            }
            if own > 0.0 { -sum / own } else { z[v as usize] }
        };
        let solved: Vec<Vec3> = rim.iter().map(solve).collect();
        rim.iter().zip(solved).for_each(|(&v, solved)| z[v as usize] = solved);
    }

    /// The vertices within [`RINGS`] of those at rest, ring by ring.
    fn band(&self, stationary: &[u32], at_rest: &[bool]) -> Vec<Vec<u32>> {
        if stationary.is_empty() {
            return Vec::new();
        }
        let beside =
            |v: &u32| !at_rest[*v as usize] && self.row(*v).iter().any(|(w, _)| at_rest[*w as usize]);
        let mut band: Vec<Vec<u32>> = vec![(0..at_rest.len() as u32).filter(beside).collect()];
        let mut seen = at_rest.to_vec();
        band[0].iter().for_each(|&v| seen[v as usize] = true);
        for ring in 1..RINGS as usize {
            let mut next = Vec::new();
            for &v in &band[ring - 1] {
                for &(w, _) in self.row(v) {
                    if !std::mem::replace(&mut seen[w as usize], true) {
                        next.push(w);
                    }
                }
            }
            band.push(next);
        }
        band
    }

    fn row(&self, v: u32) -> &[(u32, f64)] {
        self.rows.of(v as usize)
    }
}

impl PlacedComponent {
    /// Root mean square size of the matched triangles' centroids on the target over that of their
    /// matches; 1 where they are in one place.
    fn size_ratio(&self, source: &Mesh, target: &Mesh, chooser: &Chooser) -> f64 {
        let centroid = |mesh: &Mesh, t: u32| {
            mesh.triangles()[t as usize].iter().map(|&v| mesh.rest()[v as usize]).sum::<Vec3>() / 3.0
        };
        let matched =
            || self.triangles.iter().flat_map(|&t| chooser.matches(t as usize).iter().map(move |&s| (s, t)));
        rigid::size_ratio(
            matched().map(|(_, t)| centroid(target, t)),
            matched().map(|(s, _)| centroid(source, s)),
        )
    }

    /// The shift that brings the mean displacement of the matched triangles to that of their matches.
    fn centroid_shift(&self, target: &Mesh, chooser: &Chooser, key: &SourceKey, d: &[Vec3]) -> Vec3 {
        let (mut sum, mut area) = (Vec3::ZERO, 0.0);
        for &t in &self.triangles {
            let matches = chooser.matches(t as usize);
            if matches.is_empty() {
                continue;
            }
            let wanted = matches.iter().map(|&s| key.shift(s)).sum::<Vec3>() / matches.len() as f64;
            let found = target.triangles()[t as usize].iter().map(|&v| d[v as usize]).sum::<Vec3>() / 3.0;
            let weight = target.areas()[t as usize].max(f64::MIN_POSITIVE);
            sum += (wanted * self.gain - found) * weight;
            area += weight;
        }
        sum / area
    }

    /// Moves the component rigidly with the vertices `beside` it.
    fn follow(&self, target: &Mesh, beside: &[u32], displacements: &mut [Vec3]) {
        let moves = beside.iter().any(|&v| displacements[v as usize] != Vec3::ZERO);
        let from: Vec<Vec3> = beside.iter().map(|&v| target.rest()[v as usize]).collect();
        let to: Vec<Vec3> = beside.iter().zip(&from).map(|(&v, &p)| p + displacements[v as usize]).collect();
        let carry = Alignment::of(from.into_iter().zip(to)).rigid();
        for &v in &self.vertices {
            let rest = target.rest()[v as usize];
            displacements[v as usize] = if moves { carry.apply(rest) - rest } else { Vec3::ZERO };
        }
    }
}
