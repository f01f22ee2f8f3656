//! Quality: what a transfer says about each key that it has carried over.
//!
//! | | |
//! |---|---|
//! | residual | `sqrt(sum_t w_t \|grad_t d - D_t\|^2 / sum_t w_t \|D_t\|^2)`, with `D_t = (C_t - I)(I - n n^T)`: how far stitching is from what was asked |
//! | flipped | target triangles that face against where `C_t` turns them |
//! | contact gap | how much wider apart than on the source are the places that meet there |
//! | round trip | root mean square error of source -> target -> source, over the key's own displacement |

use rayon::prelude::*;

use super::apply::{Transfer, check};
use super::choose::SourceKey;
use crate::geometry::triangle::normal_and_area;
use crate::{Error, Fault, Job, Mat3, Result, Vec3};

/// What is to be known about one key.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct KeyQuality {
    /// Relative, 0 where nothing is asked for.
    pub residual: f64,
    /// Number of target triangles.
    pub flipped_triangles: usize,
    /// Target vertices whose images meet another surface in this key.
    pub contacts: usize,
    /// Mean over those, in percent of the target's diagonal; 0 where there is none.
    pub contact_gap: f64,
    /// Over the source vertices that lie on the target; relative, 0 where they do not move.
    pub round_trip: f64,
    /// Largest displacement of a target vertex, in percent of the target's diagonal.
    pub motion: f64,
}

impl Transfer {
    /// The quality of `carried`, what [`Transfer::apply`] has made of `poses`, key by key.
    ///
    /// # Errors
    ///
    /// As [`Transfer::new`] and [`Transfer::apply`].
    pub fn quality(&self, poses: &[Vec<Vec3>], carried: &[Vec<Vec3>], job: &Job) -> Result<Vec<KeyQuality>> {
        check("poses", poses, &self.source, "source")?;
        check("vertices", carried, &self.target, "target")?;
        if carried.len() != poses.len() {
            let problem = format!("{} for {} poses", carried.len(), poses.len());
            return Err(Error::InvalidValue(Fault::new("vertices", problem)));
        }
        job.report(0.0, "round trip");
        let way_back =
            Self::new(self.target.clone(), self.source.clone(), &self.matches.reversed(), self.options, job)?;
        let returned = way_back.apply(carried, job)?.poses;
        job.report(0.5, "quality");
        job.check()?;
        let all = poses.par_iter().zip(carried).zip(&returned);
        let found = all.map(|((pose, carried), returned)| {
            job.check()?;
            Ok(self.quality_of(pose, carried, returned))
        });
        let found: Result<Vec<KeyQuality>> = found.collect();
        job.report(1.0, "quality");
        found
    }

    fn quality_of(&self, pose: &[Vec3], carried: &[Vec3], returned: &[Vec3]) -> KeyQuality {
        let (source, target) = (&*self.source, &*self.target);
        let key = SourceKey::of(source, pose);
        let moved = self.chooser.displacements(&key);
        let scale = target.frame().scale;
        let displacements: Vec<Vec3> =
            carried.iter().zip(target.vertices()).map(|(&p, &v)| (p - v) / scale).collect();
        let (residual, flipped_triangles) = self.against(&self.changes(&key, &moved).0, &displacements);
        let contacts = self.contacts(&key, &moved);
        let gaps = contacts.iter().map(|contact| contact.excess(target, &displacements));
        let contact_gap = 100.0 * gaps.fold(0.0, |sum, gap| sum + gap) / contacts.len().max(1) as f64;
        let seen = |v: &usize| self.used.back_images[*v].is_some();
        let sum = |difference: &dyn Fn(usize) -> Vec3| -> f64 {
            (0..pose.len()).filter(seen).map(|v| difference(v).length_squared()).sum()
        };
        let own = sum(&|v| key.displacement[v]) * source.frame().scale.powi(2);
        let off = sum(&|v| returned[v] - pose[v]);
        let round_trip = if own > 0.0 { (off / own).sqrt() } else { 0.0 };
        let motion = 100.0 * displacements.iter().map(|d| d.length()).fold(0.0, f64::max);
        KeyQuality { residual, flipped_triangles, contacts: contacts.len(), contact_gap, round_trip, motion }
    }

    /// Residual and flipped triangles of `displacements` against the `changes` asked for.
    fn against(&self, changes: &[Mat3], displacements: &[Vec3]) -> (f64, usize) {
        let target = &*self.target;
        let rest = target.rest();
        let of = |t: usize| {
            let corners = target.triangles()[t];
            let at = corners.map(|v| rest[v as usize]);
            let d = corners.map(|v| displacements[v as usize]);
            let change = changes[t];
            let (mut off, mut asked) = (0.0, 0.0);
            for (corner, weight) in target.half_cotangents()[t].into_iter().enumerate() {
                let (i, j) = ((corner + 1) % 3, (corner + 2) % 3);
                let wanted = change * (at[j] - at[i]);
                let weight = weight * self.weights[t];
                off += weight * (d[j] - d[i] - wanted).length_squared();
                asked += weight * wanted.length_squared();
            }
            let normal = target.normals()[t];
            let target_gradient = Mat3::IDENTITY + change;
            let a = normal.any_orthonormal_vector();
            let target_normal = (target_gradient * a).cross(target_gradient * normal.cross(a));
            let (posed_normal, _) = normal_and_area([at[0] + d[0], at[1] + d[1], at[2] + d[2]]);
            (off, asked, usize::from(target_normal.dot(posed_normal) < 0.0))
        };
        let all: Vec<_> = (0..changes.len()).into_par_iter().map(of).collect();
        let add = |a: (f64, f64, usize), b: &(f64, f64, usize)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
        let (off, asked, flipped) = all.iter().fold((0.0, 0.0, 0), add);
        (if asked > 0.0 { (off.max(0.0) / asked).sqrt() } else { 0.0 }, flipped)
    }
}
