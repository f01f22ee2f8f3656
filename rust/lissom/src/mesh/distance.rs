//! Distances along edges (Dijkstra 1959).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::adjacency::Adjacency;
use crate::Vec3;
use crate::geometry::rows::Rows;

/// Ways along the edges of a mesh.
pub struct Paths<'a> {
    positions: &'a [Vec3],
    neighbours: Rows<u32>,
    tie: f64,
}

impl<'a> Paths<'a> {
    /// Between vertices at `positions`. Ways whose lengths differ by less than the part `tie` are equally long.
    pub fn new(adjacency: &Adjacency, positions: &'a [Vec3], tie: f64) -> Self {
        let both = adjacency.edges().iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
        Self { positions, neighbours: Rows::sort(positions.len(), both), tie }
    }

    /// From vertices at some distance, shortens the `distances` within `reach` of others, and tells whose.
    pub fn shorten(
        &self,
        distances: &mut [f64],
        from: impl IntoIterator<Item = (u32, f64)>,
        reach: f64,
        mut shortened: impl FnMut(u32),
    ) {
        // Numbers that are not negative are ordered as their bits are.
        let mut next = BinaryHeap::new();
        for (v, distance) in from {
            if distance < distances[v as usize] {
                distances[v as usize] = distance;
                shortened(v);
            }
            next.push(Reverse((distance.to_bits(), v)));
        }
        let longer = 1.0 + self.tie;
        while let Some(Reverse((bits, v))) = next.pop() {
            let distance = f64::from_bits(bits);
            if distance > distances[v as usize] {
                continue;
            }
            for &w in self.neighbours.of(v as usize) {
                let further = distance + self.positions[v as usize].distance(self.positions[w as usize]);
                if further * longer < distances[w as usize] && further <= reach * longer {
                    distances[w as usize] = further;
                    shortened(w);
                    next.push(Reverse((further.to_bits(), w)));
                }
            }
        }
    }
}
