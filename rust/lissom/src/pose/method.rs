//! What a pose method is.

use super::goal::Goal;
use super::handles::Hold;
use super::region::Region;
use super::unheld::Unheld;
use crate::linear::ConstrainedSystem;
use crate::mesh::Plane;
use crate::options::{choices, options};
use crate::{Job, Quat, Result, Vec3};

options! {
    /// How long an iterative method goes on, and from where.
    #[derive(Debug, Clone)]
    pub struct SolveOptions {
        /// Most iterations.
        pub max_iterations: usize = 200,
        /// Stop when an iteration lowers the energy by less than this.
        pub tolerance: f64 = 1e-6 => at_least(0.0) unit("of the energy"),
        /// Start from the previous pose, where there is one, instead of the linear guess.
        pub warm_start: bool = true,
    }
}

choices! {
    /// Whether handles hold their vertices exactly.
    pub enum Holding {
        /// They go exactly where their handle takes them.
        Hard = "hard",
        /// They are pulled there, and give way to the mesh around them.
        Soft = "soft",
    }
}

options! {
    /// What every method has.
    #[derive(Debug, Clone)]
    pub struct CommonOptions {
        /// Whether vertices of a handle go just where it takes them.
        pub constraints: Holding = Holding::Hard,
        /// How strongly soft handles pull: more holds them closer.
        pub weight: f64 = 1.0 => above(0.0) when("constraints", "soft"),
        /// Closed components keep the volume that they have at rest.
        pub preserve_volume: bool = false,
        /// What parts without a handle do, such as eyes, teeth and buttons.
        pub unheld: Unheld = Unheld::Follow,
        /// Planes, each (point, normal), that complete a half mesh by its mirror image, with the same handles: vertices on
        /// them stay on them.
        pub mirror: Vec<Plane> = Vec::new(),
        /// Planes, each (point, normal), that a whole mesh is symmetric about: every handle's mirror image moves as its
        /// mirror image. Where both are handles, the one on the normal's side leads.
        pub symmetry: Vec<Plane> = Vec::new(),
        /// How far a vertex may be from where a mirror image has it to be that.
        pub mirror_tolerance: f64 = 1e-4 => at_least(0.0) unit("of the diagonal"),
    }
}

impl CommonOptions {
    /// How the handles hold.
    pub fn hold(&self) -> Hold {
        match self.constraints {
            Holding::Hard => Hold::Hard,
            Holding::Soft => Hold::Soft(self.weight),
        }
    }
}

/// What a method makes of a goal.
#[derive(Debug)]
pub struct Solution {
    /// Displacement of every vertex of the region's mesh, in unit coordinates.
    pub displacements: Vec<Vec3>,
    /// Iterations done.
    pub iterations: usize,
    /// Energy at the end, of iterative methods.
    pub energy: Option<f64>,
    /// Whether the tolerance was reached.
    pub converged: bool,
    /// The fraction of the energy by which the last iteration lowered it.
    pub residual: f64,
    /// How far each handle of [`Goal::pivots`] was turned further, in their order.
    pub turns: Vec<Quat>,
}

impl Solution {
    /// What a method that does not iterate found.
    pub(crate) fn direct(displacements: Vec<Vec3>) -> Self {
        Self { displacements, iterations: 1, energy: None, converged: true, residual: 0.0, turns: Vec::new() }
    }

    /// What is said where it stopped early.
    pub(super) fn warning(&self) -> Option<String> {
        let last = match self.residual.is_finite() {
            true => format!(", the last of which lowered the energy by {:.1e} of it", self.residual),
            false => String::new(),
        };
        let iterations = self.iterations;
        (!self.converged).then(|| {
            format!("not converged after {iterations} iterations{last}: raise max_iterations or tolerance")
        })
    }
}

/// A way to pose a region. An instance is bound to one region, and keeps what it factored.
pub trait Method: Send + std::fmt::Debug {
    /// Moves the free vertices of `region` so that they follow `goal`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`], and [`crate::Error::SolveFailed`] where the linear algebra gives up.
    fn solve(&mut self, region: &Region, goal: &Goal, options: &SolveOptions, job: &Job) -> Result<Solution>;

    /// Lets the next solve go on from the last one, which nothing has stopped since.
    fn keep(&mut self) {}

    /// What it factored, to solve by.
    fn systems(&self) -> Vec<&ConstrainedSystem>;

    /// Whether turns of handles are among its unknowns, see [`Goal::pivots`].
    fn turns_handles(&self) -> bool {
        false
    }
}
