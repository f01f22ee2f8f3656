//! Where the next marker helps most.
//!
//! Where a fit has slid along the surface it has stretched some triangles and squeezed others, and it can slide the
//! further, the further away the markers are. So it is the vertex with the largest `d * mean(log distortion)`: the mean
//! over its triangles, `d` its distance to the nearest marker, among the components that bear markers. What it belongs
//! to on the target is nearest to where it was fitted: to be corrected by eye.

use rayon::prelude::*;

use crate::{Error, Fault, Mesh, Result, Vec3};

/// What a fit said.
pub struct Fitted {
    /// Where each source vertex came to lie, in the target's units.
    pub vertices: Vec<Vec3>,
    /// How far from the target that is, NaN where nothing faces it.
    pub distances: Vec<f64>,
    /// How much each triangle of the source's input was distorted, at least 1.
    pub distortion: Vec<f64>,
}

/// Source vertex and target vertex of the marker to add next to `markers`, `None` where every vertex is marked.
/// Vertices of the two `masks` are none that are proposed.
///
/// # Errors
/// [`crate::Error::InvalidConstraint`] for indices out of range and for a `fit` of another mesh.
pub fn next_marker(
    [source, target]: [&Mesh; 2],
    fit: &Fitted,
    markers: &[[u32; 2]],
    [source_mask, target_mask]: [&[u32]; 2],
) -> Result<Option<[u32; 2]>> {
    let (rest, goals) = (source.vertices(), target.vertices());
    let of = |side: usize| markers.iter().map(move |marker| &marker[side]);
    let outside = Fault::out_of_range("markers", of(0), rest.len())
        .or_else(|| Fault::out_of_range("markers", of(1), goals.len()))
        .or_else(|| Fault::out_of_range("source_mask", source_mask, rest.len()))
        .or_else(|| Fault::out_of_range("target_mask", target_mask, goals.len()));
    if let Some(fault) = outside {
        return Err(Error::InvalidConstraint(fault));
    }
    if fit.vertices.len() != rest.len() || fit.distortion.len() != source.input_triangles() {
        return Err(Error::InvalidConstraint(Fault::new(
            "fit",
            "was made for meshes of other faces: make it anew",
        )));
    }
    let free = |count, of_side: &mut dyn Iterator<Item = &u32>| {
        let mut free = vec![true; count];
        of_side.for_each(|&v| free[v as usize] = false);
        free
    };
    let component = |v: usize| source.components().of_vertex(source.representative(v as u32) as usize);
    let mut bears = vec![false; source.components().count()];
    of(0).filter_map(|&v| component(v as usize)).for_each(|c| bears[c] = true);

    let mut around = vec![(0.0, 0.0); rest.len()];
    for (triangle, &id) in source.triangles().iter().zip(source.triangle_ids()) {
        for &v in triangle {
            let (sum, count) = &mut around[v as usize];
            *sum += fit.distortion[id as usize].ln();
            *count += 1.0;
        }
    }
    let free_source = free(rest.len(), &mut of(0).chain(source_mask));
    let score = |v: usize| {
        let allowed =
            free_source[v] && fit.distances[v].is_finite() && component(v).is_some_and(|c| bears[c]);
        let (sum, count) = around[source.representative(v as u32) as usize];
        let away = of(0).map(|&m| rest[v].distance(rest[m as usize])).fold(f64::INFINITY, f64::min);
        allowed.then(|| (v, away * sum / count))
    };
    let scores: Vec<_> = (0..rest.len()).into_par_iter().filter_map(score).collect();
    let Some(&(best, _)) = scores.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))) else {
        return Ok(None);
    };
    let free_target = free(goals.len(), &mut of(1).chain(target_mask));
    let nearest = (0..goals.len()).filter(|&v| free_target[v]).min_by(|&a, &b| {
        let away = |v: usize| goals[v].distance_squared(fit.vertices[best]);
        away(a).total_cmp(&away(b))
    });
    Ok(nearest.map(|v| [best as u32, v as u32]))
}
