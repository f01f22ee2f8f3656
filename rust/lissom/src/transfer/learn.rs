//! Learn: keys that an artist has corrected teach the others how this target moves.
//!
//! ```text
//!     A_v = argmin_A  sum_j  S_r [ w_j |A d_j - e_j|^2 ]_v  +  (lambda tr N_v / 3 + floor) |A|^2
//!         = B_v (N_v + (lambda tr N_v / 3 + floor) I)^-1        B = sum_j S_r [ w_j e_j d_j^T ],  N = sum_j S_r [ w_j d_j d_j^T ]
//!     d'_k = d_k + strength a_v A_v d_k
//! ```
//!
//! `d_j` are displacements of corrected key `j` as it was transferred, `e_j` what the artist has added to them, and
//! `S_r` is a mean over the surface within about `r` (implicit diffusion by the graph Laplacian, which is as positive as
//! a mean is). The change of a key is a linear map of its own motion, regularised towards none: the idea of H. Li, T.
//! Weise, M. Pauly, Example-Based Facial Rigging, ACM Transactions on Graphics 29(4), 2010, whose examples change a
//! template's keys as little as they can. It counts as far as a key moves the same places the same way as a corrected
//! one, and what a key leaves at rest stays at rest. What a key tells is off by a part of its largest motion, so `w_j` is
//! one over the square of that.
//!
//! Whether it holds is asked of the corrected keys themselves: each is foretold by the others, `p_j = A^(j) d_j`, and
//! with means over a wider `R`
//!
//! ```text
//!     a = S_R [sum p.e] / S_R [sum p.p],  at most 1,  times how sure it is, by  S_R [sum p.e]^2 / (S_R [sum p.p] S_R [sum e.e])
//! ```
//!
//! (cross-validation: M. Stone 1974). Where corrections have nothing in common, nothing is learned.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::apply::check;
use super::options::LearnOptions;
use crate::linear::{Factor, Symbolic, SymmetricMatrix};
use crate::matrix::{outer, trace};
use crate::operators::mass::lumped_mass;
use crate::options::OptionSet;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory};

/// `lambda`: what a motion tells of those across it.
const PRIOR: f64 = 0.2;

/// `floor`: a key tells little where it moves less than a tenth of what it does at most.
const FLOOR: f64 = 0.01;

/// `R` over `r`: few keys tell of a place, and what they agree on is to be seen from further away.
const WIDER: f64 = 2.5;

/// What the whole mesh counts against a place, where few keys tell of that.
const ELSEWHERE: f64 = 0.05;

/// Squares of the correlation of what is foretold with what is wanted, up to which nothing and from which all of it is
/// believed.
const DOUBTED: f64 = 0.3;
const BELIEVED: f64 = 0.7;

/// A vertex of no triangle counts as so much of the usual one.
const LEAST_MASS: f64 = 1e-6;

/// A key as the artist wants it.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// Its place among the keys.
    pub key: u32,
    /// (n) positions in the mesh's own units.
    pub pose: Vec<Vec3>,
}

/// What was learned.
#[derive(Debug, Clone)]
pub struct Learned {
    /// (k) sets of positions in the mesh's own units; corrected keys are as given.
    pub poses: Vec<Vec<Vec3>>,
    /// (k) root mean square of what is added to a key over that of its motion; of corrected keys too.
    pub changes: Vec<f64>,
    /// Of each corrected key in turn what part of its correction the others foretell, at most 1; not positive where
    /// they tell nothing of it.
    pub foretold: Vec<f64>,
    /// What is doubtful.
    pub warnings: Vec<String>,
    /// How long all of it took.
    pub time: Duration,
}

/// A corrected key, in unit coordinates: how it was moved, and by how much more it is wanted to move.
struct Told {
    moved: Vec<Vec3>,
    wanted: Vec<Vec3>,
}

/// `N` and `B` at every vertex, of one key or of several.
#[derive(Clone)]
struct Evidence {
    moment: Vec<Mat3>,
    cross: Vec<Mat3>,
}

impl Evidence {
    fn none(n: usize) -> Self {
        Self { moment: vec![Mat3::ZERO; n], cross: vec![Mat3::ZERO; n] }
    }

    fn add(&mut self, other: &Self, sign: f64) {
        let add = |own: &mut [Mat3], other: &[Mat3]| {
            own.iter_mut().zip(other).for_each(|(own, &other)| *own += other * sign);
        };
        add(&mut self.moment, &other.moment);
        add(&mut self.cross, &other.cross);
    }

    /// `A_v`, and how far it is told rather than assumed, 0-1.
    fn response(&self, v: usize) -> (Mat3, f64) {
        let told = trace(self.moment[v]).max(0.0) / 3.0;
        let held = self.moment[v] + Mat3::from_diagonal(Vec3::splat(PRIOR * told + FLOOR));
        (self.cross[v] * held.inverse(), told / (told + FLOOR))
    }
}

/// A mesh with its means.
struct Surface {
    mass: Vec<f64>,
    near: Factor,
    wide: Factor,
}

impl Surface {
    fn new(mesh: &Mesh, reach: f64, job: &Job) -> Result<Self> {
        let mass = lumped_mass(mesh);
        let least = mass.iter().sum::<f64>() / mass.len() as f64 * LEAST_MASS;
        let mean = |radius: f64| {
            let edges = mesh.adjacency().edges().iter().map(|&[a, b]| (a, b, radius * radius));
            let mut matrix = SymmetricMatrix::laplacian(mass.len(), edges);
            mass.iter().enumerate().for_each(|(v, m)| matrix.add_to_diagonal(v, m.max(least)));
            Symbolic::analyse(&matrix)?.factor(&matrix)
        };
        let radius = reach * mesh.diagonal();
        let near = mean(radius)?;
        job.check()?;
        let wide = mean(WIDER * radius)?;
        Ok(Self { near, wide, mass })
    }

    /// `N` and `B` of one key.
    fn evidence(&self, Told { moved, wanted }: &Told) -> Evidence {
        let products = |with: &[Vec3]| -> Vec<Mat3> {
            with.iter().zip(moved).zip(&self.mass).map(|((&e, &d), &m)| outer(e, d) * m).collect()
        };
        let sums = [products(moved), products(wanted)];
        let column = |sums: &[Mat3], c: usize| sums.iter().map(|m| m.col(c)).collect::<Vec<_>>();
        let mut sets: Vec<_> = (0..6).map(|set| column(&sums[set / 3], set % 3)).collect();
        self.near.solve(&mut sets);
        let joined = |set: usize| -> Vec<Mat3> {
            let columns = |v: usize| [0, 1, 2].map(|c| sets[set + c][v]);
            (0..moved.len()).map(columns).map(|[x, y, z]| Mat3::from_cols(x, y, z)).collect()
        };
        let mut own = Evidence { moment: joined(0), cross: joined(3) };
        let peak = own.moment.iter().map(|&m| trace(m)).fold(0.0, f64::max);
        if peak > 0.0 {
            own.moment.iter_mut().chain(&mut own.cross).for_each(|m| *m *= 1.0 / peak);
        }
        own
    }

    /// Foretells a key by `others`: what part of it is, after adding to `sums` what [`Surface::trust`] takes.
    fn foretell(&self, Told { moved, wanted }: &Told, others: &Evidence, sums: &mut [Vec3]) -> f64 {
        let (mut whole, mut gained) = (0.0, 0.0);
        for (v, (&d, &e)) in moved.iter().zip(wanted).enumerate() {
            whole += self.mass[v] * e.length_squared();
            if d != Vec3::ZERO {
                let (response, known) = others.response(v);
                let said = response * d;
                gained += self.mass[v] * (2.0 * said.dot(e) - said.length_squared());
                let sum = Vec3::new(said.dot(e), said.length_squared(), known * e.length_squared());
                sums[v] += sum * self.mass[v];
            }
        }
        if whole > 0.0 { gained / whole } else { 0.0 }
    }

    /// `a_v` times how sure it is, from sums over the keys of `p.e`, `p.p` and `e.e`.
    fn trust(&self, sums: Vec<Vec3>) -> Vec<f64> {
        let total: Vec3 = sums.iter().sum();
        if total.min_element() <= 0.0 {
            return vec![0.0; sums.len()];
        }
        let everywhere = total * (ELSEWHERE / self.mass.iter().sum::<f64>());
        let mut sets = [sums];
        self.wide.solve(&mut sets);
        let [sums] = sets;
        let trust = |sum: Vec3| {
            let [both, said, wanted] = (sum + everywhere).to_array();
            let both = both.max(0.0);
            let sure = both * both / (said * wanted);
            (both / said).min(1.0) * ((sure - DOUBTED) / (BELIEVED - DOUBTED)).clamp(0.0, 1.0)
        };
        sums.into_iter().map(trust).collect()
    }
}

/// Carries what an artist has changed of some of the keys `poses`, (k) sets of (n) positions as they were
/// transferred to `mesh`, over to the others.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for no corrected key, places out of range and keys that are corrected twice,
/// [`Error::InvalidValue`] for options out of range and positions that are not finite or of another number,
/// [`Error::SolveFailed`], [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn learn(
    mesh: &Mesh,
    poses: &[Vec<Vec3>],
    corrected: &[Corrected],
    options: LearnOptions,
    job: &Job,
) -> Result<Learned> {
    let start = Instant::now();
    job.report(0.0, "learn");
    options.check()?;
    check("vertices", poses, mesh, "mesh")?;
    let wanted: Vec<Vec<Vec3>> = corrected.iter().map(|key| key.pose.clone()).collect();
    check("corrected", &wanted, mesh, "mesh")?;
    let places = places(corrected, poses.len())?;
    let (rest, scale, n) = (mesh.vertices(), mesh.frame().scale, mesh.vertices().len());
    memory::check("what corrected keys tell", (2 * size_of::<Mat3>() * n * (corrected.len() + 2)) as u128)?;
    let between = |from: &[Vec3], to: &[Vec3]| -> Vec<Vec3> {
        from.iter().zip(to).map(|(&from, &to)| (to - from) / scale).collect()
    };
    let told = |key: &Corrected| {
        let made = &poses[key.key as usize];
        Told { moved: between(rest, made), wanted: between(made, &key.pose) }
    };
    let told: Vec<Told> = corrected.iter().map(told).collect();
    let surface = Surface::new(mesh, options.reach, job)?;
    let evidence = told.iter().map(|key| job.check().map(|()| surface.evidence(key)));
    let evidence: Vec<Evidence> = evidence.collect::<Result<_>>()?;
    let mut all = Evidence::none(n);
    evidence.iter().for_each(|own| all.add(own, 1.0));
    let mut sums = vec![Vec3::ZERO; n];
    let mut foretold = Vec::new();
    for (key, own) in told.iter().zip(&evidence) {
        job.check()?;
        let mut others = all.clone();
        others.add(own, -1.0);
        foretold.push(surface.foretell(key, &others, &mut sums));
    }
    let alone = corrected.len() == 1;
    let trust = if alone { vec![1.0; n] } else { surface.trust(sums) };
    let response = |v: usize| all.response(v).0 * (options.strength * trust[v]);
    let responses: Vec<Mat3> = (0..n).into_par_iter().map(response).collect();
    let size = |offsets: &[Vec3]| {
        offsets.iter().zip(&surface.mass).map(|(d, m)| m * d.length_squared()).sum::<f64>().sqrt()
    };
    let change = |added: &[Vec3], moved: &[Vec3]| {
        let motion = size(moved);
        if motion > 0.0 { size(added) / motion } else { 0.0 }
    };
    let made = |(k, pose): (usize, &Vec<Vec3>)| {
        if let Some(place) = places[k] {
            let Told { moved, wanted } = &told[place];
            return (corrected[place].pose.clone(), change(wanted, moved));
        }
        let moved = between(rest, pose);
        let added: Vec<Vec3> = responses.iter().zip(&moved).map(|(&response, &d)| response * d).collect();
        let mut pose: Vec<Vec3> = pose.iter().zip(&added).map(|(&p, &more)| p + more * scale).collect();
        mesh.follow(&mut pose);
        (pose, change(&added, &moved))
    };
    let (poses, changes) = poses.par_iter().enumerate().map(made).unzip();
    let told = "a single corrected key: nothing tells whether others are to change as it does";
    let warnings = alone.then(|| told.to_owned()).into_iter().collect();
    job.report(1.0, "learn");
    Ok(Learned { poses, changes, foretold, warnings, time: start.elapsed() })
}

/// Of each of `count` keys which correction is its.
fn places(corrected: &[Corrected], count: usize) -> Result<Vec<Option<usize>>> {
    let refused = |fault| Err(Error::InvalidConstraint(fault));
    if corrected.is_empty() {
        return refused(Fault::new("corrected", "no key is corrected: nothing to learn from"));
    }
    let outside = corrected.iter().map(|key| key.key as usize).filter(|&key| key >= count);
    if let Some(fault) = Fault::at("corrected", format!("key out of range, there are {count}"), outside) {
        return refused(fault);
    }
    let mut places = vec![None; count];
    let mut twice = Vec::new();
    for (i, key) in corrected.iter().enumerate() {
        if places[key.key as usize].replace(i).is_some() {
            twice.push(key.key as usize);
        }
    }
    match Fault::at("corrected", "key corrected twice", twice) {
        Some(fault) => refused(fault),
        None => Ok(places),
    }
}
