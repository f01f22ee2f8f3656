//! Triangles between outlines: a constrained Delaunay triangulation of the outlines and of a lattice of equilateral
//! triangles between them, refined until no angle is small. The only code that knows spade.

use std::collections::HashSet;

use glam::DVec2;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation as _};

use crate::{Error, Job, Result};

/// Degrees that no angle is below, but at sharp tips of the outline.
pub const ANGLE: f64 = 25.0;

/// Points of the lattice keep this part of an edge from those of the outlines: nearer ones would have these cut in
/// half (they lie outside all circles over edges from 0.71 on).
const DISTANCE: f64 = 0.75;

/// Area of the largest triangle as a part of the equilateral one's.
const LARGEST: f64 = 1.6;

/// Points that refinement may add for each there is, before it is given up.
const ADDED: usize = 30;

/// One round leaves thin triangles between two of its own points on neighbouring sides of an outline, lest it goes on
/// forever in a sharp tip.
const ROUNDS: usize = 4;

/// Bytes that a point takes while it is triangulated, with its edges and triangles.
const POINT_BYTES: f64 = 600.0;

/// A triangulated drawing.
pub struct Triangles {
    pub points: Vec<DVec2>,
    pub triangles: Vec<[u32; 3]>,
    /// Whether refinement came to its end.
    pub complete: bool,
}

/// About how much memory the triangles of an area take, within outlines of so many points.
pub fn bytes(area: f64, edge: f64, points: usize) -> u128 {
    let lattice = area / (0.75_f64.sqrt() * edge * edge);
    ((lattice + 2.0 * points as f64) * POINT_BYTES) as u128
}

/// Fills the outlines, which do not cross, with triangles whose edges are about `edge` long.
pub fn triangulated(outlines: &[Vec<DVec2>], edge: f64, job: &Job) -> Result<Triangles> {
    let (mut points, mut sides) = (Vec::new(), Vec::new());
    for ring in outlines {
        let first = points.len();
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let parts = (a.distance(*b) / edge).ceil().max(1.0);
            points.extend((0..parts as usize).map(|part| a.lerp(*b, part as f64 / parts)));
        }
        let count = points.len() - first;
        sides.extend((0..count).map(|k| [first + k, first + (k + 1) % count]));
    }
    points.extend(lattice(outlines, &points, edge));
    // Far outside, so that no outline lies along the hull: triangles between the two would be too thin to divide.
    let far = points.iter().fold(edge, |far: f64, p| far.max(p.max_element()));
    points.extend(
        [(-far, -far), (2.0 * far, -far), (2.0 * far, 2.0 * far), (-far, 2.0 * far)].map(DVec2::from),
    );
    let limit = ADDED * points.len();
    let points = points.into_iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut crossed = false;
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, sides, |_| {
        crossed = true;
    })
    .map_err(|error| Error::SolveFailed(format!("the outline cannot be triangulated: {error}")))?;
    if crossed {
        return Err(Error::SolveFailed("the outline crosses itself: this is a bug, please report it".into()));
    }
    job.part("Triangles")?;
    let parameters = RefinementParameters::new()
        .exclude_outer_faces(true)
        .with_angle_limit(AngleLimit::from_deg(ANGLE))
        .with_max_allowed_area(LARGEST * 0.75_f64.sqrt() / 2.0 * edge * edge)
        .with_max_additional_vertices(limit);
    let mut refined = mesh.refine(parameters.clone());
    for _ in 1..ROUNDS {
        job.check()?;
        let before = mesh.num_vertices();
        refined = mesh.refine(parameters.clone());
        if mesh.num_vertices() == before {
            break;
        }
    }
    let outside: HashSet<_> = refined.excluded_faces.into_iter().collect();
    let mut number = vec![u32::MAX; mesh.num_vertices()];
    let mut made =
        Triangles { points: Vec::new(), triangles: Vec::new(), complete: refined.refinement_complete };
    for face in mesh.inner_faces().filter(|face| !outside.contains(&face.fix())) {
        made.triangles.push(face.vertices().map(|vertex| {
            let number = &mut number[vertex.index()];
            if *number == u32::MAX {
                *number = made.points.len() as u32;
                made.points.push(DVec2::new(vertex.position().x, vertex.position().y));
            }
            *number
        }));
    }
    Ok(made)
}

/// The points inside the outlines of a lattice of equilateral triangles, but those near `points`.
fn lattice(outlines: &[Vec<DVec2>], points: &[DVec2], edge: f64) -> Vec<DVec2> {
    let height = 0.75_f64.sqrt() * edge;
    let rows = 1 + points.iter().fold(0.0, |top: f64, p| top.max(p.y / height)) as usize;
    let mut crossings = vec![Vec::new(); rows];
    for ring in outlines {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            let first = (low.y / height).ceil() as usize;
            for row in (first..rows).take_while(|&row| (row as f64) * height < high.y) {
                let part = (row as f64 * height - low.y) / (high.y - low.y);
                crossings[row].push(low.x + part * (high.x - low.x));
            }
        }
    }
    let near = Near::new(points, DISTANCE * edge);
    let mut found = Vec::new();
    for (row, crossings) in crossings.iter_mut().enumerate() {
        crossings.sort_by(f64::total_cmp);
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for ends in crossings.chunks_exact(2) {
            let first = (ends[0] / edge - shift).ceil() as i64;
            let inside = (first..).map(|k| (k as f64 + shift) * edge).take_while(|&x| x < ends[1]);
            let inside = inside.map(|x| DVec2::new(x, row as f64 * height));
            found.extend(inside.filter(|&point| !near.any(point)));
        }
    }
    found
}

/// Points in squares as large as the distance that is asked for.
struct Near {
    squares: rustc_hash::FxHashMap<(i64, i64), Vec<DVec2>>,
    distance: f64,
}

impl Near {
    fn new(points: &[DVec2], distance: f64) -> Self {
        let mut near = Self { squares: Default::default(), distance };
        for &point in points {
            let square = near.square(point);
            near.squares.entry(square).or_default().push(point);
        }
        near
    }

    fn square(&self, point: DVec2) -> (i64, i64) {
        ((point.x / self.distance).floor() as i64, (point.y / self.distance).floor() as i64)
    }

    /// Whether any is within the distance.
    fn any(&self, point: DVec2) -> bool {
        let (x, y) = self.square(point);
        let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
        let others = around.filter_map(|square| self.squares.get(&square)).flatten();
        others.into_iter().any(|other| other.distance(point) < self.distance)
    }
}
