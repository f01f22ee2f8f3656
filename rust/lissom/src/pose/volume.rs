//! The volume that closed components have at rest, restored after any method.
//!
//! The surface moves along its normals, smoothed as a thin plate that is held where vertices are given: the
//! correction fades out towards the handles with continuous slope.

use super::field::smooth_system;
use super::region::Region;
use crate::linear::ConstrainedSystem;
use crate::stitch::Volumes;
use crate::{Fault, Job, Mesh, Result, Vec3};

/// The volumes to keep, and the metric in which that moves least.
#[derive(Debug)]
pub(super) struct KeptVolume {
    volumes: Volumes,
    plate: ConstrainedSystem,
}

impl KeptVolume {
    pub fn of(mesh: &Mesh, region: &Region, job: &Job) -> Result<Self> {
        Ok(Self {
            volumes: Volumes::of(mesh, mesh.rest(), mesh.rest()),
            plate: smooth_system(region, 1, job)?,
        })
    }

    pub fn system(&self) -> &ConstrainedSystem {
        &self.plate
    }

    /// What is doubtful: components that have no volume.
    pub fn warning(&self, mesh: &Mesh) -> Option<String> {
        let members = mesh.components().members();
        let open = self.volumes.open().map(|c| members[c][0] as usize).filter(|&v| !mesh.is_mirror_image(v));
        let problem = "open components, which have no volume to preserve, named by their first vertex";
        Fault::at("preserve_volume", problem, open).map(|fault| fault.to_string())
    }

    /// Moves the free vertices, all of them in the mesh's own units.
    pub fn restore(&self, mesh: &Mesh, region: &Region, vertices: &mut [Vec3]) {
        let frame = mesh.frame();
        let (rest, own) = (mesh.rest(), mesh.vertices());
        let before: Vec<Vec3> = vertices.iter().zip(own).map(|(&x, &v)| (x - v) / frame.scale).collect();
        let mut moved = before.clone();
        self.volumes.restore(mesh, rest, &mut moved, &self.volumes.at(0.0), |gradient| {
            let of_part = region.whole().iter().map(|&v| gradient[v as usize]).collect::<Vec<_>>();
            let mut corrections = [vec![Vec3::ZERO; of_part.len()]];
            self.plate.solve(&[of_part], &mut corrections);
            let mut spread = vec![Vec3::ZERO; gradient.len()];
            for (&v, &correction) in region.whole().iter().zip(&corrections[0]) {
                spread[v as usize] = correction;
            }
            spread
        });
        for (v, (moved, before)) in moved.iter().zip(&before).enumerate() {
            vertices[v] += (*moved - *before) * frame.scale;
        }
    }
}
