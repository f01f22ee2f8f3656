//! Markers: pairs of a source vertex and a target vertex, or of points of the surfaces, that belong together.

use std::collections::HashMap;

use super::pulls::Pull;
use crate::geometry::rigid::{self, Alignment};
use crate::geometry::surface::Surface;
use crate::geometry::triangle::interpolate;
use crate::{Error, Fault, Mesh, Result, Vec3, rotation};

/// Markers are collinear when none lies further than this fraction of their extent from a line.
const COLLINEAR: f64 = 1e-3;

/// A point is at a corner of its triangle where the others count for less than this.
const AT_VERTEX: f64 = 1e-9;

/// Weight along a curve, a fraction of that across it: what lies on it is known, lengths along it differ.
const SLIDING: f64 = 0.02;

/// So many markers lead a fit by themselves, whatever curves there are.
pub const LEADING: usize = 6;

/// A turn between the two sets of markers from which on the meshes are said to face different ways.
const TURNED_DEGREES: f64 = 60.0;

/// No proportions make markers scatter by more, in the target's unit coordinates: those of Suzanne and a human face do
/// by 0.03.
pub const PROPORTIONS: f64 = 0.06;

/// Nor do they put any single place further from where a similarity puts it, in the target's unit coordinates.
pub const ELSEWHERE: f64 = 2.0 * PROPORTIONS;

/// Targets that are further from the surface than this are not on it, in its unit coordinates: the middle of a cartoon's eye
/// is up to 0.08 from its rim.
const BESIDE: f64 = 0.1;

/// A point of the source and where it belongs.
#[derive(Debug, Clone, Copy)]
pub struct Marker {
    /// Corners of the source triangle that it is on, and what each counts.
    pub corners: [u32; 3],
    /// See there; (1, 0, 0) at a vertex.
    pub weights: Vec3,
    /// Where that is, in the source's unit coordinates.
    pub rest: Vec3,
    /// Where it belongs, in the target's unit coordinates.
    pub goal: Vec3,
    /// The direction along which it may slide, that of a curve there ([`super::curves`]); zero for a point.
    pub tangent: Vec3,
}

impl Marker {
    /// A vertex of the source that belongs at a point.
    pub fn at_vertex(source: &Mesh, vertex: u32, goal: Vec3) -> Self {
        let rest = source.rest()[vertex as usize];
        Self { corners: [vertex; 3], weights: Vec3::X, rest, goal, tangent: Vec3::ZERO }
    }

    /// Whether it is a vertex that belongs at a point.
    pub fn is_vertex(&self) -> bool {
        self.weights == Vec3::X && !self.is_of_curve()
    }

    /// Whether it may slide along a curve.
    pub fn is_of_curve(&self) -> bool {
        self.tangent != Vec3::ZERO
    }

    /// Where it is with the source's vertices at `x`.
    pub fn place(&self, x: &[Vec3]) -> Vec3 {
        self.pull(0.0).place(x)
    }

    /// How far it is from where it belongs, and of a curve's from that.
    pub fn off(&self, x: &[Vec3]) -> f64 {
        (self.place(x) - self.goal).reject_from_normalized(self.tangent).length()
    }

    /// A pull to where it belongs.
    pub fn pull(&self, weight: f64) -> Pull {
        let pull = Pull::to_point(self.corners, self.weights, self.goal, weight);
        match self.is_of_curve() {
            true => Pull { normal: self.tangent, along: SLIDING * weight, ..pull },
            false => pull,
        }
    }

    /// How much it counts with the source's vertices at `x`, where `within` is as near as it need be. Curves, which
    /// are selected, not clicked, do not let go.
    pub fn share(&self, x: &[Vec3], within: f64) -> f64 {
        if self.is_of_curve() { 1.0 } else { (1.0 + (self.off(x) / within).powi(2)).powi(-2) }
    }
}

/// Refuses markers that cannot be used. `points` of the source and of the
/// target, in their unit coordinates, stand in the place of vertices where there are any; those of the source count as
/// the nearest of its surface.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for no markers, an index out of range, a vertex in no face, a vertex that is
/// marked twice, and points that are not finite or of another number.
pub fn check(
    source: &Mesh,
    target: &Mesh,
    markers: &[[u32; 2]],
    points: [&[Vec3]; 2],
) -> Result<Vec<Marker>> {
    let refuse = |fault: Option<Fault>| fault.map_or(Ok(()), |f| Err(Error::InvalidConstraint(f)));
    for (name, points) in ["source_points", "points"].into_iter().zip(points) {
        if !points.is_empty() && points.len() != markers.len() {
            let problem = format!("{} for {} markers", points.len(), markers.len());
            return Err(Error::InvalidConstraint(Fault::new(name, problem)));
        }
        refuse(Fault::at(name, "not finite", (0..points.len()).filter(|&i| !points[i].is_finite())))?;
    }
    if markers.is_empty() {
        let problem = "none given; mark at least three pairs of vertices";
        return Err(Error::InvalidConstraint(Fault::new("markers", problem)));
    }
    for (side, (name, mesh)) in [("source", source), ("target", target)].into_iter().enumerate() {
        let n = mesh.vertices().len();
        let offenders = |wrong: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..markers.len()).filter(|&i| wrong(markers[i][side] as usize)).collect()
        };
        let outside = offenders(&|v| v >= n);
        refuse(Fault::at("markers", format!("{name} vertex out of range, the mesh has {n}"), outside))?;
        let loose = offenders(&|v| mesh.components().of_vertex(v).is_none());
        refuse(Fault::at("markers", format!("{name} vertex is in no face"), loose))?;
        if points[side].is_empty() {
            refuse(marked_twice(markers, side, name))?;
        }
    }
    let surface = (!points[0].is_empty()).then(|| Surface::of(source.triangles(), source.rest()));
    let marker = |(i, &[s, t]): (usize, &[u32; 2])| {
        let goal = points[1].get(i).copied().unwrap_or(target.rest()[t as usize]);
        let hit = surface.as_ref().and_then(|surface| surface.closest_point(points[0][i]));
        match hit {
            Some(hit) => on_triangle(source, hit.triangle, hit.weights, goal),
            None => Marker::at_vertex(source, s, goal),
        }
    };
    Ok(markers.iter().enumerate().map(marker).collect())
}

/// How many of `markers` belong where the target is not, in words.
pub fn beside(target: &Surface, markers: &[Marker]) -> Option<String> {
    let is_beside = |m: &&Marker| target.closest_point(m.goal).is_some_and(|hit| hit.distance > BESIDE);
    let count = markers.iter().filter(is_beside).count();
    (count > 0).then(|| {
        format!(
            "markers: {count} of {} points are far beside the target: are they in its own coordinates?",
            markers.len()
        )
    })
}

/// What places of the source, each with that where it belongs, leave open, in words.
pub fn left_open(places: &[(Vec3, Vec3)]) -> Option<String> {
    let [rests, goals] = offsets(places);
    if places.len() < 3 {
        return Some(format!("markers: only {}; three or more fix how the meshes lie", places.len()));
    }
    if collinear(&rests) || collinear(&goals) {
        return Some("markers: all on one line, so the turn about it is left open".into());
    }
    let motion = Alignment::of(places.iter().copied());
    let degrees = rotation::log(motion.rotation()).length().to_degrees();
    (degrees > TURNED_DEGREES).then(|| {
        format!(
            "markers: by them the target is turned by {degrees:.0} degrees against the source, and keys turn along; \
             if it is not, look for markers that are swapped"
        )
    })
}

/// A marker at a point of a triangle; at a vertex it is one of that.
fn on_triangle(source: &Mesh, triangle: usize, weights: Vec3, goal: Vec3) -> Marker {
    let corners = source.triangles()[triangle];
    match (0..3).find(|&k| weights[k] > 1.0 - AT_VERTEX) {
        Some(k) => Marker::at_vertex(source, corners[k], goal),
        None => {
            let rest = interpolate(corners.map(|v| source.rest()[v as usize]), weights);
            Marker { corners, weights, rest, goal, tangent: Vec3::ZERO }
        }
    }
}

/// The first vertex that several markers name, as a fault that lists those markers.
fn marked_twice(markers: &[[u32; 2]], side: usize, name: &str) -> Option<Fault> {
    let mut first = HashMap::new();
    let again = markers.iter().enumerate().find_map(|(i, marker)| {
        let earlier = *first.entry(marker[side]).or_insert(i);
        (earlier != i).then_some((earlier, i, marker[side]))
    });
    let (earlier, later, vertex) = again?;
    let ends = |i: usize| format!("({}, {})", markers[i][0], markers[i][1]);
    let problem = format!("{name} vertex {vertex} is marked twice, {} and {}", ends(earlier), ends(later));
    Fault::at("markers", problem, [earlier, later])
}

/// Offsets of the places from their centroid, on the source and on the target.
fn offsets(places: &[(Vec3, Vec3)]) -> [Vec<Vec3>; 2] {
    let centred = |at: fn(&(Vec3, Vec3)) -> Vec3| {
        let centre = rigid::centroid(places.iter().map(at));
        places.iter().map(|place| at(place) - centre).collect()
    };
    [centred(|place| place.0), centred(|place| place.1)]
}

fn collinear(offsets: &[Vec3]) -> bool {
    let far = offsets.iter().copied().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(Vec3::X);
    let axis = far.normalize_or_zero();
    offsets.iter().all(|p| p.reject_from_normalized(axis).length() <= COLLINEAR * far.length())
}
