//! Handles that turn by themselves: their rotation vectors, kept from one solve to the next.
//!
//! A search goes on from where the last one ended, so that along a drag a handle turns continuously and keeps to its
//! branch. The first one starts from the turns that the matrices have.

use super::agree::Agreement;
use super::goal::{Goal, HandleMotion};
use super::handles::Handle;
use super::region::Region;
use crate::geometry::rigid::centroid;
use crate::rotation::{exp, log, nearest_branch};
use crate::{Error, Fault, Job, Mat3, Mesh, Quat, Result, Vec3};

/// What is known of the turns of a region's handles.
#[derive(Debug)]
pub(super) struct OwnTurns {
    /// Of each handle's vertices, in unit coordinates.
    centres: Vec<Vec3>,
    /// Made when a handle first turns by itself.
    agreement: Option<Agreement>,
    /// The rotation vectors of the last solve, of those that turned by themselves in it.
    last: Vec<Option<Vec3>>,
}

impl OwnTurns {
    pub fn of(mesh: &Mesh, handles: &[Handle]) -> Self {
        let at_rest = |&v: &u32| mesh.rest()[v as usize];
        let centre = |handle: &Handle| centroid(handle.vertices.iter().map(at_rest));
        Self {
            centres: handles.iter().map(centre).collect(),
            agreement: None,
            last: vec![None; handles.len()],
        }
    }

    /// What each handle turns about, in unit coordinates.
    pub fn centres(&self) -> &[Vec3] {
        &self.centres
    }

    /// The handles of a list, ascending, of `count`.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for numbers that are no handle's, or named twice.
    pub fn free(&self, by_itself: &[u32], count: usize) -> Result<Vec<usize>> {
        let mut free: Vec<usize> = by_itself.iter().map(|&h| h as usize).collect();
        free.sort_unstable();
        let outside = by_itself.iter().enumerate().filter(|(_, h)| **h as usize >= count).map(|(i, _)| i);
        let problem = format!("number of a handle out of range, there are {count}");
        let twice = free.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        let fault = Fault::at("by_itself", problem, outside);
        match fault.or_else(|| Fault::at("by_itself", "handle named twice", twice)) {
            Some(fault) => Err(Error::InvalidConstraint(fault)),
            None => Ok(free),
        }
    }

    /// Turns the `free` handles so that they agree with where all go. `betters` tells that the method turns them
    /// further, and then goes on from where it ended.
    ///
    /// # Errors
    ///
    /// Those of [`Agreement::of`].
    pub fn agree(
        &mut self,
        region: &Region,
        free: &[usize],
        motions: &mut [HandleMotion],
        (warm, betters): (bool, bool),
        job: &Job,
    ) -> Result<()> {
        let last = |h: usize| self.last[h].filter(|_| warm);
        let mut rotations: Vec<Vec3> = motions.iter().map(|m| m.rotation).collect();
        free.iter().for_each(|&h| rotations[h] = last(h).unwrap_or(rotations[h]));
        if !betters || free.iter().any(|&h| last(h).is_none()) {
            let agreement = match self.agreement.take() {
                Some(agreement) => agreement,
                None => Agreement::of(region, self.centres.clone(), job)?,
            };
            rotations = self.agreement.insert(agreement).found(motions, free, rotations);
        }
        for &h in free {
            motions[h] = motions[h].turned_about(self.centres[h], rotations[h]);
        }
        Ok(())
    }

    /// The points that handles turn about, where they go.
    pub fn pivots(&self, free: &[usize], motions: &[HandleMotion]) -> Vec<(usize, Vec3)> {
        free.iter().map(|&h| (h, self.centres[h] + motions[h].displacement(self.centres[h]))).collect()
    }

    /// Turns handles further, as a method says.
    pub fn turn(&self, goal: &Goal, turns: &[Quat], motions: &mut [HandleMotion]) {
        for (&(h, _), &turn) in goal.pivots.iter().zip(turns) {
            let before = motions[h].rotation;
            let rotation = nearest_branch(log(Mat3::from_quat(turn) * exp(before)), before);
            motions[h] = motions[h].turned_about(self.centres[h], rotation);
        }
    }

    /// Keeps the turns of a solve.
    pub fn note(&mut self, free: &[usize], motions: &[HandleMotion]) {
        for (h, last) in self.last.iter_mut().enumerate() {
            *last = free.contains(&h).then(|| motions[h].rotation);
        }
    }
}
