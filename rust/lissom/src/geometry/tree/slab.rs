//! Slabs: what no triangle of a node can be nearer than, beside its box.
//!
//! ```text
//!     max( n . p - max n . x,   min n . x - n . p )
//! ```
//!
//! in the direction `n` that the node's triangles face (Kay & Kajiya 1986, Ray Tracing Complex Scenes). Near the middle of
//! a round body all of its surface is about equally far. There boxes are off by their own size and tell nothing; slabs are
//! off by the square of it. In double precision, since that is less than single precision tells of finely cut ones.

use crate::Vec3;

/// More than all that is lost by rounding, in the tree's units.
const PAD: f64 = 1e-13;

/// The slabs of four children; of each coordinate all four in a row.
#[derive(Clone)]
pub struct Slabs {
    normal: [[f64; 4]; 3],
    low: [f64; 4],
    high: [f64; 4],
}

impl Slabs {
    /// Around the triangles of each child.
    pub fn around(children: [impl Iterator<Item = [Vec3; 3]> + Clone; 4]) -> Self {
        let mut slabs = Self { normal: [[0.0; 4]; 3], low: [0.0; 4], high: [0.0; 4] };
        for (k, triangles) in children.into_iter().enumerate() {
            let across = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
            let normal = triangles.clone().map(across).sum::<Vec3>().normalize_or_zero();
            let heights = triangles.flatten().map(|x| normal.dot(x));
            (slabs.low[k], slabs.high[k]) =
                heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
            (0..3).for_each(|axis| slabs.normal[axis][k] = normal[axis]);
        }
        slabs
    }

    /// Raises the squares of how far each child is at least from a point.
    // Plain loops become vector instructions in every build.
    #[allow(clippy::needless_range_loop)]
    #[inline]
    pub fn raise(&self, place: Vec3, bound: &mut [f32; 4]) {
        let place = place.to_array();
        let mut height = [0.0f64; 4];
        for axis in 0..3 {
            for k in 0..4 {
                height[k] += self.normal[axis][k] * place[axis];
            }
        }
        for k in 0..4 {
            let (above, below) = (height[k] - self.high[k], self.low[k] - height[k]);
            let out = (if above > below { above } else { below }) - PAD;
            let squared = ((out * out) as f32).next_down();
            if out > 0.0 && squared > bound[k] {
                bound[k] = squared;
            }
        }
    }
}
