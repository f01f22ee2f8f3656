//! Anchors: gradients say how the target changes its shape, displacements where it goes.
//!
//! ```text
//!     sum_v  m_v / l^2  | d_v - a_v |^2        joins the stitching energy
//! ```
//!
//! Gradients know the long way only as a sum of many short ones, and each of them is off by what the fit is off.
//! So every vertex that has an image is pulled weakly to where its image goes: `a_v` is the image's
//! displacement, times the size of the component over that of its images. Over distances below `l` the gradients
//! rule, beyond it the displacements (a screened Poisson equation: Bhat, Curless, Cohen & Zitnick 2008, Fourier
//! Analysis of the 2D Screened Poisson Equation for Gradient Domain Problems).
//!
//! Where all of a component moves, the similarity that fits its images best (Umeyama 1991) is taken out first
//! and applied to the component as it is, so that similarities come over as such.

use super::choose::Chooser;
use crate::geometry::rigid::{self, Alignment};
use crate::{Mesh, Vec3};

/// The pulls of one target.
pub struct Anchors {
    parts: Vec<Part>,
}

struct Part {
    /// Vertices with an image, and their weight.
    vertices: Vec<(u32, f64)>,
    /// Root mean square spread of the vertices over that of their images.
    size: f64,
}

impl Anchors {
    /// Anchors on every vertex with an image; `length` in unit coordinates, `weights` what the stitching energy
    /// multiplies the area of each triangle with.
    pub fn new(target: &Mesh, chooser: &Chooser, weights: &[f64], length: f64) -> Self {
        let mut mass = vec![0.0; target.rest().len()];
        for ((t, &area), weight) in target.triangles().iter().zip(target.areas()).zip(weights) {
            t.iter().for_each(|&v| mass[v as usize] += area * weight / 3.0);
        }
        let part = |members: Vec<u32>| {
            let imaged = members.into_iter().filter(|&v| chooser.has_image(v as usize));
            let vertices: Vec<(u32, f64)> =
                imaged.map(|v| (v, mass[v as usize].max(f64::MIN_POSITIVE) / (length * length))).collect();
            let own = vertices.iter().map(|&(v, _)| target.rest()[v as usize]);
            let images = vertices.iter().map(|&(v, _)| chooser.image(v as usize).unwrap_or_default());
            let size = rigid::size_ratio(own, images);
            Part { vertices, size }
        };
        Self { parts: target.components().members().into_iter().map(part).collect() }
    }

    /// Whether a component of the target has any.
    pub fn hold(&self, component: usize) -> bool {
        !self.parts[component].vertices.is_empty()
    }

    /// Root mean square spread of a component's vertices over that of their images, in unit coordinates.
    pub fn size(&self, component: usize) -> f64 {
        self.parts[component].size
    }

    /// Vertices and weights.
    pub fn soft(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.parts.iter().flat_map(|part| part.vertices.iter().copied())
    }

    /// `a_v` for each of them, where the images have gone by `moved`; all in unit coordinates.
    pub fn targets(&self, target: &Mesh, chooser: &Chooser, moved: &[Vec3]) -> Vec<(u32, Vec3)> {
        self.parts.iter().flat_map(|part| part.targets(target, chooser, moved)).collect()
    }
}

impl Part {
    fn targets(&self, target: &Mesh, chooser: &Chooser, moved: &[Vec3]) -> Vec<(u32, Vec3)> {
        let moved = |v: u32| moved[v as usize];
        let vertices = self.vertices.iter().map(|&(v, _)| v);
        if vertices.clone().any(|v| moved(v) == Vec3::ZERO) {
            return vertices.map(|v| (v, moved(v) * self.size)).collect();
        }
        let from: Vec<Vec3> = vertices.clone().filter_map(|v| chooser.image(v as usize)).collect();
        let to: Vec<Vec3> = from.iter().zip(vertices.clone()).map(|(&p, v)| p + moved(v)).collect();
        let carry = Alignment::of(from.iter().copied().zip(to.iter().copied())).similar();
        let rest = |v: u32| target.rest()[v as usize];
        let count = from.len() as f64;
        let centre = vertices.clone().map(rest).sum::<Vec3>() / count;
        let shift = (to.iter().sum::<Vec3>() - from.iter().sum::<Vec3>()) / count;
        let at = |(v, (&p, &q)): (u32, (&Vec3, &Vec3))| {
            let as_a_whole = carry.linear() * (rest(v) - centre) + centre - rest(v);
            (v, as_a_whole + (shift + q - carry.apply(p)) * self.size)
        };
        vertices.zip(from.iter().zip(&to)).map(at).collect()
    }
}
