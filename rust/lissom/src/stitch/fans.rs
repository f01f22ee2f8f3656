//! A target matrix per vertex: the edges at each vertex one after another.
//!
//! Local and global step are both sums over the edges at a vertex. With `m_ij` for what the cell of `i` makes of the
//! position of its neighbour `j`, the covariance of a cell is `sum_j (x_j - x_i) m_ij^T`, over the number of cells
//! that an edge is in. In a cell of spokes `m_ij = w_ij (v_j - v_i)`, in one of spokes and rims the sum of the hats at
//! `j` of the triangles beside the edge.

use rayon::prelude::*;

use super::targets::Local;
use crate::geometry::rows::Rows;
use crate::linear::Constraints;
use crate::matrix::{dot, outer};
use crate::operators::hat_gradients_at;
use crate::{Mat3, Mesh, Vec3};

/// Vertices that a thread takes at once.
pub(super) const GRAIN: usize = 1024;

/// The edges at each vertex, at rest.
#[derive(Debug)]
pub(super) struct Fans {
    spokes: Rows<Spoke>,
    /// Of each neighbour, `m_ji`: what its cell makes of the position of `i`.
    pulls: Rows<(u32, Vec3)>,
    /// `sum_j m_ij`.
    total: Vec<Vec3>,
    /// Half the weighted size of the edges at each vertex, at rest.
    sizes: Vec<f64>,
}

/// An edge from `i`, as `i` sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spoke {
    pub neighbour: u32,
    pub weight: f64,
    /// `m_ij`: what the cell of `i` makes of the neighbour's position.
    pub own: Vec3,
}

impl Fans {
    /// Cells of spokes; one weight per edge.
    pub fn of_edges(mesh: &Mesh, weights: &[f64]) -> Self {
        let edges = mesh.adjacency().edges().iter().zip(weights);
        let rest = |v: u32| mesh.rest()[v as usize];
        Self::joining(
            mesh,
            edges.map(|(&[a, b], &w)| (w, [(rest(a) - rest(b)) * w, (rest(b) - rest(a)) * w])),
        )
    }

    /// Cells of spokes and rims; weights `w_te` opposite to each corner.
    pub fn of_corners(mesh: &Mesh, weights: &[[f64; 3]]) -> Self {
        let hats = hat_gradients_at(mesh, weights, mesh.rest());
        let edges = mesh.adjacency().edges().iter().enumerate();
        let edges = edges.map(|(e, ends)| {
            let (mut weight, mut sum) = (0.0, [Vec3::ZERO; 2]);
            for side in mesh.adjacency().sides_of(e) {
                let t = side.triangle as usize;
                for (corner, &v) in mesh.triangles()[t].iter().enumerate() {
                    match ends.iter().position(|&end| end == v) {
                        Some(end) => sum[end] += hats[t][corner],
                        None => weight += weights[t][corner],
                    }
                }
            }
            (weight, sum)
        });
        Self::joining(mesh, edges)
    }

    /// `edges` gives of each edge of the mesh its weight and what a cell around it makes of the position of each end.
    fn joining(mesh: &Mesh, edges: impl Iterator<Item = (f64, [Vec3; 2])>) -> Self {
        let ends = mesh.adjacency().edges();
        let edges: Vec<(f64, [Vec3; 2])> = edges.collect();
        let rest = |v: u32| mesh.rest()[v as usize];
        let (mut sizes, mut total) = (vec![0.0; mesh.rest().len()], vec![Vec3::ZERO; mesh.rest().len()]);
        for (&[a, b], &(weight, [at_a, at_b])) in ends.iter().zip(&edges) {
            let size = 0.5 * weight * rest(b).distance_squared(rest(a));
            sizes[a as usize] += size;
            sizes[b as usize] += size;
            total[a as usize] += at_b;
            total[b as usize] += at_a;
        }
        let spokes = ends.iter().zip(&edges).flat_map(|(&[a, b], &(weight, [at_a, at_b]))| {
            let spoke = |neighbour, own| Spoke { neighbour, weight, own };
            [(a, spoke(b, at_b)), (b, spoke(a, at_a))]
        });
        let pulls = (ends.iter().zip(&edges))
            .flat_map(|(&[a, b], &(_, [at_a, at_b]))| [(a, (b, at_a)), (b, (a, at_b))]);
        let n = total.len();
        Self { spokes: Rows::sort(n, spokes), pulls: Rows::sort(n, pulls), total, sizes }
    }

    /// The edges at a vertex.
    pub fn at(&self, vertex: usize) -> &[Spoke] {
        self.spokes.of(vertex)
    }

    /// What the cells of its neighbours make of the position of a vertex.
    pub fn pulls_at(&self, vertex: usize) -> &[(u32, Vec3)] {
        self.pulls.of(vertex)
    }

    /// Every edge once, with its weight.
    pub fn edges(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        let at = |i: u32| self.at(i as usize).iter().map(move |s| (i, s.neighbour, s.weight));
        (0..self.total.len() as u32).flat_map(at).filter(|(i, j, _)| i < j)
    }

    /// `sum_j m_ij` at a vertex.
    pub fn total(&self, vertex: usize) -> Vec3 {
        self.total[vertex]
    }

    /// Something of every vertex.
    pub fn map<T: Send>(&self, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..self.total.len()).into_par_iter().with_min_len(GRAIN).map(of).collect()
    }

    pub fn divergence(&self, changes: &[Mat3], per_edge: f64) -> Vec<Vec3> {
        self.map(|i| {
            let own = -(changes[i] * self.total[i]);
            let all = self.pulls_at(i).iter().fold(own, |sum, &(j, pull)| sum + changes[j as usize] * pull);
            all * (1.0 / per_edge)
        })
    }

    pub fn gradient(
        &self,
        changes: &[Mat3],
        displacements: &[Vec3],
        constraints: &Constraints,
        per_edge: f64,
    ) -> Vec<Vec3> {
        self.map(|i| {
            if constraints.slot(i as u32).is_none() {
                return Vec3::ZERO;
            }
            let (mut own, mut sum) = (Vec3::ZERO, -(changes[i] * self.total[i]));
            for (spoke, &(j, pull)) in self.at(i).iter().zip(self.pulls_at(i)) {
                own += (displacements[i] - displacements[j as usize]) * spoke.weight;
                sum += changes[j as usize] * pull;
            }
            own - sum * (1.0 / per_edge)
        })
    }

    pub fn covariances(&self, x: &[Vec3], per_edge: f64) -> Vec<Mat3> {
        let own = |i: usize, spoke: &Spoke| outer(x[spoke.neighbour as usize] - x[i], spoke.own);
        self.map(|i| self.at(i).iter().fold(Mat3::ZERO, |sum, s| sum + own(i, s)) * (1.0 / per_edge))
    }

    pub fn local_step(&self, x: &[Vec3], per_edge: f64, pick: impl Fn(usize, Mat3) -> Mat3 + Sync) -> Local {
        let at = |i: usize| {
            let (mut covariance, mut size) = (Mat3::ZERO, 0.0);
            for spoke in self.at(i) {
                let edge = x[spoke.neighbour as usize] - x[i];
                covariance += outer(edge, spoke.own);
                size += spoke.weight * edge.length_squared();
            }
            covariance *= 1.0 / per_edge;
            let target = pick(i, covariance);
            // Each edge is seen from both its ends.
            let size = 0.5 * size + self.sizes[i];
            (target - Mat3::IDENTITY, (size - 2.0 * dot(target, covariance), size))
        };
        let vertices = (0..x.len()).into_par_iter().with_min_len(GRAIN);
        let (changes, parts): (Vec<Mat3>, Vec<(f64, f64)>) = vertices.map(at).unzip();
        // Summed in order, not by the threads, so that results repeat to the last bit.
        let (energy, size) = parts.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        Local { changes, energy, size }
    }
}
