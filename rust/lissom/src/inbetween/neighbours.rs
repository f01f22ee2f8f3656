//! The dual graph: which triangles turn beside which, and by how much they differ.

use super::rotations::TriangleMotion;
use crate::geometry::groups::Groups;
use crate::geometry::rows::Rows;
use crate::matrix::norm_squared;
use crate::{Mat3, Mesh};

/// `|R - R'|_F^2` of 60 degrees: neighbours that turn apart by less are of one region. Between 45 and
/// 90 degrees there is little to choose on the poses of a cat with crumpled joints.
pub(super) const GENTLE: f64 = 2.0;

/// `|R - R'|_F^2` of a right angle; neighbours that turn apart by more fold over each other.
const RIGHT_ANGLE: f64 = 4.0;

/// Dual edges to a triangle without a rotation come after all others: `|R - R'|_F^2` is at most 8.
const LAST: f64 = 9.0;

/// Weights, and squared angles, that differ by less are equal but for rounding.
pub(super) const TIE: f64 = 1e-9;

/// `|a - b|_F^2 = 8 sin^2(angle / 2)` between rotations: grows with the angle between them.
pub(super) fn distance(a: Mat3, b: Mat3) -> f64 {
    norm_squared(a - b)
}

/// How late the walk takes a step between triangles of these rotations.
fn weight(rotations: [Option<Mat3>; 2]) -> f64 {
    match rotations {
        [Some(r), Some(s)] => distance(r, s),
        _ => LAST,
    }
}

/// The dual graph: of each triangle, those across its edges, each with its weight as the bits of a number that is
/// not negative (they sort alike).
pub(super) struct Neighbours(Rows<(u64, u32)>);

impl Neighbours {
    pub fn of(mesh: &Mesh, motions: &[TriangleMotion]) -> Self {
        Self::joining(&mesh.adjacency().triangle_pairs().collect::<Vec<_>>(), motions)
    }

    pub fn joining(pairs: &[[u32; 2]], motions: &[TriangleMotion]) -> Self {
        let joined = pairs.iter().flat_map(|&[a, b]| {
            let weight = weight([a, b].map(|t| motions[t as usize].rotation()));
            [(a, (weight.to_bits(), b)), (b, (weight.to_bits(), a))]
        });
        Self(Rows::sort(motions.len(), joined.collect::<Vec<_>>().into_iter()))
    }

    /// Triangles that fold over more than half of their neighbours, or turn over in a flat sheet.
    pub fn inverted(&self, motions: &[TriangleMotion]) -> impl Iterator<Item = usize> {
        let folds = |weight: f64| weight > RIGHT_ANGLE && weight < LAST;
        (0..motions.len()).filter(move |&t| {
            let beside = self.of_triangle(t as u32);
            let folded = beside.iter().filter(|(weight, _)| folds(f64::from_bits(*weight))).count();
            motions[t] == TriangleMotion::Inverted || 2 * folded > beside.len()
        })
    }

    /// Of links that lead to triangles from their hosts, `[triangle, host]`, those of the least angle to each group of
    /// triangles joined by edges, in order, each as `[host, triangle]`. One alone leads over a crease: several might
    /// choose different ways round.
    pub fn gentlest(&self, motions: &[TriangleMotion], links: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
        let groups = self.groups(|_, _, _| true);
        let mut places = vec![usize::MAX; groups.count()];
        let mut least: Vec<(f64, Vec<[u32; 2]>)> = Vec::new();
        for &[triangle, host] in links {
            let weight = weight([triangle, host].map(|t| motions[t as usize].rotation()));
            let place = &mut places[groups.of()[triangle as usize] as usize];
            if *place == usize::MAX {
                *place = least.len();
                least.push((f64::INFINITY, Vec::new()));
            }
            let (lightest, chosen) = &mut least[*place];
            if weight < *lightest - TIE {
                (*lightest, *chosen) = (weight, vec![[host, triangle]]);
            } else if weight <= *lightest + TIE && weight < GENTLE {
                chosen.push([host, triangle]);
            }
        }
        least.into_iter().map(|(_, chosen)| chosen).collect()
    }

    /// For each triangle, how many are joined to it by gentle steps.
    pub fn region_sizes(&self) -> Vec<u32> {
        let mut sizes = vec![0; self.0.count()];
        for region in self.patches(|_, _, weight| weight < GENTLE).iter() {
            for &t in region {
                sizes[t as usize] = region.len() as u32;
            }
        }
        sizes
    }

    /// Triangles in groups that `joined(triangle, neighbour, weight)` holds together.
    pub fn patches(&self, joined: impl Fn(usize, usize, f64) -> bool) -> Rows<u32> {
        self.groups(joined).members()
    }

    fn groups(&self, joined: impl Fn(usize, usize, f64) -> bool) -> Groups {
        let pairs = self.0.iter().enumerate().flat_map(|(t, beside)| {
            let joined = &joined;
            let held = beside.iter().filter(move |&&(w, s)| joined(t, s as usize, f64::from_bits(w)));
            held.map(move |&(_, s)| [t as u32, s])
        });
        Groups::joining(self.0.count(), pairs)
    }

    pub fn of_triangle(&self, t: u32) -> &[(u64, u32)] {
        self.0.of(t as usize)
    }
}
