//! Options of a path and of a blend.

use std::sync::Arc;

use super::stretch::Stretch;
use crate::mesh::Plane;
use crate::options::{choices, options};
use crate::{Mesh, Vec3};

choices! {
    /// How the turn of a triangle is chosen among all that lead to the same rotation.
    pub enum Rotation {
        /// Neighbouring triangles turn together: twists beyond half a turn, and several turns, come out whole.
        Consistent = "consistent",
        /// The turns between neighbours are spread over the whole mesh: for several turns along a long part.
        Relative = "relative",
        /// Every triangle turns by at most half a turn, by itself.
        Shortest = "shortest",
    }
}

options! {
    /// Options of [`super::Inbetween`] and [`super::Route`].
    #[derive(Debug, Clone)]
    pub struct InbetweenOptions {
        /// How the turn of every triangle is chosen.
        pub rotation: Rotation = Rotation::Consistent,
        /// How triangles grow and shrink along the path.
        pub stretch: Stretch = Stretch::Linear,
        /// Rounds in which turns are fitted to the shapes that came out, by a radian at most: lengths along the path
        /// get up to twice as good in 4 to 16.
        pub refinement: usize = 0,
        /// Shapes to hit on the way, each (time, positions), in ascending order; speed may change there.
        pub through: Vec<(f64, Vec<Vec3>)> = Vec::new(),
        /// Closed components keep their volume: it changes in equal steps and none is lost between the ends.
        pub preserve_volume: bool = false,
        /// A closed mesh in the same units, as an eyeball under a lid, that no vertex enters deeper than at the
        /// deeper of its ends, or comes closer to than at the closer one.
        pub clearance: Option<Arc<Mesh>> = None,
        /// Where the vertices of that mesh are at the end, if they move.
        pub clearance_end: Option<Vec<Vec3>> = None => unit("the mesh's units"),
        /// Planes, each (point, normal), that complete half shapes by their mirror image: vertices on them in all shapes stay
        /// on them.
        pub mirror: Vec<Plane> = Vec::new(),
        /// How far a vertex may be from its mirror image to be on the plane.
        pub mirror_tolerance: f64 = 1e-4 => at_least(0.0) unit("of the diagonal"),
    }
}

options! {
    /// Options of [`super::Blend`].
    #[derive(Debug, Clone)]
    pub struct BlendOptions {
        /// Rounds in which turns are fitted to the shape that came out.
        pub refinement: usize = 0,
    }
}
