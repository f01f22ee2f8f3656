//! Which of many boxes a point is near: of a hundred buttons, the one that it may touch.

use super::tree::{Bounds, Tree, squared_limit};
use crate::Vec3;

/// Boxes around groups of points, in a tree.
pub struct Boxes {
    tree: Tree,
    which: Vec<u32>,
}

impl Boxes {
    /// A box around the points of each group.
    pub fn around<G: IntoIterator<Item = Vec3>>(groups: impl IntoIterator<Item = G>) -> Self {
        let around = |points: G| {
            let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
            let place = points.into_iter().fold(nothing, |[low, high], p| [low.min(p), high.max(p)]);
            Bounds { place, normal: Vec3::ZERO }
        };
        let bounds: Vec<Bounds> = groups.into_iter().map(around).collect();
        let (tree, which) = Tree::new(&bounds, 0..bounds.len() as u32);
        Self { tree, which }
    }

    /// Those no further than `reach` from a point, ascending; some that are a little further may be among them.
    pub fn within(&self, point: Vec3, reach: f64) -> Vec<usize> {
        let mut found = Vec::new();
        if let Some(probe) = self.tree.probe(point, None) {
            self.tree.nearest(&probe, squared_limit(reach), |slot, _| {
                found.push(self.which[slot as usize] as usize);
                None::<(f64, ())>
            });
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_within_reach_and_hardly_any_others_are_found() {
        let corner = |k: usize| Vec3::new((k % 20) as f64, (k / 20 % 20) as f64, (k / 400) as f64) * 3.0;
        let boxes = Boxes::around((0..8000).map(|k| [corner(k) + Vec3::X, corner(k) + Vec3::Y]));
        for (k, reach) in [(0, 0.0), (421, 0.5), (7999, 1.0), (4210, f64::INFINITY)] {
            let beside = corner(k) + Vec3::new(0.5, 0.5, reach.min(1.0));
            assert_eq!(
                boxes.within(beside, reach),
                if reach.is_finite() { vec![k] } else { (0..8000).collect() }
            );
        }
        assert_eq!(boxes.within(corner(5) - Vec3::ONE, 0.9), []);
        assert_eq!(Boxes::around([[]; 0]).within(Vec3::ZERO, f64::INFINITY), []);
    }
}
