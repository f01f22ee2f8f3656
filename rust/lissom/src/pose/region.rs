//! The region of interest: what is given, what is free, and the small mesh that methods work on.

use std::collections::HashMap;
use std::sync::Arc;

use super::goal::{Goal, HandleMotion};
use crate::geometry::rigid::Alignment;
use crate::linear::Constraints;
use crate::rotation::log;
use crate::{Error, Fault, Mat3, Mesh, Result, Vec3};

/// Vertices that move together.
#[derive(Debug, Clone)]
pub struct Handle {
    /// The vertices.
    pub vertices: Vec<u32>,
    /// How much each belongs to the handle, above 0 and at most 1; `None` where all do wholly. A vertex
    /// of membership `m < 1` stays free, and is pulled with the weight `m / (1 - m)`.
    pub membership: Option<Vec<f64>>,
}

impl From<Vec<u32>> for Handle {
    fn from(vertices: Vec<u32>) -> Self {
        Self { vertices, membership: None }
    }
}

/// How the handles hold their vertices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Hold {
    /// Exactly: they are eliminated.
    #[default]
    Hard,
    /// With this weight, squared in the energy (thesis 2.2, equation 2-4).
    Soft(f64),
}

/// Handles and region, checked, with the part of the mesh that takes part.
#[derive(Debug)]
pub struct Region {
    handles: Vec<Handle>,
    /// For each vertex of the whole mesh, whether a handle holds it exactly.
    given: Vec<bool>,
    /// The triangles up to three rings from free vertices, as a mesh of their own in the whole mesh's
    /// unit coordinates.
    part: Option<Arc<Mesh>>,
    /// For each vertex of the part, its index in the whole mesh.
    whole: Vec<u32>,
    /// For each vertex of the part, its place among the handle vertices, handles in order.
    target_of: Vec<Option<u32>>,
    /// For each vertex of the part, its handle.
    handle_of: Vec<Option<u32>>,
    constraints: Constraints,
    warnings: Vec<String>,
}

impl Region {
    pub(super) fn of(mesh: &Mesh, handles: Vec<Handle>, roi: Option<&[u32]>, hold: Hold) -> Result<Self> {
        let n = mesh.vertices().len();
        let mut warnings = mesh.warnings().to_vec();
        let handle_of = owners(n, &handles)?;
        let pull = pulls(n, &handles, hold)?;
        let given: Vec<bool> = (0..n).map(|v| handle_of[v].is_some() && pull[v].is_none()).collect();
        let in_roi = match roi {
            Some(roi) => membership(n, roi)?,
            None => vec![true; n],
        };
        let outside = handle_of.iter().enumerate().filter(|(v, h)| h.is_some() && !in_roi[*v]);
        let problem = "outside the region of interest, moved all the same";
        warnings
            .extend(Fault::at("handles", problem, outside.map(|(v, _)| v)).map(|fault| fault.to_string()));

        let components = mesh.components();
        let mut points = vec![0usize; components.count()];
        let mut held = vec![0usize; components.count()];
        for v in 0..n {
            if let Some(c) = components.of_vertex(v) {
                points[c] += usize::from(handle_of[v].is_some());
                held[c] += usize::from(handle_of[v].is_some() || !in_roi[v]);
            }
        }
        let free = |v: usize| {
            let follows = in_roi[v] && handle_of[v].is_none();
            let attached = components.of_vertex(v).is_some_and(|c| points[c] > 0);
            (follows || pull[v].is_some()) && attached
        };
        let first: Vec<usize> = components.members().iter().map(|m| m[0] as usize).collect();
        let mut say = |problem: &str, which: &dyn Fn(usize) -> bool| {
            let offenders = (0..first.len()).filter(|&c| which(c)).map(|c| first[c]);
            warnings.extend(Fault::at("handles", problem, offenders).map(|fault| fault.to_string()));
        };
        say("components without a handle stay at rest, named by their first vertex", &|c| points[c] == 0);
        say(
            "components held by one or two points, whose rotation is ambiguous, named by their first vertex",
            &|c| points[c] > 0 && held[c] <= 2,
        );

        // Cells of given vertices beside free ones reach one ring further and count in full, and so do
        // their Laplacians' neighbours where curvature is continued across the border.
        let triangles = mesh.triangles();
        let mut near: Vec<bool> = (0..n).map(free).collect();
        let ring = |near: &[bool]| -> Vec<usize> {
            (0..triangles.len()).filter(|&t| triangles[t].iter().any(|&v| near[v as usize])).collect()
        };
        for _ in 0..2 {
            for &v in ring(&near).iter().flat_map(|&t| &triangles[t]) {
                near[v as usize] = true;
            }
        }
        let taking_part = if near.contains(&true) { ring(&near) } else { Vec::new() };
        let mut whole: Vec<u32> = taking_part.iter().flat_map(|&t| triangles[t]).collect();
        whole.sort_unstable();
        whole.dedup();
        let local: HashMap<u32, u32> = whole.iter().copied().zip(0u32..).collect();
        let part = (!taking_part.is_empty()).then(|| {
            let triangles = taking_part.iter().map(|&t| triangles[t].map(|v| local[&v])).collect();
            Arc::new(mesh.part(&whole, triangles))
        });
        let soft = (0u32..).zip(&whole).filter_map(|(v, &w)| Some((v, pull[w as usize]?)));
        let constraints = Constraints::hard(whole.len(), |v| !free(whole[v] as usize)).with_soft(soft);
        let mut target_of = vec![None; n];
        for (place, &v) in (0u32..).zip(handles.iter().flat_map(|h| &h.vertices)) {
            target_of[v as usize] = Some(place);
        }
        let target_of = whole.iter().map(|&v| target_of[v as usize]).collect();
        let handle_of = whole.iter().map(|&v| handle_of[v as usize]).collect();
        Ok(Self { handles, given, part, whole, target_of, handle_of, constraints, warnings })
    }

    /// The same region of a mesh whose vertices rest elsewhere, in unit coordinates; given ones do not.
    pub(super) fn reshaped(&self, rest: Vec<Vec3>) -> Self {
        Self {
            handles: self.handles.clone(),
            given: self.given.clone(),
            part: self.part.as_ref().map(|part| Arc::new(part.reshaped(rest))),
            whole: self.whole.clone(),
            target_of: self.target_of.clone(),
            handle_of: self.handle_of.clone(),
            constraints: self.constraints.clone(),
            warnings: self.warnings.clone(),
        }
    }

    /// The handles, as given.
    pub fn handles(&self) -> &[Handle] {
        &self.handles
    }

    /// Whether a handle holds a vertex of the whole mesh exactly.
    pub fn is_given(&self, vertex: u32) -> bool {
        self.given[vertex as usize]
    }

    /// The handle that a vertex of [`Region::mesh`] belongs to, wholly or in part.
    pub fn handle_of(&self, vertex: usize) -> Option<usize> {
        self.handle_of[vertex].map(|h| h as usize)
    }

    /// Something per handle as something per vertex of [`Region::mesh`]; zero where there is no handle.
    pub fn at_handles(&self, of_handle: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
        let vertices = 0..self.whole.len();
        vertices.map(|v| self.handle_of(v).map_or(Vec3::ZERO, &of_handle)).collect()
    }

    /// Whether anything besides handles is given: vertices outside the region stay at rest.
    pub fn is_anchored(&self) -> bool {
        (0..self.whole.len()).any(|v| self.stays(v))
    }

    /// Whether a vertex of [`Region::mesh`] is given and in no handle.
    fn stays(&self, vertex: usize) -> bool {
        self.handle_of[vertex].is_none() && self.constraints.slot(vertex as u32).is_none()
    }

    /// Whether nothing is free to follow.
    pub fn is_rigid(&self) -> bool {
        self.part.is_none()
    }

    /// The mesh that methods work on: free vertices and the three rings of given ones around them.
    ///
    /// # Panics
    ///
    /// Where [`Region::is_rigid`]; such a region is never given to a method.
    pub fn mesh(&self) -> &Arc<Mesh> {
        self.part.as_ref().expect("a method is only made for a region with free vertices")
    }

    /// For each vertex of [`Region::mesh`], its index in the whole mesh.
    pub fn whole(&self) -> &[u32] {
        &self.whole
    }

    /// Which vertices of [`Region::mesh`] are given.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// Whether some connected part is held by points on a line only, or a single one, so that a turn or a
    /// scale of it is left open.
    pub fn is_ambiguous(&self) -> bool {
        let mesh = self.mesh();
        let held = |v: u32| self.constraints.slot(v).is_none() || self.handle_of(v as usize).is_some();
        mesh.components().members().iter().any(|members| {
            let points: Vec<Vec3> =
                members.iter().filter(|v| held(**v)).map(|&v| mesh.rest()[v as usize]).collect();
            !Alignment::of(points.iter().map(|&p| (p, p))).is_determined()
        })
    }

    /// What is doubtful, the mesh's own doubts first.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    pub(super) fn goal(
        &self,
        mesh: &Mesh,
        targets: &[Vec3],
        handles: Vec<HandleMotion>,
        affine: bool,
    ) -> Goal {
        let rest = mesh.vertices();
        let scale = mesh.frame().scale;
        let displacements = self.whole.iter().zip(&self.target_of).map(|(&v, place)| match place {
            Some(place) => (targets[*place as usize] - rest[v as usize]) / scale,
            None => Vec3::ZERO,
        });
        Goal { displacements: displacements.collect(), handles, affine, pivots: Vec::new() }
    }

    pub(super) fn write_back(&self, mesh: &Mesh, displacements: &[Vec3], vertices: &mut [Vec3]) {
        let scale = mesh.frame().scale;
        for &v in self.constraints.free() {
            vertices[self.whole[v as usize] as usize] += displacements[v as usize] * scale;
        }
    }

    /// HandleMotion of each handle from where its vertices go (Kabsch 1976).
    pub(super) fn estimate_motions(&self, mesh: &Mesh, targets: &[Vec3]) -> Vec<HandleMotion> {
        let frame = mesh.frame();
        let rest = |v: u32| frame.to_unit(mesh.vertices()[v as usize]);
        let vertices = self.handles.iter().flat_map(|h| &h.vertices);
        let pairs: Vec<(Vec3, Vec3)> =
            vertices.zip(targets).map(|(&v, &target)| (rest(v), frame.to_unit(target))).collect();
        let fixed = (0..self.whole.len()).filter(|&v| self.stays(v)).map(|v| rest(self.whole[v]));
        let all: Vec<(Vec3, Vec3)> = pairs.iter().copied().chain(fixed.map(|p| (p, p))).collect();
        let all = Alignment::of(all.iter().copied());
        let together = if all.is_determined() { all.rotation() } else { Mat3::IDENTITY };
        let mut start = 0;
        self.handles
            .iter()
            .map(|handle| {
                let own = &pairs[start..start + handle.vertices.len()];
                start += own.len();
                let own = Alignment::of(own.iter().copied());
                let linear = if own.is_determined() { own.rotation() } else { together };
                let (from, to) = own.centroids();
                HandleMotion {
                    rotation: log(linear),
                    whole_turns: Vec3::ZERO,
                    linear,
                    offset: to - linear * from,
                }
            })
            .collect()
    }
}

/// The handle that each vertex is in.
fn owners(n: usize, handles: &[Handle]) -> Result<Vec<Option<u32>>> {
    let invalid = |fault: Fault| Err(Error::InvalidConstraint(fault));
    if handles.is_empty() {
        return invalid(Fault::new("handles", "there is no handle"));
    }
    let empty = handles.iter().enumerate().filter(|(_, h)| h.vertices.is_empty()).map(|(h, _)| h);
    if let Some(fault) = Fault::at("handles", "empty handle", empty) {
        return invalid(fault);
    }
    let outside = handles.iter().flat_map(|h| &h.vertices).filter(|&&v| v as usize >= n).map(|&v| v as usize);
    let problem = format!("vertex index out of range, the mesh has {n} vertices");
    if let Some(fault) = Fault::at("handles", problem, outside) {
        return invalid(fault);
    }
    let mut owner = vec![None; n];
    let mut twice = Vec::new();
    let mut rivals = None;
    for (h, handle) in (0u32..).zip(handles) {
        for &v in &handle.vertices {
            if let Some(other) = owner[v as usize].replace(h) {
                twice.push(v as usize);
                rivals.get_or_insert((other, h));
            }
        }
    }
    if let Some((a, b)) = rivals {
        let problem = if a == b {
            format!("vertex twice in handle {a}")
        } else {
            format!("vertex in two handles, first in {a} and {b}")
        };
        if let Some(fault) = Fault::at("handles", problem, twice) {
            return invalid(fault);
        }
    }
    Ok(owner)
}

/// Whether each vertex is in the region.
fn membership(n: usize, roi: &[u32]) -> Result<Vec<bool>> {
    if roi.is_empty() {
        return Err(Error::InvalidConstraint(Fault::new("roi", "the region of interest is empty")));
    }
    let outside = roi.iter().filter(|&&v| v as usize >= n).map(|&v| v as usize);
    let problem = format!("vertex index out of range, the mesh has {n} vertices");
    if let Some(fault) = Fault::at("roi", problem, outside) {
        return Err(Error::InvalidConstraint(fault));
    }
    let mut inside = vec![false; n];
    for &v in roi {
        inside[v as usize] = true;
    }
    Ok(inside)
}

/// The weight that pulls each handle vertex; `None` where it is held exactly or in no handle.
fn pulls(n: usize, handles: &[Handle], hold: Hold) -> Result<Vec<Option<f64>>> {
    if let Hold::Soft(weight) = hold
        && !(weight > 0.0 && weight.is_finite())
    {
        return Err(Error::InvalidValue(Fault::new("weight", "must be a positive number")));
    }
    let mut pull = vec![None; n];
    for (h, handle) in handles.iter().enumerate() {
        let ones = vec![1.0; handle.vertices.len()];
        let membership = handle.membership.as_ref().unwrap_or(&ones);
        if membership.len() != handle.vertices.len() {
            let (given, wanted) = (membership.len(), handle.vertices.len());
            let problem = format!("{given} weights for {wanted} vertices of handle {h}");
            return Err(Error::InvalidConstraint(Fault::new("handle_weights", problem)));
        }
        let bad = membership.iter().enumerate().filter(|(_, m)| !(**m > 0.0 && **m <= 1.0));
        let problem = format!("weights of handle {h} must be above 0 and at most 1");
        if let Some(fault) = Fault::at("handle_weights", problem, bad.map(|(i, _)| i)) {
            return Err(Error::InvalidConstraint(fault));
        }
        for (&v, &m) in handle.vertices.iter().zip(membership) {
            let full = match hold {
                Hold::Hard => 1.0,
                Hold::Soft(weight) => weight * weight,
            };
            pull[v as usize] = match hold {
                _ if m < 1.0 => Some(full * m / (1.0 - m)),
                Hold::Soft(_) => Some(full),
                Hold::Hard => None,
            };
        }
    }
    Ok(pull)
}
