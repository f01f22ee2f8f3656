//! Poisson editing (thesis of S. Zhou 2008, 1.2.1; Yu, Zhou, Xu, Shi, Bao, Guo & Shum 2004, Mesh Editing
//! with Poisson-Based Gradient Field Manipulation; Zayer, Rössl, Karni & Seidel 2005, Harmonic Guidance
//! for Surface Deformation).
//!
//! Each handle `h` turns by the rotation vector `r_h` and stretches by `S_h`, and has a smooth weight
//! field `w_h`: 1 on itself, 0 where the surface is held otherwise. Triangles blend by their weights,
//!
//! ```text
//!     C_t = exp( sum_h w_h(t) r_h )  ( I + sum_h w_h(t) (S_h - I) )
//! ```
//!
//! and are stitched, `L x = div C`. Blended vectors count whole turns, and where all handles move by one
//! affine motion the weights sum to 1 and `C_t` is its linear part. The sums are solved for as fields of
//! their own, three of rotations and six of stretches, however many handles there are.

use rayon::prelude::*;

use super::field::{of_handles, smooth_system};
use super::goal::{Goal, HandleMotion};
use super::method::{Method, Solution, SolveOptions};
use super::region::Region;
use super::rods::differences;
use crate::linear::ConstrainedSystem;
use crate::options::options;
use crate::rotation::{exp, polar};
use crate::stitch::{Differences, Owners, Reference, Stitcher, Weights};
use crate::{Job, Mat3, Result, Vec3};

/// Stretch of a handle that counts as none.
const ROUNDING: f64 = 1e-12;

options! {
    /// Options of Poisson editing. Positions are smoother by one order than the weights.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// How smoothly the pose joins the handles and the border of the region: 0 in value, 1 in slope too,
        /// 2 in curvature too.
        pub border: usize = 0 => at_most(2.0),
        /// Closed parts keep their thickness when they bend and twist, as a body does and a hollow shell does not.
        pub solid: bool = false,
    }
}

/// Binds the method to a region.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Poisson::new(region, options, job)?))
}

/// Poisson editing bound to a region.
#[derive(Debug)]
pub struct Poisson {
    /// The system of the weights, where its system is not that of the stitcher.
    smooth: Option<ConstrainedSystem>,
    stitcher: Stitcher,
    /// Rods, of a solid region.
    rods: Option<Differences>,
}

impl Poisson {
    /// Factors the systems of weights and positions, which are the same where weights are harmonic.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where a system cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let smooth = match options.border {
            0 => None,
            border => Some(smooth_system(region, border, job)?),
        };
        let (mesh, rods) = (region.mesh(), region.rods());
        let rods = (!rods.is_empty()).then(|| differences(rods, mesh.rest(), 1.0));
        let across = rods.as_ref().map(Differences::matrix).transpose()?;
        let stitcher = Stitcher::new(
            mesh.clone(),
            Owners::Triangles,
            Weights::Cotangent,
            across.as_ref(),
            region.constraints().clone(),
            job,
        )?;
        Ok(Self { smooth, stitcher, rods })
    }
}

/// `C - I` where fields are the mean of those at some vertices.
fn change(fields: &[Vec<Vec3>; 4], at: &[u32]) -> Mat3 {
    let mean = |of: &Vec<Vec3>| at.iter().map(|&v| of[v as usize]).sum::<Vec3>() / at.len() as f64;
    let [rotation, whole, diagonal, mixed] = fields.each_ref().map(mean);
    exp(rotation) * exp(whole) * (Mat3::IDENTITY + symmetric(diagonal, mixed)) - Mat3::IDENTITY
}

/// What is blended: rotation vector, whole turns, and the entries of `S - I` on and off the diagonal.
fn to_vectors(motion: &HandleMotion) -> [Vec3; 4] {
    let s = polar(motion.linear).1 - Mat3::IDENTITY;
    let diagonal = Vec3::new(s.x_axis.x, s.y_axis.y, s.z_axis.z);
    let mixed = Vec3::new(s.y_axis.z, s.x_axis.z, s.x_axis.y);
    // What is rounding in a rigid motion is left out, and then not solved for.
    let known = |v: Vec3| if v.abs().max_element() > ROUNDING { v } else { Vec3::ZERO };
    [motion.rotation, motion.whole_turns, known(diagonal), known(mixed)]
}

fn symmetric(diagonal: Vec3, mixed: Vec3) -> Mat3 {
    Mat3::from_cols(
        Vec3::new(diagonal.x, mixed.z, mixed.y),
        Vec3::new(mixed.z, diagonal.y, mixed.x),
        Vec3::new(mixed.y, mixed.x, diagonal.z),
    )
}

impl Method for Poisson {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        self.smooth.iter().chain([self.stitcher.system()]).collect()
    }

    fn solve(&mut self, region: &Region, goal: &Goal, _: &SolveOptions, job: &Job) -> Result<Solution> {
        job.check()?;
        let vectors: Vec<[Vec3; 4]> = goal.handles.iter().map(to_vectors).collect();
        let system = self.smooth.as_ref().unwrap_or(self.stitcher.system());
        let fields = of_handles(system, region, &vectors);
        let triangles = region.mesh().triangles().par_iter().with_min_len(512);
        let changes: Vec<Mat3> = triangles.map(|t| change(&fields, t)).collect();
        let mut asked = self.stitcher.divergence(Reference::Rest, &changes);
        if let Some(rods) = &self.rods {
            rods.add_divergence(|i, v| change(&fields, &[i as u32]) * v, &mut asked);
        }
        let mut displacements = [goal.displacements.clone()];
        self.stitcher.system().solve(&[asked], &mut displacements);
        let [displacements] = displacements;
        Ok(Solution::direct(displacements))
    }
}
