//! `R_t(t)` from the rotations between neighbours.
//!
//! Neighbours `i` and `j` turn against each other by `R_i^T R_j`; at time `t` they shall have turned by a part of that:
//!
//! ```text
//!     R_j(t) = R_i(t) D_ij(t),        D_ij(t) = exp(t log(R_i^T R_j))
//! ```
//!
//! Around a vertex these do not close up, so the rotations are those that meet all of them best, rotation averaging
//! (Govindu 2004, Lie-Algebraic Averaging for Globally Consistent Motion Estimation):
//!
//! ```text
//!     min_R  sum_ij  w_ij (2 (1 - cos a) + sin^2 a)
//! ```
//!
//! with the angles `a` of the misfits `R_j (R_i D_ij)^T`, by steps `R_i <- exp(d_i) R_i`, each a solve with the Laplacian
//! of the dual graph, factored once, from the turns that `branches` chose. For small angles this is their square.
//! Its derivative dies out towards half a turn, where that of the square jumps, so every step, and with it the path, is
//! continuous in time however many triangles fold over. Between neighbours the shortest turn is hardly ever the wrong one, so twists of any number
//! of turns come out whole.

use rayon::prelude::*;

use super::turn::Turn;
use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::{Job, Mat3, Mesh, Result, Vec3, rotation};

/// Steps at most, and the turn in radians below which a step is the last.
const STEPS: usize = 6;
const SMALL: f64 = 1e-7;

/// Angle between neighbours, in radians, from which on they are trusted less.
const CREASE: f64 = 0.5;

/// The dual graph with the rotations between neighbours.
#[derive(Debug)]
pub(super) struct Relative {
    /// Neighbours, `log(R_i^T R_j)` and the weight.
    pairs: Vec<(u32, u32, Vec3, f64)>,
    system: ConstrainedSystem,
}

impl Relative {
    /// Factors the dual graph of `mesh`, whose triangles turn by `ends`; `roots` take their own turn, and `links` join
    /// parts that ride to their hosts.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn new(mesh: &Mesh, ends: &[Mat3], roots: &[u32], links: &[[u32; 2]], job: &Job) -> Result<Self> {
        let pairs = mesh.adjacency().triangle_pairs().chain(links.iter().copied());
        let pairs: Vec<[u32; 2]> = pairs.collect();
        let pairs: Vec<(u32, u32, Vec3, f64)> = pairs
            .into_par_iter()
            .map(|[i, j]| {
                let between = rotation::log(ends[i as usize].transpose() * ends[j as usize]);
                (i, j, between, 1.0 / (1.0 + between.length_squared() / (CREASE * CREASE)))
            })
            .collect();
        let mut root = vec![false; ends.len()];
        roots.iter().for_each(|&t| root[t as usize] = true);
        let edges = pairs.iter().map(|&(i, j, _, weight)| (i, j, weight));
        let laplacian = SymmetricMatrix::laplacian(ends.len(), edges);
        let constraints = Constraints::hard(ends.len(), |t| root[t]);
        let system = ConstrainedSystem::new(&laplacian, constraints, job)?;
        Ok(Self { pairs, system })
    }

    /// The rotations at time `t`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn at(&self, t: f64, turns: &[Turn], job: &Job) -> Result<Vec<Mat3>> {
        let mut now: Vec<Mat3> = turns.par_iter().map(|turn| turn.at(t)).collect();
        let between: Vec<Mat3> = self.pairs.par_iter().map(|pair| rotation::exp(pair.2 * t)).collect();
        for _ in 0..STEPS {
            job.check()?;
            let misfits: Vec<Vec3> = (self.pairs.par_iter().zip(&between))
                .map(|(&(i, j, _, weight), &d)| {
                    slope(now[j as usize] * (now[i as usize] * d).transpose()) * weight
                })
                .collect();
            let mut rhs = vec![Vec3::ZERO; now.len()];
            for (&(i, j, ..), &misfit) in self.pairs.iter().zip(&misfits) {
                rhs[i as usize] += misfit;
                rhs[j as usize] -= misfit;
            }
            let mut step = [vec![Vec3::ZERO; now.len()]];
            self.system.solve(&[rhs], &mut step);
            let [step] = step;
            now.par_iter_mut().zip(&step).for_each(|(r, &d)| *r = rotation::exp(d) * *r);
            if step.iter().all(|d| d.length_squared() < SMALL * SMALL) {
                break;
            }
        }
        Ok(now)
    }
}

/// The axis of a rotation by `a`, times `sin a (1 + cos a) / 2`: a quarter of the derivative of its misfit.
fn slope(r: Mat3) -> Vec3 {
    let cosine = 0.5 * (r.x_axis.x + r.y_axis.y + r.z_axis.z - 1.0);
    0.25 * (1.0 + cosine)
        * Vec3::new(r.y_axis.z - r.z_axis.y, r.z_axis.x - r.x_axis.z, r.x_axis.y - r.y_axis.x)
}
