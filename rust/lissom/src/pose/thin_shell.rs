//! Thin shell, linearised (thesis of S. Zhou 2008, 1.2.3; Celniker & Gossard 1991; Welch & Witkin 1994;
//! Botsch & Kobbelt 2004, An Intuitive Framework for Real-Time Freeform Modeling).
//!
//! ```text
//!     min_d  k_s |grad d|^2 + k_b |Lap d|^2     that is     - k_s Lap d + k_b Lap^2 d = 0      (1-3)
//! ```
//!
//! for the displacement `d`, with the cotangent Laplacian `L` and lumped areas `M`:
//! `(k_s L + k_b L M^-1 L) d = 0`. The shell's own shape plays no part, so details keep their orientation.
//!
//! The equation is of fourth order: it meets given vertices in position and slope (`border` 1). Where bending
//! is not counted at given vertices, it meets them in position alone, like a hinge (`border` 0; bending is
//! then zero everywhere and the shell a membrane: Botsch & Kobbelt's smoothness parameter at 0). To meet
//! them in curvature too (`border` 2), both terms go up by one order, as in their `Lap^3`:
//! `k_s |Lap d|^2 + k_b |grad Lap d|^2`.

use super::field::{inverse_mass, polyharmonic};
use super::goal::Goal;
use super::method::Method;
use super::region::Region;
use super::responses::{Linear, Response, minima};
use crate::linear::{ConstrainedSystem, SplitMatrix, SymmetricMatrix};
use crate::operators::cotangent::cotangent_laplacian;
use crate::options::options;
use crate::{Error, Fault, Job, Result, Vec3};

options! {
    /// Options of the thin shell. `sqrt(k_b / k_s)`, as a part of the mesh's diagonal, is the length over which bending
    /// gives way to stretching; they may not both be 0.
    #[derive(Debug, Clone)]
    pub struct Options {
        /// Resistance to stretching.
        pub k_s: f64 = 1.0 => at_least(0.0),
        /// Resistance to bending.
        pub k_b: f64 = 2.0 => at_least(0.0),
        /// How smoothly the pose joins the handles and the border of the region: 0 in value, 1 in slope too,
        /// 2 in curvature too.
        pub border: usize = 1 => at_most(2.0),
    }
}

/// Binds the method to a region, with precomputed responses.
pub(super) fn bind(region: &Region, options: &Options, job: &Job) -> Result<Box<dyn Method>> {
    Ok(Box::new(Linear::new(ThinShell::new(region, options, job)?)))
}

/// A thin shell bound to a region.
#[derive(Debug)]
pub struct ThinShell {
    system: ConstrainedSystem,
    laplacian: SymmetricMatrix,
    inverse: Vec<f64>,
    options: Options,
}

impl ThinShell {
    /// Assembles and factors the shell's matrix.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for two stiffnesses of 0;
    /// [`Error::SolveFailed`] where the matrix cannot be factored.
    pub fn new(region: &Region, options: &Options, job: &Job) -> Result<Self> {
        let (k_s, k_b) = (options.k_s, options.k_b);
        if k_s == 0.0 && k_b == 0.0 {
            return Err(Error::InvalidValue(Fault::new("k_b", "must not be 0 where k_s is 0 too")));
        }
        let mesh = region.mesh();
        let laplacian = cotangent_laplacian(mesh);
        let mut inverse = inverse_mass(mesh);
        if options.border == 0 {
            let given = (0u32..).zip(&mut inverse).filter(|(v, _)| region.constraints().slot(*v).is_none());
            given.for_each(|(_, inverse)| *inverse = 0.0);
        }
        let matrix = match options.border {
            0 => SplitMatrix::from(laplacian.clone()).combine(
                k_s,
                &SplitMatrix::sandwich(&laplacian, &inverse)?,
                k_b,
            ),
            border => polyharmonic(mesh, border - 1)?.combine(k_s, &polyharmonic(mesh, border)?, k_b),
        };
        let system = ConstrainedSystem::of_split(&matrix, region.constraints().clone(), job)?;
        Ok(Self { system, laplacian, inverse, options: options.clone() })
    }

    /// `(k_s L + k_b L M^-1 L) x`, times `L M^-1` for border 2.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let (k_s, k_b) = (self.options.k_s, self.options.k_b);
        let bent = self.laplacian.times(x).into_iter().zip(&self.inverse);
        let both: Vec<f64> = bent.zip(x).map(|((l, inverse), x)| k_s * x + k_b * inverse * l).collect();
        match self.options.border {
            2 => self.laplacian.sandwich_times(&self.inverse, &both),
            _ => self.laplacian.times(&both),
        }
    }
}

impl Response for ThinShell {
    fn systems(&self) -> Vec<&ConstrainedSystem> {
        vec![&self.system]
    }

    fn displacements(&self, region: &Region, goal: &Goal) -> Vec<Vec3> {
        self.displacements_of(region, std::slice::from_ref(goal)).swap_remove(0)
    }

    fn displacements_of(&self, _region: &Region, goals: &[Goal]) -> Vec<Vec<Vec3>> {
        minima(&self.system, goals, |x| self.product(x))
    }
}
