//! The quadratic energy of the fit and its normal equations.
//!
//! ```text
//!     E(x, q) =  w_S sum_i sum_{j beside i} |Q_i - Q_j|^2  +  w_I sum_i |Q_i - I|^2
//!     Q_i     =  sum_c x_c grad phi_c^T  +  q_i n_i^T
//! ```
//!
//! `q_i = Q_i n_i` stands for the fourth vertex of triangle `i` (Sumner & Popović 2004): it is the edge
//! from the triangle to that vertex, over its rest length. Unlike in stitching it cannot be
//! eliminated triangle by triangle, since smoothness couples it to the neighbours; but written so,
//! it is one more unknown that costs the factorization little.
//!
//! With `B_i = [grad phi_0, grad phi_1, grad phi_2, n_i]` (3 x 4) and `u_i` the four unknowns of a
//! triangle, `Q_i^T = B_i u_i`, so the normal matrix is assembled from the 4 x 4 blocks `B_i^T B_i` and
//! `-B_i^T B_j`; no rectangular matrix is formed. Fixed vertices are eliminated exactly on the way.
//!
//! The three axes share this matrix, and with it a factor, as long as nothing couples them.

use rayon::prelude::*;

use crate::geometry::rows::Rows;
use crate::linear::{Factor, Symbolic, SymmetricMatrix};
use crate::matrix::outer;
use crate::operators::hat_gradients;
use crate::{Mat3, Mesh, Result, Vec3};

/// Triangles with less than this fraction of their longest edge squared as area count as having it:
/// the gradients of slivers would drown all others.
const LEAST_AREA: f64 = 1e-3;

/// Elements a task takes at least.
const GRAIN: usize = 4096;

/// Weights of the energy's terms.
#[derive(Debug, Clone, Copy)]
pub struct TermWeights {
    /// `w_S`
    pub smoothness: f64,
    /// `w_I`
    pub identity: f64,
}

/// The energy of a mesh, some of whose vertices are fixed. Its unknowns are listed as a vector for every vertex, the
/// fixed ones included, then one for every triangle.
pub struct Energy<'a> {
    mesh: &'a Mesh,
    size: f64,
    weights: TermWeights,
    elements: Vec<Element>,
    neighbours: Rows<u32>,
    /// Place of each unknown among those that are free; `None` where it is fixed.
    slot: Vec<Option<u32>>,
    matrix: SymmetricMatrix,
    symbolic: Symbolic,
    /// `A_i`
    reference: Vec<Mat3>,
}

/// The unknowns of a triangle, and the vectors that `B` multiplies them with.
type Element = [(u32, Vec3); 4];

fn elements(mesh: &Mesh, size: f64) -> Vec<Element> {
    let n = mesh.vertices().len() as u32;
    let hats = hat_gradients(mesh);
    (0..mesh.triangles().len())
        .map(|t| {
            let corners = mesh.triangles()[t];
            let [a, b, c] = corners.map(|v| mesh.rest()[v as usize]);
            let longest =
                (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            let area = mesh.areas()[t].max(LEAST_AREA * longest).max(f64::MIN_POSITIVE);
            let gradient = |k: usize| (corners[k], hats[t][k] / (area * size));
            [gradient(0), gradient(1), gradient(2), (n + t as u32, mesh.normals()[t])]
        })
        .collect()
}

impl<'a> Energy<'a> {
    /// Assembles the energy of `mesh`, whose rest positions are `mesh.rest()` times `size`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where the system is too large to order.
    pub fn new(
        mesh: &'a Mesh,
        size: f64,
        weights: TermWeights,
        is_fixed: impl Fn(usize) -> bool,
    ) -> Result<Self> {
        let (n, m) = (mesh.vertices().len(), mesh.triangles().len());
        let mut slot = vec![None; n + m];
        let free = (0..n + m).filter(|&u| u >= n || !is_fixed(u));
        let unknowns = (0u32..).zip(free).fold(0, |_, (place, u)| {
            slot[u] = Some(place);
            place + 1
        });
        // The diagonal is listed in full, for the weights to come.
        let mut entries: Vec<(u32, u32, f64)> = (0..unknowns).map(|u| (u, u, 0.0)).collect();
        let mut add = |a: u32, b: u32, value: f64| {
            if let (Some(i), Some(j)) = (slot[a as usize], slot[b as usize]) {
                entries.push((i, j, value));
            }
        };

        let elements = elements(mesh, size);
        let pairs: Vec<[u32; 2]> = mesh.adjacency().triangle_pairs().collect();
        // Each pair of neighbours is summed from either side.
        let smoothness = 2.0 * weights.smoothness;
        let mut own = vec![weights.identity; m];
        for &[i, j] in &pairs {
            own[i as usize] += smoothness;
            own[j as usize] += smoothness;
            for (a, row) in elements[i as usize] {
                for (b, column) in elements[j as usize] {
                    // The mirrored block -B_j^T B_i meets this one on the diagonal.
                    let twice = if a == b { 2.0 } else { 1.0 };
                    add(a, b, -twice * smoothness * row.dot(column));
                }
            }
        }
        for (element, weight) in elements.iter().zip(own) {
            for (k, &(a, row)) in element.iter().enumerate() {
                for &(b, column) in &element[k..] {
                    add(a, b, weight * row.dot(column));
                }
            }
        }
        let matrix = SymmetricMatrix::from_entries(unknowns as usize, entries);
        let symbolic = Symbolic::analyse(&matrix)?;
        let neighbours = Rows::sort(m, pairs.iter().flat_map(|&[i, j]| [(i, j), (j, i)]));
        let reference = vec![Mat3::IDENTITY; m];
        Ok(Self { mesh, size, weights, elements, neighbours, slot, matrix, symbolic, reference })
    }

    /// The unknowns of the mesh at rest.
    pub fn rest(&self) -> Vec<Vec3> {
        let positions = self.mesh.rest().iter().map(|&p| p * self.size);
        positions.chain(self.mesh.normals().iter().copied()).collect()
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// Factors the normal matrix with `pull`, one for every vertex, added to its diagonal.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], see [`Symbolic::factor`].
    pub fn factor(&self, pull: &[f64]) -> Result<Factor> {
        let mut matrix = self.matrix.clone();
        for (slot, &weight) in self.slot.iter().zip(pull) {
            if let Some(row) = slot {
                matrix.add_to_diagonal(*row as usize, weight);
            }
        }
        self.symbolic.factor(&matrix)
    }

    /// Takes the changes at `u` as what triangles keep to, ...
    pub fn refer(&mut self, u: &[Vec3]) {
        self.reference = self.changes(u);
    }

    /// `Q_i`
    fn changes(&self, u: &[Vec3]) -> Vec<Mat3> {
        let change = |element: &Element| element.iter().map(|&(a, row)| outer(u[a as usize], row)).sum();
        self.elements.par_iter().with_min_len(GRAIN).map(change).collect()
    }

    /// Half the gradient of `E` at `u`; by fixed unknowns too.
    pub fn gradient(&self, u: &[Vec3]) -> Vec<Vec3> {
        self.transposed(&self.changes(u), |i| self.reference[i])
    }

    /// Half the Hessian of `E` times `d`.
    pub fn curvature(&self, d: &[Vec3]) -> Vec<Vec3> {
        self.transposed(&self.changes(d), |_| Mat3::ZERO)
    }

    fn transposed(&self, changes: &[Mat3], reference: impl Fn(usize) -> Mat3 + Sync) -> Vec<Vec3> {
        let TermWeights { smoothness, identity } = self.weights;
        let of = |(i, &own): (usize, &Mat3)| {
            let around: Mat3 = self.neighbours.of(i).iter().map(|&j| own - changes[j as usize]).sum();
            (own - reference(i)) * identity + around * (2.0 * smoothness)
        };
        let weighted: Vec<Mat3> = changes.par_iter().enumerate().with_min_len(GRAIN).map(of).collect();
        let at_vertex = |v: usize| {
            let corners = self.mesh.adjacency().corners_of(v).iter();
            let at = |triangle: u32, k: u8| {
                weighted[triangle as usize] * self.elements[triangle as usize][k as usize].1
            };
            corners.map(|c| at(c.triangle, c.corner)).sum::<Vec3>()
        };
        let at_triangle = |(t, matrix): (usize, &Mat3)| *matrix * self.elements[t][3].1;
        let vertices = (0..self.mesh.vertices().len()).into_par_iter().with_min_len(GRAIN).map(at_vertex);
        vertices.chain(weighted.par_iter().enumerate().with_min_len(GRAIN).map(at_triangle)).collect()
    }

    /// The solution of the factored matrix for the right-hand side `r`; zero for fixed unknowns.
    pub fn solve(&self, factor: &Factor, r: &[Vec3]) -> Vec<Vec3> {
        let free = self.slot.iter().zip(r).filter(|(slot, _)| slot.is_some()).map(|(_, &r)| r);
        let mut sets = [free.collect::<Vec<_>>()];
        factor.solve(&mut sets);
        let [solved] = sets;
        self.slot.iter().map(|slot| slot.map_or(Vec3::ZERO, |row| solved[row as usize])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mat3;
    use crate::transfer::testing::bumpy_grid;
    use faer::prelude::Solve;

    /// `V^-1` of Sumner & Popović (2004), with the fourth vertex
    /// `v_0 + c / sqrt |c|`, `c` the cross product of the edges, written out.
    fn inverse_frame(corners: [Vec3; 3]) -> Mat3 {
        let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
        let cross = a.cross(b);
        Mat3::from_cols(a, b, cross / cross.length().sqrt()).inverse()
    }

    /// The rows of `Q_t^T` in the n + m unknowns, dense.
    fn gradient_rows(mesh: &Mesh, size: f64, t: usize) -> [Vec<f64>; 3] {
        let n = mesh.vertices().len();
        let corners = mesh.triangles()[t];
        let inverse = inverse_frame(corners.map(|v| mesh.rest()[v as usize] * size));
        std::array::from_fn(|axis| {
            let mut row = vec![0.0; n + mesh.triangles().len()];
            let column = inverse.col(axis);
            row[corners[0] as usize] = -column.element_sum();
            row[corners[1] as usize] = column.x;
            row[corners[2] as usize] = column.y;
            row[n + t] = column.z;
            row
        })
    }

    #[test]
    fn the_minimum_is_that_of_the_dense_system_with_explicit_fourth_vertices() {
        let (mesh, size, weights) = (bumpy_grid(4), 1.7, TermWeights { smoothness: 1.0, identity: 0.05 });
        let (n, m) = (mesh.vertices().len(), mesh.triangles().len());
        let mut fixed = vec![None; n];
        fixed[0] = Some(Vec3::new(-0.9, -0.8, 0.1));
        fixed[7] = Some(Vec3::new(0.2, 0.3, 0.4));
        let pull: Vec<f64> = (0..n).map(|v| 0.1 * (v % 3) as f64).collect();
        let points: Vec<Vec3> = mesh.rest().iter().map(|&v| v * 2.0 + Vec3::new(0.0, 0.1, v.x)).collect();

        let energy = Energy::new(&mesh, size, weights, |v| fixed[v].is_some()).unwrap();
        let mut x = energy.rest();
        x[0] = fixed[0].unwrap();
        x[7] = fixed[7].unwrap();
        let mut residual = energy.gradient(&x);
        for v in 0..n {
            residual[v] += (x[v] - points[v]) * pull[v];
        }
        let step = energy.solve(&energy.factor(&pull).unwrap(), &residual);
        // Its Hessian takes the step to the gradient.
        let mut image = energy.curvature(&step);
        image.iter_mut().zip(&step).zip(&pull).for_each(|((image, &step), pull)| *image += step * *pull);
        let free = |u: &usize| *u >= n || fixed[*u].is_none();
        for u in (0..n + m).filter(free) {
            assert!((image[u] - residual[u]).length() < 1e-9, "unknown {u}");
        }
        x.iter_mut().zip(step).for_each(|(x, step)| *x -= step);

        // Least squares A u = b, one row per equation, each weighted by the root of its weight.
        let rows: Vec<[Vec<f64>; 3]> = (0..m).map(|t| gradient_rows(&mesh, size, t)).collect();
        let mut equations: Vec<(Vec<f64>, Vec3)> = Vec::new();
        for t in 0..m {
            for (axis, row) in rows[t].iter().enumerate() {
                let root = weights.identity.sqrt();
                equations.push((row.iter().map(|r| r * root).collect(), Vec3::AXES[axis] * root));
                for [i, j] in mesh.adjacency().triangle_pairs() {
                    if i as usize == t || j as usize == t {
                        // Once from either side, as the double sum of Sumner & Popović (2004) has it.
                        let root = weights.smoothness.sqrt();
                        let (a, b) = (&rows[i as usize][axis], &rows[j as usize][axis]);
                        equations.push((a.iter().zip(b).map(|(a, b)| (a - b) * root).collect(), Vec3::ZERO));
                    }
                }
            }
        }
        for v in 0..n {
            let mut row = vec![0.0; n + m];
            row[v] = pull[v].sqrt();
            equations.push((row, points[v] * pull[v].sqrt()));
        }
        let free: Vec<usize> = (0..n + m).filter(|&u| u >= n || fixed[u].is_none()).collect();
        let a = faer::Mat::from_fn(equations.len(), free.len(), |i, j| equations[i].0[free[j]]);
        let b = faer::Mat::from_fn(equations.len(), 3, |i, axis| {
            let known: f64 = (0..n).filter_map(|v| fixed[v].map(|p| equations[i].0[v] * p[axis])).sum();
            equations[i].1[axis] - known
        });
        let dense = (a.transpose() * &a).partial_piv_lu().solve(a.transpose() * &b);
        for (row, &v) in free.iter().enumerate().take_while(|(_, v)| **v < n) {
            let expected = Vec3::new(dense[(row, 0)], dense[(row, 1)], dense[(row, 2)]);
            assert!((x[v] - expected).length() < 1e-10, "vertex {v}: {} against {expected}", x[v]);
        }
        assert_eq!((Some(x[0]), Some(x[7])), (fixed[0], fixed[7]));
    }
}
