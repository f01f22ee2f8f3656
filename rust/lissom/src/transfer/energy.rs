//! The quadratic energy of the fit and its normal equations.
//!
//! ```text
//!     E(x, q) =  w_S sum_{i,j adjacent} |Q_i - Q_j|^2  +  w_I sum_i |Q_i - I|^2  +  sum_v w_v |x_v - c_v|^2
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

use crate::linear::{Columns, Factor, Symbolic, SymmetricMatrix};
use crate::operators::hat_gradients;
use crate::{Mesh, Result, Vec3};

/// Triangles with less than this fraction of their longest edge squared as area count as having it:
/// the gradients of slivers would drown all others.
const LEAST_AREA: f64 = 1e-3;

/// Weights of the energy's constant terms.
#[derive(Debug, Clone, Copy)]
pub struct Weights {
    /// `w_S`
    pub smoothness: f64,
    /// `w_I`
    pub identity: f64,
}

/// The normal equations of `E` with the fixed vertices eliminated; of the closest-point term only
/// the weights, which change from step to step and touch nothing but the diagonal.
pub struct Energy {
    vertices: usize,
    /// Place of each vertex among the unknowns; `None` where it is fixed. Fourth vertices follow.
    slot: Vec<Option<u32>>,
    matrix: SymmetricMatrix,
    rhs: Vec<Vec3>,
    symbolic: Symbolic,
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

impl Energy {
    /// Assembles the energy of `mesh`, whose rest positions are `mesh.rest()` times `size`.
    ///
    /// `fixed` holds the position of every vertex that is given.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where the system is too large to order.
    pub fn new(mesh: &Mesh, size: f64, weights: Weights, fixed: &[Option<Vec3>]) -> Result<Self> {
        let (n, m) = (mesh.vertices().len(), mesh.triangles().len());
        let mut slot = vec![None; n + m];
        let free = (0..n + m).filter(|&u| u >= n || fixed[u].is_none());
        let unknowns = (0u32..).zip(free).fold(0, |_, (place, u)| {
            slot[u] = Some(place);
            place + 1
        });
        let mut rhs = vec![Vec3::ZERO; unknowns as usize];
        // The diagonal is listed in full, for the weights to come.
        let mut entries: Vec<(u32, u32, f64)> = (0..unknowns).map(|u| (u, u, 0.0)).collect();
        let mut add = |a: u32, b: u32, value: f64| match (slot[a as usize], slot[b as usize]) {
            (Some(i), Some(j)) => entries.push((i, j, value)),
            (Some(i), None) => rhs[i as usize] -= fixed[b as usize].unwrap_or_default() * value,
            (None, Some(j)) => rhs[j as usize] -= fixed[a as usize].unwrap_or_default() * value,
            (None, None) => {}
        };

        let elements = elements(mesh, size);
        let mut own = vec![weights.identity; m];
        for [i, j] in mesh.adjacency().triangle_pairs() {
            own[i as usize] += weights.smoothness;
            own[j as usize] += weights.smoothness;
            for (a, row) in elements[i as usize] {
                for (b, column) in elements[j as usize] {
                    // The mirrored block -B_j^T B_i meets this one on the diagonal.
                    let twice = if a == b { 2.0 } else { 1.0 };
                    add(a, b, -twice * weights.smoothness * row.dot(column));
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
        for &(a, row) in elements.iter().flatten() {
            if let Some(i) = slot[a as usize] {
                rhs[i as usize] += row * weights.identity;
            }
        }
        let matrix = SymmetricMatrix::from_entries(unknowns as usize, entries);
        let symbolic = Symbolic::analyse(&matrix)?;
        Ok(Self { vertices: n, slot, matrix, rhs, symbolic })
    }

    /// Factors the normal matrix with closest-point weights `pull`, one per vertex.
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

    /// The positions of least energy, for closest points `points` pulled with the weights that
    /// `factor` was made with. Fixed positions in `x` stay as they are.
    pub fn minimise(&self, factor: &Factor, pull: &[f64], points: &[Vec3], x: &mut [Vec3]) {
        let mut columns = Columns::from_vectors(&self.rhs);
        for v in 0..self.vertices {
            if let Some(row) = self.slot[v] {
                columns.set_vector(0, row as usize, self.rhs[row as usize] + points[v] * pull[v]);
            }
        }
        factor.solve(&mut columns);
        let solved = columns.vectors(0);
        for (position, slot) in x.iter_mut().zip(&self.slot) {
            if let Some(row) = slot {
                *position = solved[*row as usize];
            }
        }
    }

    /// Number of values in a factor.
    pub fn factor_size(&self) -> usize {
        self.symbolic.factor_size()
    }
}
