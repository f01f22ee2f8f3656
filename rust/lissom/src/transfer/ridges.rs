//! Ridges: where a surface bends around, as it does along lids and lips, or ends.
//!
//! Normals are averaged with those of their neighbours a few times: the mean of what faces otherwise is short.

use crate::geometry::triangle::vertex_normals;
use crate::{Mesh, Vec3};

/// Normals are averaged over so much, a fraction of the diagonal: as many times as its square over that of the mean edge, ...
const OVER: f64 = 0.0115;

/// ... within these bounds.
const TIMES: [f64; 2] = [3.0, 50.0];

/// On ridges the mean is shorter: a third of a half turn leaves 0.83.
const SHORT: f64 = 0.85;

/// Components have ridges from this part of the area of the largest on: eyes and teeth bend, and are no lids.
const LARGE: f64 = 0.1;

/// Which vertices of a mesh, whose triangles face outwards, are on a ridge or a border.
pub fn ridges(mesh: &Mesh, outward: &[[u32; 3]]) -> Vec<bool> {
    let rest = mesh.rest();
    let edges = mesh.adjacency().edges();
    let length = |&[a, b]: &[u32; 2]| rest[a as usize].distance(rest[b as usize]);
    let edge = edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    let [least, most] = TIMES;
    let times = (OVER / edge).powi(2).clamp(least, most).round() as usize;
    let mut normals: Vec<Vec3> =
        vertex_normals(outward, rest).into_iter().map(Vec3::normalize_or_zero).collect();
    let mut count = vec![1.0; rest.len()];
    edges.iter().flatten().for_each(|&v| count[v as usize] += 1.0);
    for _ in 0..times {
        let mut sums = normals.clone();
        for &[a, b] in edges {
            sums[a as usize] += normals[b as usize];
            sums[b as usize] += normals[a as usize];
        }
        normals = sums.into_iter().zip(&count).map(|(sum, count): (Vec3, &f64)| sum / *count).collect();
    }
    let mut ridges: Vec<bool> = normals.iter().map(|normal| normal.length() < SHORT).collect();
    mesh.border().into_iter().for_each(|v| ridges[v as usize] = true);
    let component = |v: u32| mesh.components().of_vertex(v as usize);
    let areas = mesh.component_areas();
    let largest = areas.iter().copied().fold(0.0, f64::max);
    for (v, ridge) in (0u32..).zip(&mut ridges) {
        *ridge &= component(v).is_some_and(|c| areas[c] >= LARGE * largest);
    }
    ridges
}
