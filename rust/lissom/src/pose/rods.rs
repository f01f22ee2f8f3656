//! Rods through the body of closed parts, so that a surface bends and twists as a solid does.
//!
//! ```text
//!     sum_i  w_i | x_i - x_opposite(i) - C_i (v_i - v_opposite(i)) |^2,        w_i = k a_i (t_i / l_i^2)^2
//! ```
//!
//! A rod goes from a vertex along the inward normal to where that leaves the body, `l_i` away (the shape diameter of
//! Shapira, Shamir & Cohen-Or 2008). It keeps its length and its angle to the surface, as the graph inside the body does
//! in Zhou, Huang, Snyder, Liu, Bao, Guo & Shum 2005, Large Mesh Deformation Using the Volumetric Graph Laplacian, and
//! the prisms of Botsch, Pauly, Gross & Kobbelt 2006, PriMo. With the area `a_i` of the vertex the sum is an
//! integral over the surface of squared strains, as the energy of the edges is: no refinement changes it.
//!
//! Rods join what is far apart in the matrix and fill its factor, so there are only so many as the thickness asks for,
//! however fine the mesh is: vertices share the rod that is nearest, each with its own area and target.
//!
//! A rod that goes the long way, from the tip of a finger into the arm, says nothing of the thickness and would keep the
//! finger straight. The thickness `t_i` of the body is no more than the length of any rod, however near, and the way to
//! it on the surface: `t_i = min_j l_j + |path(i, j)|`.

use rayon::prelude::*;

use crate::geometry::rows::Rows;
use crate::geometry::surface::Surface;
use crate::mesh::Paths;
use crate::operators::mass::lumped_mass;
use crate::stitch::{Differences, Volumes};
use crate::{Fault, Mesh, Vec3};

/// `k`: how much a strain across the body counts against one along the surface.
const STIFFNESS: f64 = 8.0;

/// How far a vertex may be from the rod that it shares, as a part of the thickness.
const SPACING: f64 = 0.2;

/// Shorter rods, as a part of the size of their vertex's cell, count as if they were so long.
const SHORTEST: f64 = 0.01;

/// Ways whose lengths differ by less than this part are equally long, whatever rounding says: of regular meshes many are.
const TIE: f64 = 1e-6;

/// From a vertex to a place on a triangle opposite.
#[derive(Debug, Clone, Copy)]
struct Rod {
    from: u32,
    to: [u32; 3],
    /// Barycentric coordinates of its end.
    at: Vec3,
    /// The cosine of the angle between it and the normal there.
    slant: f64,
    length: f64,
}

/// A vertex's share in the rod that is nearest to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Owned {
    /// The vertex.
    pub owner: u32,
    weight: f64,
    rod: Rod,
}

impl Owned {
    /// The vertices that the rod joins.
    pub fn ends(&self) -> [u32; 4] {
        [self.rod.from, self.rod.to[0], self.rod.to[1], self.rod.to[2]]
    }

    /// The same where vertices have other numbers.
    pub fn renumbered(&self, number: impl Fn(u32) -> u32) -> Self {
        let rod = Rod { from: number(self.rod.from), to: self.rod.to.map(&number), ..self.rod };
        Self { owner: number(self.owner), rod, ..*self }
    }
}

/// The rods of a mesh, in unit coordinates, and what is said of components that have none.
pub(super) fn rods(mesh: &Mesh) -> (Vec<Owned>, Option<String>) {
    let rest = mesh.rest();
    let mut solid = vec![true; mesh.components().count()];
    Volumes::of(mesh, rest, rest).open().for_each(|c| solid[c] = false);
    let members = mesh.components().members();
    let open = (0..solid.len()).filter(|&c| !solid[c]).map(|c| members[c][0] as usize);
    let problem = "open parts stay hollow: close their holes to make them solid, named by their first vertex";
    let warning = Fault::at("solid", problem, open).map(|fault| fault.to_string());

    let triangles = mesh.outward_triangles();
    let surface = Surface::of(&triangles, rest);
    let inward = inward_normals(&triangles, rest);
    let component = |v: u32| mesh.components().of_vertex(v as usize);
    let rod = |from: u32| {
        let own = component(from).filter(|&c| solid[c])?;
        let direction = inward[from as usize];
        let accept = |t: usize| component(triangles[t][0]) == Some(own) && !triangles[t].contains(&from);
        let hit = surface.exit(rest[from as usize], direction, accept)?;
        let at = hit.weights;
        let to = triangles[hit.triangle];
        // What it meets at a slant is not opposite. Normals between vertices do not jump at an edge that it meets.
        let facing: Vec3 = (0..3).map(|k| inward[to[k] as usize] * at[k]).sum();
        let slant = -facing.normalize_or_zero().dot(direction);
        (slant > 0.0).then_some(Rod { from, to, at, slant, length: hit.distance })
    };
    // An edge further the body is about as thick.
    let mut beside = vec![false; rest.len()];
    let mut apart = |v: &u32| {
        let own = !beside[*v as usize];
        let corners = mesh.adjacency().corners_of(*v as usize).iter().filter(|_| own);
        let around = corners.flat_map(|corner| mesh.triangles()[corner.triangle as usize]);
        around.for_each(|w| beside[w as usize] = true);
        own
    };
    let samples: Vec<u32> = (0..rest.len() as u32).filter(&mut apart).collect();
    let mut found: Vec<Option<Option<Rod>>> = vec![None; rest.len()];
    let sampled: Vec<Option<Rod>> = samples.par_iter().map(|&v| rod(v)).collect();
    samples.iter().zip(sampled).for_each(|(&v, rod)| found[v as usize] = Some(rod));
    let length = |rod: &Option<Option<Rod>>| rod.flatten().map_or(f64::INFINITY, |rod| rod.length);
    let lengths: Vec<f64> = found.iter().map(length).collect();
    let paths = Paths::new(mesh.adjacency(), rest, TIE);
    let mut thickness = lengths.clone();
    paths.shorten(&mut thickness, (0u32..).zip(lengths), f64::INFINITY, |_| {});
    let mut nearest = vec![None; rest.len()];
    let mut away = vec![f64::INFINITY; rest.len()];
    for v in 0..rest.len() as u32 {
        if away[v as usize].is_infinite()
            && let Some(rod) = *found[v as usize].get_or_insert_with(|| rod(v))
        {
            let reach = SPACING * thickness[v as usize].min(rod.length);
            paths.shorten(&mut away, [(v, 0.0)], reach, |w| nearest[w as usize] = Some(v));
        }
    }
    let owned = |((owner, area), nearest): ((u32, f64), Option<u32>)| {
        let (rod, thickness) = (found[nearest? as usize]??, thickness[nearest? as usize]);
        let length = rod.length.max(SHORTEST * area.sqrt());
        let strain = thickness.min(length) / (length * length);
        let weight = STIFFNESS * area * rod.slant * strain * strain;
        (weight.is_finite()).then_some(Owned { owner, weight, rod })
    };
    let owned = (0u32..).zip(lumped_mass(mesh)).zip(nearest).filter_map(owned).collect();
    (owned, warning)
}

/// The rods as differences that vertices own; `share` is how much the whole counts.
pub(super) fn differences(rods: &[Owned], rest: &[Vec3], share: f64) -> Differences {
    let row = |owned: &Owned| {
        let at = owned.rod.at;
        let values = [1.0, -at.x, -at.y, -at.z];
        let (owner, ends) = (owned.owner, owned.ends());
        [0, 1, 2, 3].map(|k| (owner, (ends[k], values[k])))
    };
    let mut factor = vec![0.0; rest.len()];
    rods.iter().for_each(|owned| factor[owned.owner as usize] = share * owned.weight);
    Differences::new(Rows::sort(rest.len(), rods.iter().flat_map(row)), factor, rest)
}

/// The unit normals at the vertices, which weigh triangles by their angle there, so that it does not matter how a face is
/// cut into triangles; zero where there is none.
fn inward_normals(triangles: &[[u32; 3]], rest: &[Vec3]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; rest.len()];
    for t in triangles {
        let corners = t.map(|v| rest[v as usize]);
        let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for k in 0..3 {
            let [own, next, last] = [0, 1, 2].map(|step| corners[(k + step) % 3]);
            let angle = (next - own).cross(last - own).length().atan2((next - own).dot(last - own));
            normals[t[k] as usize] -= across * angle;
        }
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}
