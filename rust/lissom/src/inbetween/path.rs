//! `x(t)`: what every triangle asks for at time `t`, stitched.
//!
//! ```text
//!     s_te(t) = p(t) e(start) + q(t) R_t(1)^T e(end)
//! ```
//!
//! turned by `R_t(t)`; `p` and `q` are those of `stretch`.

use rayon::prelude::*;

use super::Inbetween;
use super::elements::{Asked, Hats};
use super::stretch::shares;
use crate::{Error, Fault, Job, Result, Vec3, memory};

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
        Self::check_times(times)?;
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

    /// Refuses times that are not within 0 and 1.
    pub(super) fn check_times(times: &[f64]) -> Result<()> {
        let outside = times.iter().enumerate().filter(|(_, t)| !(0.0..=1.0).contains(*t));
        let fault = Fault::at("times", "not within 0 and 1", outside.map(|(i, _)| i));
        fault.map_or(Ok(()), |fault| Err(Error::InvalidValue(fault)))
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
        let mut asked = Vec::with_capacity(times.len());
        for &t in times {
            job.check()?;
            asked.push(self.asked(self.inner_time(t), job)?);
        }
        let mut arcs = self.elements.stitch(&asked, self.options.refinement, |t| self.turning[t], job)?;
        for ((&t, asked), y) in times.iter().zip(&asked).zip(&mut arcs) {
            if let Some(volumes) = &self.volumes {
                volumes.restore(&self.elements, &asked.line, y, self.inner_time(t), job)?;
                *y = self.elements.centred(std::mem::take(y));
            }
            if let Some(clearance) = &self.clearance
                && t > 0.0
                && t < 1.0
            {
                let (still, place) = (|v: usize| self.still[v], |y: &[Vec3]| self.shape(t, y));
                clearance.keep(&self.elements, t, self.scale, still, place, y, job)?;
            }
        }
        Ok(arcs)
    }

    /// What every triangle asks for at time `t`.
    fn asked(&self, t: f64, job: &Job) -> Result<Asked<impl Fn(usize) -> (Hats, Hats) + Sync + '_>> {
        let rotations = match &self.relative {
            Some(relative) => relative.at(t, &self.turns, &self.ends, job)?,
            None => self.turns.par_iter().map(|turn| turn.at(t)).collect(),
        };
        let hats = move |triangle: usize| {
            let [start, end] = [0, 1].map(|end| self.hats[end][triangle]);
            let (p, q) = shares(self.stretches.get(triangle).copied().flatten(), t);
            let back = self.ends[triangle].transpose();
            let stretched = [0, 1, 2].map(|c| start[c] * p + back * end[c] * q);
            (stretched, [0, 1, 2].map(|c| start[c] * (1.0 - t) + end[c] * t))
        };
        let line = self.unit[0].iter().zip(&self.unit[1]).map(|(&p, &q)| p + (q - p) * t).collect();
        Ok(Asked { hats, rotations, line })
    }
}
