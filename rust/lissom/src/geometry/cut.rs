//! The cheapest cut that parts some nodes of a graph from others (Dinic 1970, Algorithm for Solution of a Problem of Maximum
//! Flow in Networks with Power Estimation).

use crate::{Job, Result};

/// A graph whose edges cost something to cut, the same either way.
pub struct Cut {
    /// The edges at each node.
    at: Vec<Vec<u32>>,
    /// Where an edge leads; edges come in pairs, one for either way.
    to: Vec<u32>,
    /// What may still flow along it.
    room: Vec<f64>,
}

const NONE: u32 = u32::MAX;

impl Cut {
    /// A graph of so many nodes without edges.
    pub fn new(nodes: usize) -> Self {
        Self { at: vec![Vec::new(); nodes], to: Vec::new(), room: Vec::new() }
    }

    /// An edge between two nodes.
    pub fn join(&mut self, a: u32, b: u32, cost: f64) {
        for [from, to] in [[a, b], [b, a]] {
            self.at[from as usize].push(self.to.len() as u32);
            self.to.push(to);
            self.room.push(cost);
        }
    }

    /// Which nodes are on the side of `from` in the cheapest cut that parts it from `to`; of several the one that takes
    /// least.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn side(mut self, from: u32, to: u32, job: &Job) -> Result<Vec<bool>> {
        loop {
            job.check()?;
            let depth = self.depths(from);
            if depth[to as usize] == NONE {
                return Ok(depth.iter().map(|&depth| depth != NONE).collect());
            }
            let mut next = vec![0; self.at.len()];
            while let Some(path) = self.path(from, to, &depth, &mut next) {
                job.check()?;
                let most = path.iter().map(|&edge| self.room[edge as usize]).fold(f64::INFINITY, f64::min);
                for edge in path {
                    self.room[edge as usize] -= most;
                    self.room[edge as usize ^ 1] += most;
                }
            }
        }
    }

    /// How many edges with room lead to each node, at least.
    fn depths(&self, from: u32) -> Vec<u32> {
        let mut depth = vec![NONE; self.at.len()];
        depth[from as usize] = 0;
        let mut reached = vec![from];
        let mut first = 0;
        while let Some(&node) = reached.get(first) {
            first += 1;
            for &edge in &self.at[node as usize] {
                let to = self.to[edge as usize] as usize;
                if self.room[edge as usize] > 0.0 && depth[to] == NONE {
                    depth[to] = depth[node as usize] + 1;
                    reached.push(to as u32);
                }
            }
        }
        depth
    }

    /// A path of edges with room, each a step deeper; `next` are the edges to go on with at each node.
    fn path(&self, from: u32, to: u32, depth: &[u32], next: &mut [usize]) -> Option<Vec<u32>> {
        let mut path: Vec<u32> = Vec::new();
        let mut node = from;
        while node != to {
            if let Some(&edge) = self.at[node as usize].get(next[node as usize]) {
                let ahead = self.to[edge as usize];
                if self.room[edge as usize] > 0.0 && depth[ahead as usize] == depth[node as usize] + 1 {
                    path.push(edge);
                    node = ahead;
                } else {
                    next[node as usize] += 1;
                }
            } else {
                let back = path.pop()?;
                node = self.to[back as usize ^ 1];
                next[node as usize] += 1;
            }
        }
        Some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all ways to part the first node from the last, the cheapest.
    fn least(nodes: u32, edges: &[(u32, u32, f64)]) -> f64 {
        let sides = (0..1u32 << (nodes - 2)).map(|middle| (middle << 1) | 1);
        let cost = |side: u32| {
            let parts = |v: u32| side >> v & 1;
            edges.iter().filter(|(a, b, _)| parts(*a) != parts(*b)).map(|edge| edge.2).sum::<f64>()
        };
        sides.map(cost).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_cut_of_all_is_cheaper() {
        for seed in 0..60u32 {
            let mut state = seed.wrapping_mul(747_796_405).wrapping_add(1);
            let mut random = |below: u32| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 16) % below
            };
            let nodes = 4 + random(6);
            let edges: Vec<_> = (0..nodes + random(3 * nodes))
                .map(|_| (random(nodes), random(nodes), f64::from(1 + random(9))))
                .filter(|(a, b, _)| a != b)
                .collect();
            let mut cut = Cut::new(nodes as usize);
            edges.iter().for_each(|&(a, b, cost)| cut.join(a, b, cost));
            let side = cut.side(0, nodes - 1, &Job::default()).unwrap();
            let parts = edges.iter().filter(|(a, b, _)| side[*a as usize] != side[*b as usize]);
            assert!(side[0] && !side[nodes as usize - 1]);
            assert_eq!(parts.map(|edge| edge.2).sum::<f64>(), least(nodes, &edges), "{edges:?}");
        }
    }
}
