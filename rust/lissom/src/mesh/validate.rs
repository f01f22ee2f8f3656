//! What is refused, what is mended, and what is only said.

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::weld::representatives;
use crate::geometry::groups::Groups;
use crate::geometry::triangle::TriangleGeometry;
use crate::{Error, Fault, Result, Vec3};

/// Points are collinear when none lies further than this fraction of the diagonal from a line.
const COLLINEAR: f64 = 1e-12;

/// Vertices that a thread takes at once.
const GRAIN: usize = 4096;

pub(super) fn numbers(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<()> {
    let whole = |argument, problem: &str| Err(Error::InvalidMesh(Fault::new(argument, problem)));
    if vertices.is_empty() {
        return whole("vertices", "the mesh has no vertices");
    }
    if triangles.is_empty() {
        return whole("triangles", "the mesh has no faces");
    }
    if u32::try_from(3 * triangles.len().max(vertices.len())).is_err() {
        return whole("triangles", "more vertices or triangles than 32-bit indices can count");
    }
    let bad = vertices.iter().enumerate().filter(|(_, v)| !v.is_finite()).map(|(i, _)| i);
    if let Some(fault) = Fault::at("vertices", "not finite", bad) {
        return Err(Error::InvalidMesh(fault));
    }
    let n = vertices.len() as u32;
    let bad = triangles.iter().enumerate().filter(|(_, t)| t.iter().any(|&v| v >= n)).map(|(t, _)| t);
    let problem = format!("vertex index out of range, the mesh has {n} vertices");
    match Fault::at("triangles", problem, bad) {
        Some(fault) => Err(Error::InvalidMesh(fault)),
        None => Ok(()),
    }
}

pub(super) fn drop_repeating(
    triangles: Vec<[u32; 3]>,
    warnings: &mut Vec<String>,
) -> Result<(Vec<[u32; 3]>, Vec<u32>)> {
    let repeats = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
    let dropped = triangles.iter().enumerate().filter(|(_, t)| repeats(t)).map(|(t, _)| t);
    if let Some(mut fault) = Fault::at("triangles", "left out, they repeat a vertex", dropped) {
        if fault.count == triangles.len() {
            fault.problem = "every face repeats a vertex".into();
            return Err(Error::InvalidMesh(fault));
        }
        warnings.push(fault.to_string());
    }
    Ok((0u32..).zip(triangles).filter(|(_, t)| !repeats(t)).map(|(id, t)| (t, id)).unzip())
}

/// Triangles with the vertices that others are welded to, and which those are; without `weld`, where that
/// would make a difference, only a warning.
pub(super) fn seams(
    vertices: &[Vec3],
    mut triangles: Vec<[u32; 3]>,
    weld: Option<f64>,
    warnings: &mut Vec<String>,
) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut used = vec![false; vertices.len()];
    for &v in triangles.iter().flatten() {
        used[v as usize] = true;
    }
    let welds = representatives(vertices, &used, weld.unwrap_or(0.0));
    let again = (0u32..).zip(&welds).filter(|(v, w)| v != *w).map(|(v, _)| v as usize);
    let problem = match weld {
        Some(_) => "welded to another in the same place",
        None => "in the same place as another and not joined to it; weld= joins them",
    };
    let Some(fault) = Fault::at("vertices", problem, again) else { return (triangles, Vec::new()) };
    warnings.push(fault.to_string());
    if weld.is_none() {
        return (triangles, Vec::new());
    }
    triangles.iter_mut().flatten().for_each(|v| *v = welds[*v as usize]);
    (triangles, welds)
}

/// Refuses points that are all on one line (in unit coordinates, where they cannot all coincide).
pub(crate) fn refuse_collinear(rest: &[Vec3], triangles: &[[u32; 3]]) -> Result<()> {
    let used = || triangles.iter().flatten().map(|&v| rest[v as usize]);
    let origin = rest[triangles[0][0] as usize];
    let far = used().max_by(|a, b| a.distance(origin).total_cmp(&b.distance(origin))).unwrap_or(origin);
    let axis = (far - origin).normalize_or_zero();
    if used().all(|p| (p - origin).reject_from_normalized(axis).length() <= COLLINEAR) {
        return Err(Error::InvalidMesh(Fault::new("vertices", "all points lie on one line")));
    }
    Ok(())
}

/// Says what can be worked with but is worth a look.
pub(super) fn doubts(
    adjacency: &Adjacency,
    triangles: &[[u32; 3]],
    triangle_ids: &[u32],
    geometry: &TriangleGeometry,
    welds: &[u32],
    warnings: &mut Vec<String>,
) {
    let mut say = |argument: &str, problem: &str, offenders: &mut dyn Iterator<Item = usize>| {
        warnings.extend(Fault::at(argument, problem, offenders).map(|fault| fault.to_string()));
    };

    let flat = geometry.mollified.iter().zip(triangle_ids).filter(|(flat, _)| **flat);
    let problem = "slivers or without area, mollified";
    say("triangles", problem, &mut flat.map(|(_, &id)| id as usize));

    let vertices = adjacency.vertex_count();
    let again: Vec<u32> = (0..vertices)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map_init(Vec::new, |seen, v| repeated(adjacency, triangles, v, seen))
        .flatten_iter()
        .collect();
    let again = again.into_iter().map(|t| triangle_ids[t as usize] as usize);
    say("triangles", "the same three vertices again", &mut { again });

    let alone = |v: usize| welds.get(v).is_none_or(|&w| w as usize == v);
    let lonely = (0..vertices).filter(|&v| adjacency.corners_of(v).is_empty() && alone(v));
    say("vertices", "in no face", &mut { lonely });

    let edges = 0..adjacency.edges().len();
    let crowded = edges.clone().filter(|&e| adjacency.sides_of(e).len() > 2);
    let ends = |e: usize| adjacency.edges()[e][0] as usize;
    say("vertices", "on an edge with more than two faces", &mut crowded.map(ends));

    let clash = edges.filter(|&e| matches!(adjacency.sides_of(e), [a, b] if a.ascending == b.ascending));
    let problem = "on an edge whose two faces are wound against each other";
    say("vertices", problem, &mut clash.map(ends));

    let bow_ties: Vec<usize> = (0..vertices)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map_init(Vec::new, |ring, v| (v, fans(adjacency, triangles, v, ring)))
        .filter(|&(_, count)| count > 1)
        .map(|(v, _)| v)
        .collect();
    say("vertices", "joins separate fans of faces (bow-tie)", &mut bow_ties.into_iter());
}

/// The triangles of which `vertex` is the lowest that have the corners of an earlier one.
fn repeated(
    adjacency: &Adjacency,
    triangles: &[[u32; 3]],
    vertex: usize,
    seen: &mut Vec<([u32; 3], u32)>,
) -> Vec<u32> {
    seen.clear();
    for corner in adjacency.corners_of(vertex) {
        let mut key = triangles[corner.triangle as usize];
        key.sort_unstable();
        if key[0] as usize == vertex {
            seen.push((key, corner.triangle));
        }
    }
    seen.sort_unstable();
    seen.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).collect()
}

/// Number of fans: groups of triangles at a vertex that hang together by edges at that vertex.
fn fans(adjacency: &Adjacency, triangles: &[[u32; 3]], vertex: usize, ring: &mut Vec<u32>) -> usize {
    let spokes = || {
        adjacency.corners_of(vertex).iter().map(|corner| {
            let (t, c) = (triangles[corner.triangle as usize], usize::from(corner.corner));
            [t[(c + 1) % 3], t[(c + 2) % 3]]
        })
    };
    ring.clear();
    ring.extend(spokes().flatten());
    ring.sort_unstable();
    ring.dedup();
    let place = |v: u32| ring.binary_search(&v).unwrap_or_default() as u32;
    Groups::joining(ring.len(), spokes().map(|spoke| spoke.map(place))).count()
}
