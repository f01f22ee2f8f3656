//! Quality: what a transfer says about each key that it has carried over.
//!
//! | | |
//! |---|---|
//! | turned over | target triangles that face against where `C_t` turns them |
//! | torn | target triangles with an edge [`RAGGED`] times as long as `C_t` makes it |
//! | contact gap | how much wider apart than asked for are the places across openings that close ([`super::rims`]) |
//! | closing | what part of the way that is asked for they have come together, above 1 where they go further |
//! | amplitude | root mean square displacement over what the anchors ask for ([`super::anchor`]) |
//! | covered | the part of the source's motion that has a counterpart on the target |
//! | crooked | left against right, where both meshes and the source's key are symmetric ([`super::symmetry`]) |
//! | residual | `sqrt(sum_t w_t \|grad_t d - D_t\|^2 / sum_t w_t \|D_t\|^2)`, with `D_t = (C_t - I)(I - n n^T)`: how far stitching is from what was asked |
//!
//! From all but the residual, which nobody sees, comes the verdict ([`super::verdict`]).

use rayon::prelude::*;

use super::apply::{Transfer, check};
use super::choose::SourceKey;
use super::contact::Contact;
use super::symmetry::Mirror;
use super::verdict::{Findings, Verdict, judge};
use crate::geometry::triangle::normal_and_area;
use crate::{Error, Fault, Job, Mat3, Result, Vec3};

/// An edge so many times as long as asked is torn: the fit calls triangles distorted from 3 on, and asks for that
/// itself where the target is; what stitching adds shows earlier.
const RAGGED: f64 = 2.5;

/// Edges count as asked to be at least this part of what they are at rest: what is asked to vanish, as in a shut lid,
/// cannot be torn.
const COLLAPSED: f64 = 0.3;

/// Triangles that keep less than this part of their area show no side, nor that they are turned over.
const NO_SIDE: f64 = 0.05;

/// Triangles belong to a motion when they go further than this part of the largest displacement.
const MOVING: f64 = 0.05;

/// Motions below this part of the diagonal, 0.03 mm on a head, are not seen.
const UNSEEN: f64 = 1e-4;

/// Source keys whose sides differ by less than this are meant to be symmetric: those of faces keep to 1 to 3 %.
const EVEN: f64 = 0.05;

/// Places that meet are beside a gap while this part of their way is left.
const STILL_OPEN: f64 = 0.1;

/// What is to be known about one key.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KeyQuality {
    /// Whether it can be taken as it is.
    pub verdict: Verdict,
    /// Why not, in words, the worst first.
    pub reasons: Vec<String>,
    /// Target triangles to look at, as the input counts them: turned over, torn, or beside a gap; none where it is
    /// good.
    pub faces: Vec<u32>,
    /// Number of target triangles turned over.
    pub flipped_triangles: usize,
    /// Number of target triangles torn.
    pub torn_triangles: usize,
    /// Target vertices at openings that close in this key.
    pub contacts: usize,
    /// Mean over those, in percent of the target's diagonal; 0 where there is none.
    pub contact_gap: f64,
    /// What part of the way they come together; above 1 where they go further, 1 where there is none.
    pub closing: f64,
    /// Motion over that of the source, scaled as the transfer does; 1 where nothing is seen to move.
    pub amplitude: f64,
    /// Difference of left and right over the motion; 0 where there is no symmetry.
    pub crooked: f64,
    /// What part of the source's motion has a counterpart on the target; 1 where nothing is seen to move.
    pub covered: f64,
    /// Largest displacement of a target vertex, in percent of the target's diagonal.
    pub motion: f64,
    /// Relative, 0 where nothing is asked for.
    pub residual: f64,
}

/// One target triangle in a key.
struct Triangle {
    off: f64,
    asked: f64,
    turned: bool,
    torn: bool,
    moves: f64,
}

impl Transfer {
    /// The quality of `carried`, what [`Transfer::apply`] has made of `poses`, key by key. How far `led` vertices of
    /// the target go somebody else has decided since: they count as having gone as far as was asked for.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for another number of keys, for keys of another size than the meshes and values that are
    /// not finite, [`Error::InvalidConstraint`] for led vertices out of range, [`Error::Cancelled`].
    pub fn quality(
        &self,
        poses: &[Vec<Vec3>],
        carried: &[Vec<Vec3>],
        led: &[u32],
        job: &Job,
    ) -> Result<Vec<KeyQuality>> {
        check("poses", poses, &self.source, "source")?;
        check("vertices", carried, &self.target, "target")?;
        if carried.len() != poses.len() {
            let problem = format!("{} for {} poses", carried.len(), poses.len());
            return Err(Error::InvalidValue(Fault::new("vertices", problem)));
        }
        if let Some(fault) = Fault::out_of_range("led", led, self.target.vertices().len()) {
            return Err(Error::InvalidConstraint(fault));
        }
        let mut free = vec![true; self.target.vertices().len()];
        led.iter().for_each(|&v| free[self.target.representative(v) as usize] = false);
        job.report(0.0, "quality");
        job.check()?;
        let mirrors = Mirror::of_both(&self.source, &self.target);
        let mut matched = vec![false; self.source.triangles().len()];
        self.used.pairs.iter().for_each(|pair| matched[pair[0] as usize] = true);
        job.report(0.2, "quality");
        self.rims();
        let found = poses.par_iter().zip(carried).map(|(pose, carried)| {
            job.check()?;
            Ok(self.quality_of(&self.turned(pose), carried, &mirrors, [&matched, &free]))
        });
        let found: Result<Vec<KeyQuality>> = found.collect();
        job.report(1.0, "quality");
        found
    }

    fn quality_of(
        &self,
        pose: &[Vec3],
        carried: &[Vec3],
        mirrors: &[[Mirror; 2]],
        [matched, free]: [&[bool]; 2],
    ) -> KeyQuality {
        let target = &*self.target;
        let key = SourceKey::of(&self.source, pose);
        let moved = self.chooser.displacements(&key);
        let scale = target.frame().scale;
        let displacements: Vec<Vec3> =
            carried.iter().zip(target.vertices()).map(|(&p, &v)| (p - v) / scale).collect();
        let motion = displacements.iter().map(|d| d.length()).fold(0.0, f64::max);
        let triangles = self.triangles(&self.changes(&key, &moved).0, &displacements);
        let sum = |of: fn(&Triangle) -> f64| triangles.iter().map(of).sum::<f64>();
        let (off, asked) = (sum(|t| t.off), sum(|t| t.asked));
        let residual = if asked > 0.0 { (off.max(0.0) / asked).sqrt() } else { 0.0 };
        let area_of = |which: &dyn Fn(&Triangle) -> bool| -> f64 {
            triangles.iter().zip(target.areas()).filter(|(t, _)| which(t)).map(|(_, area)| area).sum()
        };
        let moving = area_of(&|t| t.moves > MOVING * motion);
        let part = |which: fn(&Triangle) -> bool| {
            let count = triangles.iter().filter(|t| which(t)).count();
            // What is turned over is so whatever its area.
            (count, if count > 0 { (area_of(&which) / moving).max(f64::MIN_POSITIVE) } else { 0.0 })
        };
        let (turned, torn) = (part(|t| t.turned), part(|t| t.torn));
        let contacts = self.ways().contacts(self.rims(), &key, true);
        let gaps: Vec<_> = contacts.iter().map(|c| c.closing(target, &displacements)).collect();
        let apart: f64 = gaps.iter().map(|(_, left)| left.max(0.0)).sum();
        let gap = apart / contacts.len().max(1) as f64;
        let (way, left) = gaps.iter().fold((0.0, 0.0), |(way, left), gap| (way + gap.0, left + gap.1));
        let closing = if way > 0.0 { 1.0 - left / way } else { 1.0 };
        let (amplitude, crooked) = (self.amplitude(&moved, &displacements, free), {
            let beyond = |[source, target]: &[Mirror; 2]| {
                let own = source.difference(&key.displacement);
                if own < EVEN { (target.difference(&displacements) - own).max(0.0) } else { 0.0 }
            };
            if motion > UNSEEN { mirrors.iter().map(beyond).fold(0.0, f64::max) } else { 0.0 }
        });
        let along = contacts.iter().map(Contact::length).sum();
        let covered = self.covered(&key, matched);
        let mut found = Findings { turned, torn, along, gap, closing, amplitude, crooked, covered };
        if self.closing.is_some() && found.closes() {
            // Lids of larger eyes have a longer way than the source's.
            found.amplitude = amplitude.min(1.0);
        }
        let (verdict, reasons) = judge(&found);
        let told = found.open() > Verdict::Good;
        let open = contacts.iter().zip(&gaps).filter(|(_, (way, left))| told && *left > STILL_OPEN * way);
        let beside = open
            .flat_map(|(contact, _)| contact.vertices())
            .flat_map(|v| target.adjacency().corners_of(v as usize).iter().map(|corner| corner.triangle));
        let wrong = triangles.iter().enumerate().filter(|(_, t)| t.turned || t.torn).map(|(t, _)| t as u32);
        let mut faces: Vec<u32> = wrong.chain(beside).map(|t| target.triangle_ids()[t as usize]).collect();
        faces.sort_unstable();
        faces.dedup();
        if verdict == Verdict::Good {
            faces.clear();
        }
        KeyQuality {
            verdict,
            reasons,
            faces,
            flipped_triangles: turned.0,
            torn_triangles: torn.0,
            contacts: contacts.len(),
            contact_gap: 100.0 * gap,
            closing,
            amplitude,
            crooked,
            covered,
            motion: 100.0 * motion,
            residual,
        }
    }

    /// What part of the source's motion is on triangles that are `matched`; 1 where nothing is seen to move.
    fn covered(&self, key: &SourceKey, matched: &[bool]) -> f64 {
        let motion = |t: usize| self.source.areas()[t] * key.shift(t as u32).length_squared();
        let of =
            |which: &dyn Fn(usize) -> bool| (0..matched.len()).filter(|&t| which(t)).map(motion).sum::<f64>();
        let all = of(&|_| true);
        if all > UNSEEN.powi(2) * self.source.area() { of(&|t| matched[t]) / all } else { 1.0 }
    }

    /// Root mean square of `displacements` over what the anchors ask for, where the images have gone by `moved`; what
    /// is not `free` counts as having gone as far.
    fn amplitude(&self, moved: &[Vec3], displacements: &[Vec3], free: &[bool]) -> f64 {
        let asked = self.anchors.targets(&self.target, &self.chooser, moved);
        let (mut own, mut wanted, mut largest) = (0.0, 0.0, 0.0f64);
        for ((v, to), (_, weight)) in asked.iter().zip(self.anchors.soft()) {
            let v = *v as usize;
            own += weight * if free[v] { displacements[v] } else { *to }.length_squared();
            wanted += weight * to.length_squared();
            largest = largest.max(to.length());
        }
        if largest > UNSEEN { (own / wanted).sqrt() } else { 1.0 }
    }

    /// Every triangle of the target, displaced, against the `changes` asked of it.
    fn triangles(&self, changes: &[Mat3], displacements: &[Vec3]) -> Vec<Triangle> {
        let target = &*self.target;
        let rest = target.rest();
        let mut follows = vec![false; target.components().count()];
        self.placer.unmatched().for_each(|component| follows[component] = true);
        let of = |t: usize| {
            let corners = target.triangles()[t];
            let at = corners.map(|v| rest[v as usize]);
            let d = corners.map(|v| displacements[v as usize]);
            let change = changes[t];
            let (mut off, mut asked, mut ragged) = (0.0, 0.0, 0.0f64);
            for (corner, weight) in target.half_cotangents()[t].into_iter().enumerate() {
                let (i, j) = ((corner + 1) % 3, (corner + 2) % 3);
                let edge = at[j] - at[i];
                let (wanted, found) = (change * edge, d[j] - d[i]);
                let weight = weight * self.weights[t];
                off += weight * (found - wanted).length_squared();
                asked += weight * wanted.length_squared();
                let least = (edge + wanted).length().max(COLLAPSED * edge.length());
                ragged = ragged.max((edge + found).length() / least);
            }
            let normal = target.normals()[t];
            let target_gradient = Mat3::IDENTITY + change;
            let a = normal.any_orthonormal_vector();
            let target_normal = (target_gradient * a).cross(target_gradient * normal.cross(a));
            let (posed_normal, area) = normal_and_area([at[0] + d[0], at[1] + d[1], at[2] + d[2]]);
            // Nothing is asked of what follows others rigidly.
            let judged = target.components().of_vertex(corners[0] as usize).is_some_and(|c| !follows[c]);
            let has_side = area > NO_SIDE * target.areas()[t] && target_normal.length() > NO_SIDE;
            Triangle {
                off,
                asked,
                turned: judged && has_side && target_normal.dot(posed_normal) < 0.0,
                torn: judged && ragged > RAGGED,
                moves: d.map(|d| d.length()).into_iter().fold(0.0, f64::max),
            }
        };
        (0..changes.len()).into_par_iter().map(of).collect()
    }
}
