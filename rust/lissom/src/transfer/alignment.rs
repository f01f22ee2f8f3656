//! Alignment: the rotation, uniform scale and translation that lay one mesh on another, without any marker.
//!
//! Samples of either surface are drawn to the closest compatible points of the other, round by round (Besl & McKay
//! 1992, A Method for Registration of 3-D Shapes), under a loss that what only one of the meshes has adds little to
//! (Geman & McClure; Zhou, Park & Koltun 2016, Fast Global Registration):
//!
//! ```text
//!     cost  =  mean over samples of both  d^2 / (d^2 + r^2),     d  the distance, over the size of the sample's mesh
//! ```
//!
//! Both ways, since a source that shrinks to a point is near to the target, but the target not to it; each over the
//! size of its own mesh, so that shrinking does not make the source's distances any less. The reach `r` falls from
//! round to round: a wide one leads to the basin, a narrow one tells what is missing from what differs. It takes the
//! place of a trimmed fraction (Chetverikov, Stepanov & Krsek 2005, Robust Euclidean Alignment of 3D Point Sets), which
//! is another one for a face on a head than for a head on a head.
//!
//! A round minimises, with the weights of that loss, distances to planes (Chen & Medioni 1992, Object Modelling by
//! Registration of Multiple Range Images) and a little of those to points, which hold where planes let slide, in one
//! linear step: the closed form of Umeyama (1991) knows no planes. The rounds begin at the meshes as they stand, and at
//! the 24 rotations of principal axes onto principal axes, all with equal sizes; the best go on with more samples.
//!
//! # Certainty
//!
//! ```text
//!     certainty  =  fit * (1 - exp(-(margin / 0.2)^2))
//!     fit        =  (0.4 - cost) / 0.2                    within 0-1
//!     margin     =  1 - (cost + 0.01) / (other + 0.01)    not below 0
//! ```
//!
//! `other` is the cost of the best candidate more than 20 degrees away. The margin says that no other rotation fits:
//! it is 0 for a sphere, whatever the residual; the 0.01 is what triangles make of symmetric shapes. The fit says that
//! there is something in common: half the cost is reached by shrinking one mesh onto any place of the other. Neither
//! suffices. Heads of different people, a face on a head and a cat on a lion have costs up to 0.28 and margins above
//! 0.2, models with nothing in common costs from 0.29 and margins up to 0.17; a cat in unlike poses is in between. A
//! source that is a small part of the target, or the reverse, has a high cost however well it lies: it is never certain.

use rayon::prelude::*;

use crate::geometry::rigid::Similarity;
use crate::geometry::surface::Surface;
use crate::linear::NormalEquations;
use crate::matrix::{eigenvectors, outer, trace};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, rotation};

/// Samples of each mesh, reaches from the first round to the last, how many candidates go on, and degrees between them.
/// With twice as many of everything the heads of other people are met no better.
const STAGES: [(usize, &[f64], usize, f64); 3] = [
    (64, &[1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.3], 6, 10.0),
    (250, &[0.3, 0.25, 0.21, 0.18, 0.15, 0.15], 3, APART),
    (1000, &[0.15; 6], usize::MAX, 0.0),
];

/// Candidates that are more degrees apart are different answers.
const APART: f64 = 20.0;

/// Weight of the distance to the point beside that to the plane.
const POINT: f64 = 0.1;

/// Costs that differ by less are those of the triangulation.
const COARSENESS: f64 = 0.01;

/// The costs of meshes that have nothing in common, and of those that have all.
const COSTS: [f64; 2] = [0.4, 0.2];

/// Margins above this are clear.
const CLEAR: f64 = 0.2;

/// How a source lies on a target.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// From the unit coordinates of the source ([`Mesh::rest`]) to those of the target.
    pub similarity: Similarity,
    /// Its rotation.
    pub rotation: Mat3,
    /// Its scale, from unit coordinates to unit coordinates.
    pub scale: f64,
    /// Root mean square distance between the surfaces, each way over the nearest three quarters of its samples, as a
    /// fraction of the target's diagonal.
    pub residual: f64,
    /// How sure that is, 0-1; see the head of this file. Below about 0.25 it is a guess.
    pub certainty: f64,
}

/// Finds the similarity that lays `source` on `target`, as far as these have something in common.
///
/// The source is turned by at most `most_turn` degrees, 180 for any rotation: which of several it is then is less of
/// a question. `masked_source` and `masked_target` hold a flag for each vertex; triangles with such a corner take no part. Both
/// meshes have to be wound the same way, outwards or inwards. Of rotations that are equally good, the least. The same
/// input gives the same output to the last bit.
///
/// # Errors
///
/// [`Error::InvalidValue`] where a mask has not one flag a vertex or leaves no surface; [`Error::Cancelled`].
pub fn align(
    source: &Mesh,
    target: &Mesh,
    masked_source: &[bool],
    masked_target: &[bool],
    most_turn: f64,
    job: &Job,
) -> Result<Found> {
    let (source, target) = rayon::join(
        || Side::new("source_mask", source, masked_source),
        || Side::new("target_mask", target, masked_target),
    );
    let sides = [&source?, &target?];
    let mut found = starts(sides, most_turn);
    let mut samples = Samples::default();
    for (count, reaches, kept, apart) in STAGES {
        samples = sides.map(|side| side.samples(count));
        let refined = found.into_par_iter().map(|placed| placed.refine(sides, &samples, reaches, job));
        let mut refined: Vec<Placed> = refined.collect::<Result<_>>()?;
        if refined.iter().any(|placed| placed.turn() <= most_turn) {
            refined.retain(|placed| placed.turn() <= most_turn);
        }
        found = best(refined, kept, apart);
    }
    let placed = found[0];
    let others = found.iter().filter(|other| placed.apart(other) > APART).map(|other| other.cost);
    let margin = 1.0 - (placed.cost + COARSENESS) / (others.fold(1.0, f64::min) + COARSENESS);
    let fit = ((COSTS[0] - placed.cost) / (COSTS[0] - COSTS[1])).clamp(0.0, 1.0);
    Ok(Found {
        similarity: Similarity::new(placed.rotation * placed.scale, Vec3::ZERO, placed.shift),
        rotation: placed.rotation,
        scale: placed.scale,
        residual: residual(&placed.pairs(sides, &samples)),
        certainty: fit * (1.0 - (-(margin.max(0.0) / CLEAR).powi(2)).exp()),
    })
}

/// Points of either surface, and the normals there.
type Samples = [Vec<(Vec3, Vec3)>; 2];

/// What is not masked of a mesh.
struct Side {
    corners: Vec<[Vec3; 3]>,
    /// The area of each triangle and all before it.
    areas: Vec<f64>,
    surface: Surface,
    centre: Vec3,
    /// Root mean square distance of the surface from its centre.
    size: f64,
    /// Principal axes, that of the largest extent first.
    axes: Mat3,
}

impl Side {
    fn new(argument: &str, mesh: &Mesh, masked: &[bool]) -> Result<Self> {
        let fault = |problem| Error::InvalidValue(Fault::new(argument, problem));
        if masked.len() != mesh.rest().len() {
            return Err(fault("must have one flag for each vertex"));
        }
        let (mut corners, mut areas, mut whole) = (Vec::new(), Vec::new(), 0.0);
        let (mut first, mut second) = (Vec3::ZERO, Mat3::ZERO);
        for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
            if triangle.iter().any(|&v| masked[v as usize]) {
                continue;
            }
            let [a, b, c] = triangle.map(|v| mesh.rest()[v as usize]);
            let sum = a + b + c;
            first += sum * (area / 3.0);
            second += (outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum)) * (area / 12.0);
            whole += area;
            corners.push([a, b, c]);
            areas.push(whole);
        }
        let centre = first / whole;
        let covariance = second * (1.0 / whole) - outer(centre, centre);
        let size = trace(covariance).sqrt();
        // Less is rounding; where nothing is open it is 0 / 0.
        if !(size > 1e-6 && size.is_finite()) {
            return Err(fault("leaves no surface to align"));
        }
        let axes = eigenvectors(covariance);
        Ok(Self { surface: Surface::new(corners.clone()), corners, areas, centre, size, axes })
    }

    /// So many samples, each of a share of the area that is as large as any other's.
    fn samples(&self, count: usize) -> Vec<(Vec3, Vec3)> {
        let whole = self.areas[self.areas.len() - 1];
        let sample = |k: usize| {
            let share = whole * (k as f64 + 0.5) / count as f64;
            let t = self.areas.partition_point(|&area| area < share).min(self.corners.len() - 1);
            let [a, b, c] = self.corners[t];
            // Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences: even in the plane.
            let (u, v) = (0.754_877_666_246_693 * k as f64 % 1.0, 0.569_840_290_998_053 * k as f64 % 1.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            (a + (b - a) * u + (c - a) * v, self.surface.normal(t))
        };
        (0..count).map(sample).collect()
    }
}

/// A candidate, `p -> shift + scale * rotation p`.
#[derive(Debug, Clone, Copy)]
struct Placed {
    rotation: Mat3,
    scale: f64,
    shift: Vec3,
    cost: f64,
    as_they_stand: bool,
}

/// A point of the moved source and one of the target, which are to meet along `normal`.
#[derive(Debug, Clone, Copy)]
struct Pair {
    at: Vec3,
    to: Vec3,
    normal: Vec3,
}

impl Pair {
    fn squared(&self) -> f64 {
        self.at.distance_squared(self.to)
    }
}

/// What the samples of the source found on the target, and those of the target on the source.
type Pairs = [Vec<Option<Pair>>; 2];

/// The meshes as they stand, and with their principal axes on each other; as they stand and nodding, turning and
/// bending a little where they are known to be turned by no more.
fn starts([source, target]: [&Side; 2], most_turn: f64) -> Vec<Placed> {
    let units = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let swaps = units.iter().flat_map(|&x| units.iter().map(move |&y| Mat3::from_cols(x, y, x.cross(y))));
    let proper = swaps.filter(|swap| swap.z_axis != Vec3::ZERO);
    let matched = proper.map(|swap| target.axes * swap * source.axes.transpose());
    let scale = target.size / source.size;
    let start = |(k, rotation): (usize, Mat3)| {
        let shift = target.centre - rotation * source.centre * scale;
        Placed { rotation, scale, shift, cost: 1.0, as_they_stand: k == 0 }
    };
    let little = most_turn.min(APART).to_radians();
    let tilts = units.iter().filter(|_| most_turn < 90.0).map(|&axis| rotation::exp(axis * little));
    let all = std::iter::once(Mat3::IDENTITY).chain(tilts).chain(matched);
    all.enumerate().map(start).filter(|placed| placed.turn() <= most_turn).collect()
}

/// The best candidates first, at most `kept` that are more than `apart` degrees from each other. The meshes as they
/// stand stay among them: people have mostly put them right, and of symmetric shapes this is the least rotation.
fn best(mut found: Vec<Placed>, kept: usize, apart: f64) -> Vec<Placed> {
    found.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
    let mut best: Vec<Placed> = Vec::new();
    for placed in found {
        if let Some(near) = best.iter_mut().find(|other| other.apart(&placed) <= apart) {
            near.as_they_stand |= placed.as_they_stand;
        } else if best.len() < kept || placed.as_they_stand {
            best.push(placed);
        }
    }
    best
}

impl Placed {
    /// The cost, and where costs are equal the rotation: half a turn has to be 5 % better than none.
    fn rank(&self) -> f64 {
        (self.cost + COARSENESS) * (1.0 + 0.05 * self.turn() / 180.0)
    }

    /// The angle of the rotation, degrees.
    fn turn(&self) -> f64 {
        rotation::log(self.rotation).length().to_degrees()
    }

    /// The angle between two rotations, degrees.
    fn apart(&self, other: &Self) -> f64 {
        rotation::log(self.rotation.transpose() * other.rotation).length().to_degrees()
    }

    /// One round for each reach but the last, which the cost is of.
    fn refine(mut self, sides: [&Side; 2], samples: &Samples, reaches: &[f64], job: &Job) -> Result<Self> {
        for (round, reach) in reaches.iter().enumerate() {
            job.check()?;
            let pairs = self.pairs(sides, samples);
            let squares = [sides[0].size * self.scale, sides[1].size].map(|size| (size * reach).powi(2));
            if round + 1 == reaches.len() {
                self.cost = cost(&pairs, squares);
            } else if let Some(step) = normal_equations(&pairs, squares).solve() {
                // The equations are linear in both, which larger steps are not.
                let turn = rotation::exp(Vec3::from_slice(&step[..3]).clamp_length_max(0.5));
                let growth = step[6].clamp(-0.3, 0.3).exp();
                self.rotation = rotation::nearest_rotation(turn * self.rotation);
                self.scale *= growth;
                self.shift = turn * self.shift * growth + Vec3::from_slice(&step[3..6]);
            }
        }
        Ok(self)
    }

    fn pairs(&self, [source, target]: [&Side; 2], samples: &Samples) -> Pairs {
        let apply = |p: Vec3| self.rotation * p * self.scale + self.shift;
        let back = self.rotation.transpose();
        let of_source = |&(point, normal): &(Vec3, Vec3)| {
            let at = apply(point);
            let hit = target.surface.closest_compatible_point(at, self.rotation * normal)?;
            Some(Pair { at, to: hit.point, normal: target.surface.normal(hit.triangle) })
        };
        let of_target = |&(point, normal): &(Vec3, Vec3)| {
            let there = back * (point - self.shift) / self.scale;
            let hit = source.surface.closest_compatible_point(there, back * normal)?;
            let normal = self.rotation * source.surface.normal(hit.triangle);
            Some(Pair { at: apply(hit.point), to: point, normal })
        };
        let [sources, targets] = samples.each_ref().map(|of| of.par_iter().with_min_len(STAGES[0].0));
        [sources.map(of_source).collect(), targets.map(of_target).collect()]
    }
}

/// The mean loss; 1 for what found nothing. `squares` are those of the reach of each mesh's samples.
fn cost(pairs: &Pairs, squares: [f64; 2]) -> f64 {
    let loss = |pair: &Option<Pair>, square: f64| pair.map_or(1.0, |p| p.squared() / (p.squared() + square));
    let sum = |side: usize| pairs[side].iter().map(|pair| loss(pair, squares[side])).sum::<f64>();
    (sum(0) + sum(1)) / (pairs[0].len() + pairs[1].len()) as f64
}

/// The equations of a step `x -> x + omega x x + t + growth x`.
fn normal_equations(pairs: &Pairs, squares: [f64; 2]) -> NormalEquations {
    let mut equations = NormalEquations::new(7);
    for (pairs, square) in pairs.iter().zip(squares) {
        for pair in pairs.iter().flatten() {
            let weight = square / (pair.squared() + square).powi(2);
            let axes = Vec3::AXES.map(|axis| (axis, weight * POINT));
            for (along, weight) in std::iter::once((pair.normal, weight)).chain(axes) {
                let (turn, off) = (pair.at.cross(along), along.dot(pair.to - pair.at));
                let row = [turn.x, turn.y, turn.z, along.x, along.y, along.z, along.dot(pair.at)];
                equations.add(&row, off, weight);
            }
        }
    }
    equations
}

/// Root mean square of the nearest three quarters each way; what found nothing is a diagonal away.
fn residual(pairs: &Pairs) -> f64 {
    let mean = |pairs: &[Option<Pair>]| {
        let mut squares: Vec<f64> = pairs.iter().map(|pair| pair.map_or(1.0, |p| p.squared())).collect();
        squares.sort_by(f64::total_cmp);
        squares.truncate(squares.len() * 3 / 4);
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    (0.5 * (mean(&pairs[0]) + mean(&pairs[1]))).sqrt()
}
