//! Whether the mesh between handles makes the turns that these were told to make.
//!
//! Where handles end says nothing of whole turns, and a mesh that is twisted too much loses some of them through its own neck.
//! What it does make is summed up along ways over it,
//!
//! ```text
//!     turn = a . sum_k log( R_k+1 R_k^T )
//! ```
//!
//! with the rotation nearest to the edges at each vertex of a way, and `a` the axis of the turn that was asked for.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::goal::HandleMotion;
use super::region::Region;
use crate::matrix::outer;
use crate::rotation::{exp, log, nearest_rotation};
use crate::{Mat3, Vec3};

/// Ways between the same two, of which the median counts: one alone may lead through a crease.
const WAYS: usize = 7;

/// Ways over the surface from what is given to what is given otherwise, by the two.
#[derive(Debug)]
pub(super) struct Ways(BTreeMap<[Given; 2], Vec<Vec<u32>>>);

/// A handle, or what stays at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Given {
    Handle(usize),
    Rest,
}

impl Ways {
    /// The shortest ones, by the number of edges, spread over where they meet.
    pub fn of(region: &Region) -> Self {
        let mesh = region.mesh();
        let n = mesh.rest().len();
        let given = |v: usize| match region.handle_of(v) {
            Some(handle) => Some(Given::Handle(handle)),
            None => region.constraints().slot(v as u32).is_none().then_some(Given::Rest),
        };
        let mut nearest: Vec<Option<Given>> = (0..n).map(given).collect();
        let mut before: Vec<u32> = (0..n as u32).collect();
        let mut reached: Vec<u32> = (0..n as u32).filter(|&v| nearest[v as usize].is_some()).collect();
        let neighbours = |v: u32| {
            let corners = mesh.adjacency().corners_of(v as usize).iter();
            corners.flat_map(|corner| mesh.triangles()[corner.triangle as usize])
        };
        let mut next = 0;
        while let Some(&v) = reached.get(next) {
            next += 1;
            for w in neighbours(v) {
                if nearest[w as usize].is_none() {
                    (nearest[w as usize], before[w as usize]) = (nearest[v as usize], v);
                    reached.push(w);
                }
            }
        }
        let mut meeting: BTreeMap<[Given; 2], Vec<[u32; 2]>> = BTreeMap::new();
        for &[v, w] in mesh.adjacency().edges() {
            if let (Some(a), Some(b)) = (nearest[v as usize], nearest[w as usize])
                && a != b
            {
                let (between, edge) = if a < b { ([a, b], [v, w]) } else { ([b, a], [w, v]) };
                meeting.entry(between).or_default().push(edge);
            }
        }
        let back = |v: u32| {
            let step = |&v: &u32| Some(before[v as usize]).filter(|&w| w != v);
            std::iter::successors(Some(v), step)
        };
        let way = |&[v, w]: &[u32; 2]| -> Vec<u32> {
            let mut way: Vec<u32> = back(v).collect();
            way.reverse();
            way.extend(back(w));
            way
        };
        let spread = |edges: Vec<[u32; 2]>| {
            let count = edges.len().min(WAYS);
            (0..count).map(|k| way(&edges[(2 * k + 1) * edges.len() / (2 * count)])).collect()
        };
        Self(meeting.into_iter().map(|(between, edges)| (between, spread(edges))).collect())
    }

    /// What is said where the mesh turns by whole turns less, or more, than handles do. Those from `count` on are images.
    pub fn warnings(
        &self,
        region: &Region,
        handles: &[HandleMotion],
        displacements: &[Vec3],
        count: usize,
    ) -> Vec<String> {
        let turn = |given: Given| match given {
            Given::Handle(h) => handles[h].rotation + handles[h].whole_turns,
            Given::Rest => Vec3::ZERO,
        };
        let end = |given: Given| match given {
            Given::Handle(h) => exp(handles[h].rotation) * exp(handles[h].whole_turns),
            Given::Rest => Mat3::IDENTITY,
        };
        let mut warnings = Vec::new();
        for (&[a, b], ways) in &self.0 {
            let asked = turn(b) - turn(a);
            let (Given::Handle(first), true) = (a, asked.length() > PI) else { continue };
            if first >= count {
                continue;
            }
            let axis = asked.normalize();
            let made = |way: &Vec<u32>| {
                let along = way.iter().map(|&v| fitted(region, displacements, v as usize));
                let (mut sum, mut last) = (0.0, end(a));
                for next in along.chain([end(b)]) {
                    sum += log(next * last.transpose()).dot(axis);
                    last = next;
                }
                sum
            };
            let mut made: Vec<f64> = ways.iter().map(made).collect();
            made.sort_unstable_by(f64::total_cmp);
            let made = made[made.len() / 2];
            // The ends are where they were asked to be: what is lost are whole turns.
            let lost = ((asked.length() - made) / TAU).round();
            if lost != 0.0 {
                let made = (asked.length() - TAU * lost).to_degrees();
                let asked = asked.length().to_degrees();
                warnings.push(match b {
                    Given::Handle(second) => format!(
                        "handles {first} and {second} turn by {asked:.0} degrees against each other, the mesh between them \
                         by {made:.0}: it has unwound; turn less, let handles between them share the turn, or choose another \
                         method"
                    ),
                    Given::Rest => format!(
                        "handle {first} turns by {asked:.0} degrees, the mesh around it by {made:.0}: it has unwound; turn \
                         less, let handles around it share the turn, or choose another method"
                    ),
                });
            }
        }
        warnings
    }
}

/// Whether two of them may turn so far against each other that [`Ways`] tell more than ends do.
pub(super) fn turn_far(handles: &[HandleMotion]) -> bool {
    handles.iter().any(|m| (m.rotation + m.whole_turns).length() > FRAC_PI_2)
}

/// The rotation nearest to how the edges at a vertex move.
fn fitted(region: &Region, displacements: &[Vec3], vertex: usize) -> Mat3 {
    let (mesh, rest) = (region.mesh(), region.mesh().rest());
    let mut sum = Mat3::ZERO;
    for corner in mesh.adjacency().corners_of(vertex) {
        for w in mesh.triangles()[corner.triangle as usize] {
            let w = w as usize;
            let edge = rest[w] - rest[vertex];
            sum += outer(edge + displacements[w] - displacements[vertex], edge);
        }
    }
    nearest_rotation(sum)
}
