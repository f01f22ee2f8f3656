//! Choose: a target matrix for every target triangle, from the matched source triangles.
//!
//! The target of triangle `t` is the mean of the gradients of its matches, `C_t = mean_s Q_s`. Triangles
//! without a match take the harmonic extension of the targets around them: over the dual graph of
//! the patch, `C_t` is the mean of its neighbours. A patch whose surroundings do not change does not
//! change.

use rayon::prelude::*;

use crate::linear::{Columns, Factor, Symbolic, SymmetricMatrix};
use crate::operators::gradient::{outer, triangle_gradient};
use crate::{Mat3, Mesh, Result, Vec3};

/// Movement below this fraction of the diagonal is the noise of single precision, not a pose.
const STILL: f64 = 1e-7;

/// Holds a patch that nothing surrounds; far below any coupling.
const GROUND: f64 = 1e-9;

/// What one key does to the source.
pub struct SourceKey {
    /// `Q_s - I` of each triangle; exactly zero where it does not move.
    pub change: Vec<Mat3>,
    /// Displacement of each triangle's centroid, in unit coordinates; exactly zero likewise.
    pub shift: Vec<Vec3>,
    /// Whether each triangle moves.
    pub moves: Vec<bool>,
}

impl SourceKey {
    /// Reads a key off `posed`, (n) positions in the source's own units.
    pub fn of(source: &Mesh, posed: &[Vec3]) -> Self {
        let tolerance = STILL * source.frame().scale;
        let vertices = source.vertices();
        let displacement: Vec<Vec3> = posed
            .iter()
            .zip(vertices)
            .map(|(&p, &v)| {
                let d = p - v;
                if d.abs().max_element() > tolerance { d / source.frame().scale } else { Vec3::ZERO }
            })
            .collect();
        let rest = source.rest();
        let per_triangle = source.triangles().par_iter().map(|t| {
            let d = t.map(|v| displacement[v as usize]);
            if d.iter().all(|&d| d == Vec3::ZERO) {
                return (Mat3::ZERO, (Vec3::ZERO, false));
            }
            let rest = t.map(|v| rest[v as usize]);
            let posed = [rest[0] + d[0], rest[1] + d[1], rest[2] + d[2]];
            (similar_gradient(rest, posed) - Mat3::IDENTITY, ((d[0] + d[1] + d[2]) / 3.0, true))
        });
        let (change, (shift, moves)) = per_triangle.unzip();
        Self { change, shift, moves }
    }
}

/// The deformation gradient whose normal is stretched by the square root of the area, as the fourth
/// vertex of Sumner & Popović (2004) has it: a uniform scale is then a multiple of the identity, and
/// stays one on a triangle that lies in another plane.
fn similar_gradient(rest: [Vec3; 3], posed: [Vec3; 3]) -> Mat3 {
    let q = triangle_gradient(rest, posed);
    let cross = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
    let (before, after) = (cross(rest).length(), cross(posed).length());
    let stretch = (after / before).sqrt();
    match cross(rest).try_normalize() {
        Some(normal) if stretch.is_finite() => q + outer(q * normal * (stretch - 1.0), normal),
        _ => q,
    }
}

/// The matches of every target triangle, and the patches that have none.
pub struct Chooser {
    start: Vec<u32>,
    matches: Vec<u32>,
    patches: Option<Patches>,
}

/// Target triangles without a match.
struct Patches {
    triangles: Vec<u32>,
    /// Neighbours of a patch: place of the patch triangle, matched target triangle.
    border: Vec<(u32, u32)>,
    /// The patch of each of them, and how many patches there are.
    patch: Vec<u32>,
    count: usize,
    factor: Factor,
}

impl Chooser {
    /// Sorts `pairs` (source triangle, target triangle) by target triangle.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where the patches without a match cannot be factored.
    pub fn new(target: &Mesh, pairs: &[[u32; 2]]) -> Result<Self> {
        let m = target.triangles().len();
        let mut sorted: Vec<[u32; 2]> = pairs.iter().map(|&[s, t]| [t, s]).collect();
        sorted.sort_unstable();
        sorted.dedup();
        let mut start = vec![0u32; m + 1];
        for &[t, _] in &sorted {
            start[t as usize + 1] += 1;
        }
        for t in 0..m {
            start[t + 1] += start[t];
        }
        let matches = sorted.into_iter().map(|[_, s]| s).collect();
        let mut chooser = Self { start, matches, patches: None };
        chooser.patches = chooser.unmatched(target)?;
        Ok(chooser)
    }

    /// The source triangles matched with a target triangle.
    pub fn matches(&self, triangle: usize) -> &[u32] {
        &self.matches[self.start[triangle] as usize..self.start[triangle + 1] as usize]
    }

    fn unmatched(&self, target: &Mesh) -> Result<Option<Patches>> {
        let is_unmatched = |t: &u32| self.matches(*t as usize).is_empty();
        let triangles: Vec<u32> = (0..target.triangles().len() as u32).filter(is_unmatched).collect();
        if triangles.is_empty() {
            return Ok(None);
        }
        let place = |t: u32| triangles.binary_search(&t).ok().map(|p| p as u32);
        let (mut border, mut inner) = (Vec::new(), Vec::new());
        for [a, b] in target.adjacency().triangle_pairs() {
            match (place(a), place(b)) {
                (Some(a), Some(b)) => inner.push((a, b)),
                (Some(a), None) => border.push((a, b)),
                (None, Some(b)) => border.push((b, a)),
                (None, None) => {}
            }
        }
        let edges = inner.iter().map(|&(a, b)| (a, b, 1.0));
        let mut matrix = SymmetricMatrix::laplacian(triangles.len(), edges);
        for row in 0..triangles.len() {
            matrix.add_to_diagonal(row, GROUND);
        }
        for &(a, _) in &border {
            matrix.add_to_diagonal(a as usize, 1.0);
        }
        let factor = Symbolic::analyse(&matrix)?.factor(&matrix)?;
        let (patch, count) = groups(triangles.len(), &inner);
        Ok(Some(Patches { triangles, border, patch, count, factor }))
    }

    /// `C_t - I` of every target triangle.
    pub fn changes(&self, key: &SourceKey) -> Vec<Mat3> {
        let m = self.start.len() - 1;
        let mut changes: Vec<Mat3> = (0..m)
            .into_par_iter()
            .map(|t| {
                let matches = self.matches(t);
                let sum: Mat3 = matches.iter().map(|&s| key.change[s as usize]).sum();
                sum * (1.0 / matches.len().max(1) as f64)
            })
            .collect();
        if let Some(patches) = &self.patches {
            patches.extend(&mut changes);
        }
        changes
    }

    /// Whether every target triangle moves: one of its matches does, or, in a patch without matches,
    /// anything around the patch.
    pub fn moves(&self, key: &SourceKey) -> Vec<bool> {
        let mut moves: Vec<bool> = (0..self.start.len() - 1)
            .map(|t| self.matches(t).iter().any(|&s| key.moves[s as usize]))
            .collect();
        if let Some(patches) = &self.patches {
            patches.spread(&mut moves);
        }
        moves
    }
}

impl Patches {
    fn extend(&self, changes: &mut [Mat3]) {
        let mut columns = Columns::zeros(self.triangles.len(), 9);
        for &(place, neighbour) in &self.border {
            for (c, value) in changes[neighbour as usize].to_cols_array().into_iter().enumerate() {
                columns.column_mut(c)[place as usize] += value;
            }
        }
        self.factor.solve(&mut columns);
        for (place, &t) in self.triangles.iter().enumerate() {
            changes[t as usize] = Mat3::from_cols_array(&std::array::from_fn(|c| columns.column(c)[place]));
        }
    }

    fn spread(&self, moves: &mut [bool]) {
        let mut reached = vec![false; self.count];
        for &(place, neighbour) in &self.border {
            reached[self.patch[place as usize] as usize] |= moves[neighbour as usize];
        }
        for (&t, &patch) in self.triangles.iter().zip(&self.patch) {
            moves[t as usize] = reached[patch as usize];
        }
    }
}

/// Numbers the groups that `pairs` of `0..count` hang together in: each one's group, and how many.
fn groups(count: usize, pairs: &[(u32, u32)]) -> (Vec<u32>, usize) {
    let mut neighbours = vec![Vec::new(); count];
    for &(a, b) in pairs {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let mut group = vec![u32::MAX; count];
    let mut groups = 0;
    for first in 0..count {
        if group[first] != u32::MAX {
            continue;
        }
        let mut open = vec![first];
        while let Some(at) = open.pop() {
            if group[at] == u32::MAX {
                group[at] = groups;
                open.extend(neighbours[at].iter().map(|&next| next as usize));
            }
        }
        groups += 1;
    }
    (group, groups as usize)
}
