//! Where a moved handle takes the shape that matches given rotations best: a start without a solve.
//!
//! For fixed rotations the best displacements are linear in those that handles ask for. From one pose to the next they
//! change by
//!
//! ```text
//!     d_v = sum over handles h   dA_h p_h(v) + db_h q_h(v)
//! ```
//!
//! with the change of each handle's affine motion and its responses: the handle's own rest positions `p_h` and ones
//! `q_h`, extended without right-hand side.

use rayon::prelude::*;

use super::goal::{Goal, HandleMotion};
use super::region::Region;
use crate::linear::ConstrainedSystem;
use crate::{Mat3, Vec3};

/// Most handles whose responses are kept; beyond, a solve is the lesser cost.
const MOST_HANDLES: usize = 16;

/// Displacements asked for that are further from those of the handles' affine motions are of another kind.
const AFFINE: f64 = 1e-12;

/// What a solve has ended with.
#[derive(Debug, Default)]
pub(super) struct Reached {
    /// Where the handles were.
    pub goal: Option<Goal>,
    /// The displacements that match the rotations best.
    pub displacements: Vec<Vec3>,
}

/// The responses of handles that have moved.
#[derive(Debug, Default)]
pub(super) struct Following {
    responses: Vec<(usize, Vec<[f64; 4]>)>,
}

impl Following {
    /// What `reached` becomes with the same rotations at another goal; `None` where that takes a solve.
    pub fn moved(
        &mut self,
        system: &ConstrainedSystem,
        region: &Region,
        reached: &Reached,
        goal: &Goal,
    ) -> Option<Vec<Vec3>> {
        let from = reached.goal.as_ref()?;
        if !(from.affine && goal.affine && from.pivots.is_empty() && goal.pivots.is_empty()) {
            return None;
        }
        let change = |(before, now): (&HandleMotion, &HandleMotion)| {
            (now.linear - before.linear, now.offset - before.offset)
        };
        let changes: Vec<(Mat3, Vec3)> = from.handles.iter().zip(&goal.handles).map(change).collect();
        let rest = region.mesh().rest();
        let asked = |v: usize| match region.handle_of(v) {
            Some(h) => changes[h].0 * rest[v] + changes[h].1,
            None => Vec3::ZERO,
        };
        // Vertices on a plane of symmetry, and those where handles meet, go ways of their own.
        let affine = (0..rest.len()).into_par_iter().with_min_len(4096).all(|v| {
            let (before, now) = (from.displacements[v], goal.displacements[v]);
            (now - before).distance(asked(v)) <= AFFINE * (1.0 + before.length() + now.length())
        });
        let moving: Vec<usize> =
            (0..changes.len()).filter(|&h| changes[h] != (Mat3::ZERO, Vec3::ZERO)).collect();
        if !affine || moving.len() > MOST_HANDLES {
            return None;
        }
        moving.iter().for_each(|&h| self.respond(system, region, h));
        let of_handles: Vec<(&[[f64; 4]], Mat3, Vec3)> = (self.responses.iter())
            .filter(|(h, _)| moving.contains(h))
            .map(|(h, responses)| (&responses[..], changes[*h].0, changes[*h].1))
            .collect();
        let constraints = system.constraints();
        let at = |v: usize| {
            if constraints.slot(v as u32).is_none() {
                return goal.displacements[v];
            }
            of_handles.iter().fold(reached.displacements[v], |sum, (responses, linear, offset)| {
                let [x, y, z, one] = responses[v];
                sum + *linear * Vec3::new(x, y, z) + *offset * one
            })
        };
        Some((0..rest.len()).into_par_iter().with_min_len(4096).map(at).collect())
    }

    fn respond(&mut self, system: &ConstrainedSystem, region: &Region, handle: usize) {
        if self.responses.iter().any(|(h, _)| *h == handle) {
            return;
        }
        if self.responses.len() == MOST_HANDLES {
            self.responses.remove(0);
        }
        let rest = region.mesh().rest();
        let of = |value: &dyn Fn(usize) -> Vec3| -> Vec<Vec3> {
            let own = |v| if region.handle_of(v) == Some(handle) { value(v) } else { Vec3::ZERO };
            (0..rest.len()).map(own).collect()
        };
        let mut fields = [of(&|v| rest[v]), of(&|_| Vec3::X)];
        system.solve::<Vec<Vec3>>(&[], &mut fields);
        let [places, ones] = fields;
        let responses = places.iter().zip(ones).map(|(p, one)| [p.x, p.y, p.z, one.x]);
        self.responses.push((handle, responses.collect()));
    }
}
