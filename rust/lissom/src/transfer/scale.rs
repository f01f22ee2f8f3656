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
use super::choose::Chooser;
use super::place::Placer;
use super::sizes::Sizes;
use crate::{Mat3, Mesh, Vec3};

/// `1 / r` of each component of a target.
pub struct Scaling {
    factors: Vec<f64>,
}

impl Scaling {
    /// The lengths of components against those of their anchors, or of their matches.
    pub fn new(target: &Mesh, anchors: &Anchors, placer: &Placer, sizes: Sizes) -> Self {
        let factor = |c: usize| {
            let size = if anchors.hold(c) { anchors.size(c) } else { placer.size(c) };
            sizes.gain(size) / size
        };
        Self { factors: (0..target.components().count()).map(factor).collect() }
    }

    /// `1 / r` where a target triangle is.
    pub fn factor(&self, target: &Mesh, triangle: usize) -> f64 {
        let component = target.components().of_vertex(target.triangles()[triangle][0] as usize);
        component.map_or(1.0, |c| self.factors[c])
    }

    /// Makes `C' - I` of the `C - I` of every target triangle, where the images have gone by `moved`.
    pub fn apply(
        &self,
        target: &Mesh,
        chooser: &Chooser,
        anchors: &Anchors,
        moved: &[Vec3],
        changes: &mut [Mat3],
    ) {
        if self.factors.iter().all(|&factor| factor == 1.0) {
            return;
        }
        let wholes: Vec<Option<Whole>> =
            (0..self.factors.len()).map(|c| anchors.whole(c, chooser, moved)).collect();
        for (corners, change) in target.triangles().iter().zip(changes) {
            let Some(c) = target.components().of_vertex(corners[0] as usize) else { continue };
            let asked = |whole: &Whole| {
                let beyond = *change + Mat3::IDENTITY - whole.of_source();
                whole.linear() - Mat3::IDENTITY + beyond * self.factors[c]
            };
            *change = wholes[c].as_ref().map_or(*change * self.factors[c], asked);
        }
    }
}
