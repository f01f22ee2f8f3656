//! Sparse symmetric matrices, stored as their lower triangle.

use faer::sparse::{SparseColMat, Triplet};

/// A sparse symmetric matrix; only the lower triangle is stored.
#[derive(Debug, Clone)]
pub struct SymmetricMatrix(pub(super) SparseColMat<u32, f64>);

impl SymmetricMatrix {
    /// The n x n matrix with `entries` `(row, column, value)`; those of the same place add up, and an
    /// entry off the diagonal stands for itself and its mirror image, so give it once.
    ///
    /// # Panics
    ///
    /// Where an index is not below `n`: the caller has validated the mesh.
    pub fn from_entries(n: usize, entries: impl IntoIterator<Item = (u32, u32, f64)>) -> Self {
        let triplets: Vec<Triplet<u32, u32, f64>> =
            entries.into_iter().map(|(i, j, value)| Triplet::new(i.max(j), i.min(j), value)).collect();
        Self(SparseColMat::try_new_from_triplets(n, n, &triplets).expect("indices are within the matrix"))
    }

    /// `sum over (i, j, w) of w (e_i - e_j) (e_i - e_j)^T`.
    pub fn laplacian(n: usize, edges: impl Iterator<Item = (u32, u32, f64)>) -> Self {
        // The diagonal is listed first, so that every vertex has its place, also one without edges.
        let mut diagonal = vec![0.0; n];
        let mut entries = Vec::new();
        for (i, j, w) in edges {
            diagonal[i as usize] += w;
            diagonal[j as usize] += w;
            entries.push((i, j, -w));
        }
        let diagonal = (0u32..).zip(diagonal).map(|(i, w)| (i, i, w));
        Self::from_entries(n, diagonal.chain(entries))
    }

    /// Number of rows and columns.
    pub fn size(&self) -> usize {
        self.0.nrows()
    }

    /// The stored entries `(row, column, value)`, row >= column.
    pub fn entries(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        (0..self.size()).flat_map(move |j| {
            let rows = self.0.symbolic().row_idx_of_col_raw(j);
            rows.iter().zip(self.0.val_of_col(j)).map(move |(&i, &value)| (i, j as u32, value))
        })
    }

    /// The product with one column.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size()];
        for (i, j, value) in self.entries() {
            y[i as usize] += value * x[j as usize];
            if i != j {
                y[j as usize] += value * x[i as usize];
            }
        }
        y
    }

    /// Adds to the diagonal, which every row must have.
    pub fn add_to_diagonal(&mut self, row: usize, value: f64) {
        let first = self.0.symbolic().row_idx_of_col_raw(row).first().copied();
        assert_eq!(first, Some(row as u32), "row {row} has no diagonal entry");
        self.0.val_of_col_mut(row)[0] += value;
    }
}
