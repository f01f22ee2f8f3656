//! Choose: a target matrix for every target triangle, from the matched source triangles.
//!
//! The target of triangle `t` is the gradient of its image on the source ([`super::image`]). Where it has none
//! that is sound, it is the mean of the gradients of its matches, `C_t = mean_s Q_s`. Triangles without a
//! match either take the harmonic extension of the targets around them: over the dual graph of
//! the patch, `C_t` is the mean of its neighbours. A patch whose surroundings do not change does not
//! change.

use rayon::prelude::*;

use super::correspondence::Correspondence;
use super::frames;
use super::image::{self, Image};
use super::options::Frames;
use super::symmetry::Twins;
use crate::geometry::groups::Groups;
use crate::geometry::rows::Rows;
use crate::linear::{Factor, Symbolic, SymmetricMatrix};
use crate::matrix::outer;
use crate::operators::gradient::triangle_gradient;
use crate::{Mat3, Mesh, Result, Vec3};

/// Movement below this fraction of the diagonal is the noise of single precision, not a pose.
const NOISE: f64 = 1e-7;

/// An image is sound while its area, against that of the triangle, is within this factor of the usual.
const MOST_RESIZED: f64 = 30.0;

/// Elements a task takes at least.
const GRAIN: usize = 4096;

/// Areas below are no triangles, in unit coordinates.
const LEAST_IMAGE_AREA: f64 = 1e-20;

/// Holds a patch that nothing surrounds; far below any coupling.
const GROUND: f64 = 1e-9;

/// What one key does to the source.
pub struct SourceKey<'a> {
    source: &'a Mesh,
    /// Displacement of each vertex, in unit coordinates; exactly zero where it does not move.
    pub displacement: Vec<Vec3>,
}

impl<'a> SourceKey<'a> {
    /// Reads a key off `posed`, (n) positions in the source's own units.
    pub fn of(source: &'a Mesh, posed: &[Vec3]) -> Self {
        let tolerance = NOISE * source.frame().scale;
        let moved = |(&p, &v): (&Vec3, &Vec3)| {
            let d = p - v;
            if d.abs().max_element() > tolerance { d / source.frame().scale } else { Vec3::ZERO }
        };
        Self { source, displacement: posed.iter().zip(source.vertices()).map(moved).collect() }
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.source.triangles()[triangle as usize].map(|v| self.displacement[v as usize])
    }

    /// Whether a triangle moves.
    pub fn moves(&self, triangle: u32) -> bool {
        self.corners(triangle) != [Vec3::ZERO; 3]
    }

    /// Displacement of a triangle's centroid, in unit coordinates; exactly zero where it does not move.
    pub fn shift(&self, triangle: u32) -> Vec3 {
        self.corners(triangle).iter().sum::<Vec3>() / 3.0
    }

    /// `Q_s - I` of a triangle; exactly zero where it does not move.
    fn change(&self, triangle: u32) -> Mat3 {
        let d = self.corners(triangle);
        if d == [Vec3::ZERO; 3] {
            return Mat3::ZERO;
        }
        let rest = self.source.triangles()[triangle as usize].map(|v| self.source.rest()[v as usize]);
        similar_gradient(rest, [rest[0] + d[0], rest[1] + d[1], rest[2] + d[2]]) - Mat3::IDENTITY
    }
}

/// The deformation gradient whose normal is stretched by the square root of the area, as the fourth
/// vertex of Sumner & Popović (2004) has it: a uniform scale is then a multiple of the identity, and
/// stays one on a triangle that lies in another plane.
fn similar_gradient(rest: [Vec3; 3], posed: [Vec3; 3]) -> Mat3 {
    let q = triangle_gradient(rest, posed);
    let cross = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
    let (before, after) = (cross(rest).length(), cross(posed).length());
    let thickness = (after / before).sqrt();
    match cross(rest).try_normalize() {
        Some(normal) if thickness.is_finite() => q + outer(q * normal * (thickness - 1.0), normal),
        _ => q,
    }
}

/// A triangle prepared for [`similar_gradient`] of many poses.
struct Frame {
    edges: [Vec3; 2],
    /// Dual to the edges within the plane.
    duals: [Vec3; 2],
    normal: Vec3,
    double_area: f64,
}

impl Frame {
    fn of([a, b, c]: [Vec3; 3]) -> Self {
        let edges = [b - a, c - a];
        let cross = edges[0].cross(edges[1]);
        let double_area = cross.length();
        let normal = cross / double_area;
        let duals = [edges[1].cross(normal) / double_area, normal.cross(edges[0]) / double_area];
        Self { edges, duals, normal, double_area }
    }

    /// [`similar_gradient`] less the identity, where the corners move by `d`.
    fn change(&self, [a, b, c]: [Vec3; 3]) -> Mat3 {
        let moved = [b - a, c - a];
        let cross = (self.edges[0] + moved[0]).cross(self.edges[1] + moved[1]);
        let size = (cross.length() * self.double_area).sqrt();
        let normal = if size > 0.0 { cross / size } else { Vec3::ZERO };
        outer(moved[0], self.duals[0])
            + outer(moved[1], self.duals[1])
            + outer(normal - self.normal, self.normal)
    }
}

/// The images and matches of every target triangle, and the patches that have none.
pub struct Chooser {
    images: Vec<Option<Image>>,
    /// Where the images are at rest.
    points: Vec<Vec3>,
    /// The images of target triangles that are triangles like them.
    sound: Vec<Option<Frame>>,
    /// The source triangles matched with each target triangle.
    matches: Rows<u32>,
    patches: Option<Patches>,
    /// How triangles are turned against their images; none where the directions are the source's ([`super::frames`]).
    frames: Vec<Mat3>,
}

/// Target triangles without a match.
struct Patches {
    triangles: Vec<u32>,
    /// Neighbours of a patch: place of the patch triangle, matched target triangle.
    border: Vec<(u32, u32)>,
    patches: Groups,
    factor: Factor,
}

impl Chooser {
    /// Sorts the pairs of `used` by target triangle; its images have one entry a target vertex, or none at all. All count
    /// triangles in use.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`] where the patches without a match cannot be factored.
    pub fn new(source: &Mesh, target: &Mesh, used: &Correspondence, frames: Frames) -> Result<Self> {
        let Correspondence { pairs, images, .. } = used;
        let mut images: Vec<_> =
            images.iter().map(|image| image.as_ref().map(|&image| Image::on(source, image))).collect();
        let place = |image: &Option<Image>| Some((*image)?.interpolate(|v| source.rest()[v as usize]));
        let twins = Twins::of_both(source, target, &images.iter().map(place).collect::<Vec<_>>());
        let mut sorted: Vec<[u32; 2]> = pairs.iter().map(|&[s, t]| [t, s]).collect();
        if let Some(twins) = &twins {
            images = image::mirrored(&images, twins);
            let [of_source, of_target] = &twins.triangles;
            let twin = |&[s, t]: &[u32; 2]| Some([of_target[t as usize]?, of_source[s as usize]?]);
            sorted.extend(pairs.iter().filter_map(twin));
        }
        sorted.sort_unstable();
        sorted.dedup();
        let matches = Rows::sort(target.triangles().len(), sorted.into_iter().map(|[t, s]| (t, s)));
        let points = images.iter().map(|image| place(image).unwrap_or_default()).collect();
        let (sound, none) = (Vec::new(), Vec::new());
        let mut chooser = Self { images, points, sound, matches, patches: None, frames: none };
        let corners =
            |(t, sound): (&[u32; 3], bool)| sound.then(|| Frame::of(t.map(|v| chooser.points[v as usize])));
        let mut sound = chooser.find_sound(source, target, used);
        if let Some(twins) = &twins {
            let of_twin = |twin: &Option<u32>| twin.is_none_or(|twin| sound[twin as usize]);
            let agreed = sound.iter().zip(&twins.triangles[1]).map(|(&own, twin)| own && of_twin(twin));
            sound = agreed.collect();
        }
        chooser.sound = target.triangles().iter().zip(sound).map(corners).collect();
        if frames == Frames::Local {
            let map = |(t, corners): (usize, &[u32; 3])| {
                chooser.sound[t].as_ref()?;
                let [from, to] = [&chooser.points, target.rest()].map(|at| corners.map(|v| at[v as usize]));
                Some(triangle_gradient(from, to))
            };
            let maps: Vec<_> = target.triangles().iter().enumerate().map(map).collect();
            chooser.frames = frames::rotations(target, &maps);
        }
        chooser.patches = chooser.unmatched(target)?;
        Ok(chooser)
    }

    /// Images that keep their size against the other triangles, and the side that they show, however either mesh is wound;
    /// or the other one where meshes overlap and the triangle itself faces away, as linings do.
    fn find_sound(&self, source: &Mesh, target: &Mesh, matches: &Correspondence) -> Vec<bool> {
        let over = [source.against(false), target.against(matches.inside_out)];
        let of = |(t, corners): (usize, &[u32; 3])| -> Option<(f64, bool)> {
            let images = corners.map(|v| self.images.get(v as usize).copied().flatten());
            let [Some(a), Some(b), Some(c)] = images else { return None };
            let [p, q, r] = corners.map(|v| self.points[v as usize]);
            let cross = (q - p).cross(r - p);
            let shows = |image: Image| {
                let s = image.triangle as usize;
                let normal = source.normals()[s] * if over[0][s] != over[1][t] { -1.0 } else { 1.0 };
                let lines = || matches.overlap && normal.dot(target.normals()[t]) < 0.0;
                normal.dot(cross) > 0.0 || (lines() && normal.dot(cross) < 0.0)
            };
            Some((0.5 * cross.length(), [a, b, c].into_iter().filter(|&i| shows(i)).count() >= 2))
        };
        let found: Vec<_> = target.triangles().par_iter().enumerate().map(of).collect();
        let ratio = |(found, &area): (&Option<(f64, bool)>, &f64)| found.map(|(image, _)| image / area);
        let mut ratios: Vec<f64> = found.iter().zip(target.areas()).filter_map(ratio).collect();
        ratios.retain(|r| r.is_finite() && *r > 0.0);
        ratios.sort_unstable_by(f64::total_cmp);
        let Some(&usual) = ratios.get(ratios.len() / 2) else { return vec![false; found.len()] };
        let sound = |(found, &area): (&Option<(f64, bool)>, &f64)| {
            found.is_some_and(|(image, faces)| {
                let against = image / (area * usual);
                faces && image > LEAST_IMAGE_AREA && against > 1.0 / MOST_RESIZED && against < MOST_RESIZED
            })
        };
        found.iter().zip(target.areas()).map(sound).collect()
    }

    /// Whether a target vertex has an image.
    pub fn has_image(&self, vertex: usize) -> bool {
        self.images.get(vertex).is_some_and(Option::is_some)
    }

    /// Where the image of a target vertex is at rest, in the source's unit coordinates.
    pub fn image(&self, vertex: usize) -> Option<Vec3> {
        self.has_image(vertex).then(|| self.points[vertex])
    }

    /// Displacements of the images of all target vertices; zero where there is none.
    pub fn displacements(&self, key: &SourceKey) -> Vec<Vec3> {
        let of = |image: &Option<Image>| match image {
            Some(image) => image.interpolate(|v| key.displacement[v as usize]),
            None => Vec3::ZERO,
        };
        self.images.par_iter().with_min_len(GRAIN).map(of).collect()
    }

    /// Whether something tells what a target triangle does.
    pub fn has_target(&self, triangle: usize) -> bool {
        self.sound[triangle].is_some() || !self.matches(triangle).is_empty()
    }

    /// The source triangles matched with a target triangle.
    pub fn matches(&self, triangle: usize) -> &[u32] {
        self.matches.of(triangle)
    }

    fn unmatched(&self, target: &Mesh) -> Result<Option<Patches>> {
        let is_unmatched = |t: &u32| !self.has_target(*t as usize);
        let triangles: Vec<u32> = (0..target.triangles().len() as u32).filter(is_unmatched).collect();
        if triangles.is_empty() {
            return Ok(None);
        }
        let place = |t: u32| triangles.binary_search(&t).ok().map(|p| p as u32);
        let (mut border, mut inner) = (Vec::new(), Vec::new());
        for [a, b] in target.adjacency().triangle_pairs() {
            match (place(a), place(b)) {
                (Some(a), Some(b)) => inner.push((a, b)),
                (Some(a), None) => border.push((a, b)),
                (None, Some(b)) => border.push((b, a)),
                (None, None) => {}
            }
        }
        let edges = inner.iter().map(|&(a, b)| (a, b, 1.0));
        let mut matrix = SymmetricMatrix::laplacian(triangles.len(), edges);
        for row in 0..triangles.len() {
            matrix.add_to_diagonal(row, GROUND);
        }
        for &(a, _) in &border {
            matrix.add_to_diagonal(a as usize, 1.0);
        }
        let factor = Symbolic::analyse(&matrix)?.factor(&matrix)?;
        let patches = Groups::joining(triangles.len(), inner.iter().map(|&(a, b)| [a, b]));
        Ok(Some(Patches { triangles, border, patches, factor }))
    }

    /// Of every target triangle `C_t - I`, where the images have gone by `moved`, and whether it moves: its
    /// image does, or one of its matches, or, in a patch without either, anything around the patch.
    pub fn changes(&self, target: &Mesh, key: &SourceKey, moved: &[Vec3]) -> (Vec<Mat3>, Vec<bool>) {
        let change = |(t, corners): (usize, &[u32; 3])| {
            if let Some(frame) = &self.sound[t] {
                let d = corners.map(|v| moved[v as usize]);
                return if d == [Vec3::ZERO; 3] { (Mat3::ZERO, false) } else { (frame.change(d), true) };
            }
            let matches = self.matches(t);
            let mean = matches.iter().map(|&s| key.change(s)).sum::<Mat3>() / matches.len().max(1) as f64;
            (mean, matches.iter().any(|&s| key.moves(s)))
        };
        let triangles = target.triangles().par_iter().enumerate().with_min_len(GRAIN);
        let (mut changes, mut moves): (Vec<Mat3>, Vec<bool>) = triangles.map(change).unzip();
        for (change, &frame) in changes.iter_mut().zip(&self.frames) {
            *change = frame * *change * frame.transpose();
        }
        if let Some(patches) = &self.patches {
            patches.extend(&mut changes);
            patches.mark(&mut moves);
        }
        (changes, moves)
    }
}

impl Patches {
    fn extend(&self, changes: &mut [Mat3]) {
        let mut columns = [0, 1, 2].map(|_| vec![Vec3::ZERO; self.triangles.len()]);
        for &(place, neighbour) in &self.border {
            for (c, column) in columns.iter_mut().enumerate() {
                column[place as usize] += changes[neighbour as usize].col(c);
            }
        }
        self.factor.solve(&mut columns);
        let [x, y, z] = columns;
        for (place, &t) in self.triangles.iter().enumerate() {
            changes[t as usize] = Mat3::from_cols(x[place], y[place], z[place]);
        }
    }

    fn mark(&self, moves: &mut [bool]) {
        let patch = self.patches.of();
        let mut reached = vec![false; self.patches.count()];
        for &(place, neighbour) in &self.border {
            reached[patch[place as usize] as usize] |= moves[neighbour as usize];
        }
        for (&t, &patch) in self.triangles.iter().zip(patch) {
            moves[t as usize] = reached[patch as usize];
        }
    }
}
