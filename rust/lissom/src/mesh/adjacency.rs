//! Which triangles meet at a vertex and across an edge.

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
    corner_start: Vec<u32>,
    corners: Vec<Corner>,
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
        let mut corner_start = vec![0u32; vertices + 1];
        for &v in triangles.iter().flatten() {
            corner_start[v as usize + 1] += 1;
        }
        for v in 0..vertices {
            corner_start[v + 1] += corner_start[v];
        }
        let mut next = corner_start.clone();
        let mut corners = vec![Corner { triangle: 0, corner: 0 }; 3 * triangles.len()];
        for (t, triangle) in (0u32..).zip(triangles) {
            for (c, &v) in (0u8..).zip(triangle) {
                corners[next[v as usize] as usize] = Corner { triangle: t, corner: c };
                next[v as usize] += 1;
            }
        }

        // Half edges by their lower vertex, then those of each by the higher: a counting sort.
        let half_edges = || {
            (0u32..).zip(triangles).flat_map(|(t, &[a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(from, to)| {
                    (from.min(to) as usize, (from.max(to), Side { triangle: t, ascending: from < to }))
                })
            })
        };
        let mut start = vec![0usize; vertices + 1];
        half_edges().for_each(|(low, _)| start[low + 1] += 1);
        for v in 0..vertices {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut sorted = vec![(0, Side { triangle: 0, ascending: true }); 3 * triangles.len()];
        for (low, half_edge) in half_edges() {
            sorted[next[low]] = half_edge;
            next[low] += 1;
        }
        let (mut edges, mut side_start) = (Vec::new(), Vec::new());
        for low in 0..vertices {
            let fan = start[low]..start[low + 1];
            // Stable, so that the sides of an edge stay in the order of the triangles.
            sorted[fan.clone()].sort_by_key(|&(high, _)| high);
            for index in fan.clone() {
                if index == fan.start || sorted[index].0 != sorted[index - 1].0 {
                    edges.push([low as u32, sorted[index].0]);
                    side_start.push(index as u32);
                }
            }
        }
        side_start.push(sorted.len() as u32);
        let sides = sorted.into_iter().map(|(_, side)| side).collect();
        Self { corner_start, corners, edges, side_start, sides }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.corner_start.len() - 1
    }

    /// The corners that meet at a vertex.
    pub fn corners_of(&self, vertex: usize) -> &[Corner] {
        &self.corners[self.corner_start[vertex] as usize..self.corner_start[vertex + 1] as usize]
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
