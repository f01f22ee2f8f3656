//! The methods by name: which there are, and how each is bound.

use super::method::Method;
use super::region::Region;
use super::responses::Linear;
use super::{arap, laplacian, laplacian_fitted, multiresolution, poisson, rotation_invariant, thin_shell};
use crate::{Job, Result};

/// Names of the methods, as in `lissom.POSE_METHODS`.
pub const METHODS: &[&str] = &[
    "laplacian",
    "laplacian_fitted",
    "rotation_invariant",
    "thin_shell",
    "poisson",
    "multiresolution",
    "arap",
];

/// A method and its options; one of [`METHODS`] each.
#[derive(Debug, Clone)]
pub enum MethodOptions {
    /// [`laplacian`]
    Laplacian(laplacian::Options),
    /// [`laplacian_fitted`]
    LaplacianFitted(laplacian_fitted::Options),
    /// [`thin_shell`]
    ThinShell(thin_shell::Options),
    /// [`rotation_invariant`]
    RotationInvariant(rotation_invariant::Options),
    /// [`poisson`]
    Poisson(poisson::Options),
    /// [`multiresolution`]
    Multiresolution(multiresolution::Options),
    /// [`arap`]
    Arap(arap::Options),
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self::Arap(arap::Options::default())
    }
}

impl MethodOptions {
    pub(super) fn bind(&self, region: &Region, job: &Job) -> Result<Box<dyn Method>> {
        Ok(match self {
            Self::Laplacian(options) => {
                Box::new(Linear::new(laplacian::Laplacian::new(region, options, job)?))
            }
            Self::LaplacianFitted(options) => {
                Box::new(Linear::new(laplacian_fitted::LaplacianFitted::new(region, options, job)?))
            }
            Self::ThinShell(options) => {
                Box::new(Linear::new(thin_shell::ThinShell::new(region, options, job)?))
            }
            Self::RotationInvariant(options) => rotation_invariant::bind(region, options, job)?,
            Self::Poisson(options) => Box::new(poisson::Poisson::new(region, options, job)?),
            Self::Multiresolution(options) => {
                Box::new(multiresolution::Multiresolution::new(region, options, job)?)
            }
            Self::Arap(options) => Box::new(arap::Arap::new(region, options, job)?),
        })
    }
}
