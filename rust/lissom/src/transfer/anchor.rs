//! Anchors: gradients say how the target changes its shape, displacements where it goes.
//!
//! ```text
//!     sum_v  m_v / l^2  | d_v - a_v |^2        joins the stitching energy
//! ```
//!
//! Gradients know the long way only as a sum of many short ones, and each of them is off by what the fit is off.
//! So every vertex that has an image is pulled weakly to where its image goes: `a_v` is the image's
//! displacement, times the size of the component over that of its images, or at its own size ([`super::scale`]).
//! Over distances below `l` the gradients rule, beyond it the displacements (a screened Poisson equation: Bhat,
//! Curless, Cohen & Zitnick 2008, Fourier Analysis of the 2D Screened Poisson Equation for Gradient Domain Problems).
//!
//! Where all of a component moves, the similarity that fits its images best (Umeyama 1991) is taken out first
//! and applied to the component as it is, so that similarities come over as such.

use super::choose::Chooser;
use super::sizes::Sizes;
use crate::geometry::rigid::{self, Alignment, Similarity};
use crate::{Mat3, Mesh, Vec3};

/// The pulls of one target.
pub struct Anchors {
    parts: Vec<AnchoredComponent>,
}

struct AnchoredComponent {
    /// Vertices with an image, and their weight.
    vertices: Vec<(u32, f64)>,
    /// Root mean square size of the vertices over that of their images, or what stands for it.
    size: f64,
    /// What the displacements of the images are multiplied with.
    gain: f64,
}

/// What a component does as a whole: the similarity that fits its images best.
pub struct Whole {
    of_images: Similarity,
    shift: Vec3,
    /// What its growth is multiplied with on the target.
    growth: f64,
}

impl Whole {
    /// Its linear part, on the source.
    pub fn of_source(&self) -> Mat3 {
        self.of_images.linear()
    }

    /// The same on the target.
    pub fn linear(&self) -> Mat3 {
        let linear = self.of_images.linear();
        let scale = linear.determinant().abs().cbrt();
        if self.growth == 1.0 || scale <= 0.0 {
            return linear;
        }
        linear * ((1.0 + self.growth * (scale - 1.0)) / scale)
    }
}

impl Anchors {
    /// Anchors on every vertex with an image; `length` in unit coordinates, `weights` what the stitching energy
    /// multiplies the area of each triangle with, `sizes` as [`super::scale`] has them.
    pub fn new(target: &Mesh, chooser: &Chooser, weights: &[f64], length: f64, sizes: Sizes) -> Self {
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
            let size = sizes.size(rigid::size_ratio(own, images));
            AnchoredComponent { vertices, size, gain: sizes.gain(size) }
        };
        Self { parts: target.components().members().into_iter().map(part).collect() }
    }

    /// Whether a component of the target has any.
    pub fn hold(&self, component: usize) -> bool {
        !self.parts[component].vertices.is_empty()
    }

    /// The lengths of a component over those of its images, in unit coordinates.
    pub fn size(&self, component: usize) -> f64 {
        self.parts[component].size
    }

    /// What a component does as a whole, where its images have gone by `moved`; `None` where one of them rests.
    pub fn whole(&self, component: usize, chooser: &Chooser, moved: &[Vec3]) -> Option<Whole> {
        self.parts[component].whole(chooser, moved)
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

impl AnchoredComponent {
    /// Where the images of the vertices are, and where they go.
    fn ways<'a>(
        &'a self,
        chooser: &'a Chooser,
        moved: &'a [Vec3],
    ) -> impl Iterator<Item = (Vec3, Vec3)> + Clone + 'a {
        let way = |&(v, _): &(u32, f64)| chooser.image(v as usize).map(|p| (p, p + moved[v as usize]));
        self.vertices.iter().filter_map(way)
    }

    fn whole(&self, chooser: &Chooser, moved: &[Vec3]) -> Option<Whole> {
        if self.vertices.is_empty() || self.vertices.iter().any(|&(v, _)| moved[v as usize] == Vec3::ZERO) {
            return None;
        }
        let alignment = Alignment::of(self.ways(chooser, moved));
        let (from, to) = alignment.centroids();
        let growth = if self.gain == self.size { 1.0 } else { self.gain / self.size };
        Some(Whole { of_images: alignment.similar(), shift: to - from, growth })
    }

    fn targets(&self, target: &Mesh, chooser: &Chooser, moved: &[Vec3]) -> Vec<(u32, Vec3)> {
        let vertices = self.vertices.iter().map(|&(v, _)| v);
        let Some(whole) = self.whole(chooser, moved) else {
            return vertices.map(|v| (v, moved[v as usize] * self.gain)).collect();
        };
        let rest = |v: u32| target.rest()[v as usize];
        let centre = rigid::centroid(vertices.clone().map(rest));
        let linear = whole.linear();
        let at = |(v, (p, q)): (u32, (Vec3, Vec3))| {
            let as_a_whole = linear * (rest(v) - centre) + centre - rest(v);
            (v, as_a_whole + (whole.shift + q - whole.of_images.apply(p)) * self.gain)
        };
        vertices.zip(self.ways(chooser, moved)).map(at).collect()
    }
}
