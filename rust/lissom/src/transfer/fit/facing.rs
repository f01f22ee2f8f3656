//! Facing: which way the faces of either mesh look.
//!
//! A fit joins places whose normals agree, but artists' meshes have normals that nobody has looked at: halves that were
//! mirrored without turning them, whole heads inside out. Faces are turned for the fit alone:
//!
//! 1. those wound against most of the part that they hang together with;
//! 2. all of the target's, where it encloses its volume the other way than the source does, and lies on it better when
//!    turned. Open surfaces enclose what is between them and their centroid, so that either alone may err: a face
//!    with deep sockets encloses little, and markers exchanged left and right lay a face on another from behind.

use std::borrow::Cow;

use super::marked::checked;
use super::options::FitOptions;
use super::side::{Placed, Side};
use crate::geometry::rigid::{Alignment, Similarity};
use crate::geometry::triangle::interpolate;
use crate::transfer::alignment;
use crate::transfer::image::SurfacePoint;
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// Where the nearest faces that look the other way are nearer than those that look alike, by this factor at the mean, it
/// lies better turned.
const NEARER: f64 = 0.7;

/// So many triangles tell.
const ASKED: usize = 2000;

/// What is said of a target that is turned as a whole.
pub const INSIDE_OUT: &str = "the target's faces look the other way than the source's: one of the two is inside out. The \
                              target is fitted as if turned; in Blender, Mesh > Normals > Recalculate Outside turns it \
                              for good";

/// A mesh with its triangles wound alike.
pub struct Wound<'a> {
    /// It, with the triangles of the one that was given, in their order.
    pub mesh: Cow<'a, Mesh>,
    /// Which of them were turned, as the input counts them; empty where none was.
    turned: Vec<bool>,
}

impl<'a> Wound<'a> {
    fn of(mesh: &'a Mesh, inside_out: bool) -> Self {
        let over = mesh.against(inside_out);
        if !over.contains(&true) {
            return Self { mesh: Cow::Borrowed(mesh), turned: Vec::new() };
        }
        let wound = mesh.turned_over(&over);
        let mut turned = vec![false; mesh.input_triangles()];
        mesh.triangle_ids().iter().zip(over).for_each(|(&t, over)| turned[t as usize] = over);
        Self { mesh: Cow::Owned(wound), turned }
    }

    /// Points of its triangles, by the corners as the mesh was given.
    pub fn as_given(&self, points: &mut [Option<SurfacePoint>]) {
        for point in points.iter_mut().flatten() {
            if self.turned.get(point.triangle as usize).is_some_and(|&turned| turned) {
                point.weights = Vec3::new(point.weights.x, point.weights.z, point.weights.y);
            }
        }
    }
}

/// Both meshes wound alike, and whether that turns all of the target.
///
/// # Errors
///
/// As [`super::fit_correspondence`].
pub fn wound_alike<'a>(
    source: &'a Mesh,
    target: &'a Mesh,
    markers: Option<&[[u32; 2]]>,
    options: &FitOptions,
    job: &Job,
) -> Result<([Wound<'a>; 2], bool)> {
    let (own, as_it_is) = rayon::join(|| Wound::of(source, false), || Wound::of(target, false));
    if enclosed(&own.mesh) * enclosed(&as_it_is.mesh) < 0.0 {
        let turned = Wound::of(target, true);
        if lies_better(&own.mesh, [&as_it_is.mesh, &turned.mesh], markers, options, job)? {
            return Ok(([own, turned], true));
        }
    }
    Ok(([own, as_it_is], false))
}

/// Six times the volume between the surface and its centroid: below 0 where it is inside out.
fn enclosed(mesh: &Mesh) -> f64 {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.rest()[v as usize]);
    let centroid = |t: &[u32; 3]| corners(t).iter().sum::<Vec3>() / 3.0;
    let moments = mesh.triangles().iter().zip(mesh.areas()).map(|(t, &area)| centroid(t) * area);
    let centre = moments.sum::<Vec3>() / mesh.area();
    let volume = |t: &[u32; 3]| {
        let [a, b, c] = corners(t).map(|p| p - centre);
        a.dot(b.cross(c))
    };
    mesh.triangles().iter().map(volume).sum()
}

/// Whether the source lies better on the second one of two targets, which is the first one turned.
fn lies_better(
    source: &Mesh,
    [as_it_is, turned]: [&Mesh; 2],
    markers: Option<&[[u32; 2]]>,
    options: &FitOptions,
    job: &Job,
) -> Result<bool> {
    let masks =
        [("source_mask", source, &options.source_mask), ("target_mask", turned, &options.target_mask)];
    let [own, other] = masks.map(|(name, mesh, mask)| Side::new(mesh, name, mask));
    let (own, other) = (own?, other?);
    let found = markers.map(|markers| checked(source, turned, markers, options)).transpose()?;
    let lie = if options.overlap {
        let [from, to] = [source, turned].map(Mesh::frame);
        let scale = Mat3::IDENTITY * (from.scale / to.scale);
        Similarity::new(scale, Vec3::ZERO, to.to_unit(from.from_unit(Vec3::ZERO)))
    } else if let Some(found) = found {
        let by_markers = Alignment::of(found.iter().map(|marker| (marker.rest, marker.goal)));
        if !by_markers.is_determined() {
            return Ok(false);
        }
        by_markers.similar()
    } else {
        let lie = |target| {
            let (masked, onto) = (&own.masked_vertex, &other.masked_vertex);
            alignment::align(source, target, masked, onto, options.most_turn, job)
        };
        let [as_it_is, turned] = [lie(as_it_is)?, lie(turned)?];
        return Ok(turned.certainty > as_it_is.certainty);
    };
    let onto = Placed::new(&other, turned.rest());
    let laid: Vec<Vec3> = source.rest().iter().map(|&p| lie.apply(p)).collect();
    let laid = Placed::new(&own, &laid);
    let step = source.triangles().len().div_ceil(ASKED);
    let distances = |t: usize| {
        let corners = source.triangles()[t].map(|v| laid.positions[v as usize]);
        let (at, normal) = (interpolate(corners, Vec3::ONE / 3.0), laid.surface.normal(t));
        let away = |normal| onto.closest(at, normal, 1.0, None, 0.0).map_or(1.0, |hit| hit.distance);
        [away(-normal), away(normal)]
    };
    let asked = (0..source.triangles().len()).step_by(step).filter(|&t| !own.masked[t]).map(distances);
    let [as_it_is, turned] = asked.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    Ok(turned < NEARER * as_it_is)
}

#[cfg(test)]
mod tests {
    use super::super::fit_correspondence;
    use super::*;
    use crate::transfer::testing::nosed_sphere;

    #[test]
    fn faces_that_look_the_other_way_are_fitted_as_if_they_did_not() {
        let mesh = |rings, around, wrong: &dyn Fn(usize) -> bool| {
            let (vertices, triangles) = nosed_sphere(rings, around);
            let wound = |(k, &[a, b, c]): (usize, &[u32; 3])| if wrong(k) { [a, c, b] } else { [a, b, c] };
            Mesh::new(vertices, triangles.iter().enumerate().map(wound).collect()).unwrap()
        };
        let right = |_| false;
        let [source, target] = [mesh(12, 20, &right), mesh(23, 31, &right)];
        let options = FitOptions::default();
        let nearest = |p: Vec3| {
            let distance = |&v: &usize| target.rest()[v].distance(p);
            (0..target.rest().len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap() as u32
        };
        let markers: Vec<[u32; 2]> =
            [5, 60, 110, 170, 215].map(|v| [v, nearest(source.rest()[v as usize])]).into();
        let fit = |source: &Mesh, target: &Mesh| {
            fit_correspondence(source, target, Some(&markers), &options, &Job::default()).unwrap()
        };
        let best = fit(&source, &target);
        let right_places = [(&source, &best.matches.images), (&target, &best.matches.back_images)];
        let told = |warnings: &[String]| warnings.iter().any(|w| w.contains("inside out"));
        for (wrong, all) in [(&(|_| true) as &dyn Fn(usize) -> bool, true), (&|k| k % 7 == 3, false)] {
            let [of_source, of_target] = [mesh(12, 20, wrong), mesh(23, 31, wrong)];
            for (source, target, all) in
                [(&of_source, &target, all), (&source, &of_target, all), (&of_source, &of_target, false)]
            {
                let found = fit(source, target);
                assert_eq!(told(&found.report.warnings), all, "{:?}", found.report.warnings);
                assert_eq!(found.matches.pairs, best.matches.pairs);
                assert_eq!(found.report.flipped_triangles, 0);
                let place = |mesh: &Mesh, image: &Option<SurfacePoint>| {
                    let SurfacePoint { triangle, weights } = image.unwrap();
                    interpolate(mesh.triangles()[triangle as usize].map(|v| mesh.rest()[v as usize]), weights)
                };
                let found = [(source, found.matches.images), (target, found.matches.back_images)];
                for ((mesh, images), (right, before)) in found.iter().zip(&right_places) {
                    for (image, before) in images.iter().zip(*before) {
                        assert!(place(mesh, image).distance(place(right, before)) < 1e-6);
                    }
                }
            }
        }
    }
}
