//! Partners: which component of the source is which component of the target.
//!
//! Lids, lashes and tear films lie closer to each other than a fit is exact, so that the nearest point
//! is often on the wrong one. Two components that have more in common with each other than either has
//! with any other are partners, and go first.

use std::collections::HashMap;

use crate::Mesh;

/// How much the components of two meshes have in common.
pub struct Overlap {
    counts: [usize; 2],
    common: HashMap<[u32; 2], f64>,
}

/// The partner of each component; `None` for those that have none.
pub struct ComponentPairs {
    pub of_source: Vec<Option<u32>>,
    pub of_target: Vec<Option<u32>>,
}

/// The component of each triangle in use.
pub fn triangle_components(mesh: &Mesh) -> Vec<u32> {
    let component = |t: &[u32; 3]| mesh.components().of_vertex(t[0] as usize).unwrap_or_default() as u32;
    mesh.triangles().iter().map(component).collect()
}

impl ComponentPairs {
    /// Nobody has a partner.
    pub fn none([sources, targets]: [usize; 2]) -> Self {
        Self { of_source: vec![None; sources], of_target: vec![None; targets] }
    }
}

impl Overlap {
    /// Nothing in common yet, between so many source and target components.
    pub fn new(counts: [usize; 2]) -> Self {
        Self { counts, common: HashMap::new() }
    }

    /// Adds what a source component has in common with a target component.
    pub fn add(&mut self, source: u32, target: u32, amount: f64) {
        *self.common.entry([source, target]).or_default() += amount;
    }

    /// Components that prefer each other.
    pub fn partners(self) -> ComponentPairs {
        let mut sorted: Vec<([u32; 2], f64)> = self.common.into_iter().collect();
        // Ties by number, so that the outcome does not depend on the order of the map.
        sorted.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut best = ComponentPairs::none(self.counts);
        for &([s, t], _) in &sorted {
            best.of_source[s as usize].get_or_insert(t);
            best.of_target[t as usize].get_or_insert(s);
        }
        let mutual = |best: &[Option<u32>], other: &[Option<u32>]| {
            let returned = |(i, b): (usize, &Option<u32>)| b.filter(|&b| other[b as usize] == Some(i as u32));
            best.iter().enumerate().map(returned).collect()
        };
        ComponentPairs {
            of_source: mutual(&best.of_source, &best.of_target),
            of_target: mutual(&best.of_target, &best.of_source),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partners_prefer_each_other() {
        let mut overlap = Overlap::new([3, 2]);
        for (s, t, amount) in [(0, 0, 5.0), (0, 1, 3.0), (1, 0, 4.0), (2, 1, 1.0), (0, 0, 5.0), (1, 0, 3.0)] {
            overlap.add(s, t, amount);
        }
        let partners = overlap.partners();
        // Target 1 prefers source 0, which prefers target 0.
        assert_eq!(partners.of_source, [Some(0), None, None]);
        assert_eq!(partners.of_target, [Some(0), None]);
    }
}
