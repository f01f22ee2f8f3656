//! Corners: what the corners of the source's triangles bear, such as UV maps, on the corners of the target's.
//!
//! UV maps have seams: edges whose two sides bear other values. A mean over a seam is a place in the middle of the
//! texture that belongs to neither side, so a face of the target takes all its corners from one side:
//!
//! 1. it starts in the source triangle that its centre lies in;
//! 2. from there it walks over the source to each of its corners' places, across every edge but seams.
//!
//! Where a seam is in the way it stays on the near side, at the place there that is nearest to the corner's. So
//! faces that a seam would cut end at it, and no value lies beyond those of the source. Step 2 crosses an edge
//! only towards the place it looks for (the visibility walk of Devillers, Pion & Teillaud 2002, Walking in a
//! Triangulation), so that it does not go around the end of a seam.
//!
//! Corners without an image take the place that their neighbours' images say, as [`super::attributes`] has it.

use rayon::prelude::*;

use super::apply::Transfer;
use super::attributes::{check_values, clamped_mean};
use crate::geometry::surface::Surface;
use crate::{Error, Fault, Job, Mesh, Result, Vec3, memory};

/// Values at either side of an edge that differ by less than this part of their range are the same: files keep
/// single precision.
const SAME: f64 = 1e-6;

/// A place is reached within this, in unit coordinates.
const REACHED: f64 = 1e-9;

/// A place is beyond an edge by more than this, in barycentric coordinates.
const BEYOND: f64 = 1e-9;

/// Faces looked up between two looks at the job.
const BATCH: usize = 4096;

impl Transfer {
    /// Carries `values`, `channels` of each corner of each source triangle of the input, over to the corners of the
    /// target's triangles.
    ///
    /// `faces` says of each target triangle which face it is part of: triangles of one face take their values from
    /// the same side of seams. Without it each is a face of its own. Every result is a convex combination of values
    /// of one source triangle; 0 at triangles that the target leaves out.
    ///
    /// # Errors
    ///
    /// As [`Transfer::attributes`], and [`Error::InvalidConstraint`] for another number of `faces`.
    pub fn corner_attributes(
        &self,
        values: &[f64],
        channels: usize,
        faces: Option<&[u32]>,
        job: &Job,
    ) -> Result<Vec<f64>> {
        let (source, target) = (&*self.source, &*self.target);
        check_values(values, source.input_triangles(), 3 * channels, "triangles of the source")?;
        self.check_images()?;
        let m = target.input_triangles();
        if let Some(faces) = faces.filter(|faces| faces.len() != m) {
            let problem = format!("{} for {m} triangles of the target", faces.len());
            return Err(Error::InvalidConstraint(Fault::new("faces", problem)));
        }
        memory::check("the attributes", 6 * size_of::<f64>() as u128 * m as u128 * channels as u128)?;
        let rest: Vec<f64> = source.rest().iter().flat_map(|p| p.to_array()).collect();
        let places = self.attributes(&rest, 3, job)?;
        let places: Vec<Vec3> = places.chunks_exact(3).map(Vec3::from_slice).collect();
        let corners = Corners::new(source, values, channels);
        let groups = self.groups(faces);
        let groups: Vec<&[u32]> =
            groups.chunk_by(|a, b| of_face(self, faces, *a) == of_face(self, faces, *b)).collect();
        let mut found = vec![0.0; m * 3 * channels];
        for batch in groups.chunks(BATCH) {
            job.check()?;
            let face = |triangles: &&[u32]| {
                let start = self.start(&corners, triangles, &places);
                let at = |&v: &u32| self.value(&corners, start, v, &places);
                let of = |&t: &u32| (t, target.triangles()[t as usize].iter().flat_map(at).collect());
                triangles.iter().map(of).collect::<Vec<(u32, Vec<f64>)>>()
            };
            for (t, row) in batch.par_iter().flat_map_iter(face).collect::<Vec<_>>() {
                let to = target.triangle_ids()[t as usize] as usize * 3 * channels;
                found[to..to + 3 * channels].copy_from_slice(&row);
            }
        }
        job.report(1.0, "attributes");
        Ok(found)
    }

    /// The target's triangles in use, face by face.
    fn groups(&self, faces: Option<&[u32]>) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.target.triangles().len() as u32).collect();
        order.sort_by_key(|&t| of_face(self, faces, t));
        order
    }

    /// The source triangle that the centre of a face lies in: from the best of those that its triangles and corners
    /// are known to lie on, across seams.
    fn start(&self, corners: &Corners, triangles: &[u32], places: &[Vec3]) -> u32 {
        let at = |t: &u32| self.target.triangles()[*t as usize];
        let all = || triangles.iter().flat_map(at);
        let centre = all().map(|v| places[v as usize]).sum::<Vec3>() / (3 * triangles.len()) as f64;
        let matched = triangles.iter().flat_map(|&t| self.chooser.matches(t as usize)).copied();
        let imaged = all().filter_map(|v| self.used.images[v as usize].map(|image| image.triangle));
        let best = matched.chain(imaged).map(|s| (corners.distance(s, centre), s));
        let best = best.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, s)| s);
        let nearest = || corners.surface.closest_point(centre).map(|hit| hit.triangle as u32);
        corners.walk(best.or_else(nearest).unwrap_or(0), centre, |_, _| false)
    }

    /// The values at a target vertex, seen from the source triangle `start`.
    fn value(&self, corners: &Corners, start: u32, vertex: u32, places: &[Vec3]) -> Vec<f64> {
        let place = places[vertex as usize];
        let t = corners.walk(start, place, |t, corner| corners.is_seam(t, corner));
        let image = self.used.images[vertex as usize].filter(|image| image.triangle == t);
        let weights = image.map_or_else(|| corners.surface.weights(t as usize, place), |image| image.weights);
        corners.at(t, if weights.is_finite() { weights } else { Vec3::X })
    }
}

/// By what triangles of one face are told from others: its number, or their own.
fn of_face(transfer: &Transfer, faces: Option<&[u32]>, triangle: u32) -> u32 {
    let id = transfer.target.triangle_ids()[triangle as usize];
    faces.map_or(id, |faces| faces[id as usize])
}

/// The source with what its corners bear.
struct Corners<'a> {
    mesh: &'a Mesh,
    surface: Surface,
    values: &'a [f64],
    channels: usize,
    /// For each triangle the one across the edge opposite to each corner, where there is just one.
    across: Vec<[Option<u32>; 3]>,
    seams: Vec<[bool; 3]>,
}

impl<'a> Corners<'a> {
    fn new(mesh: &'a Mesh, values: &'a [f64], channels: usize) -> Self {
        let surface = Surface::of(mesh.triangles(), mesh.rest());
        let count = mesh.triangles().len();
        let (across, seams) = (vec![[None; 3]; count], vec![[false; 3]; count]);
        let mut made = Self { mesh, surface, values, channels, across, seams };
        let same: Vec<f64> = (0..channels)
            .map(|c| {
                let of_channel = || values.iter().skip(c).step_by(channels);
                let high = of_channel().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
                SAME * (high - of_channel().fold(f64::INFINITY, |a, &b| a.min(b)))
            })
            .collect();
        for (edge, ends) in mesh.adjacency().edges().iter().enumerate() {
            let [a, b] = mesh.adjacency().sides_of(edge) else { continue };
            let (a, b) = (a.triangle, b.triangle);
            let differ = |v: u32| {
                let [p, q] = [a, b].map(|t| made.row(t, made.corner(t, v)));
                p.iter().zip(q).zip(&same).any(|((p, q), same)| (p - q).abs() > *same)
            };
            let is_seam = ends.iter().any(|&v| differ(v));
            for (t, other) in [(a, b), (b, a)] {
                let is_opposite = |v: &u32| !ends.contains(v);
                let opposite = mesh.triangles()[t as usize].iter().position(is_opposite).unwrap_or(0);
                made.across[t as usize][opposite] = Some(other);
                made.seams[t as usize][opposite] = is_seam;
            }
        }
        made
    }

    fn is_seam(&self, triangle: u32, corner: usize) -> bool {
        self.seams[triangle as usize][corner]
    }

    fn corner(&self, triangle: u32, vertex: u32) -> usize {
        self.mesh.triangles()[triangle as usize].iter().position(|&v| v == vertex).unwrap_or(0)
    }

    fn row(&self, triangle: u32, corner: usize) -> &[f64] {
        let start = (self.mesh.triangle_ids()[triangle as usize] as usize * 3 + corner) * self.channels;
        &self.values[start..start + self.channels]
    }

    fn at(&self, triangle: u32, weights: Vec3) -> Vec<f64> {
        let rows = [0, 1, 2].map(|corner| self.row(triangle, corner));
        (0..self.channels).map(|c| clamped_mean(rows.map(|row| row[c]), weights)).collect()
    }

    /// From a triangle to a point; infinite where it has no area to tell.
    fn distance(&self, triangle: u32, point: Vec3) -> f64 {
        let distance = self.surface.project(triangle as usize, point).distance(point);
        if distance.is_finite() { distance } else { f64::INFINITY }
    }

    /// The triangle nearest to `goal` of those reached from `start` by edges beyond which the goal lies, or which
    /// lead nearer to it; edges opposite to a `barred` corner are not crossed.
    fn walk(&self, start: u32, goal: Vec3, barred: impl Fn(u32, usize) -> bool) -> u32 {
        let mut best = (self.distance(start, goal), start);
        let mut seen = vec![start];
        let mut open = vec![best];
        while let Some((distance, t)) = open.pop() {
            if distance < best.0 {
                best = (distance, t);
            }
            if distance <= REACHED {
                break;
            }
            for (corner, beyond) in self.beyond(t, goal).into_iter().enumerate() {
                let Some(next) = self.across[t as usize][corner] else { continue };
                if barred(t, corner) || seen.contains(&next) {
                    continue;
                }
                let there = self.distance(next, goal);
                if beyond || there < distance {
                    seen.push(next);
                    open.push((there, next));
                }
            }
            // The nearest is looked at first.
            open.sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        best.1
    }

    /// Whether the point is beyond the edge opposite to each corner, seen along the normal.
    fn beyond(&self, triangle: u32, point: Vec3) -> [bool; 3] {
        let corners = self.mesh.triangles()[triangle as usize].map(|v| self.mesh.rest()[v as usize]);
        let normal = self.mesh.normals()[triangle as usize];
        let height = |k: usize| {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let inward = normal.cross(b - a);
            (inward.dot(point - a), inward.dot(corners[k] - a))
        };
        [0, 1, 2].map(|k| {
            let (of_point, of_corner) = height(k);
            of_point < -BEYOND * of_corner
        })
    }
}
