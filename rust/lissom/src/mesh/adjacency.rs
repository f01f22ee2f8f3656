//! Which triangles meet at a vertex and across an edge.

use crate::geometry::rows::Rows;

/// One corner of one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// The triangle.
    pub triangle: u32,
    /// The corner, 0 to 2.
    pub corner: u8,
}

/// Incidence of vertices, edges and triangles.
#[derive(Debug, Clone)]
pub struct Adjacency {
    corners: Rows<Corner>,
    edges: Vec<[u32; 2]>,
    side_start: Vec<u32>,
    sides: Vec<Side>,
}

/// A triangle beside an edge, and whether it runs along it from the lower to the higher vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// The triangle.
    pub triangle: u32,
    /// Whether the triangle passes the edge from its lower to its higher vertex.
    pub ascending: bool,
}

impl Adjacency {
    pub(super) fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let all = (0u32..).zip(triangles).flat_map(|(t, triangle)| {
            (0u8..).zip(triangle).map(move |(c, &v)| (v, Corner { triangle: t, corner: c }))
        });
        let corners = Rows::sort(vertices, all);

        // Half edges by their lower vertex, then those of each by the higher.
        let half_edges = (0u32..).zip(triangles).flat_map(|(t, &[a, b, c])| {
            [(a, b), (b, c), (c, a)]
                .map(|(from, to)| (from.min(to), (from.max(to), Side { triangle: t, ascending: from < to })))
        });
        let mut sorted = Rows::sort(vertices, half_edges);
        let (mut edges, mut side_start, mut sides) = (Vec::new(), Vec::new(), Vec::new());
        for low in 0..vertices {
            let fan = sorted.of_mut(low);
            // Stable, so that the sides of an edge stay in the order of the triangles.
            fan.sort_by_key(|&(high, _)| high);
            for edge in fan.chunk_by(|a, b| a.0 == b.0) {
                edges.push([low as u32, edge[0].0]);
                side_start.push(sides.len() as u32);
                sides.extend(edge.iter().map(|&(_, side)| side));
            }
        }
        side_start.push(sides.len() as u32);
        Self { corners, edges, side_start, sides }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.corners.count()
    }

    /// The corners that meet at a vertex.
    pub fn corners_of(&self, vertex: usize) -> &[Corner] {
        self.corners.of(vertex)
    }

    /// Every edge once, as its lower and higher vertex, in ascending order.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// The triangles beside an edge: one at a border, two inside, more where the mesh is not manifold.
    pub fn sides_of(&self, edge: usize) -> &[Side] {
        &self.sides[self.side_start[edge] as usize..self.side_start[edge + 1] as usize]
    }

    /// Pairs of triangles that share an edge, each pair of neighbours around the edge once.
    pub fn triangle_pairs(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        (0..self.edges.len())
            .flat_map(|e| self.sides_of(e).windows(2).map(|pair| [pair[0].triangle, pair[1].triangle]))
    }
}
