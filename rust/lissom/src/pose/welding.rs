//! Handles on a mesh whose vertices are welded: methods see each welded vertex once, callers all of them.

use std::collections::HashMap;

use super::handles::Handle;
use crate::{Error, Fault, Mesh, Result, Vec3};

/// Welded vertices may be asked to go this far apart, as a fraction of the diagonal.
const TORN: f64 = 1e-6;

/// The handles as given, and which of their vertices stand for those that are welded to the same.
#[derive(Debug)]
pub(super) struct Welding {
    handles: Vec<Handle>,
    /// Places among the vertices of all handles, handles in order.
    distinct: Vec<usize>,
}

impl Welding {
    /// With the handles on the vertices that theirs are welded to, each named once.
    pub fn of(mesh: &Mesh, handles: Vec<Handle>) -> (Self, Vec<Handle>) {
        let (mut distinct, mut start) = (Vec::new(), 0);
        let mut welded = handles.clone();
        for handle in &mut welded {
            let mut first = HashMap::new();
            // A vertex given twice is a mistake, which is not hidden here.
            let stays = |&v: &u32| *first.entry(mesh.representative(v)).or_insert(v) == v;
            let stays: Vec<bool> = handle.vertices.iter().map(stays).collect();
            distinct.extend((start..).zip(&stays).filter(|(_, stays)| **stays).map(|(place, _)| place));
            start += stays.len();
            let kept = |i: usize| stays.get(i).is_none_or(|stays| *stays);
            let mut places = 0..;
            handle.vertices.retain(|_| places.next().is_some_and(kept));
            handle.vertices.iter_mut().for_each(|v| *v = mesh.representative(*v));
            if let Some(membership) = &mut handle.membership
                && membership.len() == stays.len()
            {
                let mut places = 0..;
                membership.retain(|_| places.next().is_some_and(kept));
            }
        }
        (Self { handles, distinct }, welded)
    }

    /// The handles as given.
    pub fn handles(&self) -> &[Handle] {
        &self.handles
    }

    /// The vertices of all handles as given, in order.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.handles.iter().flat_map(|h| h.vertices.iter().copied())
    }

    /// The vertices that methods see, in the order of [`Welding::distinct_targets`].
    fn distinct_vertices(&self, mesh: &Mesh) -> Vec<u32> {
        let given: Vec<u32> = self.vertices().collect();
        self.distinct.iter().map(|&place| mesh.representative(given[place])).collect()
    }

    /// The targets of the vertices that methods see, from those of the handles as given.
    pub fn distinct_targets(&self, mesh: &Mesh, targets: &[Vec3]) -> Vec<Vec3> {
        let given: Vec<u32> = self.vertices().collect();
        let own =
            |&place: &usize| beside(mesh, given[place], mesh.representative(given[place]), targets[place]);
        self.distinct.iter().map(own).collect()
    }

    /// Refuses targets that tear welded vertices apart; `distinct` are those that methods see.
    pub fn expect_joined(&self, mesh: &Mesh, targets: &[Vec3], distinct: &[Vec3]) -> Result<()> {
        let place: HashMap<u32, Vec3> =
            self.distinct_vertices(mesh).into_iter().zip(distinct.iter().copied()).collect();
        let torn = self.vertices().zip(targets).enumerate().filter(|(_, (v, target))| {
            let w = mesh.representative(*v);
            let apart = beside(mesh, w, *v, place[&w]).distance(**target);
            let seam = mesh.vertices()[*v as usize].distance(mesh.vertices()[w as usize]);
            apart > TORN * mesh.frame().scale + 3.0 * seam
        });
        let problem = "vertices that are welded together go apart";
        let fault = Fault::at("targets", problem, torn.map(|(i, _)| i));
        fault.map_or(Ok(()), |fault| Err(Error::InvalidConstraint(fault)))
    }

    /// Puts the handle vertices that are `given` where they were asked to go, and what is welded to any vertex beside it.
    pub fn put(
        &self,
        mesh: &Mesh,
        targets: &[Vec3],
        distinct: &[Vec3],
        vertices: &mut [Vec3],
        is_given: impl Fn(u32) -> bool,
    ) {
        for (v, &target) in self.distinct_vertices(mesh).into_iter().zip(distinct) {
            if is_given(v) {
                vertices[v as usize] = target;
            }
        }
        for (v, w) in mesh.welds() {
            vertices[v as usize] = beside(mesh, w, v, vertices[w as usize]);
        }
        for (v, &target) in self.vertices().zip(targets) {
            if is_given(mesh.representative(v)) {
                vertices[v as usize] = target;
            }
        }
    }
}

/// Where `to` goes when `from`, which it is welded to, goes to `target`.
fn beside(mesh: &Mesh, from: u32, to: u32, target: Vec3) -> Vec3 {
    let offset = mesh.vertices()[to as usize] - mesh.vertices()[from as usize];
    if offset == Vec3::ZERO { target } else { target + offset }
}
