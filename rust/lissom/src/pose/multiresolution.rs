//! Multiresolution editing (thesis of S. Zhou 2008, 1.2.2; Botsch, Sumner, Pauly & Gross 2006, Deformation
//! Transfer for Detail-Preserving Surface Editing).
//!
//! ```text
//!     S = B + D        B -> B' by any other method        S' = B' + D
//! ```
//!
//! The base minimises `int |b - v|^2 + l^4 |Lap b|^2` with handles and border in place (implicit fairing,
//! Desbrun, Meyer, Schröder & Barr 1999): a wave of length `2 pi l` keeps half its height, shorter ones
//! are details. Details are put back in one of two ways: as offsets that turn with the base,
//! `x_i = b'_i + R_i (v_i - b_i)`, or by stitching the base's deformation gradients on the surface itself,
//! which costs one more solve and does not let long details fan out or run into each other.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::field::inverse_mass;
use super::goal::Goal;
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use super::registry::{MethodOptions, no_method};
use crate::linear::{ConstrainedSystem, Constraints, SplitMatrix, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::gradient::deformation_gradients;
use crate::options::{choices, options};
use crate::rotation::nearest_rotation;
use crate::stitch::{Owners, Reference, Stitcher, Weights};
use crate::{Job, Mat3, Mesh, Result, Vec3};

choices! {
    /// How details are put back.
    pub enum Details {
        /// Every triangle turns as its base does, and all are stitched.
        Gradients = "gradients",
        /// Every vertex keeps its offset in the frame of its base.
        Offsets = "offsets",
    }
}

options! {
    /// Options of multiresolution editing; those of the base's method are among them.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// Bumps narrower than this are details, and follow the base.
        pub smoothing: f64 = 0.2 => at_least(0.0) unit("of the mesh's diagonal"),
        /// How details are put back on the posed base.
        pub details: Details = Details::Gradients,
        /// The method that poses the smooth base, whose options may be given too.
        pub base: Box<MethodOptions> = Box::new(MethodOptions::Poisson(super::poisson::Options::default()))
            => otherwise(no_method),
        ..base
    }
}

/// Binds the method to a region.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Multiresolution::new(region, options, job)?))
}

/// Multiresolution editing bound to a region.
#[derive(Debug)]
pub struct Multiresolution {
    /// The region on the base.
    base: Region,
    method: Box<dyn Method>,
    details: Replace,
}

#[derive(Debug)]
enum Replace {
    Gradients(Box<Stitcher>),
    /// `v - b`.
    Offsets(Vec<Vec3>),
}

impl Multiresolution {
    /// Smooths the region and binds the base's method.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where a system cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let offsets = details(region, options.smoothing / TAU, job)?;
        let smooth = mesh.rest().iter().zip(&offsets).map(|(&v, &d)| v - d).collect();
        let base = region.reshaped(smooth);
        let method = options.base.bind(&base, job)?;
        let details = match options.details {
            Details::Gradients => {
                let (mesh, constraints) = (mesh.clone(), region.constraints().clone());
                let (owners, weights) = (Owners::Triangles, Weights::Cotangent);
                let stitcher = Stitcher::new(mesh, owners, weights, None, constraints, job)?;
                Replace::Gradients(Box::new(stitcher))
            }
            Details::Offsets => Replace::Offsets(offsets),
        };
        Ok(Self { base, method, details })
    }
}

/// `v - b`: the solution of `(M + l^4 L M^-1 L) d = l^4 L M^-1 L v`, zero in handles and at the border.
fn details(region: &Region, length: f64, job: &Job) -> Result<Vec<Vec3>> {
    let mesh = region.mesh();
    let (laplacian, inverse) = (cotangent_laplacian(mesh), inverse_mass(mesh));
    let bending = SplitMatrix::sandwich(&laplacian, &inverse)?;
    let mass = (0u32..).zip(&inverse).map(|(v, inverse)| (v, v, 1.0 / inverse));
    let mass = SymmetricMatrix::from_entries(mesh.rest().len(), mass);
    let stiffness = length.powi(4);
    let held = |v: usize| region.handle_of(v).is_some() || region.constraints().slot(v as u32).is_none();
    let constraints = Constraints::hard(mesh.rest().len(), held);
    let matrix = SplitMatrix::from(mass).combine(1.0, &bending, stiffness);
    let system = ConstrainedSystem::of_split(&matrix, constraints, job)?;
    let bent = laplacian.times_vectors(mesh.rest()).into_iter().zip(&inverse);
    let bent: Vec<Vec3> = bent.map(|(bent, &inverse)| bent * (stiffness * inverse)).collect();
    let forces = laplacian.times_vectors(&bent);
    let mut details = [vec![Vec3::ZERO; forces.len()]];
    system.solve(&[forces], &mut details);
    let [details] = details;
    Ok(details)
}

impl Method for Multiresolution {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        let mut systems = self.method.systems();
        if let Replace::Gradients(stitcher) = &self.details {
            systems.push(stitcher.system());
        }
        systems
    }

    fn keep(&mut self) {
        self.method.keep();
    }

    fn solve(&mut self, _: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution> {
        // Handles have no details: the goal of the surface is that of the base.
        let mut solution = self.method.solve(&self.base, goal, options, job)?;
        let base = self.base.mesh();
        let moved: Vec<Vec3> =
            (base.rest().iter().zip(&solution.displacements)).map(|(&b, &d)| b + d).collect();
        let mut gradients = deformation_gradients(base, &moved);
        match &self.details {
            Replace::Gradients(stitcher) => {
                solution.displacements.copy_from_slice(&goal.displacements);
                gradients.par_iter_mut().for_each(|q| *q -= Mat3::IDENTITY);
                stitcher.stitch(Reference::Rest, &gradients, &mut solution.displacements);
            }
            Replace::Offsets(offsets) => {
                let turned: Vec<Vec3> = (0..offsets.len())
                    .into_par_iter()
                    .map(|v| (frame(base, &gradients, v) - Mat3::IDENTITY) * offsets[v])
                    .collect();
                solution.displacements.iter_mut().zip(turned).for_each(|(d, turned)| *d += turned);
            }
        }
        Ok(solution)
    }
}

/// How the base turns at a vertex: the rotation nearest to the mean of its triangles' gradients.
fn frame(base: &Mesh, gradients: &[Mat3], vertex: usize) -> Mat3 {
    let corners = base.adjacency().corners_of(vertex).iter().map(|c| c.triangle as usize);
    nearest_rotation(corners.fold(Mat3::ZERO, |sum, t| sum + gradients[t] * base.areas()[t]))
}
