//! `min_x  x^T A x - 2 b^T x  +  sum_soft w |x_v - c_v|^2` with the fixed rows of `x` given.
//!
//! Fixed unknowns are eliminated exactly: `A_ff x_f = b_f - A_fc x_c`.

use rayon::prelude::*;

use super::apart::{Correction, SplitMatrix};
use super::columns::Columns;
use super::constraints::Constraints;
use super::factor::{Factor, Symbolic};
use super::lanes::{LANES, Lanes};
use super::matrix::SymmetricMatrix;
use crate::{Error, Job, Result, Vec3};

/// A symmetric system with constraints, factored.
#[derive(Debug)]
pub struct ConstrainedSystem {
    constraints: Constraints,
    symbolic: Symbolic,
    factor: Factor,
    /// Entries that couple a free row to a fixed vertex: (slot, vertex, value).
    coupling: Vec<(u32, u32, f64)>,
    /// Where rows are kept apart.
    correction: Option<Correction>,
}

impl ConstrainedSystem {
    /// Eliminates the constraints from `matrix` and factors the rest.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], [`crate::Error::OutOfMemory`], see [`Symbolic::factor`];
    /// [`crate::Error::Cancelled`].
    pub fn new(matrix: &SymmetricMatrix, constraints: Constraints, job: &Job) -> Result<Self> {
        Self::with_symbolic(matrix, constraints, None, job)
    }

    /// The same, with the symbolic part of a system of the same pattern and the same free vertices.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn with_symbolic(
        matrix: &SymmetricMatrix,
        constraints: Constraints,
        symbolic: Option<&Symbolic>,
        job: &Job,
    ) -> Result<Self> {
        job.part("order of elimination")?;
        let (reduced, coupling) = eliminate(matrix, &constraints);
        let symbolic = match symbolic {
            Some(symbolic) => symbolic.clone(),
            None => Symbolic::analyse(&reduced)?,
        };
        job.part("factorization")?;
        let factor = symbolic.factor(&reduced)?;
        Ok(Self { constraints, symbolic, factor, coupling, correction: None })
    }

    /// The same for a matrix with rows kept apart.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn of_split(matrix: &SplitMatrix, constraints: Constraints, job: &Job) -> Result<Self> {
        let system = Self::new(&matrix.sparse, constraints.clone(), job);
        match Self::corrected(system, matrix)? {
            Some(system) => Ok(system),
            None => Self::new(&matrix.whole()?, constraints, job),
        }
    }

    /// A system of the rest of `matrix`, corrected by what is apart; `None` where the rest is singular without that.
    fn corrected(rest: Result<Self>, matrix: &SplitMatrix) -> Result<Option<Self>> {
        match rest {
            rest if matrix.is_whole() => rest.map(Some),
            Ok(rest) if rest.factor.is_regularized() => Ok(None),
            Ok(mut rest) => {
                rest.correction = Correction::new(matrix, &rest.constraints, &rest.factor)?;
                Ok(rest.correction.is_some().then_some(rest))
            }
            Err(Error::SolveFailed(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The same for a matrix of 3 x 3 blocks, one block row per vertex, where the axes couple: unknown
    /// `3 v + a` is axis `a` of vertex `v`, and is constrained as `v` is.
    ///
    /// # Errors
    ///
    /// As [`ConstrainedSystem::new`].
    pub fn of_split_blocks(matrix: &SplitMatrix, constraints: &Constraints, job: &Job) -> Result<Self> {
        match Self::corrected(Self::of_blocks(&matrix.sparse, constraints, job), matrix)? {
            Some(system) => Ok(system),
            None => Self::of_blocks(&matrix.whole()?, constraints, job),
        }
    }

    fn of_blocks(matrix: &SymmetricMatrix, constraints: &Constraints, job: &Job) -> Result<Self> {
        job.part("order of elimination")?;
        let constraints = constraints.of_axes();
        let (reduced, coupling) = eliminate(matrix, &constraints);
        let symbolic = Symbolic::analyse_blocks(&reduced)?;
        job.part("factorization")?;
        let factor = symbolic.factor(&reduced)?;
        Ok(Self { constraints, symbolic, factor, coupling, correction: None })
    }

    /// The same with the factor rounded to single precision: a metric, where solutions are not what counts.
    pub fn rounded(self) -> Self {
        Self { factor: self.factor.rounded(), ..self }
    }

    /// The constraints.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// The factor.
    pub fn factor(&self) -> &Factor {
        &self.factor
    }

    /// The symbolic part, for another system of the same pattern.
    pub fn symbolic(&self) -> &Symbolic {
        &self.symbolic
    }

    /// Solves for the free vertices of every set of `x`, one vector per vertex, as in `rhs`; without a right-hand side
    /// where that is empty. On entry the fixed vertices of `x` hold what is given, and those of soft constraints
    /// their targets.
    pub fn solve<R: AsRef<[Vec3]> + Sync>(&self, rhs: &[R], x: &mut [Vec<Vec3>]) {
        assert!(rhs.is_empty() || rhs.len() == x.len(), "unknowns match right-hand sides");
        if let [x] = x
            && self.solve_one(rhs.first().map(R::as_ref), x)
        {
            return;
        }
        let free = self.constraints.free();
        let mut reduced = Columns::zeros(free.len(), 3 * x.len());
        reduced.data_mut().par_chunks_mut(free.len().max(1)).enumerate().for_each(|(c, column)| {
            let (set, axis) = (c / 3, c % 3);
            let rhs = rhs.get(set).map(R::as_ref);
            self.reduce(column, |v| rhs.map_or(0.0, |rhs| rhs[v][axis]), |v| x[set][v][axis]);
        });
        self.back_substitute(&mut reduced);
        x.par_iter_mut().enumerate().for_each(|(k, x)| {
            let [a, b, c] = [0, 1, 2].map(|axis| reduced.column(3 * k + axis));
            for (slot, &v) in free.iter().enumerate() {
                x[v as usize] = Vec3::new(a[slot], b[slot], c[slot]);
            }
        });
    }

    /// The same for one set without detours; false where the factor does not suit that.
    fn solve_one(&self, rhs: Option<&[Vec3]>, x: &mut [Vec3]) -> bool {
        if self.correction.is_some() {
            return false;
        }
        let free = self.constraints.free();
        if free.is_empty() {
            return true;
        }
        let lanes = |v: Vec3| [v.x, v.y, v.z, 0.0];
        let of = |slot: u32| rhs.map_or([0.0; LANES], |rhs| lanes(rhs[free[slot as usize] as usize]));
        let given = &*x;
        let add = |b: &mut [Lanes], places: &[u32]| {
            let mut add = |slot: u32, factor: f64, vertex: u32| {
                let b = &mut b[places[slot as usize] as usize];
                b.iter_mut().zip(lanes(given[vertex as usize])).for_each(|(b, x)| *b += factor * x);
            };
            self.coupling.iter().for_each(|&(slot, vertex, value)| add(slot, -value, vertex));
            self.pulls().for_each(|(slot, vertex, weight)| add(slot, weight, vertex));
        };
        let Some((solved, places)) = self.factor.solve_lanes(of, add) else { return false };
        for (&v, &place) in free.iter().zip(places) {
            let [a, b, c, _] = solved[place as usize];
            x[v as usize] = Vec3::new(a, b, c);
        }
        true
    }

    /// Harmonic extension of what given vertices hold, in place, for any number of sets: the solution without
    /// right-hand side.
    ///
    /// Constants come out exactly, however badly the system is conditioned: the unknown is the difference to the
    /// first given value.
    pub fn extend(&self, fields: &mut [Vec<Vec3>]) {
        let given = (0..self.constraints.vertex_count()).find(|&v| self.constraints.slot(v as u32).is_none());
        let pulled = self.constraints.soft().first().map(|&(v, _)| v as usize);
        let Some(first) = given.or(pulled) else { return };
        let shifts: Vec<Vec3> = fields.iter().map(|field| field[first]).collect();
        let shift = |fields: &mut [Vec<Vec3>], sign: f64| {
            for (field, &shift) in fields.iter_mut().zip(&shifts) {
                field.iter_mut().for_each(|value| *value += shift * sign);
            }
        };
        shift(fields, -1.0);
        self.solve::<Vec<Vec3>>(&[], fields);
        shift(fields, 1.0);
    }

    /// Solves without right-hand side, then again for what is left of it. `product` multiplies one column by
    /// the matrix, not with its entries but as `B^T (B x)` from the factors that it was assembled from.
    ///
    /// Rounding its entries alone costs a normal matrix the square of the digits that `B` costs (Björck 1987,
    /// Stability Analysis of the Method of Seminormal Equations): 1e-7 of the diagonal on 100,000 vertices,
    /// where after one correction 1e-11 is left.
    ///
    /// The columns are the axes of each set of `x` or, for a system [of blocks](Self::of_split_blocks), the sets.
    pub fn minimise(&self, x: &mut [Vec<Vec3>], product: impl Fn(&[f64]) -> Vec<f64> + Sync) {
        let rows = self.constraints.vertex_count();
        let blocks = x.first().is_some_and(|set| set.len() != rows);
        let sets = x.iter().map(Vec::as_slice);
        let mut columns =
            if blocks { Columns::interleaved(rows / 3, sets) } else { Columns::side_by_side(rows, sets) };
        self.minimise_columns(&mut columns, product);
        for (k, set) in x.iter_mut().enumerate() {
            *set = if blocks { columns.interleaved_vectors(k) } else { columns.vectors(k) };
        }
    }

    fn minimise_columns(&self, x: &mut Columns, product: impl Fn(&[f64]) -> Vec<f64> + Sync) {
        let targets = x.clone();
        let mut rest = Columns::zeros(x.rows(), x.count());
        self.solve_columns(&rest, x);
        rest.data_mut().par_chunks_mut(x.rows().max(1)).enumerate().for_each(|(c, rest)| {
            let (x, target) = (x.column(c), targets.column(c));
            for (rest, product) in rest.iter_mut().zip(product(x)) {
                *rest = -product;
            }
            for &(v, weight) in self.constraints.soft() {
                rest[v as usize] += weight * (target[v as usize] - x[v as usize]);
            }
        });
        let mut correction = Columns::zeros(x.rows(), x.count());
        self.solve_columns(&rest, &mut correction);
        for (x, correction) in x.data_mut().iter_mut().zip(correction.data_mut()) {
            *x += *correction;
        }
    }

    fn solve_columns(&self, rhs: &Columns, x: &mut Columns) {
        let free = self.constraints.free();
        let mut reduced = Columns::zeros(free.len(), rhs.count());
        reduced.data_mut().par_chunks_mut(free.len().max(1)).enumerate().for_each(|(c, column)| {
            let (rhs, x) = (rhs.column(c), x.column(c));
            self.reduce(column, |v| rhs[v], |v| x[v]);
        });
        self.back_substitute(&mut reduced);
        for c in 0..rhs.count() {
            let column = x.column_mut(c);
            for (&v, &value) in free.iter().zip(reduced.column(c)) {
                column[v as usize] = value;
            }
        }
    }

    fn back_substitute(&self, columns: &mut Columns) {
        self.factor.solve_columns(columns);
        if let Some(correction) = &self.correction {
            correction.correct(columns);
        }
    }

    /// A column of the right-hand side in the free unknowns alone.
    fn reduce(&self, column: &mut [f64], rhs: impl Fn(usize) -> f64, given: impl Fn(usize) -> f64) {
        for (target, &v) in column.iter_mut().zip(self.constraints.free()) {
            *target = rhs(v as usize);
        }
        for &(slot, vertex, value) in &self.coupling {
            column[slot as usize] -= value * given(vertex as usize);
        }
        if let Some(correction) = &self.correction {
            correction.reduce(column, &given);
        }
        for (slot, vertex, weight) in self.pulls() {
            column[slot as usize] += weight * given(vertex as usize);
        }
    }

    /// Soft constraints of free vertices: the row, the vertex and the weight.
    fn pulls(&self) -> impl Iterator<Item = (u32, u32, f64)> {
        let row = |&(vertex, weight): &(u32, f64)| Some((self.constraints.slot(vertex)?, vertex, weight));
        self.constraints.soft().iter().filter_map(row)
    }
}

/// The rows and columns of the free unknowns, soft constraints added, and what couples them to the fixed.
fn eliminate(matrix: &SymmetricMatrix, constraints: &Constraints) -> (SymmetricMatrix, Vec<(u32, u32, f64)>) {
    assert_eq!(matrix.size(), constraints.vertex_count(), "one row per vertex");
    let mut coupling = Vec::new();
    for (i, j, value) in matrix.entries() {
        match (constraints.slot(i), constraints.slot(j)) {
            (Some(a), None) => coupling.push((a, j, value)),
            (None, Some(b)) => coupling.push((b, i, value)),
            _ => {}
        }
    }
    coupling.sort_unstable_by_key(|&(slot, vertex, _)| (slot, vertex));
    let mut reduced = matrix.select(|v| constraints.slot(v));
    for &(vertex, weight) in constraints.soft() {
        if let Some(slot) = constraints.slot(vertex) {
            reduced.add_to_diagonal(slot as usize, weight);
        }
    }
    (reduced, coupling)
}
