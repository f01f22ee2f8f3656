//! Markers: pairs of a source vertex and a target vertex that belong together.

use std::collections::HashMap;

use crate::{Error, Fault, Mesh, Result, Vec3, rotation};

/// Markers are collinear when none lies further than this fraction of their extent from a line.
const COLLINEAR: f64 = 1e-3;

/// A turn between the two sets of markers from which on the meshes are said to face different ways.
const TURNED_DEGREES: f64 = 60.0;

/// Refuses markers that cannot be used and says which are doubtful.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for no markers, an index out of range, a vertex in no face, and a
/// vertex that is marked twice.
pub fn check(source: &Mesh, target: &Mesh, markers: &[[u32; 2]], warnings: &mut Vec<String>) -> Result<()> {
    let refuse = |fault: Option<Fault>| fault.map_or(Ok(()), |f| Err(Error::InvalidConstraint(f)));
    if markers.is_empty() {
        return refuse(Some(Fault::new("markers", "none given; mark at least three pairs of vertices")));
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
        refuse(marked_twice(markers, side, name))?;
    }
    if markers.len() < 3 {
        warnings.push(format!("markers: only {}; three or more fix how the meshes lie", markers.len()));
    } else if [(0, source), (1, target)].iter().any(|&(side, mesh)| collinear(markers, side, mesh)) {
        warnings.push("markers: all on one line, so the turn about it is left open".into());
    } else {
        let degrees = turn(source, target, markers).to_degrees();
        if degrees > TURNED_DEGREES {
            warnings.push(format!(
                "markers: the target is turned by {degrees:.0} degrees against the source; turn one to \
                 face the same way, or check for markers that are swapped"
            ));
        }
    }
    Ok(())
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

/// Positions, in unit coordinates, of one side's markers.
fn points(markers: &[[u32; 2]], side: usize, mesh: &Mesh) -> Vec<Vec3> {
    markers.iter().map(|m| mesh.rest()[m[side] as usize]).collect()
}

/// Offsets from the centroid.
fn centred(points: &[Vec3]) -> Vec<Vec3> {
    let centre = points.iter().sum::<Vec3>() / points.len() as f64;
    points.iter().map(|&p| p - centre).collect()
}

fn collinear(markers: &[[u32; 2]], side: usize, mesh: &Mesh) -> bool {
    let offsets = centred(&points(markers, side, mesh));
    let far = offsets.iter().copied().max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(Vec3::X);
    let axis = far.normalize_or_zero();
    offsets.iter().all(|p| p.reject_from_normalized(axis).length() <= COLLINEAR * far.length())
}

/// How far the target's markers are turned against the source's: the angle of the nearest rotation.
fn turn(source: &Mesh, target: &Mesh, markers: &[[u32; 2]]) -> f64 {
    let (s, t) = (centred(&points(markers, 0, source)), centred(&points(markers, 1, target)));
    let covariance = s.iter().zip(&t).map(|(&s, &t)| crate::operators::gradient::outer(t, s)).sum();
    rotation::log(rotation::nearest_rotation(covariance)).length()
}

/// Size of the target over size of the source, both in unit coordinates: the root mean square spread
/// of their markers. 1 (boxes of one size) where the markers have no spread.
pub fn size_ratio(source: &Mesh, target: &Mesh, markers: &[[u32; 2]]) -> f64 {
    let spread = |side, mesh: &Mesh| {
        centred(&points(markers, side, mesh)).iter().map(|p| p.length_squared()).sum::<f64>().sqrt()
    };
    let ratio = spread(1, target) / spread(0, source);
    if ratio.is_finite() && ratio > 1e-3 && ratio < 1e3 { ratio } else { 1.0 }
}
