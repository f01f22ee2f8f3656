//! Obstacles: a lid that closes slides over the eye, and does not go through it.
//!
//! A closed component of the target, such as an eye, keeps larger components out. With `s` the distance of a vertex
//! from it, negative inside, a key may not go below
//!
//! ```text
//!     min(CLEAR, that of its image on the source)                     where the source has obstacles, else
//!     min(CLEAR, s_rest + max(0, travel - |s_rest|))                  travel = how far it goes past the obstacle
//! ```
//!
//! so that what is inside at rest, as the rim of a lid often is, stays there as long as it hardly moves, and has
//! come out once it has gone twice as far as it was deep. Where surfaces meet ([`super::contact`]) they meet
//! outside. Vertices that fall short become pulls of [`super::contact`] towards where they should be; those are
//! soft, so that what is still missing is asked for again.

use rayon::prelude::*;

use crate::geometry::body::{Body, SignedDistance};
use crate::geometry::boxes::Boxes;
use crate::geometry::triangle::interpolate;
use crate::{Mesh, Vec3};

/// How far outside vertices are kept, a fraction of the target's diagonal: their triangles are then outside too.
const CLEAR: f64 = 0.002;

/// Less than this is not worth a pull: fits are no nearer.
const SLACK: f64 = 0.0005;

/// Vertices further inside are on the other side of something else.
const REACH: f64 = 0.05;

/// What a lid goes at most: obstacles further away are not in its way.
const AS_FAR_AS_LIDS: f64 = 2.0 * REACH;

/// What is further from the box around an obstacle, once a key is on, is not pushed into it by what is corrected.
const BESIDE: f64 = 0.01;

/// Obstacles are components with less of their edges than this on a boundary ...
const OPEN: f64 = 0.05;

/// ... and less than this of the area of what gives way to them.
const SMALLER: f64 = 0.5;

/// ... that are convex: of so many triangles, points further in front than this part of the size are fewer than this
/// part of all.
const SAMPLES: usize = 200;
const DENT: f64 = 0.02;
const DENTED: f64 = 0.01;

/// How far outside of the obstacles a vertex has to be.
#[derive(Debug, Clone, Copy)]
pub enum Least {
    /// So far, in unit coordinates.
    Outside(f64),
    /// As far as its own way tells.
    Travelled,
}

/// The obstacles of a mesh.
pub struct Obstacles {
    all: Vec<Obstacle>,
    /// Around each of them at rest.
    boxes: Boxes,
    /// The area of each component.
    areas: Vec<f64>,
}

/// An obstacle in a key.
struct Posed<'a> {
    obstacle: &'a Obstacle,
    /// Where it moves.
    moved: Option<Body>,
}

impl Posed<'_> {
    fn side(&self, point: Vec3) -> Option<SignedDistance> {
        self.moved.as_ref().unwrap_or(&self.obstacle.rest).side(point, REACH)
    }
}

/// The obstacles of a mesh in a key.
pub struct Standing<'a> {
    all: Vec<Posed<'a>>,
    boxes: Boxes,
}

impl<'a> Standing<'a> {
    /// Those that a point may be within `reach` of, or in.
    fn near(&self, point: Vec3, reach: f64) -> impl Iterator<Item = &Posed<'a>> {
        self.boxes.within(point, reach).into_iter().map(|k| &self.all[k])
    }
}

/// A component that keeps others out.
struct Obstacle {
    component: usize,
    vertices: Vec<u32>,
    /// The corners of its triangles, by their place among its vertices.
    triangles: Vec<[u32; 3]>,
    rest: Body,
}

impl Obstacle {
    fn new(mesh: &Mesh, component: usize, triangles: &[[u32; 3]]) -> Option<Self> {
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| vertices.partition_point(|&w| w < v) as u32;
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(place)).collect();
        let rest: Vec<Vec3> = vertices.iter().map(|&v| mesh.rest()[v as usize]).collect();
        let rest = Body::new(&rest, triangles.clone())?;
        Some(Self { component, vertices, triangles, rest })
    }

    /// Where its vertices are once `displacements` are on.
    fn at<'a>(&'a self, mesh: &'a Mesh, displacements: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
        self.vertices.iter().map(|&v| mesh.rest()[v as usize] + displacements[v as usize])
    }

    fn posed(&self, mesh: &Mesh, displacements: &[Vec3]) -> Option<Posed<'_>> {
        if self.vertices.iter().all(|&v| displacements[v as usize] == Vec3::ZERO) {
            return Some(Posed { obstacle: self, moved: None });
        }
        let moved: Vec<Vec3> = self.at(mesh, displacements).collect();
        Some(Posed { obstacle: self, moved: Some(Body::new(&moved, self.triangles.clone())?) })
    }

    /// What `values` at the vertices of the mesh are at a place of this surface.
    fn carried(&self, side: &SignedDistance, values: &[Vec3]) -> Vec3 {
        let corners = self.triangles[side.hit.triangle].map(|place| self.vertices[place as usize]);
        interpolate(corners.map(|v| values[v as usize]), side.hit.weights)
    }
}

impl Obstacles {
    /// Finds the obstacles of a mesh near some of its vertices; `None` where nothing gives way to any.
    pub fn near(target: &Mesh, vertices: &[u32]) -> Option<Self> {
        let components = target.components();
        let component = |v: u32| components.of_vertex(v as usize);
        let areas = target.component_areas();
        let mut triangles = vec![Vec::new(); components.count()];
        for t in target.outward_triangles() {
            component(t[0]).into_iter().for_each(|c| triangles[c].push(t));
        }
        let (mut edges, mut open) = (vec![0usize; areas.len()], vec![0usize; areas.len()]);
        for (e, edge) in target.adjacency().edges().iter().enumerate() {
            if let Some(c) = component(edge[0]) {
                edges[c] += 1;
                open[c] += usize::from(target.adjacency().sides_of(e).len() == 1);
            }
        }
        let largest = areas.iter().copied().fold(0.0, f64::max);
        let keeps_out =
            |&c: &usize| areas[c] < SMALLER * largest && (open[c] as f64) < OPEN * edges[c] as f64;
        let at = |v: &u32| target.rest()[*v as usize];
        let found: Vec<usize> = (0..triangles.len()).filter(keeps_out).collect();
        let boxes = Boxes::around(found.iter().map(|&c| triangles[c].iter().flatten().map(at)));
        let mut is_near = vec![false; found.len()];
        vertices.iter().flat_map(|v| boxes.within(at(v), AS_FAR_AS_LIDS)).for_each(|k| is_near[k] = true);
        let all: Vec<Obstacle> = found
            .into_iter()
            .zip(is_near)
            .filter(|&(c, is_near)| is_near && convex(target, &triangles[c]))
            .filter_map(|(c, _)| Obstacle::new(target, c, &triangles[c]))
            .collect();
        let boxes = Boxes::around(all.iter().map(|obstacle| obstacle.vertices.iter().map(at)));
        (!all.is_empty()).then_some(Self { all, boxes, areas })
    }

    /// The obstacles where `displacements` take them.
    pub fn standing(&self, mesh: &Mesh, displacements: &[Vec3]) -> Standing<'_> {
        let all: Vec<Posed> =
            self.all.iter().filter_map(|obstacle| obstacle.posed(mesh, displacements)).collect();
        let boxes = Boxes::around(all.iter().map(|posed| posed.obstacle.at(mesh, displacements)));
        Standing { all, boxes }
    }

    /// Which of `vertices` obstacles may be in the way of.
    pub fn in_the_way(&self, mesh: &Mesh, vertices: impl Iterator<Item = u32>) -> Vec<u32> {
        let meets = |v: &u32| {
            let own = mesh.components().of_vertex(*v as usize);
            let near = self.boxes.within(mesh.rest()[*v as usize], AS_FAR_AS_LIDS);
            own.is_some_and(|own| near.iter().any(|&k| self.gives_way(own, &self.all[k])))
        };
        vertices.filter(meets).collect()
    }

    /// Which of `vertices` are near obstacles once `displacements` are on.
    pub fn reached(
        &self,
        mesh: &Mesh,
        standing: &Standing,
        vertices: &[u32],
        displacements: &[Vec3],
    ) -> Vec<u32> {
        let is_near = |v: &u32| {
            let at = mesh.rest()[*v as usize] + displacements[*v as usize];
            standing.near(at, BESIDE).next().is_some()
        };
        vertices.iter().copied().filter(is_near).collect()
    }

    /// For each point of a component, given with a vertex of it, how far it is outside of the obstacles once
    /// `displacements` are on, negative inside; `None` where there is none near.
    pub fn outside(
        &self,
        mesh: &Mesh,
        displacements: &[Vec3],
        points: &[Option<(u32, Vec3)>],
    ) -> Vec<Option<f64>> {
        let standing = self.standing(mesh, displacements);
        let of = |point: &Option<(u32, Vec3)>| {
            let (vertex, point) = (*point)?;
            let own = mesh.components().of_vertex(vertex as usize)?;
            let near = standing.near(point, REACH).filter(|posed| self.gives_way(own, posed.obstacle));
            near.filter_map(|posed| Some(posed.side(point)?.signed_distance)).min_by(f64::total_cmp)
        };
        points.par_iter().map(of).collect()
    }

    fn gives_way(&self, component: usize, obstacle: &Obstacle) -> bool {
        self.areas[obstacle.component] < SMALLER * self.areas[component]
    }

    /// Which of some vertices `displacements` take too far into an obstacle, and what they are short of, in unit
    /// coordinates. `least` has each with how far outside it must be, [`Least::Travelled`] where nothing else says so.
    pub fn short(
        &self,
        target: &Mesh,
        standing: &Standing,
        least: &[(u32, Least)],
        displacements: &[Vec3],
    ) -> Vec<(u32, Vec3)> {
        let of = |&(v, least): &(u32, Least)| {
            let d = displacements[v as usize];
            let own = target.components().of_vertex(v as usize).filter(|_| d != Vec3::ZERO)?;
            let at = target.rest()[v as usize];
            let near = standing.near(at + d, CLEAR).filter(|posed| self.gives_way(own, posed.obstacle));
            let short = near.filter_map(|posed| {
                let now = posed.side(at + d).filter(|now| now.signed_distance < CLEAR)?;
                let wanted = match least {
                    Least::Outside(distance) => distance.min(CLEAR),
                    Least::Travelled => {
                        let carried = posed.obstacle.carried(&now, displacements);
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

/// Whether a closed surface is convex, as eyes are and teeth are not: only there is a side certain. Hardly any of its
/// points lie in front of any of its triangles.
fn convex(mesh: &Mesh, triangles: &[[u32; 3]]) -> bool {
    let at = |t: &[u32; 3]| t.map(|v| mesh.rest()[v as usize]);
    let corners = || triangles.iter().map(|t| at(t)[0]);
    let (low, high) = corners().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
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
