//! Options of a transfer.

use crate::options::{choices, options};

choices! {
    /// What a component of the target does that no source triangle is matched with.
    pub enum Unmatched {
        /// It follows the nearest matched surface of the target, rigidly.
        Follow = "follow",
        /// It stays at rest.
        Rest = "rest",
    }
}

choices! {
    /// How much each target triangle counts.
    pub enum Weighting {
        /// By its area, so that the result does not depend on how finely either mesh is cut.
        Area = "area",
        /// By its number of matches, as in the paper.
        Pairs = "pairs",
    }
}

choices! {
    /// How far the target goes for what the source does.
    pub enum Scale {
        /// With the size of the target: on one twice as large twice as far.
        Target = "target",
        /// As far as on the source, in its units: 1 cm stays 1 cm; the whole mesh turns as there.
        Source = "source",
    }
}

choices! {
    /// In which directions a place of the target moves.
    pub enum Frames {
        /// In those in which its place on the source moves: up stays up.
        Global = "global",
        /// Turned as the surface there is turned against the source's: along a brow stays along it.
        Local = "local",
    }
}

options! {
    /// Options of a transfer ([`super::anchor`], [`super::contact`]).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TransferOptions {
        /// What components of the target do that no part of the source matches, such as eyes and teeth.
        pub unmatched: Unmatched = Unmatched::Follow,
        /// How much each triangle of the target counts.
        pub weighting: Weighting = Weighting::Area,
        /// How far the target goes for what the source does.
        pub scale: Scale = Scale::Target,
        /// In which directions a place of the target moves.
        pub frames: Frames = Frames::Global,
        /// The length below which gradients rule and beyond it displacements: lower suits shapes that are much
        /// alike, inf is gradients alone.
        pub anchor: f64 = 1.0 => above(0.0) at_most(f64::INFINITY) unit("of the target's diagonal"),
        /// Openings of another height that close on the source, as lids do in a blink, close by the same part of it on
        /// the target, and slide around closed convex parts, as eyes are.
        pub contact: bool = true,
        /// How many times as long as at rest edges of the target get at most, unless the source is stretched as much
        /// there; inf for any.
        pub stretch: f64 = 3.0 => at_least(1.0) at_most(f64::INFINITY),
    }
}

options! {
    /// Options of learning from corrected keys ([`super::learn()`]).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LearnOptions {
        /// How much of what is learned is taken.
        pub strength: f64 = 1.0 => at_least(0.0),
        /// How far around a correction it counts.
        pub reach: f64 = 0.04 => above(0.0) at_most(1.0) unit("of the mesh's diagonal"),
    }
}
