//! Morph: the person of a family of shapes that the target looks like, before anything bends freely.
//!
//! ```text
//!     y(c) = v + sum_k c_k m_k        x = shift + size R y(c)
//!     min over c, R, size, shift      E_P(x) / sum_p along_p  +  s^2 |c|^2
//! ```
//!
//! The modes `m_k` are principal components of measured shapes, as long as these spread, so that `|c|^2` is what a
//! normal distribution says against a person (Blanz & Vetter 1999, A Morphable Model for the Synthesis of 3D Faces).
//! Pulls are looked up as the registration looks them up, from both sides and to planes, and each round makes one
//! Gauss-Newton step in all unknowns at once. The prior lets go as the reach falls (Amberg, Romdhani & Vetter 2007,
//! Optimal Step Nonrigid ICP Algorithms for Surface Registration, do so with stiffness): while one does not know what
//! belongs together, it is an average face that is laid there. What no person of the family is like, is left to the
//! registration, which begins here.

use rayon::prelude::*;

use super::lie::{Lie, is_worth};
use super::look_up::LookUp;
use super::markers::Marker;
use super::pulls::Pull;
use super::side::{Placed, Side};
use crate::linear::NormalEquations;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, rotation};

/// Reach of the closest points, as fractions of the target's diagonal: at the first stage and at the last.
const REACH: [f64; 2] = [0.15, 0.03];

/// ... but not below so many times what a quarter of the vertices is off by at most.
const QUARTILES: f64 = 4.0;

/// The same of `s`: how far off a surface is that is of the family, over the root of how many places of it tell
/// something of their own.
const SPREAD: [f64; 2] = [1e-2, 3e-4];

/// The prior where one knows what belongs together: as much as the equations need to be solved.
const KNOWN: f64 = 1e-10;

/// Stages, and rounds of closest points at each.
const STAGES: usize = 6;
const ROUNDS: usize = 4;

/// Pulls that a step takes, evenly chosen: neighbours tell much the same.
const ENOUGH: usize = 12_000;

/// What all markers count together, beside all other pulls.
const MARKED: f64 = 0.5;

/// Most turn and growth of a step: the equations are linear in both.
const MOST_TURN: f64 = 0.5;
const MOST_GROWTH: f64 = 0.3;

/// Pulls that are summed one after another.
const GRAIN: usize = 256;

/// Unknowns of the similarity: turn, shift, growth.
const OF_LIE: usize = 7;

/// Somebody of a family of shapes.
pub struct Morph {
    /// How much of each mode, in its spreads.
    coefficients: Vec<f64>,
    /// Its vertices, in the source's unit coordinates.
    rest: Vec<Vec3>,
    rotation: Mat3,
    size: f64,
    shift: Vec3,
    /// `m_k` at each vertex in turn, in the source's unit coordinates.
    modes: Vec<Vec3>,
}

/// Refuses modes that are not those of `source`.
///
/// # Errors
///
/// [`Error::InvalidValue`].
pub fn check(modes: &[Vec<Vec3>], source: &Mesh) -> Result<()> {
    let n = source.vertices().len();
    let refuse = |problem: String, bad: Vec<usize>| match Fault::at("modes", problem, bad) {
        Some(fault) => Err(Error::InvalidValue(fault)),
        None => Ok(()),
    };
    let of_others = (0..modes.len()).filter(|&k| modes[k].len() != n).collect();
    refuse(format!("not of the source's {n} vertices"), of_others)?;
    refuse(
        "not finite".into(),
        (0..modes.len()).filter(|&k| modes[k].iter().any(|p| !p.is_finite())).collect(),
    )
}

impl Morph {
    /// The mean person of `modes`, in the source's units, as `lie` says.
    pub fn new(source: &Mesh, modes: &[Vec<Vec3>], lie: &Lie) -> Self {
        let per_unit = 1.0 / source.frame().scale;
        let at = |v: usize| modes.iter().map(move |mode| mode[v] * per_unit);
        Self {
            coefficients: vec![0.0; modes.len()],
            rest: source.rest().to_vec(),
            rotation: lie.turn.unwrap_or(Mat3::IDENTITY),
            size: lie.size,
            shift: lie.shift,
            modes: (0..source.rest().len()).flat_map(at).collect(),
        }
    }

    /// Finds who it is that `target` is most like; by `markers` besides.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`].
    pub fn find(
        &mut self,
        source: &Side,
        target: &Placed,
        markers: &[Marker],
        detour: f64,
        job: &Job,
    ) -> Result<()> {
        let mut look_up = LookUp::new(source, target, detour, false);
        let falling =
            |[from, to]: [f64; 2], stage: usize| from * (to / from).powf(stage as f64 / (STAGES - 1) as f64);
        let mut surface = None;
        for stage in 0..STAGES {
            let off = look_up.find_partners(&self.placed(), job)?;
            let reach = falling(REACH, stage).max(QUARTILES * off);
            for _ in 0..ROUNDS {
                let x = self.placed();
                let placed = Placed::again(source, &x, surface.take());
                let mut pulls = look_up.forth(&placed, 1.0, reach, job)?;
                pulls.extend(look_up.back(&placed, 1.0, reach, job)?);
                surface = Some(placed.surface);
                let step = pulls.len().div_ceil(ENOUGH).max(1);
                let mut pulls: Vec<Pull> = pulls.into_iter().step_by(step).collect();
                let share = MARKED * pulls.iter().map(|pull| pull.along).sum::<f64>() / markers.len() as f64;
                pulls.extend(markers.iter().map(|marker| marker.pull(share)));
                self.step(source.mesh, &pulls, &x, falling(SPREAD, stage).powi(2));
            }
        }
        Ok(())
    }

    /// The person that a target of the same triangles is most like: each vertex belongs to its own like.
    pub fn of_same(source: &Mesh, target: &Mesh, modes: &[Vec<Vec3>]) -> Self {
        let places: Vec<(Vec3, Vec3)> =
            source.rest().iter().copied().zip(target.rest().iter().copied()).collect();
        let mut morph = Self::new(source, modes, &Lie::of(&places, Vec::new(), 0.0));
        let pull = |(v, goal): (usize, &Vec3)| Pull::to_point([v as u32; 3], Vec3::X, *goal, 1.0);
        let pulls: Vec<Pull> = target.rest().iter().enumerate().map(pull).collect();
        let rounds = if modes.is_empty() { 0 } else { 2 * ROUNDS };
        for _ in 0..rounds {
            let x = morph.placed();
            morph.step(source, &pulls, &x, KNOWN);
        }
        morph
    }

    /// Its turn, where that is worth telling, its size on the target, and what is to be added then.
    pub fn lie(&self) -> (Option<Mat3>, f64, Vec3) {
        (Some(self.rotation).filter(|&turn| is_worth(turn)), self.size, self.shift)
    }

    /// Its vertices once turned, in the source's unit coordinates.
    pub fn turned(&self) -> Vec<Vec3> {
        self.rest.iter().map(|&p| self.rotation * p).collect()
    }

    /// Its vertices in the units of `source`, and how much of each mode that is.
    pub fn told(&self, source: &Mesh) -> (Vec<Vec3>, Vec<f64>) {
        if self.coefficients.is_empty() {
            return (source.vertices().to_vec(), Vec::new());
        }
        let mut vertices = self.rest.iter().map(|&p| source.frame().from_unit(p)).collect::<Vec<_>>();
        source.follow(&mut vertices);
        (vertices, self.coefficients.clone())
    }

    /// Where the vertices are on the target.
    fn placed(&self) -> Vec<Vec3> {
        self.rest.iter().map(|&p| self.rotation * p * self.size + self.shift).collect()
    }

    /// One step; `x` are the vertices where they are, `prior` counts `|c|^2`.
    fn step(&mut self, source: &Mesh, pulls: &[Pull], x: &[Vec3], prior: f64) {
        let Some(solution) = self.equations(pulls, x, prior).solve() else { return };
        let turn = rotation::exp(Vec3::from_slice(&solution[..3]).clamp_length_max(MOST_TURN));
        let growth = solution[6].clamp(-MOST_GROWTH, MOST_GROWTH).exp();
        self.rotation = rotation::nearest_rotation(turn * self.rotation);
        self.size *= growth;
        self.shift = turn * self.shift * growth + Vec3::from_slice(&solution[3..6]);
        self.coefficients.iter_mut().zip(&solution[OF_LIE..]).for_each(|(c, step)| *c += step);
        let k = self.coefficients.len();
        for ((p, rest), modes) in self.rest.iter_mut().zip(source.rest()).zip(self.modes.chunks(k)) {
            *p = *rest + modes.iter().zip(&self.coefficients).map(|(m, c)| *m * *c).sum::<Vec3>();
        }
    }

    fn equations(&self, pulls: &[Pull], x: &[Vec3], prior: f64) -> NormalEquations {
        let k = self.coefficients.len();
        let count = OF_LIE + k;
        let whole: f64 = pulls.iter().map(|pull| pull.along).sum();
        let linear = self.rotation * self.size;
        let add = |pulls: &[Pull]| {
            let mut sum = NormalEquations::new(count);
            let (mut row, mut moves) = (vec![0.0; count], vec![Vec3::ZERO; k]);
            for pull in pulls {
                moves.fill(Vec3::ZERO);
                for (&v, weight) in pull.corners.iter().zip(pull.weights.to_array()) {
                    let modes = &self.modes[v as usize * k..(v as usize + 1) * k];
                    if weight != 0.0 {
                        moves.iter_mut().zip(modes).for_each(|(to, &mode)| *to += linear * mode * weight);
                    }
                }
                let (at, off) = (pull.place(x), pull.goal - pull.place(x));
                for (direction, weight) in pull.directions() {
                    let turned = at.cross(direction);
                    row[..3].copy_from_slice(&turned.to_array());
                    row[3..6].copy_from_slice(&direction.to_array());
                    row[6] = direction.dot(at);
                    row[OF_LIE..].iter_mut().zip(&moves).for_each(|(r, m)| *r = direction.dot(*m));
                    sum.add(&row, direction.dot(off), weight / whole);
                }
            }
            sum
        };
        // Each chunk's sum by itself, all in order: the same to the last bit, however many threads there are.
        let parts: Vec<NormalEquations> =
            pulls.par_chunks(pulls.len().div_ceil(64).max(GRAIN)).map(add).collect();
        let mut all = NormalEquations::new(count);
        parts.iter().for_each(|part| all.plus(part));
        // The unknowns are steps.
        (OF_LIE..).zip(&self.coefficients).for_each(|(i, c)| all.add_one(i, -c, prior));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::fit::{FitOptions, fit_correspondence};
    use crate::transfer::testing::nosed_sphere;

    /// A family of heads: longer, wider at the bottom, with a nose that sticks out.
    fn modes(vertices: &[Vec3]) -> Vec<Vec<Vec3>> {
        let of = |mode: fn(Vec3) -> Vec3| vertices.iter().map(|&p| mode(p)).collect();
        let front = |p: Vec3| Vec3::X * (p.x - 0.9).max(0.0);
        vec![of(|p| Vec3::Z * 0.1 * p.z), of(|p| Vec3::Y * 0.1 * p.y * (1.0 - p.z)), of(front)]
    }

    fn person(rings: usize, around: usize, amounts: [f64; 3], map: impl Fn(Vec3) -> Vec3) -> Mesh {
        let (vertices, triangles) = nosed_sphere(rings, around);
        let modes = modes(&vertices);
        let at = |v: usize| vertices[v] + (0..3).map(|k| modes[k][v] * amounts[k]).sum::<Vec3>();
        Mesh::new((0..vertices.len()).map(at).map(map).collect(), triangles).unwrap()
    }

    #[test]
    fn a_person_of_the_family_is_found_whatever_the_triangles_and_the_place() {
        let mean = person(26, 40, [0.0; 3], |p| p);
        for amounts in [[1.0, -0.5, 0.7], [-1.2, 0.8, -0.4]] {
            let turn = rotation::exp(Vec3::new(0.4, -0.3, 0.2));
            let target = person(31, 47, amounts, |p| turn * p * 30.0 + Vec3::splat(7.0));
            let like = person(26, 40, amounts, |p| turn * p * 30.0 + Vec3::splat(7.0));
            let marked: Vec<u32> = vec![1, 300, 517, 811];
            let points = marked.iter().map(|&v| like.vertices()[v as usize]).collect();
            let options = FitOptions { modes: modes(mean.vertices()), points, ..FitOptions::default() };
            let markers: Vec<[u32; 2]> = marked.iter().map(|&v| [v, 0]).collect();
            let fit = fit_correspondence(&mean, &target, Some(&markers), &options, &Job::default()).unwrap();
            let own = person(26, 40, amounts, |p| p);
            let off = fit.rest.iter().zip(own.vertices()).map(|(a, b)| a.distance(*b));
            assert!(off.fold(0.0, f64::max) < 0.03, "{:?}", fit.coefficients);
            let off = fit.fitted_vertices.iter().zip(like.vertices()).map(|(a, b)| a.distance(*b));
            assert!(off.fold(0.0, f64::max) < 0.02 * target.frame().scale);
        }
    }

    #[test]
    fn a_person_of_the_same_triangles_is_found_exactly() {
        let mean = person(12, 20, [0.0; 3], |p| p);
        let options = FitOptions { modes: modes(mean.vertices()), ..FitOptions::default() };
        let target = person(12, 20, [1.0, -2.0, 0.5], |p| p * 3.0 + Vec3::X);
        let fit = fit_correspondence(&mean, &target, None, &options, &Job::default()).unwrap();
        for (found, amount) in fit.coefficients.iter().zip([1.0, -2.0, 0.5]) {
            assert!((found - amount).abs() < 1e-3, "{:?}", fit.coefficients);
        }
    }

    #[test]
    fn modes_of_other_meshes_and_what_is_no_number_are_refused() {
        let mean = person(8, 12, [0.0; 3], |p| p);
        let good = modes(mean.vertices());
        let mut other = good.clone();
        other[1].pop();
        let mut endless = good;
        endless[2][5].y = f64::NAN;
        for (modes, k, problem) in [(other, 1, "not of the source's"), (endless, 2, "not finite")] {
            let options = FitOptions { modes, ..FitOptions::default() };
            let fit = fit_correspondence(&mean, &mean, None, &options, &Job::default());
            let Err(Error::InvalidValue(fault)) = fit else { panic!("not refused") };
            assert_eq!((fault.argument.as_str(), fault.indices.as_slice()), ("modes", [k].as_slice()));
            assert!(fault.problem.contains(problem));
        }
    }
}
