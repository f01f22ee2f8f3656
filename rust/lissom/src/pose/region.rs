//! The region of interest: what is given, what is free, and the small mesh that methods work on.

use std::collections::HashMap;
use std::sync::Arc;

use super::goal::{Goal, HandleMotion};
use super::handles::{Handle, Hold, membership, owners, pulls};
use super::rods::{Owned, rods};
use crate::geometry::rigid::Alignment;
use crate::linear::Constraints;
use crate::rotation::log;
use crate::symmetry::Symmetry;
use crate::{Fault, Mat3, Mesh, Result, Vec3};

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
    /// Of the part.
    symmetry: Symmetry,
    /// Those that reach a free vertex, of a solid region.
    rods: Vec<Owned>,
    warnings: Vec<String>,
}

impl Region {
    /// A `solid` region has [`rods`] through its closed parts.
    pub(super) fn of(
        mesh: &Mesh,
        symmetry: &Symmetry,
        handles: Vec<Handle>,
        roi: Option<&[u32]>,
        hold: Hold,
        solid: bool,
    ) -> Result<Self> {
        let n = mesh.vertices().len();
        let mut warnings = mesh.warnings().to_vec();
        let handle_of = owners(n, &handles)?;
        let pull = pulls(n, &handles, hold)?;
        let given: Vec<bool> = (0..n).map(|v| handle_of[v].is_some() && pull[v].is_none()).collect();
        let in_roi = match roi {
            Some(roi) => membership(n, roi)?,
            None => vec![true; n],
        };
        let outside = handle_of.iter().enumerate();
        let outside = outside.filter(|(v, h)| h.is_some() && !in_roi[*v] && !mesh.is_mirror_image(*v));
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
        let ambiguous = |&c: &usize| points[c] > 0 && held[c] <= 2 && !mesh.is_mirror_image(first[c]);
        let ambiguous = (0..first.len()).filter(ambiguous).map(|c| first[c]);
        let problem =
            "components held by one or two points, whose rotation is ambiguous, named by their first vertex";
        warnings.extend(Fault::at("handles", problem, ambiguous).map(|fault| fault.to_string()));

        let (mut rods, hollow) = if solid { rods(mesh) } else { (Vec::new(), None) };
        warnings.extend(hollow);
        rods.retain(|rod| rod.ends().iter().any(|&v| free(v as usize)));

        // Cells of given vertices beside free ones reach one ring further and count in full, and so do
        // their Laplacians' neighbours where curvature is continued across the border.
        let triangles = mesh.triangles();
        let mut near: Vec<bool> = (0..n).map(free).collect();
        let joined = rods.iter().flat_map(|rod| rod.ends().into_iter().chain([rod.owner]));
        joined.for_each(|v| near[v as usize] = true);
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
        let rods = rods.iter().map(|rod| rod.renumbered(|v| local[&v])).collect();
        let soft = (0u32..).zip(&whole).filter_map(|(v, &w)| Some((v, pull[w as usize]?)));
        let constraints = Constraints::hard(whole.len(), |v| !free(whole[v] as usize)).with_soft(soft);
        let mut target_of = vec![None; n];
        for (place, &v) in (0u32..).zip(handles.iter().flat_map(|h| &h.vertices)) {
            target_of[v as usize] = Some(place);
        }
        let target_of = whole.iter().map(|&v| target_of[v as usize]).collect();
        let handle_of = whole.iter().map(|&v| handle_of[v as usize]).collect();
        let symmetry = symmetry.of_part(&whole);
        Ok(Self { handles, given, part, whole, target_of, handle_of, constraints, symmetry, rods, warnings })
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
            symmetry: self.symmetry.clone(),
            rods: self.rods.clone(),
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

    /// The mesh that methods work on: free vertices and the three rings of given ones around them and around the ends of
    /// their rods.
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

    /// What [`Region::mesh`] and its handles are symmetric about.
    pub fn symmetry(&self) -> &Symmetry {
        &self.symmetry
    }

    /// Rods through the body, by the vertices of [`Region::mesh`]; none where the region is not solid.
    pub(super) fn rods(&self) -> &[Owned] {
        &self.rods
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
