//! Riding: what sits on a surface goes with it.
//!
//! A *seat* is a patch of a component's vertices beside some points: eyes on a head, a button on a sleeve, a hair. The rigid
//! motion of the patch from one shape to another, the nearest in least squares (Kabsch 1976), is that of whatever sits
//! there.

use std::sync::OnceLock;

use crate::geometry::rigid::{Alignment, Similarity, centroid};
use crate::geometry::rows::Rows;
use crate::geometry::surface::Surface;
use crate::{Mat3, Mesh, Vec3};

/// Vertices from which on a seat is wide enough, however far what sits on it is away.
const WIDE: usize = 64;

/// A patch of one component's vertices, and what sits on it.
#[derive(Debug, Clone)]
pub struct Seat {
    /// The component.
    pub component: usize,
    /// The nearest triangle of each point that sits here.
    pub triangles: Vec<u32>,
    vertices: Vec<u32>,
}

impl Seat {
    /// The vertices of the patch, ascending.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The rigid motion of the patch from where its vertices are `from` to where they are `to`; without a turn where they
    /// are on one line.
    pub fn motion(&self, from: impl Fn(u32) -> Vec3, to: impl Fn(u32) -> Vec3) -> Similarity {
        let fit = Alignment::of(self.vertices.iter().map(|&v| (from(v), to(v))));
        if fit.is_determined() {
            return fit.rigid();
        }
        let (from, to) = fit.centroids();
        Similarity::new(Mat3::IDENTITY, from, to)
    }
}

/// Where the seats of a mesh are looked for.
pub struct Seats<'a> {
    mesh: &'a Mesh,
    at: &'a [Vec3],
    /// The triangles of all components that may be sat on, and their surface.
    all: (Vec<u32>, Surface),
    /// The triangles of each component, and their surface once something sits there.
    triangles: Rows<u32>,
    surfaces: Vec<OnceLock<Surface>>,
}

impl<'a> Seats<'a> {
    /// On the components of `mesh` that `may` be sat on, with its vertices in the positions `at`.
    pub fn new(mesh: &'a Mesh, at: &'a [Vec3], may: impl Fn(usize) -> bool) -> Self {
        let components = mesh.components();
        let component = |t: &[u32; 3]| components.of_vertex(t[0] as usize).unwrap_or_default() as u32;
        let triangles = mesh.triangles().iter().map(component).zip(0u32..);
        let all: Vec<u32> = triangles.clone().filter(|&(c, _)| may(c as usize)).map(|(_, t)| t).collect();
        let surface = surface(mesh, at, &all);
        Self {
            mesh,
            at,
            all: (all, surface),
            triangles: Rows::sort(components.count(), triangles),
            surfaces: (0..components.count()).map(|_| OnceLock::new()).collect(),
        }
    }

    /// The seat of `points` on the component that is nearest to their centroid, within `reach`, among those that
    /// `accept` says: the triangles nearest to them, and rings around these until the patch is as wide as the
    /// centroid is far, so that no small tilt of it swings them.
    pub fn of(&self, points: &[Vec3], reach: f64, accept: impl Fn(usize) -> bool) -> Option<Seat> {
        let (all, surface_of_all) = &self.all;
        let first = |t: usize| self.mesh.triangles()[all[t] as usize][0];
        let component = |t: usize| self.mesh.components().of_vertex(first(t) as usize);
        let centre = centroid(points.iter().copied());
        let hit = surface_of_all.closest_point_on(centre, reach, |t| component(t).is_some_and(&accept))?;
        let component = component(hit.triangle)?;
        let triangles: Vec<u32> = if let [_] = points {
            vec![all[hit.triangle]]
        } else {
            let own = self.triangles.of(component);
            let surface = once(&self.surfaces[component], || surface(self.mesh, self.at, own));
            points.iter().filter_map(|&p| Some(own[surface.closest_point(p)?.triangle])).collect()
        };
        let mut vertices = self.corners(triangles.iter().copied());
        while vertices.len() < WIDE && !self.is_wide(&vertices, hit.point, hit.distance) {
            let around = vertices.iter().flat_map(|&v| self.mesh.adjacency().corners_of(v as usize));
            let wider = self.corners(around.map(|corner| corner.triangle));
            if wider.len() == vertices.len() {
                break;
            }
            vertices = wider;
        }
        Some(Seat { component, triangles, vertices })
    }

    /// Whether a patch reaches as far as `distance` from the `foot` of what sits on it, and is on no line.
    fn is_wide(&self, vertices: &[u32], foot: Vec3, distance: f64) -> bool {
        let points = vertices.iter().map(|&v| self.at[v as usize]);
        let reaches = points.clone().any(|p| p.distance(foot) >= distance);
        reaches && Alignment::of(points.map(|p| (p, p))).is_determined()
    }

    fn corners(&self, triangles: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut corners: Vec<u32> = triangles.flat_map(|t| self.mesh.triangles()[t as usize]).collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }
}

/// What is in a cell, built where it is empty, and before the cell is entered: a thread that waits in there for its share
/// of the building may be handed other work that wants the same cell, and would wait for itself.
pub fn once<T>(cell: &OnceLock<T>, build: impl FnOnce() -> T) -> &T {
    cell.get().unwrap_or_else(|| {
        let built = build();
        cell.get_or_init(|| built)
    })
}

/// The surface of some triangles of a mesh.
fn surface(mesh: &Mesh, at: &[Vec3], triangles: &[u32]) -> Surface {
    let corners = |&t: &u32| mesh.triangles()[t as usize].map(|v| at[v as usize]);
    Surface::new(triangles.iter().map(corners).collect())
}
