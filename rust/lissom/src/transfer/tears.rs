//! Tears: edges of the target that a key makes longer than anything around their place on the source.
//!
//! A fit is nowhere exact. Where two places that lie on each other part, as lips do, vertices that it has put on the wrong
//! one make rags of the triangles beside them, and a long edge at the corner of a coarse mouth takes what a source
//! with dense loops there spreads over ten. So no edge `e` of the target gets longer than
//!
//! ```text
//!     max( limit, min( |C_t e| / |e|, s_t ) )      times its length at rest
//! ```
//!
//! where `C_t` is what was asked of the triangles beside it ([`super::choose`]) and `s_t` the most that any of the
//! source's triangles around their matches and images is stretched: what is stretched on the source may be.

use super::apply::Transfer;
use super::choose::SourceKey;
use crate::operators::gradient::singular_values;
use crate::{Mat3, Mesh, Vec3};

impl Transfer {
    /// Brings edges of the target that are torn to what they may be; `displacements` in its unit coordinates, `changes` is
    /// what was asked of its triangles. What does not move stays, and so do those that `meet` others.
    pub(super) fn mend_tears(
        &self,
        key: &SourceKey,
        changes: &[Mat3],
        meet: &[u32],
        displacements: &mut [Vec3],
    ) {
        let (target, rest) = (&*self.target, self.target.rest());
        let edges = target.adjacency().edges();
        let mut positions: Vec<Vec3> = rest.iter().zip(&*displacements).map(|(&p, &d)| p + d).collect();
        let at_rest = |e: usize| rest[edges[e][0] as usize].distance(rest[edges[e][1] as usize]);
        let is_torn = |e: usize| {
            let [a, b] = edges[e].map(|v| positions[v as usize]);
            a.distance(b) > self.stretch * at_rest(e)
        };
        if !(0..edges.len()).any(is_torn) {
            return;
        }
        let of_source = Stretched::of(&self.source, key);
        let most = |e: usize| {
            let [a, b] = edges[e].map(|v| rest[v as usize]);
            let sides = target.adjacency().sides_of(e).iter().map(|side| side.triangle as usize);
            let allowed = sides.map(|t| {
                let asked = (b - a + changes[t] * (b - a)).length() / a.distance(b);
                let corners = target.triangles()[t].map(|v| self.used.images[v as usize]);
                let images = corners.iter().flatten().map(|image| image.triangle);
                let around = self.chooser.matches(t).iter().copied().chain(images);
                let there = around.map(|s| of_source.around(s)).fold(1.0, f64::max);
                asked.min(1.0 + (there - 1.0) * self.scaling.factor(target, t).max(1.0))
            });
            allowed.fold(self.stretch, f64::max)
        };
        let limits: Vec<f64> = (0..edges.len()).map(|e| most(e) * at_rest(e)).collect();
        let mut held: Vec<bool> = displacements.iter().map(|&d| d == Vec3::ZERO).collect();
        meet.iter().for_each(|&v| held[v as usize] = true);
        target.shorten_edges(&mut positions, |e| limits[e], |v| held[v]);
        for (((d, &p), &v), held) in displacements.iter_mut().zip(&positions).zip(rest).zip(held) {
            if !held {
                *d = p - v;
            }
        }
    }
}

/// How much the triangles of the source are stretched by a key.
struct Stretched<'a> {
    source: &'a Mesh,
    /// The most at each vertex.
    vertices: Vec<f64>,
}

impl<'a> Stretched<'a> {
    fn of(source: &'a Mesh, key: &SourceKey) -> Self {
        let mut vertices = vec![1.0; source.rest().len()];
        for corners in source.triangles() {
            let d = corners.map(|v| key.displacement[v as usize]);
            if d == [Vec3::ZERO; 3] {
                continue;
            }
            let rest = corners.map(|v| source.rest()[v as usize]);
            let [most, _] = singular_values(rest, [rest[0] + d[0], rest[1] + d[1], rest[2] + d[2]]);
            corners.iter().for_each(|&v| vertices[v as usize] = most.max(vertices[v as usize]));
        }
        Self { source, vertices }
    }

    /// The most around a triangle.
    fn around(&self, triangle: u32) -> f64 {
        self.source.triangles()[triangle as usize]
            .map(|v| self.vertices[v as usize])
            .into_iter()
            .fold(1.0, f64::max)
    }
}
