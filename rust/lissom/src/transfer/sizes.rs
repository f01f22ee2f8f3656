//! Sizes: how lengths and displacements on the source become those on the target ([`super::scale`]).

use super::options::Scale;
use crate::Mesh;

/// How lengths in the unit coordinates of the source become those of the target.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    /// `r`, where it is not each component's own.
    size: Option<f64>,
    /// What displacements are multiplied with, where it is not `r`.
    gain: Option<f64>,
}

impl Sizes {
    /// By an option; meshes that `overlap` have one size, however far off the body clothes lie.
    pub fn new(source: &Mesh, target: &Mesh, scale: Scale, overlap: bool) -> Self {
        let as_they_are = Some(source.frame().scale / target.frame().scale);
        let keep = scale == Scale::Source;
        Self { size: as_they_are.filter(|_| overlap), gain: as_they_are.filter(|_| keep) }
    }

    /// `r` of a component that is so many times as large as what it is matched with.
    pub fn size(self, own: f64) -> f64 {
        self.size.unwrap_or(own)
    }

    /// What displacements are multiplied with, for a component with this `r`.
    pub fn gain(self, size: f64) -> f64 {
        self.gain.unwrap_or(size)
    }
}
