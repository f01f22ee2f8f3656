//! Scale: how far the target goes for what the source does.
//!
//! Gradients have no size: a target twice as large makes every motion twice as large, as its features are. Where
//! motions are to keep their own size, so that a smile of 1 cm is one of 1 cm, the displacement of the target at
//! `x` is that of the source at the image of `x`, and as lengths on the target are `r` times those on the source,
//! the changes asked of its triangles are `1 / r` of what they are there:
//!
//! ```text
//!     C' = A' + (C - A) / r
//! ```
//!
//! `A` is what a component does as a whole ([`super::anchor`]): turns have no size either, and a head that turns by 90
//! degrees does so on every target; `A'` is the same turn with `1 / r` of the growth. `r` is a component's own:
//! that of its anchors, or of its matches where it has none. With `r = 1` it is `C' = C`.

use super::anchor::{Anchors, Whole};
use super::apply::Transfer;
use super::choose::SourceKey;
use super::options::Scale;
use super::place::Placer;
use crate::{Mat3, Mesh, Vec3};

/// What a displacement in the source's unit coordinates is in the target's, where motions keep their own size;
/// `None` where they go with the size of the target.
pub fn gain(source: &Mesh, target: &Mesh, scale: Scale) -> Option<f64> {
    match scale {
        Scale::Target => None,
        Scale::Source => Some(source.frame().scale / target.frame().scale),
    }
}

/// `1 / r` of each component of the target.
pub fn factors(target: &Mesh, anchors: &Anchors, placer: &Placer, gain: Option<f64>) -> Vec<f64> {
    let factor = |c: usize| {
        let size = if anchors.hold(c) { anchors.size(c) } else { placer.size(c) };
        gain.map_or(1.0, |gain| gain / size)
    };
    (0..target.components().count()).map(factor).collect()
}

impl Transfer {
    /// Of every target triangle `C' - I`, and whether it moves.
    pub(super) fn changes(&self, key: &SourceKey, moved: &[Vec3]) -> (Vec<Mat3>, Vec<bool>) {
        let (mut changes, moves) = self.chooser.changes(&self.target, key, moved);
        if self.factors.iter().all(|&factor| factor == 1.0) {
            return (changes, moves);
        }
        let wholes: Vec<Option<Whole>> =
            (0..self.factors.len()).map(|c| self.anchors.whole(c, &self.chooser, moved)).collect();
        for (corners, change) in self.target.triangles().iter().zip(&mut changes) {
            let Some(c) = self.target.components().of_vertex(corners[0] as usize) else { continue };
            let asked = |whole: &Whole| {
                whole.linear() - Mat3::IDENTITY
                    + (*change + Mat3::IDENTITY - whole.of_source()) * self.factors[c]
            };
            *change = wholes[c].as_ref().map_or(*change * self.factors[c], asked);
        }
        (changes, moves)
    }
}
