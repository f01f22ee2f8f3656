//! Obstacles: a lid that closes slides over the eye, and does not go through it.
//!
//! A solid component of the target, such as an eye, keeps larger components out. With `s` the distance of a vertex
//! from the solid, negative inside, a key may not go below
//!
//! ```text
//!     min(CLEAR, that of its image on the source)                     where the source has solids, else
//!     min(CLEAR, s_rest + max(0, travel - |s_rest|))                  travel = how far it goes past the solid
//! ```
//!
//! so that what is inside at rest, as the rim of a lid often is, stays there as long as it hardly moves, and has
//! come out once it has gone twice as far as it was deep. Where surfaces meet ([`super::contact`]) they meet
//! outside. Vertices that fall short become pulls of [`super::contact`] towards where they should be; those are
//! soft, so that what is still missing is asked for again.

use rayon::prelude::*;

use crate::geometry::solid::{SignedDistance, Solid};
use crate::{Mesh, Vec3};

/// How far outside vertices are kept, a fraction of the target's diagonal: their triangles are then outside too.
const CLEAR: f64 = 0.002;

/// Less than this is not worth a pull: fits are no nearer.
const SLACK: f64 = 0.0005;

/// Vertices further inside are on the other side of something else.
const REACH: f64 = 0.05;

/// What is further from the box around a solid, once a key is on, is not pushed into it by what is corrected.
const BESIDE: f64 = 0.01;

/// Solids are components with less of their edges than this on a boundary ...
const OPEN: f64 = 0.05;

/// ... and less than this of the area of what gives way to them.
const SMALLER: f64 = 0.5;

/// ... that are convex: of so many triangles, points further in front than this part of the size are fewer than this
/// part of all.
const SAMPLES: usize = 200;
const DENT: f64 = 0.02;
const DENTED: f64 = 0.01;

/// How far outside of the solids a vertex has to be.
#[derive(Debug, Clone, Copy)]
pub enum Least {
    /// So far, in unit coordinates.
    Outside(f64),
    /// As far as its own way tells.
    Travelled,
}

/// The solids of a mesh.
pub struct Obstacles {
    solids: Vec<Obstacle>,
    /// The area of each component.
    areas: Vec<f64>,
}

/// An obstacle in a key.
struct Posed<'a> {
    obstacle: &'a Obstacle,
    /// Where it moves.
    moved: Option<Solid>,
    bounds: [Vec3; 2],
}

impl Posed<'_> {
    fn side(&self, point: Vec3) -> Option<SignedDistance> {
        self.moved.as_ref().unwrap_or(&self.obstacle.rest).side(point, REACH)
    }
}

/// The solids of a mesh in a key.
pub struct Standing<'a>(Vec<Posed<'a>>);

/// A component that keeps others out.
struct Obstacle {
    component: usize,
    vertices: Vec<u32>,
    /// The corners of its triangles, by their place among its vertices.
    triangles: Vec<[u32; 3]>,
    rest: Solid,
    bounds: [Vec3; 2],
}

impl Obstacle {
    fn new(mesh: &Mesh, component: usize, triangles: &[[u32; 3]]) -> Option<Self> {
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| vertices.partition_point(|&w| w < v) as u32;
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(place)).collect();
        let rest: Vec<Vec3> = vertices.iter().map(|&v| mesh.rest()[v as usize]).collect();
        let bounds = bounds(rest.iter().copied());
        let rest = Solid::new(rest, triangles.clone())?;
        Some(Self { component, vertices, triangles, rest, bounds })
    }

    /// Where it is once `displacements` are on.
    fn posed(&self, mesh: &Mesh, displacements: &[Vec3]) -> Option<Posed<'_>> {
        if self.vertices.iter().all(|&v| displacements[v as usize] == Vec3::ZERO) {
            return Some(Posed { obstacle: self, moved: None, bounds: self.bounds });
        }
        let at = |&v: &u32| mesh.rest()[v as usize] + displacements[v as usize];
        let moved: Vec<Vec3> = self.vertices.iter().map(at).collect();
        let bounds = bounds(moved.iter().copied());
        Some(Posed { obstacle: self, moved: Some(Solid::new(moved, self.triangles.clone())?), bounds })
    }

    /// Whether a point may come near it, if it goes no further than a lid does.
    fn is_near(&self, point: Vec3) -> bool {
        is_within(self.bounds, 2.0 * REACH, point)
    }

    /// What `values` at the vertices of the mesh are at a place of this surface.
    fn blend(&self, side: &SignedDistance, values: &[Vec3]) -> Vec3 {
        let corners = self.triangles[side.hit.triangle].map(|place| self.vertices[place as usize]);
        (0..3).map(|k| values[corners[k] as usize] * side.hit.weights[k]).sum()
    }
}

impl Obstacles {
    /// Finds the solids of a mesh near some of its vertices; `None` where nothing gives way to any.
    pub fn near(target: &Mesh, vertices: &[u32]) -> Option<Self> {
        let components = target.components();
        let component = |v: u32| components.of_vertex(v as usize);
        let mut areas = vec![0.0; components.count()];
        let mut triangles = vec![Vec::new(); components.count()];
        for (t, area) in target.outward_triangles().iter().zip(target.areas()) {
            if let Some(c) = component(t[0]) {
                areas[c] += area;
                triangles[c].push(*t);
            }
        }
        let (mut edges, mut open) = (vec![0usize; areas.len()], vec![0usize; areas.len()]);
        for (e, edge) in target.adjacency().edges().iter().enumerate() {
            if let Some(c) = component(edge[0]) {
                edges[c] += 1;
                open[c] += usize::from(target.adjacency().sides_of(e).len() == 1);
            }
        }
        let largest = areas.iter().copied().fold(0.0, f64::max);
        let is_solid = |&c: &usize| areas[c] < SMALLER * largest && (open[c] as f64) < OPEN * edges[c] as f64;
        let at = |v: &u32| target.rest()[*v as usize];
        let is_near = |triangles: &[[u32; 3]]| {
            let bounds = bounds(triangles.iter().flatten().map(at));
            vertices.iter().any(|v| is_within(bounds, 2.0 * REACH, at(v)))
        };
        let solids: Vec<Obstacle> = triangles
            .iter()
            .enumerate()
            .filter(|(c, triangles)| is_solid(c) && is_near(triangles) && convex(target, triangles))
            .filter_map(|(component, triangles)| Obstacle::new(target, component, triangles))
            .collect();
        (!solids.is_empty()).then_some(Self { solids, areas })
    }

    /// The solids where `displacements` take them.
    pub fn standing(&self, mesh: &Mesh, displacements: &[Vec3]) -> Standing<'_> {
        Standing(self.solids.iter().filter_map(|solid| solid.posed(mesh, displacements)).collect())
    }

    /// Which of `vertices` solids may be in the way of.
    pub fn in_the_way(&self, mesh: &Mesh, vertices: impl Iterator<Item = u32>) -> Vec<u32> {
        let meets = |v: &u32| {
            let own = mesh.components().of_vertex(*v as usize);
            let near = |solid: &Obstacle| {
                own.is_some_and(|own| self.gives_way(own, solid)) && solid.is_near(mesh.rest()[*v as usize])
            };
            self.solids.iter().any(near)
        };
        vertices.filter(meets).collect()
    }

    /// Which of `vertices` are near solids once `displacements` are on.
    pub fn reached(
        &self,
        mesh: &Mesh,
        Standing(posed): &Standing,
        vertices: &[u32],
        displacements: &[Vec3],
    ) -> Vec<u32> {
        let is_near = |v: &u32| {
            let at = mesh.rest()[*v as usize] + displacements[*v as usize];
            posed.iter().any(|posed| is_within(posed.bounds, BESIDE, at))
        };
        vertices.iter().copied().filter(is_near).collect()
    }

    /// For each point of a component, given with a vertex of it, how far it is outside of the solids once
    /// `displacements` are on, negative inside; `None` where there is none near.
    pub fn outside(
        &self,
        mesh: &Mesh,
        displacements: &[Vec3],
        points: &[Option<(u32, Vec3)>],
    ) -> Vec<Option<f64>> {
        let Standing(posed) = self.standing(mesh, displacements);
        let of = |point: &Option<(u32, Vec3)>| {
            let (vertex, point) = (*point)?;
            let own = mesh.components().of_vertex(vertex as usize)?;
            let near = posed.iter().filter(|posed| self.gives_way(own, posed.obstacle));
            near.filter_map(|posed| Some(posed.side(point)?.signed_distance)).min_by(f64::total_cmp)
        };
        points.par_iter().map(of).collect()
    }

    fn gives_way(&self, component: usize, solid: &Obstacle) -> bool {
        self.areas[solid.component] < SMALLER * self.areas[component]
    }

    /// Which of some vertices `displacements` take too far into a solid, and what they are short of, in unit
    /// coordinates. `least` has each with how far outside it must be, [`Least::Travelled`] where nothing else says so.
    pub fn short(
        &self,
        target: &Mesh,
        Standing(posed): &Standing,
        least: &[(u32, Least)],
        displacements: &[Vec3],
    ) -> Vec<(u32, Vec3)> {
        let of = |&(v, least): &(u32, Least)| {
            let d = displacements[v as usize];
            let own = target.components().of_vertex(v as usize).filter(|_| d != Vec3::ZERO)?;
            let at = target.rest()[v as usize];
            let near = posed.iter().filter(|posed| self.gives_way(own, posed.obstacle));
            let short = near.filter_map(|posed| {
                let now = posed.side(at + d).filter(|now| now.signed_distance < CLEAR)?;
                let wanted = match least {
                    Least::Outside(distance) => distance.min(CLEAR),
                    Least::Travelled => {
                        let carried = posed.obstacle.blend(&now, displacements);
                        let before = posed.obstacle.rest.side(at, REACH);
                        let before = before.map_or(CLEAR, |before| before.signed_distance);
                        let beyond = ((d - carried).length() - before.abs()).max(0.0);
                        CLEAR.min(before + beyond)
                    }
                };
                let missing = wanted - now.signed_distance;
                (missing > SLACK).then(|| now.out * missing)
            });
            let short: Vec3 = short.sum();
            (short != Vec3::ZERO).then_some((v, short))
        };
        least.par_iter().filter_map(of).collect()
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Whether a point is in a box, or within `reach` of it.
fn is_within([low, high]: [Vec3; 2], reach: f64, point: Vec3) -> bool {
    low.cmple(high).all() && point.clamp(low, high).distance(point) < reach
}

/// Whether a closed surface is convex, as eyes are and teeth are not: only there is a side certain. Hardly any of its
/// points lie in front of any of its triangles.
fn convex(mesh: &Mesh, triangles: &[[u32; 3]]) -> bool {
    let at = |t: &[u32; 3]| t.map(|v| mesh.rest()[v as usize]);
    let corners = || triangles.iter().map(|t| at(t)[0]);
    let [low, high] = bounds(corners());
    let near = DENT * low.distance(high);
    let some = || triangles.iter().step_by(triangles.len().div_ceil(SAMPLES));
    let in_front = |t: &[u32; 3]| {
        let [a, b, c] = at(t);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        corners().filter(|p| (*p - a).dot(normal) > near).count()
    };
    let count: usize = some().map(in_front).sum();
    (count as f64) < DENTED * (some().count() * triangles.len()) as f64
}
