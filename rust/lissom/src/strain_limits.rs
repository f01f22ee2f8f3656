//! Strain limits: no edge longer than so many times what it is at rest (Provot 1995, Deformation Constraints in a
//! Mass-Spring Model to Describe Rigid Cloth Behavior).
//!
//! ```text
//!     |x_a - x_b| <= limit_ab |v_a - v_b|      for every edge ab
//! ```
//!
//! Each sweep brings both ends of every edge that is too long together by half of what is too much, or the one
//! that is free by all of it; a vertex of several such edges goes by their mean, so that the order of the edges does
//! not count and what is symmetric stays so. The set of shapes within the limits is convex and holds the shape at rest.

use rayon::prelude::*;

use crate::geometry::rows::Rows;
use crate::{Error, Fault, Job, Mesh, Result, Vec3};

/// Edges may be longer than their limit by this part of it.
const SLACK: f64 = 1e-3;

/// Sweeps at most: what is too much spreads by an edge a sweep.
const SWEEPS: usize = 400;

impl Mesh {
    /// `shapes`, (k) sets of positions in the mesh's own units, with no edge longer than `limit` times what it is at
    /// rest, but those between two of the vertices that are `held`.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a limit below 1 and for positions that are not finite,
    /// [`Error::InvalidConstraint`] for held vertices out of range, [`Error::Cancelled`].
    pub fn limit_stretch(
        &self,
        shapes: &[Vec<Vec3>],
        limit: f64,
        held: &[u32],
        job: &Job,
    ) -> Result<Vec<Vec<Vec3>>> {
        if limit.is_nan() || limit < 1.0 {
            let problem = format!("must be at least 1, got {limit}");
            return Err(Error::InvalidValue(Fault::new("limit", problem)));
        }
        if let Some(fault) = Fault::out_of_range("held", held, self.vertices().len()) {
            return Err(Error::InvalidConstraint(fault));
        }
        let mut stays = vec![false; self.vertices().len()];
        held.iter().for_each(|&v| stays[self.representative(v) as usize] = true);
        let limits: Vec<f64> = (self.adjacency().edges().iter())
            .map(|&[a, b]| limit * self.rest()[a as usize].distance(self.rest()[b as usize]))
            .collect();
        let within = |(k, shape): (usize, &Vec<Vec3>)| {
            job.check()?;
            let infinite = (0..shape.len()).filter(|&v| !shape[v].is_finite());
            if let Some(fault) = Fault::at(format!("shapes[{k}]"), "not finite", infinite) {
                return Err(Error::InvalidValue(fault));
            }
            let before: Vec<Vec3> = shape.iter().map(|&p| self.frame().to_unit(p)).collect();
            let mut after = before.clone();
            self.shorten_edges(&mut after, |e| limits[e], |v| stays[v]);
            let moved = before.iter().zip(after).zip(shape);
            let mut found: Vec<Vec3> =
                moved.map(|((&before, after), &p)| p + (after - before) * self.frame().scale).collect();
            self.follow(&mut found);
            Ok(found)
        };
        shapes.par_iter().enumerate().map(within).collect()
    }

    /// Brings `positions`, in unit coordinates, within what `limit` says of each edge: its length at most. Vertices that
    /// are `held` stay; an edge between two of them keeps its length.
    pub fn shorten_edges(
        &self,
        positions: &mut [Vec3],
        limit: impl Fn(usize) -> f64,
        held: impl Fn(usize) -> bool,
    ) {
        let edges = self.adjacency().edges();
        let length =
            |positions: &[Vec3], [a, b]: [u32; 2]| positions[a as usize].distance(positions[b as usize]);
        let held: Vec<bool> = (0..positions.len()).map(held).collect();
        let is_free = |[a, b]: [u32; 2]| !(held[a as usize] && held[b as usize]);
        let limits: Vec<f64> =
            (0..edges.len()).map(|e| if is_free(edges[e]) { limit(e) } else { f64::INFINITY }).collect();
        let too_long = |positions: &[Vec3], e: usize| length(positions, edges[e]) > limits[e] * (1.0 + SLACK);
        let mut long: Vec<usize> = (0..edges.len()).filter(|&e| too_long(positions, e)).collect();
        if long.is_empty() {
            return;
        }
        let ends = (0u32..).zip(edges).flat_map(|(e, &[a, b])| [(a, e), (b, e)]);
        let beside = Rows::sort(positions.len(), ends);
        let mut steps = vec![(Vec3::ZERO, 0.0); positions.len()];
        for _ in 0..SWEEPS {
            for &e in &long {
                let [a, b] = edges[e].map(|v| v as usize);
                let way = positions[b] - positions[a];
                let share = if held[a] || held[b] { 1.0 } else { 0.5 };
                let step = way * (share * (1.0 - limits[e] / way.length()));
                for (v, step) in [(a, step), (b, -step)].into_iter().filter(|&(v, _)| !held[v]) {
                    steps[v] = (steps[v].0 + step, steps[v].1 + 1.0);
                }
            }
            let mut near = Vec::new();
            for v in long.iter().flat_map(|&e| edges[e]) {
                let (sum, count) = std::mem::take(&mut steps[v as usize]);
                if count > 0.0 {
                    positions[v as usize] += sum / count;
                    near.extend(beside.of(v as usize).iter().map(|&e| e as usize));
                }
            }
            near.sort_unstable();
            near.dedup();
            long = near.into_iter().filter(|&e| too_long(positions, e)).collect();
            if long.is_empty() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of `n` squares along x, and its mesh.
    fn strip(n: usize) -> Mesh {
        let vertices = (0..=n).flat_map(|i| [0.0, 1.0].map(|y| Vec3::new(i as f64, y, 0.0))).collect();
        let square = |i: usize| {
            let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3].map(|v| v as u32);
            [[a, c, b], [b, c, d]]
        };
        Mesh::new(vertices, (0..n).flat_map(square).collect()).unwrap()
    }

    #[test]
    fn what_one_edge_takes_is_shared_along_the_strip() {
        let mesh = strip(11);
        let torn = |v: usize| mesh.rest()[v] + if v > 11 { Vec3::X * 0.5 } else { Vec3::ZERO };
        let mut found: Vec<Vec3> = (0..mesh.rest().len()).map(torn).collect();
        let limit = |e: usize| {
            let [a, b] = mesh.adjacency().edges()[e].map(|v| mesh.rest()[v as usize]);
            2.0 * a.distance(b)
        };
        let ends = [0, 1, 22, 23];
        mesh.shorten_edges(&mut found, limit, |v| ends.contains(&v));
        for (e, &[a, b]) in mesh.adjacency().edges().iter().enumerate() {
            let length = found[a as usize].distance(found[b as usize]);
            assert!(length < limit(e) * 1.0011, "edge {e} is {length} long");
        }
        assert!(ends.iter().all(|&v| found[v] == torn(v)), "held ends have moved");
        let twin = |v: usize| 23 - v;
        let middle = (torn(0) + torn(23)) * 0.5;
        for v in 0..24 {
            let off = (found[v] - middle) + (found[twin(v)] - middle);
            assert!(off.length() < 1e-12, "{v} and its twin are not alike: {off}");
        }
    }

    #[test]
    fn what_is_within_its_limits_stays_to_the_bit() {
        let mesh = strip(4);
        let stretched: Vec<Vec3> = mesh.rest().iter().map(|&p| p * Vec3::new(1.9, 1.0, 1.0)).collect();
        let mut found = stretched.clone();
        mesh.shorten_edges(
            &mut found,
            |e| {
                let [a, b] = mesh.adjacency().edges()[e].map(|v| mesh.rest()[v as usize]);
                2.0 * a.distance(b)
            },
            |_| false,
        );
        assert_eq!(found, stretched);
    }
}
