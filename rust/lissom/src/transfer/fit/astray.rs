//! Astray: curves that the surfaces speak against.
//!
//! A curve leads what is beside it wherever it goes, and few markers do not tell whether it is cut short or another one,
//! as the lower lid for the upper. The surfaces do: they are fitted without curves at first, and where that puts one
//! elsewhere by more than a part of its length, with it. It is believed unless it bends the source around it more *and*
//! keeps it further from the target than without. Shapes may be wrong about a curve, as those of faces are about the
//! eyes of a cartoon, but there the right curve brings them nearer to each other.

use super::lie::Lie;
use super::marked::LedBy;
use super::markers::{LEADING, Marker};
use super::options::FitOptions;
use super::proportions::{bending, root_mean_square};
use super::registration::{Registered, register};
use super::side::{Placed, Side};
use crate::geometry::triangle::vertex_normals;
use crate::{Job, Result, Vec3};

/// Curves are believed where they are off by less than this part of their length: by lengths along them, those of the lids
/// of another artist's head are off by up to 0.08, what is cut short by a quarter by 0.09 and more.
const OFF: f64 = 0.09;

/// How far around a curve it is seen what it does, a part of its length.
const AROUND: f64 = 0.25;

/// From so many times as much bending times distance on a curve leads astray: right ones make it up to 1.05 times as much on
/// faces, and half on cartoons; what is cut short or of the other lid from 1.3 times on.
const WORSE: f64 = 1.25;

/// Bending and distances below are none.
const LEAST: f64 = 1e-6;

/// What of the progress of a fit each of the three goes through.
const PROGRESS: [f64; 4] = [0.1, 0.4, 0.65, 0.9];

/// Registers by what leads, less the curves that lead astray, which are left out there and in `lie`.
///
/// # Errors
///
/// As [`register`].
pub fn register_less_astray(
    source: &Side,
    target: &Placed,
    lie: &mut Lie,
    led_by: &mut LedBy,
    options: &FitOptions,
    job: &Job,
) -> Result<Registered> {
    let [start, second, third, end] = PROGRESS;
    let points = led_by.followed_points();
    let curves = led_by.followed_curves();
    // Exact ones are followed whatever the surfaces say.
    if options.marker_tolerance == 0.0 || curves.is_empty() || points.len() >= LEADING {
        return register(source, target, lie, options, start..end, job);
    }
    let all = std::mem::replace(&mut lie.markers, points);
    let free = register(source, target, lie, options, start..second, job)?;
    let doubted: Vec<(usize, f64)> = curves
        .into_iter()
        .map(|i| (i, led_by.curve(i)))
        .filter(|(_, curve)| off(curve, &free.vertices) > OFF * length(curve))
        .map(|(i, curve)| (i, off(curve, &free.vertices)))
        .collect();
    lie.markers = all;
    if doubted.is_empty() {
        return register(source, target, lie, options, second..end, job);
    }
    let led = register(source, target, lie, options, second..third, job)?;
    let mut astray = Vec::new();
    for (i, off) in doubted {
        let around = Around::of(led_by.curve(i), source);
        let [without, with] = [&free, &led].map(|fit| around.strain(&fit.vertices, source, target, lie, job));
        if with? > WORSE * without? {
            astray.push((i, off));
        }
    }
    if astray.is_empty() {
        return Ok(led);
    }
    astray.into_iter().for_each(|(i, off)| led_by.leave_out(i, off));
    lie.markers = led_by.followed();
    lie.by_curves = !led_by.followed_curves().is_empty();
    register(source, target, lie, options, third..end, job)
}

/// How far a curve is from where it belongs, at the mean and along it too.
fn off(curve: &[Marker], x: &[Vec3]) -> f64 {
    curve.iter().map(|m| m.place(x).distance(m.goal)).sum::<f64>() / curve.len().max(1) as f64
}

/// How long it is on the target.
fn length(curve: &[Marker]) -> f64 {
    curve.windows(2).map(|pair| pair[0].goal.distance(pair[1].goal)).sum()
}

/// What of the source is around a curve.
struct Around {
    vertices: Vec<u32>,
    triangle_pairs: Vec<[u32; 2]>,
}

impl Around {
    fn of(curve: &[Marker], source: &Side) -> Self {
        let (mesh, rest) = (source.mesh, source.mesh.rest());
        let at = |marker: &Marker| rest[marker.corners[0] as usize];
        let long: f64 = curve.windows(2).map(|pair| at(&pair[0]).distance(at(&pair[1]))).sum();
        let reach = (AROUND * long).powi(2);
        let is_near: Vec<bool> =
            rest.iter().map(|p| curve.iter().any(|m| at(m).distance_squared(*p) < reach)).collect();
        let is_within = |t: u32| mesh.triangles()[t as usize].iter().all(|&v| is_near[v as usize]);
        Self {
            vertices: (0u32..).zip(&is_near).filter(|(_, near)| **near).map(|(v, _)| v).collect(),
            triangle_pairs: mesh
                .adjacency()
                .triangle_pairs()
                .filter(|&[a, b]| is_within(a) && is_within(b))
                .collect(),
        }
    }

    /// How unlike neighbouring triangles change, times how far from the target vertices are, at the root mean square.
    fn strain(&self, x: &[Vec3], source: &Side, target: &Placed, lie: &Lie, job: &Job) -> Result<f64> {
        let normals = vertex_normals(source.mesh.triangles(), x);
        let distances = job.in_batches(self.vertices.len(), |i| {
            let v = self.vertices[i] as usize;
            target.closest(x[v], normals[v], f64::INFINITY, None, 0.0).map(|hit| hit.distance.powi(2))
        })?;
        let bending = bending(source.mesh, x, lie.size, self.triangle_pairs.iter().copied());
        Ok(bending.max(LEAST) * root_mean_square(distances.into_iter().flatten()).max(LEAST))
    }
}
