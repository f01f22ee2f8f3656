//! Alignment: the rotation, uniform scale and translation that lay one mesh on another, without any marker.
//!
//! Samples of either surface are drawn to the closest compatible points of the other, round by round (Besl & McKay
//! 1992, A Method for Registration of 3-D Shapes), under a loss that what only one of the meshes has adds little to
//! (Geman & McClure; Zhou, Park & Koltun 2016, Fast Global Registration):
//!
//! ```text
//!     cost  =  mean over samples of both  d^2 / (d^2 + r^2),        d  the distance, over the size of the sample's mesh
//! ```
//!
//! Both ways, since a source that shrinks to a point is near to the target while the target is not near to it. Each
//! way over the size of its own mesh, so that shrinking does not make the source's own distances any less, and the
//! cost is the same with source and target exchanged. The reach `r` falls from round to round: a wide one leads to
//! the basin, a narrow one tells the parts that are missing from those that differ. It takes the place of a trimmed
//! fraction (Chetverikov, Stepanov & Krsek 2005, Robust Euclidean Alignment of 3D Point Sets), which would have to be
//! known, and is another one for a face on a head than for a head on a head.
//!
//! A round minimises, with the weights of that loss, distances to planes (Chen & Medioni 1992, Object Modelling by
//! Registration of Multiple Range Images) and a little of those to points, which hold where planes let slide. Rotation
//! and scale are those of one linear step; the closed form of Umeyama (1991) knows no planes.
//!
//! The rounds begin at the meshes as they stand, and at the 24 rotations that lay principal axes on principal axes,
//! all with the sizes made equal; the best of them go on with more samples.
//!
//! # Certainty
//!
//! ```text
//!     certainty  =  fit * (1 - exp(-(margin / 0.2)^2))
//!     fit        =  (0.4 - cost) / 0.2            within 0-1
//!     margin     =  1 - (cost + 0.01) / (other + 0.01),   not below 0
//! ```
//!
//! `other` is the cost of the best other candidate, more than 20 degrees away. The margin says that the rotation is
//! the only one that fits: it is 0 for a sphere, whatever the residual; the 0.01 is what triangles make of symmetric
//! shapes. The fit says that there is something in common: half the cost is reached by shrinking one mesh onto any
//! place of the other. Neither suffices. Measured on heads of different people, a face on a head, a cat on a lion
//! (right), and on models that have nothing in common (wrong): right ones have costs up to 0.28 and margins above 0.2,
//! wrong ones costs from 0.29 and margins up to 0.17. A target of which the source is a small part has a high cost
//! however well it lies, and is never certain.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::geometry::rigid::Similarity;
use crate::geometry::surface::Surface;
use crate::matrix::{outer, trace};
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, rotation};

/// Samples of each mesh, reaches from the first to the last round, and how many candidates go on, so many degrees
/// apart. Heads of 27,000 vertices come out the same within half a degree with twice as many of everything.
const STAGES: [(usize, &[f64], usize, f64); 3] = [
    (64, &[1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.3], 6, 10.0),
    (250, &[0.3, 0.25, 0.21, 0.18, 0.15, 0.15], 3, APART),
    (1000, &[0.15; 6], usize::MAX, 0.0),
];

/// Candidates that are more degrees apart are different answers.
const APART: f64 = 20.0;

/// Weight of the distance to the point beside that to the plane.
const POINT: f64 = 0.1;

/// Of each mesh's samples, the nearest that the residual is of.
const TRIMMED: f64 = 0.75;

/// Costs that differ by less are those of the triangulation.
const COARSENESS: f64 = 0.01;

/// By so much half a turn has to be better than none.
const HALF_A_TURN: f64 = 0.05;

/// Costs above the first say that there is nothing in common, those below the second that there is.
const COSTS: [f64; 2] = [0.4, 0.2];

/// Margins above this are clear.
const CLEAR: f64 = 0.2;

/// Longest steps of one round, radians and logarithm of the scale: beyond, the linear step is none.
const STEPS: [f64; 2] = [0.5, 0.3];

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
/// `masked_source` and `masked_target` hold a flag for each vertex; triangles with such a corner take no part. Both
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
    job: &Job,
) -> Result<Found> {
    let (source, target) = rayon::join(
        || Side::new("source_mask", source, masked_source),
        || Side::new("target_mask", target, masked_target),
    );
    let sides = [&source?, &target?];
    let mut found = starts(sides);
    let mut samples = [Vec::new(), Vec::new()];
    for (count, reaches, kept, apart) in STAGES {
        samples = sides.map(|side| side.samples(count));
        let refined = found.into_par_iter().map(|placed| placed.refine(sides, &samples, reaches, job));
        found = best(refined.collect::<Result<_>>()?, kept, apart);
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

/// A point of a surface and the normal there.
#[derive(Debug, Clone, Copy)]
struct Sample {
    point: Vec3,
    normal: Vec3,
}

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
        let open = |t: &usize| mesh.triangles()[*t].iter().all(|&v| !masked[v as usize]);
        let open: Vec<usize> = (0..mesh.triangles().len()).filter(open).collect();
        let at = |&t: &usize| mesh.triangles()[t].map(|v| mesh.rest()[v as usize]);
        let corners: Vec<[Vec3; 3]> = open.iter().map(at).collect();
        let (mut whole, mut moment, mut areas) = (0.0, Vec3::ZERO, Vec::with_capacity(open.len()));
        for (&t, [a, b, c]) in open.iter().zip(&corners) {
            whole += mesh.areas()[t];
            moment += (a + b + c) * (mesh.areas()[t] / 3.0);
            areas.push(whole);
        }
        let centre = moment / whole;
        let mut covariance = Mat3::ZERO;
        for (&t, corners) in open.iter().zip(&corners) {
            let [a, b, c] = corners.map(|p| p - centre);
            let sum = a + b + c;
            covariance += (outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum)) * mesh.areas()[t];
        }
        let size = (trace(covariance) / (12.0 * whole)).sqrt();
        // Also where nothing is open, which leaves this 0 / 0.
        if !(whole > 0.0 && size > f64::EPSILON && size.is_finite()) {
            return Err(fault("leaves no surface to align"));
        }
        let axes = principal_axes(covariance);
        Ok(Self { surface: Surface::new(corners.clone()), corners, areas, centre, size, axes })
    }

    /// So many samples, each of a share of the area that is as large as any other's.
    fn samples(&self, count: usize) -> Vec<Sample> {
        let whole = self.areas[self.areas.len() - 1];
        let sample = |k: usize| {
            let share = whole * (k as f64 + 0.5) / count as f64;
            let t = self.areas.partition_point(|&area| area < share).min(self.corners.len() - 1);
            let [a, b, c] = self.corners[t];
            // Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences: even in the plane.
            let (u, v) = (0.754_877_666_246_693 * k as f64 % 1.0, 0.569_840_290_998_053 * k as f64 % 1.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            Sample { point: a + (b - a) * u + (c - a) * v, normal: self.surface.normals()[t] }
        };
        (0..count).map(sample).collect()
    }
}

/// Orthonormal right-handed eigenvectors of a symmetric matrix, by descending eigenvalue (Jacobi 1846).
fn principal_axes(mut m: Mat3) -> Mat3 {
    let mut axes = Mat3::IDENTITY;
    // Convergence is quadratic: five sweeps leave nothing.
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(30) {
        let angle = 0.5 * (2.0 * m.col(q)[p]).atan2(m.col(q)[q] - m.col(p)[p]);
        let mut turn = Mat3::IDENTITY;
        (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (angle.cos(), angle.cos());
        (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (angle.sin(), -angle.sin());
        m = turn.transpose() * m * turn;
        axes *= turn;
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| m.col(b)[b].total_cmp(&m.col(a)[a]));
    let (x, y) = (axes.col(order[0]), axes.col(order[1]));
    Mat3::from_cols(x, y, x.cross(y))
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

/// The meshes as they stand, and with their principal axes on each other.
fn starts([source, target]: [&Side; 2]) -> Vec<Placed> {
    let units = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let swaps = units.iter().flat_map(|&x| units.iter().map(move |&y| Mat3::from_cols(x, y, x.cross(y))));
    let proper = swaps.filter(|swap| swap.z_axis != Vec3::ZERO);
    let matched = proper.map(|swap| target.axes * swap * source.axes.transpose());
    let scale = target.size / source.size;
    let start = |(k, rotation): (usize, Mat3)| {
        let shift = target.centre - rotation * source.centre * scale;
        Placed { rotation, scale, shift, cost: 1.0, as_they_stand: k == 0 }
    };
    std::iter::once(Mat3::IDENTITY).chain(matched).enumerate().map(start).collect()
}

/// The best candidates first, at most `kept` that are more than `apart` degrees from each other. The meshes as they
/// stand stay among them: people have mostly put them right, and of symmetric shapes this is the least rotation.
fn best(mut found: Vec<Placed>, kept: usize, apart: f64) -> Vec<Placed> {
    found.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
    let mut best: Vec<Placed> = Vec::new();
    for placed in found {
        let wanted = best.len() < kept || placed.as_they_stand;
        if wanted && best.iter().all(|other| other.apart(&placed) > apart) {
            best.push(placed);
        }
    }
    best
}

impl Placed {
    /// The cost, and where costs are equal the rotation.
    fn rank(&self) -> f64 {
        (self.cost + COARSENESS) * (1.0 + HALF_A_TURN * rotation::log(self.rotation).length() / PI)
    }

    /// The angle between two rotations, degrees.
    fn apart(&self, other: &Self) -> f64 {
        rotation::log(self.rotation.transpose() * other.rotation).length().to_degrees()
    }

    /// One round for each reach but the last, which the cost is of.
    fn refine(
        mut self,
        sides: [&Side; 2],
        samples: &[Vec<Sample>; 2],
        reaches: &[f64],
        job: &Job,
    ) -> Result<Self> {
        for (round, reach) in reaches.iter().enumerate() {
            job.check()?;
            let pairs = self.pairs(sides, samples);
            let squares = [sides[0].size * self.scale, sides[1].size].map(|size| (size * reach).powi(2));
            if round + 1 == reaches.len() {
                self.cost = cost(&pairs, squares);
            } else if let Some([a, b, c, x, y, z, growth]) = solve(normal_equations(&pairs, squares)) {
                let turn = rotation::exp(Vec3::new(a, b, c).clamp_length_max(STEPS[0]));
                let growth = growth.clamp(-STEPS[1], STEPS[1]).exp();
                self.rotation = rotation::nearest_rotation(turn * self.rotation);
                self.scale *= growth;
                self.shift = turn * self.shift * growth + Vec3::new(x, y, z);
            }
        }
        Ok(self)
    }

    fn pairs(&self, [source, target]: [&Side; 2], samples: &[Vec<Sample>; 2]) -> Pairs {
        let apply = |p: Vec3| self.rotation * p * self.scale + self.shift;
        let back = self.rotation.transpose();
        let of_source = |s: &Sample| {
            let at = apply(s.point);
            let hit = target.surface.closest_compatible_point(at, self.rotation * s.normal)?;
            Some(Pair { at, to: hit.point, normal: target.surface.normals()[hit.triangle] })
        };
        let of_target = |s: &Sample| {
            let point = back * (s.point - self.shift) / self.scale;
            let hit = source.surface.closest_compatible_point(point, back * s.normal)?;
            let normal = self.rotation * source.surface.normals()[hit.triangle];
            Some(Pair { at: apply(hit.point), to: s.point, normal })
        };
        let few = STAGES[0].0;
        [
            samples[0].par_iter().with_min_len(few).map(of_source).collect(),
            samples[1].par_iter().with_min_len(few).map(of_target).collect(),
        ]
    }
}

/// The mean loss; 1 for what found nothing. `squares` are those of the reach of each mesh's samples.
fn cost(pairs: &Pairs, squares: [f64; 2]) -> f64 {
    let loss = |pair: &Option<Pair>, square: f64| pair.map_or(1.0, |p| p.squared() / (p.squared() + square));
    let sum = |side: usize| pairs[side].iter().map(|pair| loss(pair, squares[side])).sum::<f64>();
    (sum(0) + sum(1)) / (pairs[0].len() + pairs[1].len()) as f64
}

/// Matrix (upper triangle) and right-hand side of a step `x -> x + omega x x + t + growth x`.
fn normal_equations(pairs: &Pairs, squares: [f64; 2]) -> ([[f64; 7]; 7], [f64; 7]) {
    let (mut matrix, mut rhs) = ([[0.0; 7]; 7], [0.0; 7]);
    for (pairs, square) in pairs.iter().zip(squares) {
        for pair in pairs.iter().flatten() {
            let weight = square / (pair.squared() + square).powi(2);
            let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| (axis, weight * POINT));
            for (along, weight) in std::iter::once((pair.normal, weight)).chain(axes) {
                let (turn, off) = (pair.at.cross(along), along.dot(pair.to - pair.at));
                let row = [turn.x, turn.y, turn.z, along.x, along.y, along.z, along.dot(pair.at)];
                for i in 0..7 {
                    rhs[i] += weight * row[i] * off;
                    (i..7).for_each(|j| matrix[i][j] += weight * row[i] * row[j]);
                }
            }
        }
    }
    (matrix, rhs)
}

/// The solution of a positive definite system; `None` where it is not, as of no pairs at all.
fn solve((mut matrix, mut rhs): ([[f64; 7]; 7], [f64; 7])) -> Option<[f64; 7]> {
    for k in 0..7 {
        let row = matrix[k];
        for i in k + 1..7 {
            let factor = row[i] / row[k];
            (i..7).for_each(|j| matrix[i][j] -= factor * row[j]);
            rhs[i] -= factor * rhs[k];
        }
    }
    let mut x = [0.0; 7];
    for k in (0..7).rev() {
        let known: f64 = (k + 1..7).map(|j| matrix[k][j] * x[j]).sum();
        x[k] = (rhs[k] - known) / matrix[k][k];
    }
    ((0..7).all(|k| matrix[k][k] > 0.0) && x.iter().all(|x| x.is_finite())).then_some(x)
}

/// Root mean square of the nearer distances, each way as much; what found nothing is a diagonal away.
fn residual(pairs: &Pairs) -> f64 {
    let mean = |pairs: &[Option<Pair>]| {
        let mut squares: Vec<f64> = pairs.iter().map(|pair| pair.map_or(1.0, |p| p.squared())).collect();
        squares.sort_by(f64::total_cmp);
        squares.truncate((squares.len() as f64 * TRIMMED) as usize);
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    (0.5 * (mean(&pairs[0]) + mean(&pairs[1]))).sqrt()
}
