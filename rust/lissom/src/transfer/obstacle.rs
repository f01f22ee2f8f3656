//! Obstacles: a lid that closes slides over the eye, and does not go through it.
//!
//! A solid component of the target, such as an eye or a row of teeth, keeps larger components out. With `s` the
//! distance of a vertex from the solid, negative inside, a key may not go below
//!
//! ```text
//!     min(CLEAR, s_rest + max(0, travel - |s_rest|))        travel = how far the vertex goes past the solid
//! ```
//!
//! so that what is inside at rest, as the rim of a lid often is, stays there as long as it hardly moves, and has
//! come out once it has gone twice as far as it was deep. Where surfaces meet ([`super::contact`]) they meet
//! outside. Vertices that fall short become pulls of [`super::contact`]
//! towards where they should be; those are soft, so that what is still missing is asked for again.

use rayon::prelude::*;

use super::closest::Surface;
use crate::{Mesh, Vec3};

/// How far outside vertices are kept, a fraction of the target's diagonal: their triangles are then outside too.
const CLEAR: f64 = 0.002;

/// Vertices further inside are on the other side of something else.
const REACH: f64 = 0.05;

/// Solids are components with less of their edges than this on a boundary ...
const OPEN: f64 = 0.05;

/// ... and less than this of the area of what gives way to them.
const SMALLER: f64 = 0.5;

/// The solids of a target.
pub struct Obstacles {
    solids: Vec<Solid>,
    /// The area of each component.
    areas: Vec<f64>,
}

struct Solid {
    component: usize,
    triangles: Vec<[u32; 3]>,
    rest: Surface,
}

/// How far a vertex is outside of a surface, and the way out there.
struct Depth {
    outside: f64,
    out: Vec3,
    triangle: usize,
    weights: Vec3,
}

impl Obstacles {
    /// Finds the solids of `target`; `None` where nothing gives way to any.
    pub fn of(target: &Mesh) -> Option<Self> {
        let components = target.components();
        let component = |v: u32| components.of_vertex(v as usize);
        let mut areas = vec![0.0; components.count()];
        let mut triangles = vec![Vec::new(); components.count()];
        for (t, area) in target.triangles().iter().zip(target.areas()) {
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
        let solids: Vec<Solid> = (0..areas.len())
            .filter(is_solid)
            .map(|component| {
                let triangles = std::mem::take(&mut triangles[component]);
                let rest = surface(&triangles, |v| target.rest()[v as usize]);
                Solid { component, triangles, rest }
            })
            .collect();
        (!solids.is_empty()).then_some(Self { solids, areas })
    }

    /// Vertices that `displacements` take too far into a solid, and what they are short of, in unit coordinates.
    /// Those that are `met` have to come out whatever their travel.
    pub fn short(&self, target: &Mesh, met: &[bool], displacements: &[Vec3]) -> Vec<(u32, Vec3)> {
        let rest = target.rest();
        let posed: Vec<Surface> = (self.solids.iter())
            .map(|solid| surface(&solid.triangles, |v| rest[v as usize] + displacements[v as usize]))
            .collect();
        let of = |v: u32| {
            let d = displacements[v as usize];
            let own = target.components().of_vertex(v as usize).filter(|_| d != Vec3::ZERO)?;
            let at = rest[v as usize];
            let short = self.solids.iter().zip(&posed).filter_map(|(solid, posed)| {
                if self.areas[solid.component] >= SMALLER * self.areas[own] {
                    return None;
                }
                let now = depth(posed, at + d).filter(|now| now.outside < CLEAR)?;
                let corners = solid.triangles[now.triangle];
                let carried: Vec3 = (0..3).map(|k| displacements[corners[k] as usize] * now.weights[k]).sum();
                let before = depth(&solid.rest, at).map_or(CLEAR, |before| before.outside);
                let beyond = ((d - carried).length() - before.abs()).max(0.0);
                let wanted = if met[v as usize] { CLEAR } else { CLEAR.min(before + beyond) };
                (now.outside < wanted).then(|| now.out * (wanted - now.outside))
            });
            let short: Vec3 = short.sum();
            (short != Vec3::ZERO).then_some((v, short))
        };
        (0..rest.len() as u32).into_par_iter().filter_map(of).collect()
    }
}

fn surface(triangles: &[[u32; 3]], at: impl Fn(u32) -> Vec3) -> Surface {
    Surface::new(triangles.iter().map(|t| t.map(&at)).collect())
}

fn depth(surface: &Surface, point: Vec3) -> Option<Depth> {
    let hit = surface.closest_point_within(point, REACH)?;
    let out = surface.normals()[hit.triangle];
    let outside = if (point - hit.point).dot(out) < 0.0 { -hit.distance } else { hit.distance };
    Some(Depth { outside, out, triangle: hit.triangle, weights: surface.weights(hit.triangle, hit.point) })
}
