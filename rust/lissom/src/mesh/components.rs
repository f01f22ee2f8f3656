//! Connected components: vertices joined by triangles.

/// Marks a vertex that no triangle uses.
const NONE: u32 = u32::MAX;

/// Connected components, numbered by their first vertex.
#[derive(Debug, Clone)]
pub struct Components {
    of_vertex: Vec<u32>,
    count: usize,
}

/// Joins `pairs` of `0..count`; gives each element's root and the number of groups.
pub(super) fn roots(count: usize, pairs: impl Iterator<Item = [u32; 2]>) -> (Vec<u32>, usize) {
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    let mut parent: Vec<u32> = (0..count as u32).collect();
    let mut groups = count;
    for [a, b] in pairs {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        if a != b {
            parent[b as usize] = a;
            groups -= 1;
        }
    }
    let of = (0..count as u32).map(|v| root(&mut parent, v)).collect();
    (of, groups)
}

impl Components {
    pub(super) fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let pairs = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let (root, _) = roots(vertices, pairs);
        let mut used = vec![false; vertices];
        for &v in triangles.iter().flatten() {
            used[v as usize] = true;
        }
        let mut number = vec![NONE; vertices];
        let mut count = 0;
        let mut of_vertex = vec![NONE; vertices];
        for v in (0..vertices).filter(|&v| used[v]) {
            let root = root[v] as usize;
            if number[root] == NONE {
                number[root] = count;
                count += 1;
            }
            of_vertex[v] = number[root];
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
