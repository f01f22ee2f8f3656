//! What nobody holds: components without a handle, and vertices in no triangle.
//!
//! They follow the nearest surface that handles hold, rigidly, by the motion of the patch of it that is beside them at rest
//! ([`crate::riding`]): eyes, teeth, buttons, hairs. Vertices outside the region of interest count as held.

use rayon::prelude::*;

use super::handles::Handle;
use crate::geometry::rigid::Similarity;
use crate::options::choices;
use crate::riding::{Seat, Seats};
use crate::{Fault, Mesh, Vec3};

choices! {
    /// What becomes of components without a handle.
    pub enum Unheld {
        /// They follow the nearest surface that a handle holds, rigidly.
        Follow = "follow",
        /// They stay at rest.
        Rest = "rest",
    }
}

/// What follows, and where it sits.
#[derive(Debug)]
pub(super) struct Followers {
    followers: Vec<(Vec<u32>, Seat)>,
    warnings: Vec<String>,
}

impl Followers {
    /// Of `mesh` with `handles` and a region of interest that are known to be good.
    pub fn of(mesh: &Mesh, handles: &[Handle], roi: Option<&[u32]>, unheld: Unheld) -> Self {
        let (n, components) = (mesh.vertices().len(), mesh.components());
        let mut stays = vec![roi.is_some(); n];
        roi.iter().flat_map(|roi| *roi).for_each(|&v| stays[v as usize] = false);
        let mut handled = vec![false; components.count()];
        let mut held = vec![false; components.count()];
        let mut alone: Vec<bool> = (0..n).map(|v| !stays[v]).collect();
        for &v in handles.iter().flat_map(|h| &h.vertices) {
            alone[v as usize] = false;
            components.of_vertex(v as usize).into_iter().for_each(|c| handled[c] = true);
        }
        for (v, &stays) in stays.iter().enumerate() {
            components.of_vertex(v).into_iter().for_each(|c| held[c] |= handled[c] || stays);
        }
        let follow = unheld == Unheld::Follow;
        let firsts: Vec<usize> = components.members().iter().map(|m| m[0] as usize).collect();
        let say = |problem: &str, which: &dyn Fn(usize) -> bool| {
            let offenders = (0..firsts.len())
                .filter(|&c| which(c) && !mesh.is_mirror_image(firsts[c]))
                .map(|c| firsts[c]);
            Fault::at("handles", problem, offenders).map(|fault| fault.to_string())
        };
        let problem = "components without a handle follow the nearest surface that has one, named by their first vertex";
        let mut warnings: Vec<String> = say(problem, &|c| !held[c] && follow).into_iter().collect();
        let problem = "components without a handle stay at rest, named by their first vertex";
        warnings.extend(say(problem, &|c| !handled[c] && (held[c] || !follow)));

        let mut parts = components.members();
        for (v, w) in mesh.welds() {
            components.of_vertex(w as usize).into_iter().for_each(|c| parts[c].push(v));
        }
        let mut component = 0..;
        parts.retain(|_| component.next().is_some_and(|c: usize| !held[c]));
        let loose = |&v: &u32| {
            let v = v as usize;
            alone[v] && components.of_vertex(v).is_none() && mesh.representative(v as u32) == v as u32
        };
        parts.extend((0..n as u32).filter(loose).map(|v| vec![v]));
        if !follow || parts.is_empty() {
            return Self { followers: Vec::new(), warnings };
        }
        let seats = Seats::new(mesh, mesh.rest(), |c| held[c]);
        let seated = |part: Vec<u32>| {
            let points: Vec<Vec3> = part.iter().map(|&v| mesh.rest()[v as usize]).collect();
            Some((part, seats.of(&points, f64::INFINITY, |_| true)?))
        };
        Self { followers: parts.into_par_iter().filter_map(seated).collect(), warnings }
    }

    /// Who follows, and who stays.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Moves what follows to where it belongs, once the held surface is posed.
    pub fn carry(&self, mesh: &Mesh, vertices: &mut [Vec3]) {
        let rest = mesh.vertices();
        let motion = |(_, seat): &(Vec<u32>, Seat)| {
            let moves = seat.vertices().iter().any(|&v| vertices[v as usize] != rest[v as usize]);
            moves.then(|| seat.motion(|v| rest[v as usize], |v| vertices[v as usize]))
        };
        let motions: Vec<Option<Similarity>> = self.followers.par_iter().map(motion).collect();
        for ((part, _), motion) in self.followers.iter().zip(motions) {
            for &v in part {
                vertices[v as usize] = motion.map_or(rest[v as usize], |m| m.apply(rest[v as usize]));
            }
        }
    }
}
