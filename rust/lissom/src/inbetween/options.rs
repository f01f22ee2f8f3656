//! What a path may be told.

use std::sync::Arc;

use super::stretch::Stretch;
use crate::{Mesh, Vec3};

/// How the turn of a triangle is chosen among all that lead to the same rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rotation {
    /// Neighbours turn together: twists beyond half a turn, and several turns, come out whole.
    #[default]
    Consistent,
    /// The turns between neighbours, integrated over the whole mesh.
    Relative,
    /// Every triangle by at most half a turn.
    Shortest,
}

/// Options of [`Inbetween`].
#[derive(Debug, Clone, Default)]
pub struct InbetweenOptions {
    /// How turns are chosen.
    pub rotation: Rotation,
    /// How stretches go from start to end.
    pub stretch: Stretch,
    /// How many rounds of refitting the rotations to the stitched shape.
    pub refinement: usize,
    /// Whether closed components keep their volume, in equal steps from the start's to the end's.
    pub preserve_volume: bool,
    /// What no in-between may enter deeper than the ends do.
    pub clearance: Option<Obstacle>,
}

/// A closed surface in the same units, and where its vertices are at the end, if elsewhere.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// Where it is at the start.
    pub mesh: Arc<Mesh>,
    /// One position per vertex.
    pub end: Option<Vec<Vec3>>,
}
