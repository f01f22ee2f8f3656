//! Stitch: positions from the edges that every triangle asks for, and rotations refitted to them.
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - R_t s_te |^2
//! ```
//!
//! with the stretched edges `s_te` and the rotations `R_t` that a path or a blend chooses. The unknown is
//! `y = x - line`, how far the shape lies off the straight blend of its shapes:
//!
//! ```text
//!     L y = sum_{corners}  R_t h(s) - h(line),        h(s) = sum w_te s_te  at the corner
//! ```
//!
//! Where nothing turns `y` is zero to the last bit.
//!
//! *Refinement* keeps `s` and takes both as unknown, positions and rotations (Sorkine & Alexa 2007, As-Rigid-As-
//! Possible Surface Modeling): the best `R_t` for given positions is the nearest rotation to `sum x_c h_c(s)^T`,
//! the best positions are the stitch, by the same factor. Rounds are accelerated as in posing (`pose::lbfgs`).

use std::sync::Arc;

use rayon::prelude::*;

use crate::linear::{Columns, ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::stitch::lbfgs::{Lbfgs, dot};
use crate::{Job, Mat3, Mesh, Result, Vec3, rotation};

/// Of each corner of a triangle: `sum w_te e` over the two edges that meet there.
pub(super) type Hats = [Vec3; 3];

/// The factored stitch of one mesh.
#[derive(Debug)]
pub(super) struct Elements {
    pub mesh: Arc<Mesh>,
    pub laplacian: SymmetricMatrix,
    pub system: ConstrainedSystem,
    /// The vertices of each component that nothing holds.
    pub afloat: Vec<Vec<u32>>,
}

/// What one shape asks for.
pub(super) struct Asked<S> {
    /// The stretched edges of a triangle and those on the straight line, as hats.
    pub hats: S,
    pub rotations: Vec<Mat3>,
    /// The straight blend of the shapes, in unit coordinates.
    pub line: Vec<Vec3>,
    /// Of each component afloat, where its centroid is off the straight line; none of them where empty.
    pub drift: Vec<Vec3>,
}

impl Elements {
    /// Factors the stitch with weights `w_te`, opposite each corner. Vertices that are `still` are held.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn new(mesh: Arc<Mesh>, weights: &[[f64; 3]], still: &[bool], job: &Job) -> Result<Self> {
        let (held, afloat) = holds(&mesh, still);
        let edges = mesh
            .triangles()
            .iter()
            .zip(weights)
            .flat_map(|(&[a, b, c], w)| [(b, c, w[0]), (c, a, w[1]), (a, b, w[2])]);
        let laplacian = SymmetricMatrix::laplacian(still.len(), edges);
        let system = ConstrainedSystem::new(&laplacian, Constraints::hard(still.len(), |v| held[v]), job)?;
        Ok(Self { mesh, laplacian, system, afloat })
    }

    /// `y` of each shape, in unit coordinates, after `rounds` of refitting the rotations where they `may_turn`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn stitch<S: Fn(usize) -> (Hats, Hats) + Sync>(
        &self,
        asked: &[Asked<S>],
        rounds: usize,
        may_turn: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Vec<Vec<Vec3>>> {
        let mut shapes = self.lift(asked.iter().map(|a| self.divergence(a, &a.rotations)), job)?;
        if rounds == 0 {
            return Ok(self.finished(asked, shapes));
        }
        let mut memories: Vec<Lbfgs> = asked.iter().map(|_| Lbfgs::default()).collect();
        // The last step of each, by what it may be replaced with, and the energy before it.
        let mut last: Vec<Option<(Vec<Vec3>, f64)>> = asked.iter().map(|_| None).collect();
        for round in 0..rounds {
            let mut rhs = Vec::with_capacity(asked.len());
            for (k, a) in asked.iter().enumerate() {
                job.check()?;
                let (mut b, mut energy) = self.refit(a, &shapes[k], &may_turn);
                if let Some((plain, before)) = last[k].take()
                    && energy > before
                {
                    shapes[k] = plain;
                    memories[k] = Lbfgs::default();
                    (b, energy) = self.refit(a, &shapes[k], &may_turn);
                }
                rhs.push(b);
                last[k] = Some((Vec::new(), energy));
            }
            let stitched = self.lift(rhs.into_iter(), job)?;
            for (k, plain) in stitched.into_iter().enumerate() {
                if round + 1 == rounds {
                    shapes[k] = plain;
                    continue;
                }
                let lifted: Vec<Vec3> = shapes[k].iter().zip(&plain).map(|(&y, &p)| y - p).collect();
                let gradient = self.gradient(&lifted);
                let direction = memories[k].direction(&gradient, &lifted, 1.0);
                shapes[k].iter_mut().zip(direction).for_each(|(y, d)| *y += d);
                if let Some((kept, _)) = &mut last[k] {
                    *kept = plain;
                }
            }
        }
        Ok(self.finished(asked, shapes))
    }

    /// Solves for several right-hand sides at once.
    pub fn lift(&self, rhs: impl ExactSizeIterator<Item = Vec<Vec3>>, job: &Job) -> Result<Vec<Vec<Vec3>>> {
        let (n, count) = (self.laplacian.size(), rhs.len());
        let mut columns = Columns::zeros(n, 3 * count);
        for (block, b) in rhs.enumerate() {
            job.check()?;
            for (v, b) in b.into_iter().enumerate() {
                columns.set_vector(block, v, b);
            }
        }
        let mut y = Columns::zeros(n, 3 * count);
        self.system.solve(&columns, &mut y);
        Ok((0..count).map(|block| y.vectors(block)).collect())
    }

    /// `L y` at the vertices that are free.
    fn gradient(&self, y: &[Vec3]) -> Vec<Vec3> {
        let columns = Columns::from_vectors(y);
        let products: Vec<Vec<f64>> =
            (0..3).into_par_iter().map(|axis| self.laplacian.times(columns.column(axis))).collect();
        let mut gradient = vec![Vec3::ZERO; y.len()];
        for &v in self.system.constraints().free() {
            let v = v as usize;
            gradient[v] = Vec3::new(products[0][v], products[1][v], products[2][v]);
        }
        gradient
    }

    /// The right-hand side of the stitch.
    fn divergence<S: Fn(usize) -> (Hats, Hats) + Sync>(&self, asked: &Asked<S>, turns: &[Mat3]) -> Vec<Vec3> {
        let corners = turns.par_iter().enumerate().map(|(t, &r)| {
            let (stretched, line) = (asked.hats)(t);
            [0, 1, 2].map(|c| r * stretched[c] - line[c])
        });
        self.gather(&corners.collect::<Vec<_>>())
    }

    /// The right-hand side of the stitch with the rotations that fit `line + y` best, and the energy there,
    /// up to a constant.
    fn refit<S: Fn(usize) -> (Hats, Hats) + Sync>(
        &self,
        asked: &Asked<S>,
        y: &[Vec3],
        may_turn: impl Fn(usize) -> bool + Sync,
    ) -> (Vec<Vec3>, f64) {
        let triangles = self.mesh.triangles().par_iter().enumerate();
        let corners: Vec<[Vec3; 3]> = triangles
            .map(|(t, corners)| {
                let (stretched, line) = (asked.hats)(t);
                let mut turn = asked.rotations[t];
                if may_turn(t) {
                    let x = corners.map(|v| asked.line[v as usize] + y[v as usize]);
                    turn = fitted(x, stretched, turn);
                }
                [0, 1, 2].map(|c| turn * stretched[c] - line[c])
            })
            .collect();
        let b = self.gather(&corners);
        // |e(x) - R s|^2 summed is y.L y - 2 y.b but for what does not depend on y: R s has the same weighted
        // length whatever R, and what remains of the line is in the second term.
        let smooth = dot(y, &self.product(y));
        let line = self
            .mesh
            .triangles()
            .par_iter()
            .zip(&corners)
            .map(|(corners, b)| (0..3).map(|c| asked.line[corners[c] as usize].dot(b[c])).sum::<f64>());
        let line: Vec<f64> = line.collect();
        (b.clone(), smooth - 2.0 * dot(y, &b) - 2.0 * line.iter().sum::<f64>())
    }

    fn product(&self, y: &[Vec3]) -> Vec<Vec3> {
        let columns = Columns::from_vectors(y);
        let [x, y, z] = [0, 1, 2].map(|axis| self.laplacian.times(columns.column(axis)));
        (0..x.len()).map(|v| Vec3::new(x[v], y[v], z[v])).collect()
    }

    /// Sums what the corners ask for at the vertices.
    fn gather(&self, corners: &[[Vec3; 3]]) -> Vec<Vec3> {
        let adjacency = self.mesh.adjacency();
        (0..adjacency.vertex_count())
            .into_par_iter()
            .with_min_len(1024)
            .map(|v| {
                let at = adjacency.corners_of(v).iter();
                at.fold(Vec3::ZERO, |sum, c| sum + corners[c.triangle as usize][usize::from(c.corner)])
            })
            .collect()
    }

    fn finished<S>(&self, asked: &[Asked<S>], shapes: Vec<Vec<Vec3>>) -> Vec<Vec<Vec3>> {
        asked.iter().zip(shapes).map(|(a, y)| self.centred(&a.drift, y)).collect()
    }

    /// Moves every component that nothing holds so that its centroid is off its straight line by its `drift`, and welded
    /// vertices with those that they are welded to.
    pub fn centred(&self, drift: &[Vec3], mut y: Vec<Vec3>) -> Vec<Vec3> {
        for (k, vertices) in self.afloat.iter().enumerate() {
            let sum: Vec3 = vertices.iter().map(|&v| y[v as usize]).sum();
            let off = sum / vertices.len() as f64 - drift.get(k).copied().unwrap_or_default();
            for &v in vertices {
                y[v as usize] -= off;
            }
        }
        self.mesh.follow(&mut y);
        y
    }
}

/// The rotation that takes the stretched edges nearest to those of `x`; `near` where no edge has a length.
fn fitted(x: [Vec3; 3], stretched: Hats, near: Mat3) -> Mat3 {
    let outer = |p: Vec3, h: Vec3| Mat3::from_cols(p * h.x, p * h.y, p * h.z);
    // The hats sum to zero, so any origin does.
    let covariance = outer(x[1] - x[0], stretched[1]) + outer(x[2] - x[0], stretched[2]);
    if covariance == Mat3::ZERO { near } else { rotation::nearest_rotation(covariance) }
}

/// Which vertices are held, and the components that nothing but one of their vertices holds, for
/// the time of the solve.
fn holds(mesh: &Mesh, still: &[bool]) -> (Vec<bool>, Vec<Vec<u32>>) {
    let in_triangles = |v: usize| mesh.components().of_vertex(v).is_some();
    let mut held: Vec<bool> = (0..still.len()).map(|v| still[v] || !in_triangles(v)).collect();
    let mut afloat = mesh.components().members();
    afloat.retain(|vertices| vertices.iter().all(|&v| !still[v as usize]));
    for vertices in &afloat {
        held[vertices[0] as usize] = true;
    }
    (held, afloat)
}
