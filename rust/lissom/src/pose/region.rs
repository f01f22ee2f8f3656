//! The region of interest: what is given, what is free, and the small mesh that methods work on.

use std::collections::HashMap;

use super::Goal;
use crate::linear::Constraints;
use crate::operators::gradient::outer;
use crate::rotation::{log, nearest_rotation};
use crate::{Error, Fault, Mat3, Mesh, Result, Vec3};

/// Points count as spread in a plane when the second singular value of their covariance exceeds this
/// fraction of the first.
const SPREAD: f64 = 1e-6;

/// Handles and region, checked, with the part of the mesh that takes part.
#[derive(Debug)]
pub struct Region {
    handles: Vec<Vec<u32>>,
    /// The triangles up to two rings from free vertices, as a mesh of their own in the whole mesh's
    /// unit coordinates.
    part: Option<Mesh>,
    /// For each vertex of the part, its index in the whole mesh.
    whole: Vec<u32>,
    /// For each vertex of the part, its handle.
    handle_of: Vec<Option<u32>>,
    constraints: Constraints,
    warnings: Vec<String>,
}

impl Region {
    pub(super) fn of(mesh: &Mesh, handles: Vec<Vec<u32>>, roi: Option<&[u32]>) -> Result<Self> {
        let n = mesh.vertices().len();
        let mut warnings = mesh.warnings().to_vec();
        let handle_of = owners(n, &handles)?;
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
            in_roi[v] && handle_of[v].is_none() && components.of_vertex(v).is_some_and(|c| points[c] > 0)
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

        // Cells of given vertices beside free ones reach one ring further, and count in full.
        let triangles = mesh.triangles();
        let ring = |near: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..triangles.len()).filter(|&t| triangles[t].iter().any(|&v| near(v as usize))).collect()
        };
        let mut beside = vec![false; n];
        for &v in ring(&free).iter().flat_map(|&t| &triangles[t]) {
            beside[v as usize] = true;
        }
        let taking_part = ring(&|v| beside[v]);
        let mut whole: Vec<u32> = taking_part.iter().flat_map(|&t| triangles[t]).collect();
        whole.sort_unstable();
        whole.dedup();
        let local: HashMap<u32, u32> = whole.iter().copied().zip(0u32..).collect();
        let part = (!taking_part.is_empty()).then(|| {
            let triangles = taking_part.iter().map(|&t| triangles[t].map(|v| local[&v])).collect();
            mesh.part(&whole, triangles)
        });
        let constraints = Constraints::hard(whole.len(), |v| !free(whole[v] as usize));
        let handle_of = whole.iter().map(|&v| handle_of[v as usize]).collect();
        Ok(Self { handles, part, whole, handle_of, constraints, warnings })
    }

    /// The handles, as given.
    pub fn handles(&self) -> &[Vec<u32>] {
        &self.handles
    }

    /// Whether nothing is free to follow.
    pub fn is_rigid(&self) -> bool {
        self.part.is_none()
    }

    /// The mesh that methods work on: free vertices and the two rings of given ones around them.
    ///
    /// # Panics
    ///
    /// Where [`Region::is_rigid`]; such a region is never given to a method.
    pub fn mesh(&self) -> &Mesh {
        self.part.as_ref().expect("a method is only made for a region with free vertices")
    }

    /// Which vertices of [`Region::mesh`] are given.
    pub fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// What is doubtful, the mesh's own doubts first.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    pub(super) fn goal(&self, mesh: &Mesh, targets: &[Vec3], rotations: &[Vec3]) -> Goal {
        let rest = mesh.vertices();
        let scale = mesh.frame().scale;
        let moved: HashMap<u32, Vec3> = (self.handles.iter().flatten().zip(targets))
            .map(|(&v, &target)| (v, (target - rest[v as usize]) / scale))
            .collect();
        let of_handle = |v: usize, value: &dyn Fn(u32) -> Vec3| self.handle_of[v].map_or(Vec3::ZERO, value);
        let vertices = 0..self.whole.len();
        Goal {
            displacements: vertices.clone().map(|v| of_handle(v, &|_| moved[&self.whole[v]])).collect(),
            rotations: vertices.map(|v| of_handle(v, &|h| rotations[h as usize])).collect(),
        }
    }

    pub(super) fn write_back(&self, mesh: &Mesh, displacements: &[Vec3], vertices: &mut [Vec3]) {
        let scale = mesh.frame().scale;
        for &v in self.constraints.free() {
            vertices[self.whole[v as usize] as usize] += displacements[v as usize] * scale;
        }
    }

    /// Rotation vector of each handle from where its vertices go (Kabsch 1976).
    pub(super) fn estimate_rotations(&self, mesh: &Mesh, targets: &[Vec3]) -> Vec<Vec3> {
        let rest = mesh.vertices();
        let pairs: Vec<(Vec3, Vec3)> = (self.handles.iter().flatten().zip(targets))
            .map(|(&v, &target)| (mesh.frame().to_unit(rest[v as usize]), mesh.frame().to_unit(target)))
            .collect();
        let stays = self.whole.iter().zip(&self.handle_of).enumerate();
        let stays = stays.filter(|(v, (_, h))| h.is_none() && self.constraints.slot(*v as u32).is_none());
        let fixed = stays.map(|(_, (&v, _))| mesh.frame().to_unit(rest[v as usize])).map(|p| (p, p));
        let all: Vec<(Vec3, Vec3)> = pairs.iter().copied().chain(fixed).collect();
        let together = rotation_between(&all).unwrap_or(Vec3::ZERO);
        let mut start = 0;
        self.handles
            .iter()
            .map(|handle| {
                let own = &pairs[start..start + handle.len()];
                start += handle.len();
                rotation_between(own).unwrap_or(together)
            })
            .collect()
    }
}

/// The handle that each vertex is in.
fn owners(n: usize, handles: &[Vec<u32>]) -> Result<Vec<Option<u32>>> {
    let invalid = |fault: Fault| Err(Error::InvalidConstraint(fault));
    if handles.is_empty() {
        return invalid(Fault::new("handles", "there is no handle"));
    }
    let empty = handles.iter().enumerate().filter(|(_, h)| h.is_empty()).map(|(h, _)| h);
    if let Some(fault) = Fault::at("handles", "empty handle", empty) {
        return invalid(fault);
    }
    let outside = handles.iter().flatten().filter(|&&v| v as usize >= n).map(|&v| v as usize);
    let problem = format!("vertex index out of range, the mesh has {n} vertices");
    if let Some(fault) = Fault::at("handles", problem, outside) {
        return invalid(fault);
    }
    let mut owner = vec![None; n];
    let mut twice = Vec::new();
    let mut rivals = None;
    for (h, handle) in (0u32..).zip(handles) {
        for &v in handle {
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

/// The rotation that takes the first points to the second best; `None` where they are too few, or
/// all on a line, to tell.
fn rotation_between(pairs: &[(Vec3, Vec3)]) -> Option<Vec3> {
    let count = pairs.len() as f64;
    let from = pairs.iter().map(|p| p.0).sum::<Vec3>() / count;
    let to = pairs.iter().map(|p| p.1).sum::<Vec3>() / count;
    let mut cross = Mat3::ZERO;
    let mut spread = Mat3::ZERO;
    for &(a, b) in pairs {
        cross += outer(b - to, a - from);
        spread += outer(a - from, a - from);
    }
    // The sum of the principal 2 x 2 minors of the covariance is s1 s2 + s1 s3 + s2 s3.
    let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    let squares =
        spread.x_axis.length_squared() + spread.y_axis.length_squared() + spread.z_axis.length_squared();
    let second = 0.5 * (trace * trace - squares);
    (second > SPREAD * SPREAD * trace * trace).then(|| log(nearest_rotation(cross)))
}
