//! Which vertices are given, exactly or softly, and which are solved for.

/// Marks a vertex that is fixed.
const FIXED: u32 = u32::MAX;

/// Hard constraints (vertices that are given, and eliminated) and soft ones (vertices pulled with a
/// weight); all others are free.
#[derive(Debug, Clone)]
pub struct Constraints {
    free: Vec<u32>,
    slot: Vec<u32>,
    soft: Vec<(u32, f64)>,
}

impl Constraints {
    /// Of `n` vertices, those with `fixed(v)` are given.
    pub fn hard(n: usize, fixed: impl Fn(usize) -> bool) -> Self {
        let free: Vec<u32> = (0..n).filter(|&v| !fixed(v)).map(|v| v as u32).collect();
        let mut slot = vec![FIXED; n];
        for (s, &v) in (0u32..).zip(&free) {
            slot[v as usize] = s;
        }
        Self { free, slot, soft: Vec::new() }
    }

    /// Adds soft constraints: `weight |x_v - c_v|^2` joins the energy (a weight, not its square; a
    /// vertex may come again). Those of fixed vertices have no effect.
    pub fn with_soft(mut self, soft: impl IntoIterator<Item = (u32, f64)>) -> Self {
        self.soft.extend(soft);
        self
    }

    /// The same constraints with further vertices given.
    pub fn also_fixed(self, fixed: impl Fn(usize) -> bool) -> Self {
        if !self.free.iter().any(|&v| fixed(v as usize)) {
            return self;
        }
        Self::hard(self.slot.len(), |v| self.slot[v] == FIXED || fixed(v)).with_soft(self.soft)
    }

    /// The same constraints on three unknowns a vertex, `3 v + a` for axis `a`.
    pub fn of_axes(&self) -> Self {
        let soft = self.soft.iter().flat_map(|&(v, weight)| [0, 1, 2].map(|a| (3 * v + a, weight)));
        let fixed = |unknown: usize| self.slot[unknown / 3] == FIXED;
        Self::hard(3 * self.vertex_count(), fixed).with_soft(soft)
    }

    /// The free vertices, ascending.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// Number of vertices, free and fixed.
    pub fn vertex_count(&self) -> usize {
        self.slot.len()
    }

    /// The place of a vertex among the free ones; `None` where it is fixed.
    pub fn slot(&self, vertex: u32) -> Option<u32> {
        let slot = self.slot[vertex as usize];
        (slot != FIXED).then_some(slot)
    }

    /// The soft constraints, as vertex and weight.
    pub fn soft(&self) -> &[(u32, f64)] {
        &self.soft
    }
}
