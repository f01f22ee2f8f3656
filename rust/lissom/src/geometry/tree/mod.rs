//! A tree of boxes over triangles, in which what faces the wrong way is passed over like what is too far.
//!
//! Four children a node, side by side, so that one pass of vector instructions looks at all (Wald, Benthin & Boulos
//! 2008, Getting Rid of Packets); in single precision, rounded outwards. Beside the box of its places a child has the
//! box of its *normals*: where no normal in it is within 90 degrees of the one asked for, nothing below is compatible. A
//! tree without them finds out triangle by triangle, and where all around faces away that is all of them (cones of
//! normals: Johnson & Cohen 2001, Spatialized Normal Cone Hierarchies; boxes take no trigonometry to join).

mod growth;
mod node;
mod slab;
#[cfg(test)]
mod tests;

use self::growth::{Branch, Item, grow};
use self::node::{LEAF, NOTHING, Node, PAD};
use self::slab::Slabs;
use crate::Vec3;

/// Points further away are not rounded to single precision, but look at all boxes.
const FAR: f64 = 1e6;

/// Directions are no nearer to an axis' plane: their inverses are finite, and a ray that leaves the plane by less passes all
/// boxes before it has left one by their room for rounding.
const FLAT: f64 = 1e-12;

/// Places on the stack of a search: a node leaves three, and all but three of the nodes above each other have a quarter of
/// what the one above has.
const STACK: usize = 64;

/// Reach is meant to include what is just as far; by this part of its square, which rounding loses.
const ROUNDING: f64 = 1e-12;

/// The square up to which a search looks that reaches so far.
pub fn squared_limit(reach: f64) -> f64 {
    reach * reach * (1.0 + ROUNDING) + f64::MIN_POSITIVE
}

/// The tree; what it holds has a *slot* each.
pub struct Tree {
    nodes: Vec<Node>,
    /// Of each node, or none at all.
    slabs: Vec<Slabs>,
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
    exact: Vec3,
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
        let mut tree = Self { nodes, slabs: Vec::new(), slots: items.len() as u32, centre, per_unit };
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
            self.nodes[own].first[k] = *slot;
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
        self.slabs.clear();
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

    /// Lets a search pass over what is in a slab that is too far, until the tree is fitted again; `corners` are those of the
    /// triangle in each slot.
    pub fn add_slabs(&mut self, corners: impl Fn(u32) -> [Vec3; 3]) {
        let placed = |slot| corners(slot).map(|p| (p - self.centre) * self.per_unit);
        // Where what is below each node ends; children come after their parents.
        let mut end = vec![self.slots; self.nodes.len()];
        let mut slabs = Vec::with_capacity(self.nodes.len());
        for (own, node) in self.nodes.iter().enumerate() {
            let ends = [1, 2, 3, 4].map(|k| node.first.get(k).map_or(end[own], |&next| next.min(end[own])));
            for (&child, end_of_child) in node.child.iter().zip(ends) {
                if child & LEAF == 0 {
                    end[child as usize] = end_of_child;
                }
            }
            slabs.push(Slabs::around([0, 1, 2, 3].map(|k| (node.first[k]..ends[k]).map(&placed))));
        }
        self.slabs = slabs;
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
        Some(Probe { exact: q, place: q.to_array().map(|x| x as f32), is_far, facing })
    }

    /// Which slot holds the best, of which `at` tells its cost and whatever else: the square of a distance from the
    /// probe, below `limit`.
    pub fn nearest<T>(
        &self,
        probe: &Probe,
        limit: f64,
        at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let bound = |own, ()| (self.bound(own, probe), [(); 4]);
        self.search(limit, self.per_unit * self.per_unit, (), bound, at)
    }

    /// The same among `slots`, which ascend: where none of them is below a node, it is not looked into.
    pub fn nearest_of<T>(
        &self,
        slots: &[u32],
        probe: &Probe,
        limit: f64,
        at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let bound = |own: usize, all| {
            let mut bound = self.bound(own, probe);
            let shares = self.nodes[own].deal(slots, all, &mut bound);
            (bound, shares)
        };
        self.search(limit, self.per_unit * self.per_unit, [0, slots.len() as u32], bound, at)
    }

    #[inline]
    fn bound(&self, own: usize, probe: &Probe) -> [f32; 4] {
        let node = &self.nodes[own];
        let mut bound = if probe.is_far { [0.0; 4] } else { node.outside(probe.place) };
        if let Some(facing) = probe.facing {
            node.pass_over(facing, &mut bound);
        }
        if let Some(slabs) = self.slabs.get(own)
            && !probe.is_far
        {
            slabs.raise(probe.exact, &mut bound);
        }
        bound
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
        let bound = |own: usize, ()| (self.nodes[own].along(origin, inverse, pad), [(); 4]);
        self.search(f64::INFINITY, self.per_unit, (), bound, at)
    }

    /// Depth first, the nearest child before the others. `to_bounds` takes a cost to what `bound` is in, which is told what
    /// it has told of the node as a child: `all` of the first.
    fn search<T, S: Copy>(
        &self,
        limit: f64,
        to_bounds: f64,
        all: S,
        bound: impl Fn(usize, S) -> ([f32; 4], [S; 4]),
        mut at: impl FnMut(u32, f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let (mut best, mut least) = (None, limit);
        let rounded = |cost: f64| ((cost * to_bounds) as f32).next_up();
        let mut limit = rounded(limit);
        let mut stack = [(0.0f32, 0, all); STACK];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (bounded, child, share) = stack[height];
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
            let (bounds, shares) = bound(child as usize, share);
            let first = height;
            for ((child, bounded), share) in
                self.nodes[child as usize].child.into_iter().zip(bounds).zip(shares)
            {
                if child != NOTHING && bounded < limit {
                    // The nearest comes last, to be taken first.
                    let mut place = height;
                    while place > first && stack[place - 1].0 < bounded {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = (bounded, child, share);
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
