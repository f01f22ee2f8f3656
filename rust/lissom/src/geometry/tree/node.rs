//! A node of a tree: its four children side by side, and what a search asks of them.

/// By how much boxes are larger than what is in them, in the tree's units, where everything is within 1 of the centre:
/// more than all that is lost by rounding to single precision.
pub const PAD: f32 = 1e-6;

/// In the place of a child that there is not.
pub const NOTHING: u32 = u32::MAX;

/// Children with this bit are slots, others are nodes.
pub const LEAF: u32 = 1 << 31;

/// Four children; of each coordinate all four in a row.
#[derive(Clone)]
pub struct Node {
    /// Their boxes, ...
    pub low: [[f32; 4]; 3],
    pub high: [[f32; 4]; 3],
    /// ... those of the normals in them, ...
    pub normal_low: [[f32; 4]; 3],
    pub normal_high: [[f32; 4]; 3],
    /// ... which they are, ...
    pub child: [u32; 4],
    /// ... and the first slot below each.
    pub first: [u32; 4],
}

impl Node {
    /// No children yet.
    pub fn nothing() -> Self {
        let (low, high) = ([[f32::INFINITY; 4]; 3], [[f32::NEG_INFINITY; 4]; 3]);
        Self { low, high, normal_low: low, normal_high: high, child: [NOTHING; 4], first: [NOTHING; 4] }
    }

    /// The boxes around all children.
    #[inline]
    pub fn joined(&self) -> [[f32; 3]; 4] {
        let mut joined =
            [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3], [f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        (0..3).for_each(|axis| {
            (0..4).for_each(|k| {
                joined[0][axis] = joined[0][axis].min(self.low[axis][k]);
                joined[1][axis] = joined[1][axis].max(self.high[axis][k]);
                joined[2][axis] = joined[2][axis].min(self.normal_low[axis][k]);
                joined[3][axis] = joined[3][axis].max(self.normal_high[axis][k]);
            });
        });
        joined
    }

    /// The square of how far each child is at least from a point.
    // Plain loops become vector instructions in every build; iterators do not where nothing is inlined across crates.
    #[allow(clippy::needless_range_loop)]
    #[inline]
    pub fn outside(&self, place: [f32; 3]) -> [f32; 4] {
        let mut squared = [0.0f32; 4];
        for axis in 0..3 {
            for k in 0..4 {
                let below = self.low[axis][k] - place[axis];
                let above = place[axis] - self.high[axis][k];
                let out = if below > above { below } else { above };
                let out = if out > 0.0 { out } else { 0.0 };
                squared[k] += out * out;
            }
        }
        // Far from the boxes the error is a part of the distance.
        squared.iter_mut().for_each(|x| *x *= 1.0 - PAD);
        squared
    }

    /// How far along a ray each child is at least, infinite where it is not; of the direction the inverse, and boxes are
    /// larger by `pad`.
    // As above.
    #[allow(clippy::needless_range_loop)]
    #[inline]
    pub fn along(&self, origin: [f32; 3], inverse: [f32; 3], pad: f32) -> [f32; 4] {
        let (mut near, mut far) = ([0.0f32; 4], [f32::INFINITY; 4]);
        for axis in 0..3 {
            let up = inverse[axis] > 0.0;
            let (first, last) = if up { (&self.low, &self.high) } else { (&self.high, &self.low) };
            let pad = if up { pad } else { -pad };
            for k in 0..4 {
                let enter = (first[axis][k] - pad - origin[axis]) * inverse[axis];
                let leave = (last[axis][k] + pad - origin[axis]) * inverse[axis];
                near[k] = if enter > near[k] { enter } else { near[k] };
                far[k] = if leave < far[k] { leave } else { far[k] };
            }
        }
        for k in 0..4 {
            let met = near[k] * (1.0 - PAD) <= far[k] * (1.0 + PAD);
            near[k] = if met { near[k] * (1.0 - PAD) } else { f32::INFINITY };
        }
        near
    }

    /// Deals out slots below the node, which ascend, to the children that they are below; where among all they begin and
    /// end is what comes in and goes out.
    #[inline]
    pub fn deal(&self, slots: &[u32], [begin, end]: [u32; 2], bound: &mut [f32; 4]) -> [[u32; 2]; 4] {
        let mut shares = [[end; 2]; 4];
        let mut from = begin;
        for k in 0..4 {
            let next = self.first.get(k + 1).copied().unwrap_or(NOTHING);
            let own = &slots[from as usize..end as usize];
            let to = from + own.partition_point(|&slot| slot < next) as u32;
            shares[k] = [from, to];
            if from == to {
                bound[k] = f32::INFINITY;
            }
            from = to;
        }
        shares
    }

    /// Leaves out the children in which nothing faces the way of a normal.
    #[allow(clippy::needless_range_loop)]
    #[inline]
    pub fn pass_over(&self, facing: [f32; 3], bound: &mut [f32; 4]) {
        let mut most = [0.0f32; 4];
        for axis in 0..3 {
            let side = if facing[axis] > 0.0 { &self.normal_high } else { &self.normal_low };
            for k in 0..4 {
                most[k] += side[axis][k] * facing[axis];
            }
        }
        for k in 0..4 {
            bound[k] = if most[k] > -PAD { bound[k] } else { f32::INFINITY };
        }
    }
}
