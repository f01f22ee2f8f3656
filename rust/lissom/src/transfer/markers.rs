//! Markers: pairs of a source vertex and a target vertex, or a point of the target, that belong together.

use std::collections::HashMap;

use crate::geometry::rigid::{self, Alignment};
use crate::{Error, Fault, Mesh, Result, Vec3, rotation};

/// Markers are collinear when none lies further than this fraction of their extent from a line.
const COLLINEAR: f64 = 1e-3;

/// A turn between the two sets of markers from which on the meshes are said to face different ways.
const TURNED_DEGREES: f64 = 60.0;

/// A source vertex and where it belongs.
#[derive(Debug, Clone, Copy)]
pub struct Marker {
    /// The source vertex.
    pub vertex: u32,
    /// Where that is, in the source's unit coordinates.
    pub rest: Vec3,
    /// Where it belongs, in the target's unit coordinates.
    pub goal: Vec3,
}

/// Refuses markers that cannot be used and says which are doubtful. `points`, in the target's unit coordinates,
/// stand in the place of the target vertices where there are any.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for no markers, an index out of range, a vertex in no face, a vertex that is
/// marked twice, and points that are not finite or of another number.
pub fn check(
    source: &Mesh,
    target: &Mesh,
    markers: &[[u32; 2]],
    points: &[Vec3],
    warnings: &mut Vec<String>,
) -> Result<Vec<Marker>> {
    let refuse = |fault: Option<Fault>| fault.map_or(Ok(()), |f| Err(Error::InvalidConstraint(f)));
    let pointed = !points.is_empty();
    if pointed && points.len() != markers.len() {
        let problem = format!("{} for {} markers", points.len(), markers.len());
        return Err(Error::InvalidConstraint(Fault::new("points", problem)));
    }
    refuse(Fault::at("points", "not finite", (0..points.len()).filter(|&i| !points[i].is_finite())))?;
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
        if side == 0 || !pointed {
            refuse(marked_twice(markers, side, name))?;
        }
    }
    let goal = |(i, &[_, t]): (usize, &[u32; 2])| {
        if pointed { points[i] } else { target.rest()[t as usize] }
    };
    let rest = |s: u32| source.rest()[s as usize];
    let found: Vec<Marker> = (markers.iter().enumerate())
        .map(|(i, pair)| Marker { vertex: pair[0], rest: rest(pair[0]), goal: goal((i, pair)) })
        .collect();
    let [rests, goals] = offsets(&found);
    if found.len() < 3 {
        warnings.push(format!("markers: only {}; three or more fix how the meshes lie", found.len()));
    } else if collinear(&rests) || collinear(&goals) {
        warnings.push("markers: all on one line, so the turn about it is left open".into());
    } else {
        let motion = Alignment::of(found.iter().map(|m| (m.rest, m.goal)));
        let degrees = rotation::log(motion.rotation()).length().to_degrees();
        if degrees > TURNED_DEGREES {
            warnings.push(format!(
                "markers: the target is turned by {degrees:.0} degrees against the source; turn one to \
                 face the same way, or check for markers that are swapped"
            ));
        }
    }
    Ok(found)
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

/// Offsets of the markers from the centroid, on the source and on the target.
fn offsets(markers: &[Marker]) -> [Vec<Vec3>; 2] {
    let centred = |at: fn(&Marker) -> Vec3| {
        let centre = markers.iter().map(at).sum::<Vec3>() / markers.len() as f64;
        markers.iter().map(|m| at(m) - centre).collect()
    };
    [centred(|m| m.rest), centred(|m| m.goal)]
}

fn collinear(offsets: &[Vec3]) -> bool {
    let far = offsets.iter().copied().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(Vec3::X);
    let axis = far.normalize_or_zero();
    offsets.iter().all(|p| p.reject_from_normalized(axis).length() <= COLLINEAR * far.length())
}

/// Size of the target over size of the source, both in unit coordinates, by their markers.
pub fn size_ratio(markers: &[Marker]) -> f64 {
    rigid::size_ratio(markers.iter().map(|m| m.goal), markers.iter().map(|m| m.rest))
}
