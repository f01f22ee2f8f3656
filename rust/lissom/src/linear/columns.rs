//! A block of right-hand sides or unknowns: dense columns, one after another.

use crate::Vec3;

/// A dense matrix, column by column; three columns make one set of positions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Columns {
    rows: usize,
    data: Vec<f64>,
}

impl Columns {
    /// `rows` x `columns` zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, data: vec![0.0; rows * columns] }
    }

    /// Three columns x, y, z per block, one vector per row.
    pub fn side_by_side<'a>(rows: usize, blocks: impl Iterator<Item = &'a [Vec3]>) -> Self {
        let axes = blocks.flat_map(|block| [0, 1, 2].map(|a| block.iter().map(move |v| v[a])));
        Self { rows, data: axes.flatten().collect() }
    }

    /// One column per block, of three rows x, y, z per vector.
    pub fn interleaved<'a>(rows: usize, blocks: impl Iterator<Item = &'a [Vec3]>) -> Self {
        Self { rows: 3 * rows, data: blocks.flatten().flat_map(Vec3::to_array).collect() }
    }

    /// The vectors of one column that has three rows x, y, z per vector.
    pub fn interleaved_vectors(&self, column: usize) -> Vec<Vec3> {
        self.column(column).chunks_exact(3).map(Vec3::from_slice).collect()
    }

    /// The vectors of columns `3 block`, `3 block + 1`, `3 block + 2`.
    pub fn vectors(&self, block: usize) -> Vec<Vec3> {
        let [x, y, z] = [0, 1, 2].map(|a| self.column(3 * block + a));
        (0..self.rows).map(|i| Vec3::new(x[i], y[i], z[i])).collect()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.data.len().checked_div(self.rows).unwrap_or(0)
    }

    /// One column.
    pub fn column(&self, index: usize) -> &[f64] {
        &self.data[index * self.rows..(index + 1) * self.rows]
    }

    /// One column, to write.
    pub fn column_mut(&mut self, index: usize) -> &mut [f64] {
        &mut self.data[index * self.rows..(index + 1) * self.rows]
    }

    /// All values, column by column.
    pub fn data_mut(&mut self) -> &mut [f64] {
        &mut self.data
    }
}
