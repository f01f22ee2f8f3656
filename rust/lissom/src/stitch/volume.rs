//! The volume of closed components, restored.
//!
//! ```text
//!     V(x) = 1/6 sum_t  a . (b x c)
//! ```
//!
//! The correction of least energy in the metric of a matrix `K` that changes the volume is along
//! `d = K^-1 grad V`; how far, `V(x + l d) = V` says, by Newton's steps.

use std::collections::BTreeMap;

use crate::geometry::triangle::normal_and_area;
use crate::{Mesh, Vec3};

/// Newton's steps: a cubic polynomial, started near its root.
const STEPS: usize = 8;

/// A border is closed by a fan of triangles to its centroid, where the fans of a component are smaller than this fraction
/// of its surface at both ends: a bar without a lid has a volume, a sheet has none.
const FAN: f64 = 0.1;

/// The components whose volume is kept, with their volume at both ends.
#[derive(Debug)]
pub struct Volumes {
    /// Whether each component has a volume.
    closed: Vec<bool>,
    borders: Vec<Border>,
    ends: [Vec<f64>; 2],
}

/// One closed line of border edges.
#[derive(Debug)]
struct Border {
    component: usize,
    /// Each edge as the triangle beside it has it.
    edges: Vec<[u32; 2]>,
}

impl Volumes {
    /// The volumes of a mesh with its vertices at `a`, and at `b`.
    pub fn of(mesh: &Mesh, a: &[Vec3], b: &[Vec3]) -> Self {
        let count = mesh.components().count();
        let mut closed = vec![true; count];
        let mut open = Vec::new();
        for (e, &[low, high]) in mesh.adjacency().edges().iter().enumerate() {
            let Some(c) = mesh.components().of_vertex(low as usize) else { continue };
            match mesh.adjacency().sides_of(e) {
                [side] => open.push((c, if side.ascending { [low, high] } else { [high, low] })),
                [p, q] if p.ascending != q.ascending => {}
                _ => closed[c] = false,
            }
        }
        let mut new = Self { closed, borders: borders(open), ends: [vec![], vec![]] };
        for x in [a, b] {
            let (mut surface, mut fans) = (vec![0.0; count], vec![0.0; count]);
            for t in mesh.triangles() {
                if let Some(c) = mesh.components().of_vertex(t[0] as usize) {
                    surface[c] += normal_and_area(t.map(|v| x[v as usize])).1;
                }
            }
            for border in &new.borders {
                let centre = border.centre(x);
                let fan = border
                    .edges
                    .iter()
                    .map(|e| normal_and_area([x[e[0] as usize], centre, x[e[1] as usize]]).1);
                fans[border.component] += fan.sum::<f64>();
            }
            for (c, closed) in new.closed.iter_mut().enumerate() {
                *closed &= fans[c] <= FAN * surface[c];
            }
        }
        new.ends = [new.volumes(mesh, a), new.volumes(mesh, b)];
        new
    }

    /// Components that have no volume.
    pub fn open(&self) -> impl Iterator<Item = usize> + '_ {
        self.closed.iter().enumerate().filter(|(_, closed)| !**closed).map(|(c, _)| c)
    }

    /// The volume of each component at time `t`, from that at both ends.
    pub fn at(&self, t: f64) -> Vec<f64> {
        self.ends[0].iter().zip(&self.ends[1]).map(|(a, b)| a * (1.0 - t) + b * t).collect()
    }

    /// Moves `y`, the distance from `line`, so that the components have the `wanted` volumes. `precondition` multiplies
    /// a gradient by `K^-1`.
    pub fn restore(
        &self,
        mesh: &Mesh,
        line: &[Vec3],
        y: &mut [Vec3],
        wanted: &[f64],
        precondition: impl Fn(&[Vec3]) -> Vec<Vec3>,
    ) {
        let at = |y: &[Vec3]| -> Vec<Vec3> { line.iter().zip(y).map(|(&l, &y)| l + y).collect() };
        let mut x = at(y);
        let towards = precondition(&self.gradient(mesh, &x));
        for _ in 0..STEPS {
            let (volumes, slopes) = (self.volumes(mesh, &x), self.gradient(mesh, &x));
            let mut slope = vec![0.0; volumes.len()];
            for (v, (g, d)) in slopes.iter().zip(&towards).enumerate() {
                if let Some(c) = mesh.components().of_vertex(v) {
                    slope[c] += g.dot(*d);
                }
            }
            let step: Vec<f64> = (0..volumes.len())
                .map(|c| {
                    let step = (wanted[c] - volumes[c]) / slope[c];
                    if self.closed[c] && step.is_finite() { step } else { 0.0 }
                })
                .collect();
            for (v, d) in towards.iter().enumerate() {
                if let Some(c) = mesh.components().of_vertex(v) {
                    y[v] += *d * step[c];
                }
            }
            x = at(y);
        }
    }

    /// The volume of each component about its own first vertex.
    fn volumes(&self, mesh: &Mesh, x: &[Vec3]) -> Vec<f64> {
        let mut volumes = vec![0.0; mesh.components().count()];
        let mut origins = vec![None; volumes.len()];
        let mut add = |c: usize, corners: [Vec3; 3]| {
            let origin = *origins[c].get_or_insert(corners[0]);
            let [p, q, r] = corners.map(|p| p - origin);
            volumes[c] += p.dot(q.cross(r)) / 6.0;
        };
        for t in mesh.triangles() {
            if let Some(c) = mesh.components().of_vertex(t[0] as usize) {
                add(c, t.map(|v| x[v as usize]));
            }
        }
        for border in &self.borders {
            let centre = border.centre(x);
            for &[p, q] in &border.edges {
                add(border.component, [x[q as usize], x[p as usize], centre]);
            }
        }
        volumes
    }

    /// The gradient of the volume by every vertex: a third of the area normals around it.
    fn gradient(&self, mesh: &Mesh, x: &[Vec3]) -> Vec<Vec3> {
        let mut gradient = vec![Vec3::ZERO; x.len()];
        let sixth = |p: Vec3, q: Vec3, r: Vec3| (q - p).cross(r - p) / 6.0;
        for t in mesh.triangles() {
            let [p, q, r] = t.map(|v| x[v as usize]);
            t.iter().for_each(|&v| gradient[v as usize] += sixth(p, q, r));
        }
        for border in &self.borders {
            let centre = border.centre(x);
            let mut shared = Vec3::ZERO;
            for &[p, q] in &border.edges {
                let part = sixth(x[q as usize], x[p as usize], centre);
                gradient[p as usize] += part;
                gradient[q as usize] += part;
                shared += part;
            }
            let share = shared / border.edges.len() as f64;
            border.edges.iter().for_each(|e| gradient[e[0] as usize] += share);
        }
        gradient
    }
}

impl Border {
    fn centre(&self, x: &[Vec3]) -> Vec3 {
        self.edges.iter().map(|e| x[e[0] as usize]).sum::<Vec3>() / self.edges.len() as f64
    }
}

/// Joins border edges, each with its component, to closed lines.
fn borders(open: Vec<(usize, [u32; 2])>) -> Vec<Border> {
    let mut next: BTreeMap<u32, Vec<(usize, u32)>> = BTreeMap::new();
    for (component, [from, to]) in open {
        next.entry(from).or_default().push((component, to));
    }
    let mut borders = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let (mut border, mut from) = (Border { component: 0, edges: Vec::new() }, first);
        while let Some(mut ways) = next.remove(&from) {
            if let Some((component, to)) = ways.pop() {
                border.component = component;
                border.edges.push([from, to]);
                if !ways.is_empty() {
                    next.insert(from, ways);
                }
                from = to;
            }
        }
        borders.push(border);
    }
    borders
}
