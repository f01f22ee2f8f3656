//! Rotation consistency: which of its logarithms each triangle follows.
//!
//! `log R` is known up to whole turns. Walk from triangle to triangle across shared edges and take
//! the branch nearest to the one that the walk comes from (Baxter, Barla & Anjyo 2008, Rigid shape
//! interpolation using normal equations). Where all neighbours differ by less than half a turn, as
//! flat meshes do, any order gives the same; elsewhere the order decides, because a wrong branch is
//! handed on. So the walk follows the minimum spanning tree of the dual graph, weighted by the angle
//! between neighbours: the doubtful steps come last and lead to few.
//!
//! Even so the walk must cross creases and crumples, where neighbours differ so much that their
//! branches are a matter of chance, and a few wrong ones in a row make a turn out of nothing. Triangles
//! joined by gentle steps make a *region*. Within one the branch is handed from neighbour to
//! neighbour; regions of a few triangles, the crumples, hand on only what they were handed.
//!
//! Last, what lies beyond half a turn must pay: a patch of such triangles whose border agrees better
//! with its shortest turns takes those.
//!
//! Near a whole turn the axis of `log R` is noise. Beyond half a turn a triangle therefore turns about
//! the axis that it inherits, by its *twist* about that axis with whole turns counted, and what is
//! left of its rotation, the *swing*, is a second factor:
//!
//! ```text
//!     R(t) = exp(t angle axis) exp(t swing)
//! ```
//!
//! Reversed in time this is of the same form, about the same axis.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::rotations::Motion;
use crate::geometry::groups::Groups;
use crate::geometry::matrix::norm_squared;
use crate::geometry::rows::Rows;
use crate::{Job, Mat3, Mesh, Result, Vec3, rotation};

/// `|R - R'|_F^2` of 60 degrees: neighbours that turn apart by less are of one region. Between 45 and
/// 90 degrees there is little to choose on the poses of a cat with crumpled joints.
const GENTLE: f64 = 2.0;

/// Regions of fewer triangles are not trusted with a turn of their own; 16 and 64 do alike.
const REGION: u32 = 16;

/// `|R - R'|_F^2` of a right angle; neighbours that turn apart by more fold over each other.
const RIGHT_ANGLE: f64 = 4.0;

/// Dual edges to a triangle without a rotation come after all others: `|R - R'|_F^2` is at most 8.
const LAST: f64 = 9.0;

/// A turn that knows its way: `exp(t angle axis) exp(t swing)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn {
    axis: Vec3,
    angle: f64,
    swing: Vec3,
}

impl Turn {
    pub const NONE: Self = Self { axis: Vec3::ZERO, angle: 0.0, swing: Vec3::ZERO };

    /// About one axis, by a rotation vector.
    pub fn about(omega: Vec3) -> Self {
        let angle = omega.length();
        let axis = if angle > 0.0 { omega / angle } else { Vec3::ZERO };
        Self { axis, angle, swing: Vec3::ZERO }
    }

    /// Rotation vector, as far as the two factors have one.
    pub fn omega(&self) -> Vec3 {
        self.axis * self.angle + self.swing
    }

    /// The rotation at time `t`.
    pub fn at(&self, t: f64) -> Mat3 {
        let main = rotation::exp(self.axis * (t * self.angle));
        if self.swing == Vec3::ZERO { main } else { main * rotation::exp(self.swing * t) }
    }

    /// The way to `r` nearest to this one.
    fn lift(&self, r: Mat3) -> Self {
        let q = glam::DQuat::from_mat3(&r);
        let twist = 2.0 * Vec3::new(q.x, q.y, q.z).dot(self.axis).atan2(q.w);
        let angle = twist + TAU * ((self.angle - twist) / TAU).round();
        if angle.abs() > PI {
            let swing = rotation::log(rotation::exp(-self.axis * angle) * r);
            return Self { axis: self.axis, angle, swing };
        }
        Self::about(rotation::nearest_branch(rotation::log(r), self.omega()))
    }
}

/// Each triangle by the least angle, whatever its neighbours do.
pub(super) fn shortest(motions: &[Motion]) -> Vec<Turn> {
    let turn = |m: &Motion| m.rotation().map_or(Turn::NONE, |r| Turn::about(rotation::log(r)));
    motions.par_iter().map(turn).collect()
}

/// Each triangle by the branch nearest to its neighbour's, along the minimum spanning tree (Prim).
///
/// `moved` counts the vertices of each triangle that move. Triangles at rest are the roots. A
/// component without any starts from the triangle that turns least: of those held by most vertices,
/// since a whole turn looks like none, and of those outside crumples. Triangles without a rotation
/// take their neighbour's. With the turns come the steps of the walk, in order.
pub(super) fn consistent(
    neighbours: &Neighbours,
    motions: &[Motion],
    moved: &[u8],
    job: &Job,
) -> Result<(Vec<Turn>, Vec<Step>)> {
    let mut walk = Walk {
        neighbours,
        motions,
        sizes: neighbours.region_sizes(),
        turns: vec![None; motions.len()],
        handed_on: vec![Turn::NONE; motions.len()],
        steps: Vec::with_capacity(motions.len()),
    };
    let mut queue = BinaryHeap::new();
    let at_rest = (0..motions.len() as u32).filter(|&t| moved[t as usize] == 0);
    queue.extend(at_rest.map(|t| Reverse((0u64, t, t))));
    walk.run(&mut queue, job)?;

    let mut roots: Vec<(bool, u8, bool, u64, u32)> = (0u32..)
        .zip(motions)
        .filter(|(t, _)| walk.turns[*t as usize].is_none())
        .map(|(t, m)| {
            let least = m.rotation().map(|r| distance(r, Mat3::IDENTITY).to_bits());
            let crumple = walk.sizes[t as usize] < REGION;
            (least.is_none(), moved[t as usize], crumple, least.unwrap_or_default(), t)
        })
        .collect();
    roots.par_sort_unstable();
    for (.., root) in roots {
        if walk.turns[root as usize].is_none() {
            queue.push(Reverse((0, root, root)));
            walk.run(&mut queue, job)?;
        }
    }
    let mut turns: Vec<Turn> = walk.turns.into_iter().map(|turn| turn.unwrap_or(Turn::NONE)).collect();
    drop_unpaid(neighbours, motions, &mut turns);
    Ok((turns, walk.steps))
}

/// A walk in progress.
struct Walk<'a> {
    neighbours: &'a Neighbours,
    motions: &'a [Motion],
    /// Number of triangles in the region of each triangle.
    sizes: Vec<u32>,
    turns: Vec<Option<Turn>>,
    /// The turn that each triangle gives to those beyond a crease.
    handed_on: Vec<Turn>,
    steps: Vec<Step>,
}

/// A step of the walk, to a triangle from one visited before; a root from itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub triangle: u32,
    pub from: u32,
}

/// Triangles to visit: weight of the step, triangle, the triangle it is reached from; a root from itself.
type Queue = BinaryHeap<Reverse<(u64, u32, u32)>>;

impl Walk<'_> {
    /// Empties the queue.
    fn run(&mut self, queue: &mut Queue, job: &Job) -> Result<()> {
        while let Some(Reverse((weight, triangle, from))) = queue.pop() {
            let (t, from) = (triangle as usize, from as usize);
            if self.turns[t].is_some() {
                continue;
            }
            let near = match self.turns[from] {
                Some(turn) if f64::from_bits(weight) < GENTLE => turn,
                _ => self.handed_on[from],
            };
            let turn = self.motions[t].rotation().map_or(near, |r| near.lift(r));
            self.turns[t] = Some(turn);
            let trusted = t == from || self.sizes[t] >= REGION;
            self.handed_on[t] = if trusted { turn } else { self.handed_on[from] };
            let next = self.neighbours.of_triangle(triangle).iter();
            let unseen = next.filter(|(_, s)| self.turns[*s as usize].is_none());
            queue.extend(unseen.map(|&(weight, s)| Reverse((weight, s, triangle))));
            self.steps.push(Step { triangle, from: from as u32 });
            if self.steps.len().is_multiple_of(4096) {
                job.check()?;
            }
        }
        Ok(())
    }
}

/// Gives shortest turns to patches beyond half a turn whose borders agree better with those.
fn drop_unpaid(neighbours: &Neighbours, motions: &[Motion], turns: &mut [Turn]) {
    let beyond: Vec<bool> = turns.iter().map(|turn| turn.angle.abs() > PI).collect();
    let within = |a: usize, b: usize| beyond[a] && beyond[b];
    for patch in neighbours.patches(|t, s, _| within(t, s)).iter() {
        if !beyond[patch[0] as usize] {
            continue;
        }
        let shortest: Vec<Turn> = patch
            .iter()
            .map(|&t| {
                let own = motions[t as usize].rotation().map(rotation::log);
                own.map_or(turns[t as usize], Turn::about)
            })
            .collect();
        let (mut kept, mut dropped) = (0.0, 0.0);
        for (&t, short) in patch.iter().zip(&shortest) {
            let outside = neighbours.of_triangle(t).iter().map(|(_, s)| *s as usize).filter(|&s| !beyond[s]);
            for s in outside {
                kept += turns[t as usize].omega().distance(turns[s].omega());
                dropped += short.omega().distance(turns[s].omega());
            }
        }
        if dropped < kept {
            for (&t, short) in patch.iter().zip(shortest) {
                turns[t as usize] = short;
            }
        }
    }
}

/// `|a - b|_F^2 = 8 sin^2(angle / 2)` between rotations: grows with the angle between them.
fn distance(a: Mat3, b: Mat3) -> f64 {
    norm_squared(a - b)
}

/// The dual graph: of each triangle, those across its edges, each with its weight as the bits of a number that is
/// not negative (they sort alike).
pub(super) struct Neighbours(Rows<(u64, u32)>);

impl Neighbours {
    pub fn of(mesh: &Mesh, motions: &[Motion]) -> Self {
        Self::joining(&mesh.adjacency().triangle_pairs().collect::<Vec<_>>(), motions)
    }

    fn joining(pairs: &[[u32; 2]], motions: &[Motion]) -> Self {
        let joined = pairs.iter().flat_map(|&[a, b]| {
            let weight = match [a, b].map(|t| motions[t as usize].rotation()) {
                [Some(r), Some(s)] => distance(r, s),
                _ => LAST,
            };
            [(a, (weight.to_bits(), b)), (b, (weight.to_bits(), a))]
        });
        Self(Rows::sort(motions.len(), joined.collect::<Vec<_>>().into_iter()))
    }

    /// Triangles that fold over more than half of their neighbours, or turn over in a flat sheet.
    pub fn inverted(&self, motions: &[Motion]) -> impl Iterator<Item = usize> {
        let folds = |weight: f64| weight > RIGHT_ANGLE && weight < LAST;
        (0..motions.len()).filter(move |&t| {
            let beside = self.of_triangle(t as u32);
            let folded = beside.iter().filter(|(weight, _)| folds(f64::from_bits(*weight))).count();
            motions[t] == Motion::Inverted || 2 * folded > beside.len()
        })
    }

    /// For each triangle, how many are joined to it by gentle steps.
    fn region_sizes(&self) -> Vec<u32> {
        let mut sizes = vec![0; self.0.count()];
        for region in self.patches(|_, _, weight| weight < GENTLE).iter() {
            for &t in region {
                sizes[t as usize] = region.len() as u32;
            }
        }
        sizes
    }

    /// Triangles in groups that `joined(triangle, neighbour, weight)` holds together.
    fn patches(&self, joined: impl Fn(usize, usize, f64) -> bool) -> Rows<u32> {
        let pairs = self.0.iter().enumerate().flat_map(|(t, beside)| {
            let joined = &joined;
            let held = beside.iter().filter(move |&&(w, s)| joined(t, s as usize, f64::from_bits(w)));
            held.map(move |&(_, s)| [t as u32, s])
        });
        Groups::joining(self.0.count(), pairs).members()
    }

    fn of_triangle(&self, t: u32) -> &[(u64, u32)] {
        self.0.of(t as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: Mat3, b: Mat3) -> f64 {
        distance(a, b).sqrt()
    }

    #[test]
    fn a_lifted_turn_leads_to_the_rotation_and_back() {
        let near = Turn::about(Vec3::new(0.2, -0.1, 1.0).normalize() * 9.0);
        for tilt in [Vec3::ZERO, Vec3::X * 0.1, Vec3::new(-0.5, 0.3, 0.1)] {
            let r = near.at(1.0) * rotation::exp(tilt);
            let turn = near.lift(r);
            assert!(apart(turn.at(1.0), r) < 1e-12 && apart(turn.at(0.0), Mat3::IDENTITY) == 0.0);
            assert!((turn.angle - 9.0).abs() < 0.3 && turn.swing.length() < 0.7, "{turn:?}");
        }
    }

    #[test]
    fn reversed_in_time_a_turn_is_the_turn_of_the_inverse() {
        let near = Turn::about(Vec3::Y * 7.0);
        let turn = near.lift(near.at(1.0) * rotation::exp(Vec3::new(0.3, 0.2, -0.4)));
        let back = Turn::about(-Vec3::Y * 7.0).lift(turn.at(1.0).transpose());
        for t in [0.2, 0.5, 0.9] {
            assert!(apart(back.at(1.0 - t), turn.at(t) * turn.at(1.0).transpose()) < 1e-12);
        }
    }

    #[test]
    fn near_a_whole_turn_the_axis_is_inherited() {
        let near = Turn::about(Vec3::Z * 6.2);
        let turn = near.lift(rotation::exp(Vec3::X * 0.01));
        assert!((turn.angle - TAU).abs() < 1e-12 && turn.axis == Vec3::Z);
        assert!((turn.swing - Vec3::X * 0.01).length() < 1e-12);
    }

    #[test]
    fn below_half_a_turn_the_shortest_is_taken() {
        let turn = Turn::about(Vec3::Z * 3.0).lift(rotation::exp(Vec3::X * 0.01));
        assert!((turn.omega() - Vec3::X * 0.01).length() < 1e-12);
    }

    /// Turns about z of triangles whose rotations are by `degrees`, the first of them at rest.
    fn walked(degrees: &[f64], pairs: &[[u32; 2]]) -> Vec<f64> {
        let turn = |d: &f64| Motion::Turns(rotation::exp(Vec3::Z * d.to_radians()));
        let motions: Vec<Motion> = degrees.iter().map(turn).collect();
        let moved: Vec<u8> = (0..motions.len()).map(|t| if t == 0 { 0 } else { 3 }).collect();
        let neighbours = Neighbours::joining(pairs, &motions);
        let (turns, _) = consistent(&neighbours, &motions, &moved, &Job::default()).unwrap();
        turns.iter().map(|turn| turn.omega().z.to_degrees().round()).collect()
    }

    fn chain(count: usize) -> Vec<[u32; 2]> {
        (1..count as u32).map(|t| [t - 1, t]).collect()
    }

    #[test]
    fn gentle_steps_make_a_whole_turn() {
        let degrees: Vec<f64> = (0..=16).map(|k| 45.0 * f64::from(k)).collect();
        assert_eq!(walked(&degrees, &chain(17)), degrees);
    }

    #[test]
    fn a_crumple_between_two_regions_makes_none() {
        let crumple: Vec<f64> = (1..5).map(|k| 72.0 * f64::from(k)).collect();
        let degrees = [vec![0.0; 20], crumple, vec![0.0; 20]].concat();
        let found = walked(&degrees, &chain(44));
        assert_eq!((found[20], found[43]), (72.0, 0.0), "{found:?}");
    }

    #[test]
    fn a_turn_that_its_border_denies_is_dropped() {
        // A patch at -61 degrees along a region at rest, and a gentle way round to it that makes it 299.
        let way: Vec<f64> = (1..6).map(|k| 50.0 * f64::from(k)).collect();
        let degrees = [vec![0.0; 20], way, vec![-61.0; 20]].concat();
        let mut pairs = chain(45);
        pairs.extend((0..20).map(|t| [t, t + 25]));
        let found = walked(&degrees, &pairs);
        assert!(found[25..].iter().all(|&d| d == -61.0), "{found:?}");
        // Without the border the way round is all there is.
        assert!(walked(&degrees, &chain(45))[25..].iter().all(|&d| d == 299.0));
    }
}
