//! Laplacian editing with implicitly fitted transformations (thesis of S. Zhou 2008, 2.3-2.4; Sorkine,
//! Cohen-Or, Lipman, Alexa, Rössl & Seidel 2004, Laplacian Surface Editing).
//!
//! ```text
//!     min_x  sum_i  | (A x)_i - T_i(x) delta_i |^2  +  w^2 sum_{i in H} | x_i - u_i |^2      delta = A v
//!     T_i = s I + [h]x  =  argmin  sum_{j in i and its neighbours}  | x_j - T_i v_j - t |^2
//! ```
//!
//! The details turn and grow with the surface, as far as a linear map can tell: `s I + [h]x` is a rotation
//! with a uniform scale for small turns, and swells by `1 / cos` for larger ones. The translation `t` is
//! free in the fit, as in Sorkine et al. and unlike equation 2-11, which depends on the origin.
//!
//! With `p_j = v_j - mean`, `q = sum |p_j|^2` and `K = sum [p_j]x^T [p_j]x` the fit is
//! `s = sum p_j . x_j / q`, `h = K^-1 sum p_j x x_j`: scale and turn do not mix. So the term of vertex `i` is
//! linear, `sum_j B_ij x_j` with 3 x 3 blocks `B_ij = a_ij I - delta p_j^T / q + [delta]x K^-1 [p_j]x`. It
//! vanishes for `x = v`, where `T_i = I`, hence the unknown may as well be the displacement `d = x - v`.
//! Without scale, `s = 1`, the second part of `B_ij` is left out.
//!
//! The normal matrix, 3n x 3n, has the blocks `sum_i B_ij^T B_ik`: two rings wide, and assembled from them
//! directly, block column by block column (thesis 2.4.2).

use rayon::prelude::*;

use super::goal::Goal;
use super::laplacian::{LaplacianWeights, operator};
use super::method::Method;
use super::region::Region;
use super::responses::{Linear, Response, minima};
use crate::linear::{ConstrainedSystem, SplitMatrix, SymmetricMatrix, long_rows};
use crate::matrix::{cross, outer};
use crate::operators::graph::graph_laplacian;
use crate::options::options;
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// Added to `K`, relative to its trace. Where a vertex and its neighbours lie on a line, turns about it
/// cannot be told, and are none.
const LINE: f64 = 1e-12;

/// Weight of the edges of the displacement where the constraints leave a turn or a scale open, relative to
/// the largest entry of the matrix: of all poses it picks one that moves as little as it may.
const AMBIGUOUS: f64 = 1e-8;

options! {
    /// Options of fitted Laplacian editing. Uniform weights are the thesis's choice: its `delta` also has a part
    /// along the surface, which tells turns where the surface is flat, where the cotangent one vanishes.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// How much each neighbour of a vertex counts.
        pub weights: LaplacianWeights = LaplacianWeights::Uniform,
        /// Let details grow and shrink as they turn: for handles that scale; large turns swell.
        pub scale: bool = true,
    }
}

/// Binds the method to a region, with precomputed responses.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Linear::new(LaplacianFitted::new(region, options, job)?)))
}

/// Fitted Laplacian editing bound to a region.
#[derive(Debug)]
pub struct LaplacianFitted {
    system: ConstrainedSystem,
    rows: Vec<Row>,
    /// The edges, weighed, where the constraints leave something open.
    edges: Option<SymmetricMatrix>,
}

/// Block row `i`: `(j, B_ij)`, ascending.
type Row = Vec<(u32, Mat3)>;

impl LaplacianFitted {
    /// Assembles and factors the normal matrix.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where it cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let rows = rows(mesh, options);
        let mut matrix = normal_matrix(&rows)?;
        let edges = region.is_ambiguous().then(|| {
            let edges = graph_laplacian(mesh).of_axes();
            edges.combine(AMBIGUOUS * matrix.sparse.largest(), &edges, 0.0)
        });
        if let Some(edges) = &edges {
            matrix.sparse = matrix.sparse.combine(1.0, edges, 1.0);
        }
        let system = ConstrainedSystem::of_split_blocks(&matrix, region.constraints(), job)?;
        Ok(Self { system, rows, edges })
    }

    /// `B^T (B x)`.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut product = match &self.edges {
            Some(edges) => edges.times(x),
            None => vec![0.0; x.len()],
        };
        for row in &self.rows {
            let at = |j: u32| 3 * j as usize..3 * j as usize + 3;
            let sum: Vec3 = row.iter().map(|&(j, b)| b * Vec3::from_slice(&x[at(j)])).sum();
            for &(j, b) in row {
                let part = b.transpose() * sum;
                product[at(j)].iter_mut().zip(part.to_array()).for_each(|(y, part)| *y += part);
            }
        }
        product
    }
}

fn rows(mesh: &Mesh, options: &Options) -> Vec<Row> {
    let (laplacian, squares) = operator(mesh, options.weights);
    let rest = mesh.rest();
    let rows = laplacian.rows();
    (squares.into_par_iter().enumerate())
        .map(|(i, square)| fit(rest, rows.of(i), square.sqrt(), options.scale))
        .collect()
}

/// `B_ij` of the row `scale a_ij`.
fn fit(rest: &[Vec3], row: &[(u32, f64)], scale: f64, grow: bool) -> Row {
    let mean = row.iter().map(|&(j, _)| rest[j as usize]).sum::<Vec3>() / row.len() as f64;
    let arm = |j: u32| rest[j as usize] - mean;
    let delta: Vec3 = row.iter().map(|&(j, a)| arm(j) * (a * scale)).sum();
    let q: f64 = row.iter().map(|&(j, _)| arm(j).length_squared()).sum();
    if q == 0.0 {
        return row.iter().map(|&(j, a)| (j, Mat3::IDENTITY * (a * scale))).collect();
    }
    let scatter = row.iter().fold(Mat3::ZERO, |sum, &(j, _)| sum + outer(arm(j), arm(j))) * (1.0 / q);
    let turn = (Mat3::IDENTITY * (1.0 + LINE) - scatter).inverse() * (1.0 / q);
    let turned = cross(delta) * turn;
    let grown = if grow { delta * (1.0 / q) } else { Vec3::ZERO };
    row.iter()
        .map(|&(j, a)| {
            let p = arm(j);
            (j, Mat3::IDENTITY * (a * scale) - outer(grown, p) + turned * cross(p))
        })
        .collect()
}

/// Blocks `sum_i B_ij^T B_ik`, long rows apart.
fn normal_matrix(rows: &[Row]) -> Result<SplitMatrix> {
    let long = long_rows(&rows.iter().map(Vec::len).collect::<Vec<_>>());
    let length = |&(i, _): &(u32, Mat3)| if long[i as usize] { 3 } else { 3 * rows[i as usize].len() };
    SymmetricMatrix::weigh(3 * rows.len(), |j| rows[j / 3].iter().map(length).sum())?;
    let mut sums: Vec<Mat3> = vec![Mat3::ZERO; rows.len()];
    let mut reached = vec![false; rows.len()];
    let sparse = SymmetricMatrix::from_blocks(rows.len(), |k, column| {
        // The diagonal block comes always.
        reached[k as usize] = true;
        let mut ring: Vec<u32> = vec![k];
        for &(i, _) in rows[k as usize].iter().filter(|(i, _)| !long[*i as usize]) {
            let row = &rows[i as usize];
            let Ok(place) = row.binary_search_by_key(&k, |&(j, _)| j) else { continue };
            let right = row[place].1;
            for &(j, left) in row.iter().filter(|(j, _)| *j >= k) {
                if !std::mem::replace(&mut reached[j as usize], true) {
                    ring.push(j);
                }
                sums[j as usize] += left.transpose() * right;
            }
        }
        ring.sort_unstable();
        for j in ring {
            column.push((j, std::mem::replace(&mut sums[j as usize], Mat3::ZERO)));
            reached[j as usize] = false;
        }
    });
    let apart = rows.iter().zip(&long).filter(|(_, long)| **long).flat_map(|(row, _)| {
        [0, 1, 2].map(|axis| {
            let entries =
                row.iter().flat_map(|&(j, b)| [0, 1, 2].map(|a| (3 * j + a, b.col(a as usize)[axis])));
            (1.0, entries.collect())
        })
    });
    Ok(SplitMatrix::new(sparse, apart.collect()))
}

impl Response for LaplacianFitted {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![&self.system]
    }

    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3> {
        self.displacements_of(region, std::slice::from_ref(goal)).swap_remove(0)
    }

    fn displacements_of(&self, _region: &Region, goals: &[Goal]) -> Vec<Vec<Vec3>> {
        minima(&self.system, goals, |x| self.product(x))
    }

    fn axes_couple(&self) -> bool {
        true
    }
}
