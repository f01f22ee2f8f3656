//! `x(t)`: stitch the edges that every triangle asks for at time `t`.
//!
//! The unknown is `y(t) = x(t) - ((1-t) start + t end)`, how far the arc lies off the straight line:
//!
//! ```text
//!     L y(t) = div [ (1-t) (R(t) - I) e(start)  +  t (R(t) R(1)^T - I) e(end) ]
//! ```
//!
//! Where nothing turns `y` is zero to the last bit.

use rayon::prelude::*;

use super::Inbetween;
use crate::linear::Columns;
use crate::operators::divergence::divergence;
use crate::{Error, Fault, Job, Mat3, Result, Vec3, memory};

/// Times solved as one block of right-hand sides: enough to share each pass over the factor, and
/// few enough to answer a cancellation at once.
const TIMES_AT_ONCE: usize = 8;

impl Inbetween {
    /// Positions at each of `times`, in the mesh's own units: exactly `start` at 0 and `end` at 1.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a time that is not within 0 and 1, [`Error::OutOfMemory`],
    /// [`Error::SolveFailed`] where positions overflow, [`Error::Cancelled`].
    pub fn at(&self, times: &[f64], job: &Job) -> Result<Vec<Vec<Vec3>>> {
        let outside = times.iter().enumerate().filter(|(_, t)| !(0.0..=1.0).contains(*t));
        if let Some(fault) = Fault::at("times", "not within 0 and 1", outside.map(|(i, _)| i)) {
            return Err(Error::InvalidValue(fault));
        }
        // Once here, and once more for whoever takes them over.
        let bytes = 2 * size_of::<Vec3>() as u128 * times.len() as u128 * self.shapes[0].len() as u128;
        memory::check("the in-betweens", bytes)?;
        let mut shapes = Vec::with_capacity(times.len());
        for chunk in times.chunks(TIMES_AT_ONCE) {
            job.report(shapes.len() as f64 / times.len() as f64, "in-betweens");
            let arcs = self.arcs(chunk, job)?;
            shapes
                .extend(chunk.par_iter().zip(arcs).map(|(&t, arc)| self.shape(t, &arc)).collect::<Vec<_>>());
        }
        let overflow = shapes.iter().enumerate().filter(|(_, x)| !x.iter().all(|p| p.is_finite()));
        match Fault::at("times", "positions beyond the range of numbers", overflow.map(|(i, _)| i)) {
            Some(fault) => Err(Error::SolveFailed(fault.to_string())),
            None => Ok(shapes),
        }
    }

    /// The position on the straight line plus the arc's distance from it.
    fn shape(&self, t: f64, arc: &[Vec3]) -> Vec<Vec3> {
        let [a, b] = &self.shapes;
        let (start, end) = if self.reversed { (b, a) } else { (a, b) };
        if t == 0.0 {
            return start.clone();
        }
        if t == 1.0 {
            return end.clone();
        }
        let s = self.inner_time(t);
        let line = a.iter().zip(b).map(|(&p, &q)| p + (q - p) * s);
        line.zip(arc).map(|(p, &y)| p + y * self.scale).collect()
    }

    /// The time in the order in which the shapes are kept.
    fn inner_time(&self, t: f64) -> f64 {
        if self.reversed { 1.0 - t } else { t }
    }

    /// `y(t)` in unit coordinates, for a few times at once.
    pub(super) fn arcs(&self, times: &[f64], job: &Job) -> Result<Vec<Vec<Vec3>>> {
        let n = self.shapes[0].len();
        let mut rhs = Columns::zeros(n, 3 * times.len());
        for (block, &t) in times.iter().enumerate() {
            job.check()?;
            let t = self.inner_time(t);
            let (from_start, from_end): (Vec<Mat3>, Vec<Mat3>) = self
                .turns
                .par_iter()
                .map(|turn| {
                    let (forward, back) = (turn.at(t), turn.back(t));
                    ((forward - Mat3::IDENTITY) * (1.0 - t), (back - Mat3::IDENTITY) * t)
                })
                .unzip();
            let asked = [from_start, from_end];
            let [a, b] = [0, 1].map(|end| divergence(self.mesh.adjacency(), &self.hats[end], &asked[end]));
            for (v, (a, b)) in a.into_iter().zip(b).enumerate() {
                rhs.set_vector(block, v, a + b);
            }
        }
        let mut y = Columns::zeros(n, 3 * times.len());
        self.system.solve(&rhs, &mut y);
        Ok((0..times.len()).map(|block| self.centred(y.vectors(block))).collect())
    }

    /// Moves every component that nothing holds so that its centroid is on its straight line, and welded
    /// vertices with those that they are welded to.
    fn centred(&self, mut y: Vec<Vec3>) -> Vec<Vec3> {
        for vertices in &self.afloat {
            let sum: Vec3 = vertices.iter().map(|&v| y[v as usize]).sum();
            let off = sum / vertices.len() as f64;
            for &v in vertices {
                y[v as usize] -= off;
            }
        }
        self.mesh.follow(&mut y);
        y
    }
}
