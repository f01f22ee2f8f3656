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
//! Beyond half a turn a whole patch turns about one axis, with whole turns counted (`turn`).
//!
//! Steps of equal weight, as on the two sides of a symmetric mesh, are taken at once, and a triangle that several of them
//! lead to follows their mean: symmetric shapes go a symmetric way.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use rayon::prelude::*;

use super::neighbours::{GENTLE, Neighbours, TIE, distance};
use super::rotations::TriangleMotion;
use super::turn::{HALF_TURN, Turn, is_half, sided_log};
use crate::{Job, Mat3, Result, Vec3, rotation};

/// Regions of fewer triangles are not trusted with a turn of their own; 16 and 64 do alike.
const REGION: u32 = 16;

/// Rotation vectors whose sum is at least this share of their lengths' sum are about one axis; those of crumples are not.
const ONE_AXIS: f64 = 0.8;

/// What was chosen, and from where.
#[derive(Debug, Default)]
pub(super) struct Branches {
    pub turns: Vec<Turn>,
    /// Triangles that the others' turns were chosen from.
    pub roots: Vec<u32>,
    /// From the hosts of parts that ride to these, where the walk entered them.
    pub links: Vec<[u32; 2]>,
    /// Roots that might as well turn the other way.
    pub halves: Vec<u32>,
}

/// Each triangle by the least angle, whatever its neighbours do.
pub(super) fn shortest(motions: &[TriangleMotion], drift: impl Fn(usize) -> Vec3 + Sync) -> Vec<Turn> {
    let turn = |(t, m): (usize, &TriangleMotion)| {
        m.rotation().map_or(Turn::NONE, |r| Turn::about(sided_log(r, drift(t))))
    };
    motions.par_iter().enumerate().map(turn).collect()
}

/// Each triangle by the branch nearest to its neighbour's, along the minimum spanning tree (Prim).
///
/// `moved` counts the vertices of each triangle that move. Triangles at rest are the roots. A
/// component without any starts from the triangle that turns least: of those held by most vertices,
/// since a whole turn looks like none, and of those outside crumples. Triangles without a rotation
/// take their neighbour's. `drift` is how far the component of a triangle goes, and `leaves` how far a triangle leaves its
/// place beside another that turns by a rotation. `links` lead to triangles of parts that
/// ride, from those that they sit on, hosts first: such parts are entered last, each by its gentlest links.
pub(super) fn consistent(
    neighbours: &Neighbours,
    motions: &[TriangleMotion],
    moved: &[u8],
    links: &[[u32; 2]],
    drift: impl Fn(usize) -> Vec3,
    leaves: impl Fn(usize, usize, Mat3) -> Vec3,
    job: &Job,
) -> Result<Branches> {
    let mut walk = Walk {
        neighbours,
        motions,
        leaves: &leaves,
        sizes: neighbours.region_sizes(),
        turns: vec![None; motions.len()],
        handed_on: vec![Turn::NONE; motions.len()],
        roots: Vec::new(),
        halves: Vec::new(),
    };
    let mut queue = BinaryHeap::new();
    let at_rest = (0..motions.len() as u32).filter(|&t| moved[t as usize] == 0);
    queue.extend(at_rest.map(|t| Reverse((0u64, t, t))));
    walk.run(&mut queue, job)?;

    let mut rides = vec![false; motions.len()];
    links.iter().for_each(|&[t, _]| rides[t as usize] = true);
    let mut roots: Vec<(bool, u8, bool, u64, u32)> = (0u32..)
        .zip(motions)
        .filter(|(t, _)| walk.turns[*t as usize].is_none() && !rides[*t as usize])
        .map(|(t, m)| {
            let least = m.rotation().map(|r| distance(r, Mat3::IDENTITY).to_bits());
            let crumple = walk.sizes[t as usize] < REGION;
            (least.is_none(), moved[t as usize], crumple, least.unwrap_or_default(), t)
        })
        .collect();
    roots.par_sort_unstable();
    for (k, &(none, held, crumple, least, first)) in roots.iter().enumerate() {
        if walk.turns[first as usize].is_some() {
            continue;
        }
        let limit = (f64::from_bits(least) + TIE).to_bits();
        let alike = roots[k..]
            .iter()
            .take_while(|root| (root.0, root.1, root.2) == (none, held, crumple) && root.3 <= limit);
        for &(.., root) in alike {
            let t = root as usize;
            if walk.turns[t].is_some() {
                continue;
            }
            let omega = motions[t].rotation().map(|r| sided_log(r, drift(t)));
            let half = omega.is_some_and(is_half);
            // One alone chooses the way round.
            if root != first && (half || none) {
                continue;
            }
            walk.handed_on[t] = omega.map_or(Turn::NONE, Turn::about);
            walk.halves.extend(half.then_some(root));
            queue.push(Reverse((0, root, root)));
        }
        walk.run(&mut queue, job)?;
    }
    let mut turns = settled(neighbours, motions, &walk.turns);
    let links = neighbours.gentlest(motions, links);
    if !links.is_empty() {
        let seen = walk.turns.iter().map(Option::is_some);
        walk.turns = seen.zip(turns).map(|(seen, turn)| seen.then_some(turn)).collect();
        for links in &links {
            let turn = |host: u32| walk.turns[host as usize].unwrap_or(Turn::NONE);
            let way = turn(links[0][0]).omega();
            for &[host, triangle] in links {
                // Equal rotations may be whole turns apart.
                if turn(host).omega().distance(way) < PI {
                    walk.handed_on[host as usize] = turn(host);
                    queue.push(Reverse((0, triangle, host)));
                }
            }
            walk.run(&mut queue, job)?;
        }
        turns = settled(neighbours, motions, &walk.turns);
    }
    Ok(Branches { turns, roots: walk.roots, links: links.concat(), halves: walk.halves })
}

/// The turns of a walk, with those that do not pay dropped and axes shared.
fn settled(neighbours: &Neighbours, motions: &[TriangleMotion], walked: &[Option<Turn>]) -> Vec<Turn> {
    let mut turns: Vec<Turn> = walked.iter().map(|turn| turn.unwrap_or(Turn::NONE)).collect();
    drop_unpaid(neighbours, motions, &mut turns);
    share_axes(neighbours, motions, &mut turns);
    turns
}

/// A walk in progress.
struct Walk<'a> {
    neighbours: &'a Neighbours,
    motions: &'a [TriangleMotion],
    /// Number of triangles in the region of each triangle.
    sizes: Vec<u32>,
    turns: Vec<Option<Turn>>,
    /// The turn that each triangle gives to those beyond a crease.
    handed_on: Vec<Turn>,
    leaves: &'a dyn Fn(usize, usize, Mat3) -> Vec3,
    roots: Vec<u32>,
    /// Triangles that were entered by half a turn.
    halves: Vec<u32>,
}

/// Triangles to visit: weight of the step, triangle, the triangle it is reached from; a root from itself.
type Queue = BinaryHeap<Reverse<(u64, u32, u32)>>;

impl Walk<'_> {
    /// Empties the queue.
    fn run(&mut self, queue: &mut Queue, job: &Job) -> Result<()> {
        let mut at_once = Vec::new();
        while let Some(&Reverse((least, ..))) = queue.peek() {
            job.check()?;
            let limit = (f64::from_bits(least) + TIE).to_bits();
            while let Some(Reverse((weight, triangle, from))) = queue.peek().filter(|next| next.0.0 <= limit)
            {
                if self.turns[*triangle as usize].is_none() {
                    at_once.push((*triangle, *from, f64::from_bits(*weight) < GENTLE));
                }
                queue.pop();
            }
            at_once.sort_unstable();
            for steps in at_once.chunk_by(|a, b| a.0 == b.0) {
                self.step(steps, queue);
            }
            at_once.clear();
        }
        Ok(())
    }

    /// Visits a triangle by one step, or several that are equal: triangle, from, whether it is gentle.
    fn step(&mut self, steps: &[(u32, u32, bool)], queue: &mut Queue) {
        let (triangle, first, _) = steps[0];
        let t = triangle as usize;
        let handed_on = Turn::mean(steps.iter().map(|&(_, from, _)| self.handed_on[from as usize]));
        let near = Turn::mean(steps.iter().map(|&(_, from, gentle)| {
            let own = self.turns[from as usize].filter(|_| gentle);
            own.unwrap_or(self.handed_on[from as usize])
        }));
        let trusted = triangle == first || self.sizes[t] >= REGION;
        let own = self.motions[t].rotation();
        let folded = own.filter(|_| trusted && triangle != first);
        let folded = folded.and_then(|r| near.folded(r, |host| (self.leaves)(t, first as usize, host)));
        self.halves.extend(folded.map(|_| triangle));
        let turn = folded.or_else(|| Some(near.nearest_to(own?))).unwrap_or(near);
        self.turns[t] = Some(turn);
        self.handed_on[t] = if trusted { turn } else { handed_on };
        let next = self.neighbours.of_triangle(triangle).iter();
        let unseen = next.filter(|(_, s)| self.turns[*s as usize].is_none());
        queue.extend(unseen.map(|&(weight, s)| Reverse((weight, s, triangle))));
        if triangle == first {
            self.roots.push(triangle);
        }
    }
}

/// Gives shortest turns to patches beyond half a turn whose borders agree better with those.
fn drop_unpaid(neighbours: &Neighbours, motions: &[TriangleMotion], turns: &mut [Turn]) {
    let beyond: Vec<bool> = turns.iter().map(Turn::is_beyond_half).collect();
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
        let (mut kept, mut dropped, mut count) = (0.0, 0.0, 0.0);
        for (&t, short) in patch.iter().zip(&shortest) {
            let outside = neighbours.of_triangle(t).iter().map(|(_, s)| *s as usize).filter(|&s| !beyond[s]);
            for s in outside {
                kept += turns[t as usize].omega().distance(turns[s].omega());
                dropped += short.omega().distance(turns[s].omega());
                count += 1.0;
            }
        }
        // Where either is as near, the walk has chosen.
        if dropped < kept - 2.0 * HALF_TURN * count {
            for (&t, short) in patch.iter().zip(shortest) {
                turns[t as usize] = short;
            }
        }
    }
}

/// Turns every patch beyond half a turn about one axis, the mean of those along its border. Each triangle there has a
/// tilt of its own, by its shear, and handed on alone would lean the whole patch.
fn share_axes(neighbours: &Neighbours, motions: &[TriangleMotion], turns: &mut [Turn]) {
    let beyond: Vec<bool> = turns.iter().map(Turn::is_beyond_half).collect();
    for patch in neighbours.patches(|t, s, _| beyond[t] && beyond[s]).iter() {
        if !beyond[patch[0] as usize] {
            continue;
        }
        let around = patch.iter().flat_map(|&t| neighbours.of_triangle(t)).map(|(_, s)| *s as usize);
        let border: Vec<Vec3> = around.filter(|&s| !beyond[s]).map(|s| turns[s].omega()).collect();
        let (sum, size) = (border.iter().sum::<Vec3>(), border.iter().map(|o| o.length()).sum::<f64>());
        if patch.len() < REGION as usize || sum.length() < ONE_AXIS * size {
            continue;
        }
        let Some(axis) = sum.try_normalize() else { continue };
        for &t in patch {
            let (turn, motion) = (turns[t as usize], motions[t as usize]);
            let shared = Turn { axis, angle: turn.angle * turn.axis.dot(axis).signum(), swing: Vec3::ZERO };
            turns[t as usize] = motion.rotation().map_or(shared, |r| shared.nearest_to(r));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns about z of triangles whose rotations are by `degrees`, the first of them at rest.
    fn walked(degrees: &[f64], pairs: &[[u32; 2]], links: &[[u32; 2]]) -> Vec<f64> {
        let turn = |d: &f64| TriangleMotion::Turns(rotation::exp(Vec3::Z * d.to_radians()));
        let motions: Vec<TriangleMotion> = degrees.iter().map(turn).collect();
        let moved: Vec<u8> = (0..motions.len()).map(|t| if t == 0 { 0 } else { 3 }).collect();
        let neighbours = Neighbours::joining(pairs, &motions);
        let found = consistent(
            &neighbours,
            &motions,
            &moved,
            links,
            |_| Vec3::ZERO,
            |_, _, _| Vec3::X,
            &Job::default(),
        );
        found.unwrap().turns.iter().map(|turn| turn.omega().z.to_degrees().round()).collect()
    }

    fn chain(count: usize) -> Vec<[u32; 2]> {
        (1..count as u32).map(|t| [t - 1, t]).collect()
    }

    #[test]
    fn gentle_steps_make_a_whole_turn() {
        let degrees: Vec<f64> = (0..=16).map(|k| 45.0 * f64::from(k)).collect();
        assert_eq!(walked(&degrees, &chain(17), &[]), degrees);
    }

    #[test]
    fn what_rides_takes_the_branch_of_its_host() {
        // A part that sits on the last of the host, and one that sits on that part.
        let host: Vec<f64> = (0..=16).map(|k| 45.0 * f64::from(k)).collect();
        let degrees = [host, vec![730.0, 740.0], vec![690.0, 690.0]].concat();
        let pairs = [chain(17), vec![[17, 18], [19, 20]]].concat();
        let links = [[17, 16], [18, 16], [19, 18], [20, 18]];
        assert_eq!(walked(&degrees, &pairs, &links), degrees);
        // By themselves they take the short way.
        assert_eq!(walked(&degrees, &pairs, &[])[17..], [10.0, 20.0, -30.0, -30.0]);
    }

    #[test]
    fn a_crumple_between_two_regions_makes_none() {
        let crumple: Vec<f64> = (1..5).map(|k| 72.0 * f64::from(k)).collect();
        let degrees = [vec![0.0; 20], crumple, vec![0.0; 20]].concat();
        let found = walked(&degrees, &chain(44), &[]);
        assert_eq!((found[20], found[43]), (72.0, 0.0), "{found:?}");
    }

    #[test]
    fn a_turn_that_its_border_denies_is_dropped() {
        // A patch at -61 degrees along a region at rest, and a gentle way round to it that makes it 299.
        let way: Vec<f64> = (1..6).map(|k| 50.0 * f64::from(k)).collect();
        let degrees = [vec![0.0; 20], way, vec![-61.0; 20]].concat();
        let mut pairs = chain(45);
        pairs.extend((0..20).map(|t| [t, t + 25]));
        let found = walked(&degrees, &pairs, &[]);
        assert!(found[25..].iter().all(|&d| d == -61.0), "{found:?}");
        // Without the border the way round is all there is.
        assert!(walked(&degrees, &chain(45), &[])[25..].iter().all(|&d| d == 299.0));
    }
}
