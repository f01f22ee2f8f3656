//! Options of the fit.

use crate::Vec3;
use crate::options::options;

/// Most weights, and most rounds at each; far beyond what anything gains from.
const MOST_ROUNDS: f64 = 1000.0;

options! {
    /// Options of the fit: `w_S`, `w_I` and the largest `w_C`, and how it goes about it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FitOptions {
        /// Where on the target the source vertex of each marker belongs, where that is not at its vertices;
        /// a marker's target vertex then only names it.
        pub points: Vec<Vec3> = Vec::new() => unit("the target's units"),
        /// Where on the source each marker is, where that is not at its vertices; a marker's source vertex then
        /// only names it.
        pub source_points: Vec<Vec3> = Vec::new() => unit("the source's units"),
        /// Edge paths of the source, each with one of the target that belongs to it: rims of lids, lips. One that ends
        /// with its first vertex is closed. They are matched by length between the markers that lie on both.
        pub curves: Vec<[Vec<u32>; 2]> = Vec::new(),
        /// How far off markers may be: they pull at first and are released in the end. 0 takes them as exact.
        pub marker_tolerance: f64 = 0.01 => at_least(0.0) unit("of the target's diagonal"),
        /// How much neighbouring triangles must change alike.
        pub smoothness: f64 = 1.0 => above(0.0),
        /// How much triangles must keep their shape and orientation.
        pub identity: f64 = 0.1 => above(0.0),
        /// How tightly the source is pulled onto the target in the end.
        pub closest: f64 = 500.0 => at_least(1.0),
        /// How many pulls it takes from 1 to the tightest, each of which costs a factorization.
        pub steps: usize = 6 => at_least(1.0) at_most(MOST_ROUNDS),
        /// Rounds of closest points at each pull.
        pub rounds: usize = 4 => at_least(1.0) at_most(MOST_ROUNDS),
        /// How far the centre of a triangle may be from the other surface to be matched there.
        pub match_distance: f64 = 0.02 => above(0.0) unit("of the target's diagonal"),
        /// How people of the source's kind differ from it, most of all first: offsets of its vertices, as long as they
        /// spread. The fit begins at the one that the target looks like.
        pub modes: Vec<Vec<Vec3>> = Vec::new() => unit("the source's units"),
        /// Without markers, by how much the target is turned against the source at most; 180 for any way.
        pub most_turn: f64 = 180.0 => above(0.0) at_most(180.0) unit("degrees"),
        /// The meshes lie on each other as they are, as clothes lie on a body: every place belongs to the closest
        /// one within `match_distance`, nothing is pulled, and motions keep their size. Takes no markers.
        pub overlap: bool = false,
        /// Vertices of the source that match nothing: the inside of a mouth, eye sockets.
        pub source_mask: Vec<u32> = Vec::new(),
        /// Vertices of the target that match nothing.
        pub target_mask: Vec<u32> = Vec::new(),
    }
}

impl FitOptions {
    /// How far on the way from the first step to the last one a step is; at its end where it is the only one.
    pub(super) fn share_of(&self, step: usize) -> f64 {
        if self.steps == 1 { 1.0 } else { step as f64 / (self.steps - 1) as f64 }
    }
}
