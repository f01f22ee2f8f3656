//! Parts that ride: an eye in its socket, a button on a sleeve, hairs.
//!
//! A floating component that sits on a larger one, and keeps its place there in all shapes, goes with it in between. The
//! seat's rigid motions `F_k`, from each shape `k` to the shape in between, carry its centroid from all of them:
//!
//! ```text
//!     c(t) = sum_k a_k F_k(t) c_k  +  F_0(t) s(t)
//! ```
//!
//! with the shares `a_k` of the shapes, and `s` how far the part's own screw, as it is seen from the seat, is off a
//! straight line. On a seat at rest that is the screw alone. Vertices in no triangle, as those of loose edges, ride on
//! the surface nearest to them.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::geometry::rigid::{Similarity, centroid, size};
use crate::riding::{Seat, Seats, once};
use crate::{Mat3, Mesh, Vec3};

/// How much larger a part must be than one that rides on it: two eyes do not ride on each other.
const LARGER: f64 = 1.25;

/// How far a part may be from its seat, and how far it may leave its place there, in sizes of its own.
const NEAR: f64 = 3.0;
const KEEPS: f64 = 1.0;

/// How many components a part may sit on for all that is near, as an iris on its eye or on the head; a part that leaves
/// its place by less than this many of its sizes needs no look at the others.
const CANDIDATES: usize = 3;
const FIRM: f64 = 0.01;

/// A vertex in no triangle has its seat from another shape than the first where it leaves that by less than this share.
const LOOSE: f64 = 0.5;

/// What rides in some shapes of a mesh.
#[derive(Debug)]
pub(super) struct Riders {
    /// Those that others ride on come first.
    pub parts: Vec<Part>,
    vertices: Vec<(u32, Seat)>,
}

/// A component that rides.
#[derive(Debug)]
pub(super) struct Part {
    /// Its place among the floating components.
    pub floating: usize,
    pub component: usize,
    pub seat: Seat,
}

impl Riders {
    /// Of `floating` components and of vertices in no triangle that are not `stationary`.
    pub fn of(mesh: &Mesh, shapes: &[Vec<Vec3>], floating: &[Vec<u32>], stationary: &[bool]) -> Self {
        let components = mesh.components();
        let loose = |v: &u32| {
            components.of_vertex(*v as usize).is_none()
                && mesh.representative(*v) == *v
                && !stationary[*v as usize]
        };
        let loose: Vec<u32> = (0..stationary.len() as u32).filter(loose).collect();
        if loose.is_empty() && (components.count() < 2 || floating.is_empty()) {
            return Self { parts: Vec::new(), vertices: Vec::new() };
        }
        let at = &shapes[0];
        // What touches in one shape, as arms that are crossed, is apart in another: a seat is looked for in all.
        let seats: Vec<OnceLock<Seats>> = shapes.iter().map(|_| OnceLock::new()).collect();
        let seats = |k: usize| once(&seats[k], || Seats::new(mesh, &shapes[k], |_| true));
        let members = components.members();
        let sizes: Vec<f64> =
            members.iter().map(|vertices| size(vertices.iter().map(|&v| at[v as usize]))).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let part = |(place, vertices): (usize, &Vec<u32>)| {
            let component = components.of_vertex(vertices[0] as usize)?;
            let size = sizes[component];
            if LARGER * size >= largest {
                return None;
            }
            let centre = |x: &[Vec3]| centroid(vertices.iter().map(|&v| x[v as usize]));
            let leaves = |seat: &Seat| {
                let left = |x: &Vec<Vec3>| motion(seat, at, x).apply(centre(at)).distance(centre(x)) / size;
                shapes[1..].iter().map(left).fold(0.0, f64::max)
            };
            let mut best = (KEEPS, None);
            for (k, shape) in shapes.iter().enumerate() {
                let points: Vec<Vec3> = vertices.iter().map(|&v| shape[v as usize]).collect();
                let mut seen = Vec::new();
                while seen.len() < CANDIDATES && best.0 > FIRM {
                    let larger = |other: usize| sizes[other] > LARGER * size && !seen.contains(&other);
                    let Some(seat) = seats(k).of(&points, NEAR * size, larger) else { break };
                    seen.push(seat.component);
                    let left = leaves(&seat);
                    if left < best.0 {
                        best = (left, Some(seat));
                    }
                }
            }
            Some(Part { floating: place, component, seat: best.1? })
        };
        let mut parts: Vec<Part> = floating.par_iter().enumerate().filter_map(part).collect();
        parts.sort_by(|p, q| sizes[q.component].total_cmp(&sizes[p.component]));
        let ride = |&v: &u32| {
            let leaves = |seat: &Seat| {
                let left = |x: &Vec<Vec3>| motion(seat, at, x).apply(at[v as usize]).distance(x[v as usize]);
                shapes[1..].iter().map(left).fold(0.0, f64::max)
            };
            let seat = |k: usize| {
                let seat = seats(k).of(&[shapes[k][v as usize]], f64::INFINITY, |_| true)?;
                Some((leaves(&seat), seat))
            };
            let mut best = seat(0)?;
            for k in 1..shapes.len() {
                // By much less only: the vertices of a strand are to sit alike.
                best = seat(k).filter(|(left, _)| *left < LOOSE * best.0).unwrap_or(best);
            }
            Some((v, best.1))
        };
        Self { parts, vertices: loose.par_iter().filter_map(ride).collect() }
    }

    /// Of every triangle of a part, the one of its seat that is nearest to it.
    pub fn links(&self, mesh: &Mesh, floating: &[Vec<u32>]) -> Vec<[u32; 2]> {
        let mut links = Vec::new();
        for part in &self.parts {
            for (&v, &host) in floating[part.floating].iter().zip(&part.seat.triangles) {
                let corners = mesh.adjacency().corners_of(v as usize).iter();
                links.extend(corners.filter(|c| c.corner == 0).map(|c| [c.triangle, host]));
            }
        }
        links
    }

    /// Puts what rides in its place, by `y` off the straight blend `line` of the shapes, whose shares are `shares`.
    /// The screws of parts are `offsets` off their lines.
    pub fn place(
        &self,
        floating: &[Vec<u32>],
        shapes: &[Vec<Vec3>],
        shares: &[f64],
        offsets: &[Vec3],
        line: &[Vec3],
        y: &mut [Vec3],
    ) {
        for part in &self.parts {
            let vertices = &floating[part.floating];
            let centre = |x: &[Vec3]| centroid(vertices.iter().map(|&v| x[v as usize]));
            let offset = offsets.get(part.floating).copied().unwrap_or_default();
            let off = carried(&part.seat, shapes, shares, offset, line, y, centre) - centre(y);
            for &v in vertices {
                y[v as usize] += off;
            }
        }
        let own =
            |(v, seat): &(u32, Seat)| carried(seat, shapes, shares, Vec3::ZERO, line, y, |x| x[*v as usize]);
        let places: Vec<Vec3> = self.vertices.par_iter().map(own).collect();
        for ((v, _), place) in self.vertices.iter().zip(places) {
            y[*v as usize] = place;
        }
    }
}

/// The motion of a seat from one shape to another.
pub(super) fn motion(seat: &Seat, from: &[Vec3], to: &[Vec3]) -> Similarity {
    seat.motion(|v| from[v as usize], |v| to[v as usize])
}

/// How far off the straight blend the seat carries a `place`.
fn carried(
    seat: &Seat,
    shapes: &[Vec<Vec3>],
    shares: &[f64],
    offset: Vec3,
    line: &[Vec3],
    y: &[Vec3],
    place: impl Fn(&[Vec3]) -> Vec3,
) -> Vec3 {
    // A seat that goes straight turns nowhere, and adds no rounding.
    if offset == Vec3::ZERO && seat.vertices().iter().all(|&v| y[v as usize] == Vec3::ZERO) {
        return Vec3::ZERO;
    }
    let mut first = Mat3::IDENTITY;
    let mut sum = Vec3::ZERO;
    for (k, (shape, &share)) in shapes.iter().zip(shares).enumerate() {
        let now = seat.motion(|v| shape[v as usize], |v| line[v as usize] + y[v as usize]);
        if k == 0 {
            first = now.linear();
        }
        sum += (now.apply(place(shape)) - place(shape)) * share;
    }
    sum + first * offset
}
