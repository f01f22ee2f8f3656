//! The volume of closed components, restored.
//!
//! ```text
//!     V(x) = 1/6 sum_t  a . (b x c),        V(x(t)) = (1-t) V(start) + t V(end)
//! ```
//!
//! The correction of least energy in the metric of the stitch that changes the volume is along
//! `d = L^-1 grad V`; how far, `V(x + l d) = V(x(t))` says, by Newton's steps.

use super::elements::Elements;
use crate::{Job, Mesh, Result, Vec3};

/// Newton's steps: a cubic polynomial, started near its root.
const STEPS: usize = 8;

/// The components whose volume is kept, with their volume at both ends.
#[derive(Debug)]
pub(super) struct Volumes {
    /// Of each component.
    closed: Vec<bool>,
    ends: [Vec<f64>; 2],
}

impl Volumes {
    pub fn of(mesh: &Mesh, a: &[Vec3], b: &[Vec3]) -> Self {
        let mut closed = vec![true; mesh.components().count()];
        for (e, edge) in mesh.adjacency().edges().iter().enumerate() {
            let sides = mesh.adjacency().sides_of(e);
            let inside = matches!(sides, [p, q] if p.ascending != q.ascending);
            if let Some(c) = mesh.components().of_vertex(edge[0] as usize).filter(|_| !inside) {
                closed[c] = false;
            }
        }
        Self { closed, ends: [volumes(mesh, a), volumes(mesh, b)] }
    }

    /// Components that have no volume.
    pub fn open(&self) -> impl Iterator<Item = usize> + '_ {
        self.closed.iter().enumerate().filter(|(_, closed)| !**closed).map(|(c, _)| c)
    }

    /// Moves `y`, the distance from the straight `line`, so that the volumes are those of time `t`.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Cancelled`].
    pub fn restore(
        &self,
        elements: &Elements,
        line: &[Vec3],
        y: &mut [Vec3],
        t: f64,
        job: &Job,
    ) -> Result<()> {
        let mesh = &*elements.mesh;
        let at = |y: &[Vec3]| -> Vec<Vec3> { line.iter().zip(y).map(|(&l, &y)| l + y).collect() };
        let mut x = at(y);
        let towards = elements.lift(std::iter::once(gradient(mesh, &x)), job)?.remove(0);
        for _ in 0..STEPS {
            let (volumes, slopes) = (volumes(mesh, &x), gradient(mesh, &x));
            let mut slope = vec![0.0; volumes.len()];
            for (v, (g, d)) in slopes.iter().zip(&towards).enumerate() {
                if let Some(c) = mesh.components().of_vertex(v) {
                    slope[c] += g.dot(*d);
                }
            }
            let step: Vec<f64> = (0..volumes.len())
                .map(|c| {
                    let missing = self.ends[0][c] * (1.0 - t) + self.ends[1][c] * t - volumes[c];
                    let step = missing / slope[c];
                    if self.closed[c] && step.is_finite() { step } else { 0.0 }
                })
                .collect();
            for (v, d) in towards.iter().enumerate() {
                if let Some(c) = mesh.components().of_vertex(v) {
                    y[v] += *d * step[c];
                }
            }
            x = at(y);
        }
        Ok(())
    }
}

/// The volume of each component about its own first vertex.
fn volumes(mesh: &Mesh, x: &[Vec3]) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.components().count()];
    let mut origins = vec![None; volumes.len()];
    for t in mesh.triangles() {
        if let Some(c) = mesh.components().of_vertex(t[0] as usize) {
            let origin = *origins[c].get_or_insert(x[t[0] as usize]);
            let [p, q, r] = t.map(|v| x[v as usize] - origin);
            volumes[c] += p.dot(q.cross(r)) / 6.0;
        }
    }
    volumes
}

/// The gradient of the volume by every vertex: a third of the area normals around it.
fn gradient(mesh: &Mesh, x: &[Vec3]) -> Vec<Vec3> {
    let mut gradient = vec![Vec3::ZERO; x.len()];
    for t in mesh.triangles() {
        let [p, q, r] = t.map(|v| x[v as usize]);
        let normal = (q - p).cross(r - p) / 6.0;
        for v in t {
            gradient[*v as usize] += normal;
        }
    }
    gradient
}
