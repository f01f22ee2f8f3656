//! A tree of boxes over triangles, in which what faces the wrong way is passed over like what is too far.
//!
//! Four children a node, side by side, so that one pass of vector instructions looks at all (Wald, Benthin & Boulos
//! 2008, Getting Rid of Packets); in single precision, rounded outwards. Beside the box of its places a child has the
//! box of its *normals*: where no normal in it is within 90 degrees of the one asked for, nothing below is compatible. A
//! tree without them finds out triangle by triangle, and where all around faces away that is all of them (cones of
//! normals: Johnson & Cohen 2001, Spatialized Normal Cone Hierarchies; boxes take no trigonometry to join).

mod growth;
mod node;

use self::growth::{Branch, Item, grow};
use self::node::{LEAF, NOTHING, Node, PAD};
use crate::Vec3;

/// Points further away are not rounded to single precision, but look at all boxes.
const FAR: f64 = 1e6;

/// Directions are no nearer to an axis' plane: their inverses are finite, and a ray that leaves the plane by less passes all
/// boxes before it has left one by their room for rounding.
const FLAT: f64 = 1e-12;

/// Places on the stack of a search: a node leaves three, and all but three of the nodes above each other have a quarter of
/// what the one above has.
const STACK: usize = 64;

/// The tree; what it holds has a *slot* each.
pub struct Tree {
    nodes: Vec<Node>,
    slots: u32,
    centre: Vec3,
    per_unit: f64,
}

/// A box of places and one of normals.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// Of places in space.
    pub place: [Vec3; 2],
    /// The unit normal.
    pub normal: Vec3,
}

/// Where something is asked for, as the tree rounds it.
pub struct Probe {
    place: [f32; 3],
    is_far: bool,
    facing: Option<[f32; 3]>,
}

impl Tree {
    /// Over what has these bounds, and which of them each slot holds.
    pub fn new(bounds: &[Bounds], which: impl Iterator<Item = u32>) -> (Self, Vec<u32>) {
        let (centre, per_unit) = frame(bounds.iter().copied());
        let item = |triangle: u32| {
            let Bounds { place: [low, high], normal } = bounds[triangle as usize];
            let place = ((low + high) * 0.5 - centre) * per_unit;
            let key = [place.x, place.y, place.z, normal.x, normal.y, normal.z];
            Item { key: key.map(|x| x as f32), triangle }
        };
        let mut items: Vec<Item> = which.map(item).collect();
        let branch = grow(&mut items);
        let nodes = Vec::with_capacity(items.len() / 2 + 1);
        let mut tree = Self { nodes, slots: items.len() as u32, centre, per_unit };
        let order: Vec<u32> = items.iter().map(|item| item.triangle).collect();
        let mut slot = 0;
        match branch {
            Branch::Leaf => tree.push(&[Branch::Leaf], &mut slot),
            Branch::Node(children) => tree.push(&children, &mut slot),
        };
        tree.fit(|slot| bounds[order[slot as usize] as usize]);
        (tree, order)
    }

    fn push(&mut self, children: &[Branch], slot: &mut u32) -> u32 {
        let own = self.nodes.len();
        self.nodes.push(Node::nothing());
        for (k, child) in children.iter().enumerate() {
            self.nodes[own].child[k] = match child {
                Branch::Leaf => {
                    *slot += 1;
                    LEAF | (*slot - 1)
                }
                Branch::Node(children) => self.push(children, slot),
            };
        }
        own as u32
    }

    /// The same tree over what has moved to these bounds, of each slot.
    pub fn fit(&mut self, bounds: impl Fn(u32) -> Bounds) {
        (self.centre, self.per_unit) = frame((0..self.slots).map(&bounds));
        // Children come after their parents.
        for own in (0..self.nodes.len()).rev() {
            for k in 0..4 {
                let child = self.nodes[own].child[k];
                let [low, high, normal_low, normal_high] = if child == NOTHING {
                    continue;
                } else if child & LEAF != 0 {
                    let Bounds { place: [low, high], normal } = bounds(child & !LEAF);
                    let rounded = |p: Vec3, pad: f32| p.to_array().map(|x| x as f32 + pad);
                    let [low, high] = [low, high].map(|p| (p - self.centre) * self.per_unit);
                    [rounded(low, -PAD), rounded(high, PAD), rounded(normal, -PAD), rounded(normal, PAD)]
                } else {
                    self.nodes[child as usize].joined()
                };
                let node = &mut self.nodes[own];
                (0..3).for_each(|axis| {
                    node.low[axis][k] = low[axis];
                    node.high[axis][k] = high[axis];
                    node.normal_low[axis][k] = normal_low[axis];
                    node.normal_high[axis][k] = normal_high[axis];
                });
            }
        }
    }

    /// A point, and the normal that what is found must face the way of; `None` for a normal without a direction.
    pub fn probe(&self, point: Vec3, facing: Option<Vec3>) -> Option<Probe> {
        let q = (point - self.centre) * self.per_unit;
        let facing = match facing {
            Some(normal) => {
                let largest = normal.abs().max_element();
                if !(largest > 0.0 && largest.is_finite()) {
                    return None;
                }
                Some((normal / largest).to_array().map(|x| x as f32))
            }
            None => None,
        };
        let is_far = q.abs().max_element() > FAR;
        Some(Probe { place: q.to_array().map(|x| x as f32), is_far, facing })
    }

    /// Which slot holds the best, of which `at` tells its cost and whatever else: the square of a distance from the
    /// probe, below `limit`.
    pub fn nearest<T>(
        &self,
        probe: &Probe,
        limit: f64,
        at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let bound = |node: &Node| {
            let mut bound = if probe.is_far { [0.0; 4] } else { node.outside(probe.place) };
            if let Some(facing) = probe.facing {
                node.pass_over(facing, &mut bound);
            }
            bound
        };
        self.search(limit, self.per_unit * self.per_unit, bound, at)
    }

    /// The same for a ray of unit `direction`; the cost is how far along it is.
    pub fn along<T>(
        &self,
        origin: Vec3,
        direction: Vec3,
        at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let origin = (origin - self.centre) * self.per_unit;
        let inverse = direction.to_array().map(|d| (1.0 / f64::max(d.abs(), FLAT).copysign(d)) as f32);
        // The boxes themselves have room for rounding where all is within 1 of the centre.
        let pad = PAD * origin.abs().max_element() as f32;
        let origin = origin.to_array().map(|x| x as f32);
        self.search(f64::INFINITY, self.per_unit, |node: &Node| node.along(origin, inverse, pad), at)
    }

    /// Depth first, the nearest child before the others. `to_bounds` takes a cost to what `bound` is in.
    fn search<T>(
        &self,
        limit: f64,
        to_bounds: f64,
        bound: impl Fn(&Node) -> [f32; 4],
        mut at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let (mut best, mut least) = (None, limit);
        let rounded = |cost: f64| ((cost * to_bounds) as f32).next_up();
        let mut limit = rounded(limit);
        let mut stack = [(0.0f32, NOTHING); STACK];
        let mut height = 1;
        stack[0] = (0.0, 0);
        while height > 0 {
            height -= 1;
            let (bounded, child) = stack[height];
            if bounded >= limit {
                continue;
            }
            if child & LEAF != 0 {
                if let Some((cost, found)) = at(child & !LEAF, least)
                    && cost < least
                {
                    (least, limit, best) = (cost, rounded(cost), Some(found));
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let bounds = bound(node);
            let first = height;
            for (child, bounded) in node.child.into_iter().zip(bounds) {
                if child != NOTHING && bounded < limit {
                    // The nearest comes last, to be taken first.
                    let mut place = height;
                    while place > first && stack[place - 1].0 < bounded {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = (bounded, child);
                    height += 1;
                }
            }
        }
        best.map(|found| (least, found))
    }
}

/// The centre of it all, and what takes it to within 1 of that.
fn frame(bounds: impl Iterator<Item = Bounds>) -> (Vec3, f64) {
    let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = bounds.fold(nothing, |(low, high), of| (low.min(of.place[0]), high.max(of.place[1])));
    let (centre, size) = ((low + high) * 0.5, (high - low).max_element() * 0.5);
    if centre.is_finite() && size.is_finite() {
        (centre, 1.0 / size.clamp(1e-100, 1e100))
    } else {
        (Vec3::ZERO, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// The bounds of the triangles of a wavy sheet of `n` by `n` squares, `lift` above the plane.
    fn sheet(n: usize, lift: f64) -> Vec<Bounds> {
        let at = |i: usize, j: usize| {
            let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
            Vec3::new(x, y, lift + 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
        };
        let squares = (0..n * n).map(|k| (k / n, k % n));
        let halves = squares.flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        halves
            .map(|[a, b, c]| {
                let normal = (b - a).cross(c - a).normalize();
                Bounds { place: [a.min(b).min(c), a.max(b).max(c)], normal }
            })
            .collect()
    }

    /// The least squared distance to the centre of a box that faces the way of `facing`, and how many were looked at.
    fn nearest(tree: &Tree, bounds: &[Bounds], order: &[u32], point: Vec3, facing: Vec3) -> (f64, usize) {
        let looked_at = Cell::new(0);
        let at = |slot: u32, _| {
            looked_at.set(looked_at.get() + 1);
            let Bounds { place: [low, high], normal } = bounds[order[slot as usize] as usize];
            let squared = ((low + high) * 0.5).distance_squared(point);
            (normal.dot(facing) > 0.0).then_some((squared, ()))
        };
        let probe = tree.probe(point, Some(facing)).unwrap();
        let found = tree.nearest(&probe, f64::INFINITY, at);
        (found.map_or(f64::INFINITY, |found| found.0), looked_at.get())
    }

    #[test]
    fn nothing_nearer_is_passed_over() {
        for (shift, scale) in [(Vec3::ZERO, 1.0), (Vec3::new(3e5, -1e3, 7.0), 1.0), (Vec3::ONE, 1e-7)] {
            let moved = |bounds: &Bounds| {
                let place = bounds.place.map(|p| p * scale + shift);
                Bounds { place, ..*bounds }
            };
            let (flat, bounds): (Vec<Bounds>, Vec<Bounds>) =
                sheet(13, 0.2).iter().map(|of| (Bounds { place: [shift; 2], ..*of }, moved(of))).unzip();
            let (tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
            // Sorted where all lies in one place, and then moved apart.
            let (mut late, late_order) = Tree::new(&flat, 0..flat.len() as u32);
            late.fit(|slot| bounds[late_order[slot as usize] as usize]);
            for k in 0..60 {
                let way = Vec3::new((k as f64).sin(), (2.7 * k as f64).cos(), (1.9 * k as f64).sin());
                let off = [1.0, 0.01, 1e3, 1e9][k % 4];
                let point = shift + (Vec3::new(0.5, 0.4, 0.2) + way * off) * scale;
                let facing = Vec3::new(way.y, way.z, way.x) * 1e-30;
                let all = (0..bounds.len() as u32).collect::<Vec<_>>();
                let least = all.iter().filter(|&&t| bounds[t as usize].normal.dot(facing) > 0.0);
                let squared = |&t: &u32| {
                    ((bounds[t as usize].place[0] + bounds[t as usize].place[1]) * 0.5)
                        .distance_squared(point)
                };
                let expected = least.map(squared).fold(f64::INFINITY, f64::min);
                assert_eq!(nearest(&tree, &bounds, &order, point, facing).0, expected);
                assert_eq!(nearest(&late, &bounds, &late_order, point, facing).0, expected);
            }
        }
    }

    #[test]
    fn what_faces_away_costs_next_to_nothing_however_much_there_is() {
        // Closer by, as finely cut, is what faces away: one third of it is nearer than what is looked for, of which more
        // is as near to within the size of a triangle the smaller these are.
        let cost = |n: usize| -> f64 {
            let mut bounds = sheet(n, 0.0);
            bounds.extend(sheet(n, 0.3).iter().map(|of| Bounds { normal: -of.normal, ..*of }));
            let (tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
            let queries = sheet(20, 0.29);
            let each = queries.iter().map(|of| nearest(&tree, &bounds, &order, of.place[0], of.normal).1);
            each.sum::<usize>() as f64 / queries.len() as f64
        };
        let (few, many) = (cost(20), cost(80));
        assert!(few < 50.0 && many < 5.0 * few, "{few} of 1600 triangles looked at, {many} of 25600");
    }

    #[test]
    fn no_direction_and_no_triangles_find_nothing() {
        let (tree, order) = Tree::new(&[], 0..0);
        assert_eq!(nearest(&tree, &[], &order, Vec3::ZERO, Vec3::X), (f64::INFINITY, 0));
        assert!(tree.probe(Vec3::ZERO, Some(Vec3::ZERO)).is_none());
        assert!(tree.probe(Vec3::ZERO, Some(Vec3::splat(f64::NAN))).is_none());
    }
}
