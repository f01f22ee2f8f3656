//! Distances along edges (Dijkstra 1959).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::adjacency::Adjacency;
use crate::Vec3;
use crate::geometry::rows::Rows;

/// How far each vertex is from the nearest of `sources`, along edges between `positions`; infinite where none lead.
pub(super) fn along_edges(adjacency: &Adjacency, positions: &[Vec3], sources: &[u32]) -> Vec<f64> {
    let both = adjacency.edges().iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
    let beside = Rows::sort(positions.len(), both);
    let mut distances = vec![f64::INFINITY; positions.len()];
    // Bits of numbers that are not negative sort as the numbers do.
    let mut queue = BinaryHeap::new();
    for &source in sources {
        distances[source as usize] = 0.0;
        queue.push(Reverse((0u64, source)));
    }
    while let Some(Reverse((bits, v))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > distances[v as usize] {
            continue;
        }
        for &w in beside.of(v as usize) {
            let further = distance + positions[v as usize].distance(positions[w as usize]);
            if further < distances[w as usize] {
                distances[w as usize] = further;
                queue.push(Reverse((further.to_bits(), w)));
            }
        }
    }
    distances
}
