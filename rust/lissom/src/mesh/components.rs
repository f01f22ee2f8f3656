//! Connected components: vertices joined by triangles.

use crate::geometry::groups::Groups;

/// Marks a vertex that no triangle uses.
const NONE: u32 = u32::MAX;

/// Connected components, numbered by their first vertex.
#[derive(Debug, Clone)]
pub struct Components {
    of_vertex: Vec<u32>,
    count: usize,
}

impl Components {
    /// Of `vertices` vertices that `triangles` join.
    pub fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let pairs = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let groups = Groups::joining(vertices, pairs);
        let mut used = vec![false; vertices];
        for &v in triangles.iter().flatten() {
            used[v as usize] = true;
        }
        // Vertices without triangles are groups of their own, and left out of the numbers.
        let mut number = vec![NONE; groups.count()];
        let mut count = 0;
        let mut of_vertex = vec![NONE; vertices];
        for v in (0..vertices).filter(|&v| used[v]) {
            let number = &mut number[groups.of()[v] as usize];
            if *number == NONE {
                *number = count;
                count += 1;
            }
            of_vertex[v] = *number;
        }
        Self { of_vertex, count: count as usize }
    }

    /// How many components there are; vertices without triangles are in none.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The component of a vertex, `None` for one without triangles.
    pub fn of_vertex(&self, vertex: usize) -> Option<usize> {
        let component = self.of_vertex[vertex];
        (component != NONE).then_some(component as usize)
    }

    /// The vertices of each component, ascending.
    pub fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.count];
        for (v, &c) in (0u32..).zip(&self.of_vertex) {
            if c != NONE {
                members[c as usize].push(v);
            }
        }
        members
    }
}
