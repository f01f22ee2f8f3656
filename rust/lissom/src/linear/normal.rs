//! Normal equations of few unknowns, dense: `sum weight (row . x - off)^2` at its least.

/// What is left of a diagonal entry, of itself, where elimination leaves rounding alone.
const OPEN: f64 = 1e-13;

/// Of the matrix the upper triangle, row by row.
pub struct NormalEquations {
    matrix: Vec<f64>,
    rhs: Vec<f64>,
}

impl NormalEquations {
    /// Of so many unknowns; nothing is asked of them yet.
    pub fn new(count: usize) -> Self {
        Self { matrix: vec![0.0; count * count], rhs: vec![0.0; count] }
    }

    /// Asks for `row . x = off`.
    pub fn add(&mut self, row: &[f64], off: f64, weight: f64) {
        let count = row.len();
        for (i, r) in row.iter().enumerate() {
            let scaled = weight * r;
            self.rhs[i] += scaled * off;
            let to = &mut self.matrix[i * count + i..(i + 1) * count];
            to.iter_mut().zip(&row[i..]).for_each(|(to, r)| *to += scaled * r);
        }
    }

    /// Asks for `x_i = value`.
    pub fn add_one(&mut self, i: usize, value: f64, weight: f64) {
        self.matrix[i * self.rhs.len() + i] += weight;
        self.rhs[i] += weight * value;
    }

    /// Asks for what `other` does besides.
    pub fn plus(&mut self, other: &Self) {
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(a, b)| *a += b);
        self.rhs.iter_mut().zip(&other.rhs).for_each(|(a, b)| *a += b);
    }

    /// By elimination; `None` where they leave something open.
    pub fn solve(mut self) -> Option<Vec<f64>> {
        let count = self.rhs.len();
        let least: Vec<f64> = (0..count).map(|k| OPEN * self.matrix[k * count + k]).collect();
        for k in 0..count {
            let (above, below) = self.matrix.split_at_mut((k + 1) * count);
            let row = &above[k * count..];
            for (i, under) in (k + 1..count).zip(below.chunks_mut(count)) {
                let factor = row[i] / row[k];
                under[i..].iter_mut().zip(&row[i..]).for_each(|(u, r)| *u -= factor * r);
                self.rhs[i] -= factor * self.rhs[k];
            }
        }
        let mut x = vec![0.0; count];
        for k in (0..count).rev() {
            let row = &self.matrix[k * count..(k + 1) * count];
            let known: f64 = (k + 1..count).map(|j| row[j] * x[j]).sum();
            x[k] = (self.rhs[k] - known) / row[k];
        }
        let definite = (0..count).all(|k| self.matrix[k * count + k] > least[k]);
        (definite && x.iter().all(|x| x.is_finite())).then_some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_met_in_least_squares() {
        let rows = [[1.0, 2.0, 0.5], [0.3, -1.0, 2.0], [2.0, 0.1, -0.4], [1.0, 1.0, 1.0]];
        let x = [0.7, -1.1, 2.3];
        let mut equations = NormalEquations::new(3);
        let mut more = NormalEquations::new(3);
        for (i, row) in rows.iter().enumerate() {
            let off = row.iter().zip(x).map(|(r, x)| r * x).sum();
            let to = if i < 2 { &mut equations } else { &mut more };
            to.add(row, off, 1.0 + i as f64);
        }
        equations.plus(&more);
        equations.add_one(1, x[1], 3.0);
        let found = equations.solve().unwrap();
        assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        let mut open = NormalEquations::new(3);
        rows[..2].iter().for_each(|row| open.add(row, 1.0, 1.0));
        assert!(open.solve().is_none());
        assert!(NormalEquations::new(2).solve().is_none());
    }
}
