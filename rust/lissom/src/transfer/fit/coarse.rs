//! Coarse: the source with a fraction of its vertices, on which the fit begins.
//!
//! While the pull is weak, what bends is wide, and a few vertices tell it as well as all do. The energy is the same on both
//! where the terms that are sums over triangles and vertices, not over differences of neighbours, count as many times more
//! as there are fewer of these. What the coarse source is pulled to then pulls the whole one ([`super::registration`]).
//!
//! Of the vertices those are kept that are beside none that was kept before, a maximal independent set, as algebraic
//! multigrid chooses its coarse points (Ruge & Stüben 1987); every other one belongs to the nearest of those that it is
//! beside; and the triangles are the dual of these cells, one where three of them meet (Edelsbrunner & Shah 1997,
//! Triangulating Topological Spaces).

use std::collections::HashSet;

use super::markers::Marker;
use super::side::Side;
use crate::geometry::rows::Rows;
use crate::{Mesh, Result, Vec3};

/// What has no more triangles is coarse.
const ENOUGH: usize = 20_000;

/// A component of fewer vertices stays whole, ...
const FEW: usize = 150;

/// ... and one of which more than this part is on its border: a lash is too narrow for cells.
const NARROW: f64 = 0.25;

/// Cells of more than this part of the vertices are not worth it.
const WORTH: f64 = 0.75;

/// A mesh with fewer vertices.
pub struct Coarse {
    /// It itself, in the unit coordinates of the whole.
    pub mesh: Mesh,
    /// Its vertices as the whole counts them.
    pub vertices: Vec<u32>,
    /// How many triangles of the whole there are for one of it.
    pub stands_for: f64,
    /// Markers by its own vertices.
    pub markers: Vec<Marker>,
}

impl Coarse {
    /// Of a source, with all vertices that are marked; `None` where that is coarse enough as it is, or cannot be thinned.
    pub fn of(side: &Side, markers: &[Marker]) -> Option<Self> {
        let whole = side.mesh;
        let mut kept = vec![false; whole.rest().len()];
        markers.iter().flat_map(|m| m.corners).for_each(|v| kept[v as usize] = true);
        let narrow = |members: &Vec<u32>| {
            let border = members.iter().filter(|&&v| side.is_border(v as usize)).count();
            members.len() < FEW || border as f64 > NARROW * members.len() as f64
        };
        let stay = whole.components().members().into_iter().filter(narrow).flatten();
        stay.for_each(|v| kept[v as usize] = true);
        let mut triangles = whole.triangles().to_vec();
        while triangles.len() > ENOUGH {
            let fewer = dual(whole.rest(), &triangles, &kept);
            if fewer.len() as f64 > WORTH * triangles.len() as f64 {
                break;
            }
            triangles = fewer;
        }
        if triangles.is_empty() || triangles.len() == whole.triangles().len() {
            return None;
        }
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| vertices.binary_search(&v).ok().map(|place| place as u32);
        // One that is in no triangle any more would lead nothing.
        let of_part = |marker: &Marker| {
            let [a, b, c] = marker.corners.map(place);
            Some(Marker { corners: [a?, b?, c?], ..*marker })
        };
        let markers = markers.iter().map(of_part).collect::<Option<Vec<Marker>>>()?;
        let stands_for = whole.triangles().len() as f64 / triangles.len() as f64;
        let triangles = triangles.iter().map(|t| t.map(|v| place(v).unwrap_or_default())).collect();
        let mesh = whole.part(&vertices, triangles);
        Some(Self { mesh, vertices, stands_for, markers })
    }

    /// As a side, where that of the whole is given.
    ///
    /// # Errors
    ///
    /// As [`Side::new`], though there is no cause.
    pub fn side(&self, whole: &Side) -> Result<Side<'_>> {
        let masked = (0u32..).zip(&self.vertices).filter(|(_, v)| whole.masked_vertex[**v as usize]);
        Side::new(&self.mesh, "source_mask", &masked.map(|(place, _)| place).collect::<Vec<u32>>())
    }
}

/// The triangles between the cells of vertices that are not beside each other but for those that are `kept` anyway.
fn dual(rest: &[Vec3], triangles: &[[u32; 3]], kept: &[bool]) -> Vec<[u32; 3]> {
    let edges = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
    let beside = Rows::sort(rest.len(), edges);
    let mut chosen = kept.to_vec();
    for v in 0..rest.len() {
        chosen[v] = chosen[v] || !beside.of(v).iter().any(|&b| chosen[b as usize]);
    }
    let cell = |v: u32| {
        let distance = |b: u32| rest[b as usize].distance_squared(rest[v as usize]);
        let near = beside.of(v as usize).iter().copied().filter(|&b| chosen[b as usize]);
        let nearest = near.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        if chosen[v as usize] { v } else { nearest.unwrap_or(v) }
    };
    let cells: Vec<u32> = (0..rest.len() as u32).map(cell).collect();
    let mut found = HashSet::new();
    let meeting = triangles.iter().map(|t| t.map(|v| cells[v as usize])).filter(|&[a, b, c]| {
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        a != b && b != c && c != a && found.insert(sorted)
    });
    meeting.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::testing::nosed_sphere;

    #[test]
    fn a_coarse_source_is_closed_faces_the_same_way_and_has_all_that_is_marked() {
        let (vertices, triangles) = nosed_sphere(90, 130);
        let whole = Mesh::new(vertices, triangles).unwrap();
        let marker = |v: u32| Marker::at_vertex(&whole, v, Vec3::ONE);
        let marked = [700, 701, 830, 9000];
        let side = Side::new(&whole, "source_mask", &[0, 1]).unwrap();
        let coarse = Coarse::of(&side, &marked.map(marker)).unwrap();
        assert_eq!(coarse.side(&side).unwrap().masked_vertex.iter().filter(|&&masked| masked).count(), 1);
        assert!(coarse.markers.iter().zip(marked).all(|(m, v)| {
            coarse.vertices[m.corners[0] as usize] == v && m.rest == coarse.mesh.rest()[m.corners[0] as usize]
        }));
        assert!((3.0..8.0).contains(&coarse.stands_for), "{}", coarse.stands_for);
        let adjacency = coarse.mesh.adjacency();
        assert!((0..adjacency.edges().len()).all(|edge| adjacency.sides_of(edge).len() == 2));
        assert!(coarse.mesh.border().is_empty());
        let edges = adjacency.edges().len() as isize;
        assert_eq!(coarse.vertices.len() as isize - edges + coarse.mesh.triangles().len() as isize, 2);
        let outwards = |(t, normal): (&[u32; 3], &Vec3)| {
            t.iter().map(|&v| coarse.mesh.vertices()[v as usize]).sum::<Vec3>().dot(*normal) > 0.0
        };
        let sides = coarse.mesh.triangles().iter().zip(coarse.mesh.normals()).map(outwards);
        let inwards = sides.zip(coarse.mesh.areas()).filter(|(outwards, _)| !outwards);
        let inwards = inwards.fold(0.0, |sum, (_, area)| sum + area);
        let areas = [&whole, &coarse.mesh].map(|mesh| mesh.area());
        assert!(
            (areas[1] / areas[0] - 1.0).abs() < 0.01 && inwards < 1e-3 * areas[1],
            "{areas:?}, {inwards}"
        );
    }

    #[test]
    fn what_is_coarse_or_narrow_stays_whole() {
        let (vertices, triangles) = nosed_sphere(12, 20);
        let ball = Mesh::new(vertices, triangles).unwrap();
        assert!(Coarse::of(&Side::new(&ball, "source_mask", &[]).unwrap(), &[]).is_none());
        // Of a strip one square wide, cells would leave single triangles.
        let (mut vertices, mut triangles) = nosed_sphere(90, 130);
        let (first, squares) = (vertices.len() as u32, 200);
        vertices.extend((0..2 * squares + 2).map(|k| Vec3::new(f64::from(k / 2), f64::from(k % 2), 9.0)));
        let corners = (0..squares).map(|k| first + 2 * k);
        triangles.extend(corners.flat_map(|k| [[k, k + 2, k + 1], [k + 1, k + 2, k + 3]]));
        let whole = Mesh::new(vertices, triangles).unwrap();
        let coarse = Coarse::of(&Side::new(&whole, "source_mask", &[]).unwrap(), &[]).unwrap();
        let of_strip = coarse.vertices.iter().filter(|&&v| v >= first).count();
        assert_eq!(of_strip, 2 * squares as usize + 2);
        assert!(coarse.vertices.len() - of_strip < first as usize / 3);
    }
}
