//! Paths with known answers, identities, and bad input.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::*;
use crate::{Error, Job, Mat3, Mesh, Vec3, rotation};

/// A mesh with the two shapes of a path.
struct Case {
    mesh: Arc<Mesh>,
    start: Vec<Vec3>,
    end: Vec<Vec3>,
}

impl Case {
    fn new(start: Vec<Vec3>, triangles: Vec<[u32; 3]>, end: Vec<Vec3>) -> Self {
        Self { mesh: Arc::new(Mesh::new(start.clone(), triangles).unwrap()), start, end }
    }

    fn path(&self, rotation: Rotation) -> Inbetween {
        let options = InbetweenOptions { rotation, ..Default::default() };
        Inbetween::new(self.mesh.clone(), &self.start, &self.end, options, &Job::default()).unwrap()
    }

    fn at(&self, t: f64) -> Vec<Vec3> {
        at(&self.path(Rotation::Consistent), t)
    }

    fn reversed(&self) -> Self {
        Self { mesh: self.mesh.clone(), start: self.end.clone(), end: self.start.clone() }
    }

    /// Root mean square relative deviation of the edge lengths from the mean of both ends.
    fn edge_error(&self, x: &[Vec3]) -> f64 {
        let edges = self.mesh.adjacency().edges();
        let squares = edges.iter().map(|e| {
            let length = |x: &[Vec3]| x[e[0] as usize].distance(x[e[1] as usize]);
            (2.0 * length(x) / (length(&self.start) + length(&self.end)) - 1.0).powi(2)
        });
        (squares.sum::<f64>() / edges.len() as f64).sqrt()
    }
}

fn at(path: &Inbetween, t: f64) -> Vec<Vec3> {
    path.at(&[t], &Job::default()).unwrap().remove(0)
}

fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

fn centroid(x: &[Vec3]) -> Vec3 {
    x.iter().sum::<Vec3>() / x.len() as f64
}

/// A repeatable stream of numbers in (-1, 1).
fn numbers(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// The triangles of a grid of `rows` x `columns` quads; `closed` joins the last column to the first.
fn grid(rows: u32, columns: u32, closed: bool) -> Vec<[u32; 3]> {
    let stride = if closed { columns } else { columns + 1 };
    let quad = |(i, j): (u32, u32)| {
        let (a, b) = (i * stride + j, i * stride + (j + 1) % stride);
        [[a, b, b + stride], [a, b + stride, a + stride]]
    };
    (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).flat_map(quad).collect()
}

const RING: usize = 40;
const LEVELS: usize = 200;

/// A slender square bar, length 20 and side 0.4, twisted by `turns`; every coordinate of the free
/// levels is off by up to `noise`.
fn bar(turns: f64, noise: f64) -> Case {
    let ring = (0..RING).map(|i| {
        let (side, share) = (i / 10, (i % 10) as f64 / 10.0);
        let (x, y) = [(share, 0.0), (1.0, share), (1.0 - share, 1.0), (0.0, 1.0 - share)][side];
        Vec3::new(0.4 * (x - 0.5), 0.4 * (y - 0.5), 0.0)
    });
    let ring: Vec<Vec3> = ring.collect();
    let height = |level: usize| 20.0 * level as f64 / (LEVELS - 1) as f64;
    let levels = (0..LEVELS).flat_map(|k| ring.iter().map(move |&p| p + Vec3::Z * height(k)));
    let start: Vec<Vec3> = levels.collect();
    let mut next = numbers(7);
    let mut twist = |(i, &p): (usize, &Vec3)| {
        let off = if i < RING { Vec3::ZERO } else { Vec3::new(next(), next(), next()) * noise };
        rotation::exp(Vec3::Z * (TAU * turns * p.z / 20.0)) * p + off
    };
    let end = start.iter().enumerate().map(&mut twist).collect();
    Case::new(start.clone(), grid(LEVELS as u32 - 1, RING as u32, true), end)
}

/// How far the last ring has turned against the first, in degrees between -180 and 180.
fn end_turn(start: &[Vec3], x: &[Vec3]) -> f64 {
    let angle = |from: usize| {
        let rings = [start, x].map(|x| &x[from..from + RING]);
        let centres = rings.map(centroid);
        let spokes = rings[0].iter().zip(rings[1]).map(|(p, q)| (*p - centres[0], *q - centres[1]));
        let (sine, cosine) =
            spokes.fold((0.0, 0.0), |(s, c), (p, q)| (s + p.x * q.y - p.y * q.x, c + p.x * q.x + p.y * q.y));
        sine.atan2(cosine).to_degrees()
    };
    (angle(start.len() - RING) - angle(0) + 540.0).rem_euclid(360.0) - 180.0
}

/// A flat strip bent within its plane into a spiral of `turns`, growing tighter.
fn spiral(turns: f64) -> Case {
    let (length, rows, columns) = (20.0, 120u32, 6u32);
    let steps = 100 * rows as usize;
    let angle = |s: f64| TAU * turns * s * (1.0 + 0.3 * s) / 1.3;
    let mut spine = vec![Vec3::ZERO];
    for k in 0..steps {
        let a = angle((k as f64 + 0.5) / steps as f64);
        spine.push(spine[k] + Vec3::new(a.cos(), a.sin(), 0.0) * (length / steps as f64));
    }
    let places = (0..=rows).flat_map(|i| (0..=columns).map(move |j| (i, f64::from(j) / 6.0 - 0.5)));
    let start = places.clone().map(|(i, y)| Vec3::new(length * f64::from(i) / f64::from(rows), y, 0.0));
    let end = places.map(|(i, y)| {
        let a = angle(f64::from(i) / f64::from(rows));
        spine[100 * i as usize] + Vec3::new(-a.sin(), a.cos(), 0.0) * y
    });
    Case::new(start.collect(), grid(rows, columns, false), end.collect())
}

/// A bent open sheet in two separate pieces, in general position at both ends.
fn two_sheets() -> Case {
    let mut next = numbers(3);
    let piece: Vec<Vec3> =
        (0..36).map(|i| Vec3::new(f64::from(i / 6), f64::from(i % 6), 0.3 * f64::from(i % 5))).collect();
    let start: Vec<Vec3> = piece.iter().copied().chain(piece.iter().map(|&p| p + Vec3::X * 10.0)).collect();
    let faces = grid(5, 5, false);
    let triangles: Vec<[u32; 3]> =
        faces.iter().copied().chain(faces.iter().map(|t| t.map(|v| v + 36))).collect();
    let turn = rotation::exp(Vec3::new(1.0, -2.0, 0.5));
    let end = start.iter().map(|&p| turn * p + Vec3::new(next(), next(), next()) * 0.2).collect();
    Case::new(start, triangles, end)
}

#[test]
fn both_ends_are_exact() {
    for case in [bar(1.5, 0.0), two_sheets(), two_sheets().reversed()] {
        let path = case.path(Rotation::Consistent);
        let ends = path.at(&[0.0, 1.0], &Job::default()).unwrap();
        assert_eq!(ends, [case.start.clone(), case.end.clone()]);
        // And the path leads there: what is solved for just before is as near as the time is.
        let near = path.at(&[1e-9, 1.0 - 1e-9], &Job::default()).unwrap();
        assert!(farthest(&near[0], &case.start) < 1e-6 && farthest(&near[1], &case.end) < 1e-6);
    }
}

#[test]
fn the_way_back_is_the_same_path() {
    for case in [bar(2.5, 0.0), bar(1.5, 1e-3), spiral(1.7), two_sheets()] {
        for t in [0.125, 0.3, 0.5, 0.9] {
            let apart = farthest(&case.at(t), &case.reversed().at(1.0 - t));
            assert!(apart <= 1e-8 / case.mesh.frame().scale, "{apart:e} at {t}");
        }
    }
}

#[test]
fn a_rigid_motion_is_interpolated_as_that_rotation() {
    let axis = Vec3::new(0.3, 0.5, -0.8).normalize();
    let mut case = bar(0.0, 0.0);
    let turn = |t: f64| rotation::exp(axis * (t * 170f64.to_radians()));
    case.end = case.start.iter().map(|&p| turn(1.0) * p + Vec3::new(3.0, 1.0, 2.0)).collect();
    // A screw: about the axis through the point that the turn alone leaves on it.
    let shift = Vec3::new(3.0, 1.0, 2.0);
    let along = axis * shift.dot(axis);
    let across = shift - along;
    let pivot = (across + axis.cross(across) / 85f64.to_radians().tan()) * 0.5;
    assert!((turn(1.0) * -pivot + pivot).distance(across) < 1e-12);
    for t in [0.2, 0.5, 0.9] {
        let known: Vec<Vec3> =
            case.start.iter().map(|&p| turn(t) * (p - pivot) + pivot + along * t).collect();
        let off = farthest(&case.at(t), &known);
        assert!(off < 1e-9, "{off:e}");
        assert!(case.edge_error(&known) < 1e-12 && case.edge_error(&case.at(t)) < 1e-8);
    }
}

#[test]
fn twists_of_several_turns_come_out_whole() {
    for turns in [0.5, 1.5, 2.5] {
        for (noise, edges) in [(0.0, 0.01), (1e-3, 0.01), (5e-3, 0.02)] {
            let case = bar(turns, noise);
            let x = case.at(0.5);
            let half = (180.0 * turns + 180.0).rem_euclid(360.0) - 180.0;
            let off = (end_turn(&case.start, &x) - half + 540.0).rem_euclid(360.0) - 180.0;
            assert!(off.abs() < 2.0, "{turns} turns, noise {noise}: off by {off} degrees");
            assert!(case.edge_error(&x) < edges, "{turns} turns, noise {noise}: {}", case.edge_error(&x));
        }
    }
}

#[test]
fn shortest_turns_break_a_twist_and_consistent_ones_do_not() {
    let case = bar(1.5, 0.0);
    let broken = case.edge_error(&at(&case.path(Rotation::Shortest), 0.5));
    assert!(broken > 10.0 * case.edge_error(&case.at(0.5)), "{broken}");
}

/// The setting of Alexa, Cohen-Or & Levin (2000): the planar angle, made consistent breadth first, and its least squares,
/// written down independently and solved densely in complex numbers.
#[test]
fn a_flat_mesh_takes_the_planar_angle() {
    let mut case = spiral(0.9);
    // A small part of it, for the dense solve: still more than half a turn from end to end.
    let keep = |x: &[Vec3]| -> Vec<Vec3> {
        x.iter().step_by(7 * 5).chain(x[6..].iter().step_by(7 * 5)).copied().collect()
    };
    let (start, end) = (keep(&case.start), keep(&case.end));
    let rungs = start.len() as u32 / 2;
    let triangles = (0..rungs - 1).flat_map(|i| [[i, i + 1, rungs + i], [i + 1, rungs + i + 1, rungs + i]]);
    case = Case::new(start, triangles.collect(), end);
    let t = 0.4;
    let x = case.at(t);
    assert!(x.iter().all(|p| p.z == 0.0), "leaves its plane");

    // The strip is a chain of triangles, so breadth first is from one to the next.
    let mut angles: Vec<f64> = Vec::new();
    let mut normal = vec![vec![0.0; x.len()]; x.len()];
    let mut rhs = vec![Vec3::ZERO; x.len()];
    for i in 0..rungs as usize - 1 {
        for tri in [2 * i, 2 * i + 1].map(|k| case.mesh.triangles()[k]) {
            let [p, q] = [&case.start, &case.end].map(|x| tri.map(|v| x[v as usize]));
            let edge = |p: [Vec3; 3], k: usize| p[(k + 2) % 3] - p[(k + 1) % 3];
            let cotangent = |p: [Vec3; 3], k: usize| {
                let (a, b) = (edge(p, (k + 1) % 3), edge(p, (k + 2) % 3));
                -0.5 * a.dot(b) / a.cross(b).length()
            };
            // Polar decomposition in the plane: the angle that maximises sum w e(end) . R e(start),
            // with the start's cotangents, is that of the gradient.
            let (mut cosine, mut sine) = (0.0, 0.0);
            for k in 0..3 {
                cosine += cotangent(p, k) * edge(p, k).dot(edge(q, k));
                sine += cotangent(p, k) * edge(p, k).cross(edge(q, k)).z;
            }
            let mut angle = sine.atan2(cosine);
            while let Some(last) = angles.last().filter(|last| (angle - **last).abs() > PI) {
                angle += TAU * (last - angle).signum();
            }
            angles.push(angle);
            let turn = |a: f64, e: Vec3| rotation::exp(Vec3::Z * a) * e;
            for k in 0..3 {
                let (i, j) = (tri[(k + 1) % 3] as usize, tri[(k + 2) % 3] as usize);
                let w = 0.5 * (cotangent(p, k) + cotangent(q, k));
                let asked = turn(t * angle, edge(p, k)) * (1.0 - t) + turn((t - 1.0) * angle, edge(q, k)) * t;
                for (a, b, sign) in [(i, j, -1.0), (j, i, 1.0)] {
                    normal[a][a] += w;
                    normal[a][b] -= w;
                    rhs[a] += asked * (w * sign);
                }
            }
        }
    }
    let spread = angles.iter().fold(0.0f64, |m, a| m.max(a.abs()));
    assert!(spread > PI, "turns by {spread} only");
    // The first triangle's branch is the one whole turn that the equations leave open.
    // Rows of vertices that do not move are no equations.
    let free = |a: &usize| case.start[*a] != case.end[*a];
    assert!((0..x.len()).filter(free).count() > x.len() - 3);
    for (a, row) in normal.iter().enumerate().filter(|(a, _)| free(a)) {
        let residual = row.iter().zip(&x).map(|(w, &p)| p * *w).sum::<Vec3>() - rhs[a];
        assert!(residual.length() < 1e-9, "row {a}: {residual}");
    }
}

#[test]
fn a_spiral_unrolls() {
    let case = spiral(1.7);
    let straight: Vec<Vec3> = case.start.iter().zip(&case.end).map(|(p, q)| p.midpoint(*q)).collect();
    let x = case.at(0.5);
    assert!(case.edge_error(&x) < 1e-3, "{}", case.edge_error(&x));
    assert!(case.edge_error(&straight) > 0.4);
}

#[test]
fn positions_minimise_the_energy_of_both_ends() {
    let case = two_sheets();
    let path = case.path(Rotation::Consistent);
    let (t, x) = (0.35, at(&path, 0.35));
    // Written down per triangle from gradients, areas and the polar decomposition.
    let energy = |x: &[Vec3]| -> f64 {
        let of = |tri: &[u32; 3]| {
            let [p, q, r] = [&case.start, &case.end, &x.to_vec()].map(|x| tri.map(|v| x[v as usize]));
            let basis = |p: [Vec3; 3]| {
                let (a, b) = (p[1] - p[0], p[2] - p[0]);
                (Mat3::from_cols(a, b, a.cross(b).normalize()), 0.5 * a.cross(b).length())
            };
            let ((p, area_p), (q, area_q)) = (basis(p), basis(q));
            let x = Mat3::from_cols(r[1] - r[0], r[2] - r[0], Vec3::ZERO);
            let (turn, _) = rotation::polar(q * p.inverse());
            let omega = rotation::log(turn);
            let (ahead, back) = (rotation::exp(omega * t), rotation::exp(omega * (t - 1.0)));
            let asked = ahead * p * (1.0 - t) + back * q * t;
            [(p, area_p), (q, area_q)]
                .into_iter()
                .map(|(rest, area)| {
                    let plane = Mat3::from_diagonal(Vec3::new(1.0, 1.0, 0.0));
                    let off = (x - asked) * plane * rest.inverse();
                    area * off.to_cols_array().iter().map(|x| x * x).sum::<f64>()
                })
                .sum::<f64>()
        };
        case.mesh.triangles().iter().map(of).sum()
    };
    let least = energy(&x);
    let mut next = numbers(11);
    for _ in 0..20 {
        let step: Vec<Vec3> = x.iter().map(|_| Vec3::new(next(), next(), next()) * 1e-3).collect();
        let moved = |sign: f64| energy(&x.iter().zip(&step).map(|(&p, &d)| p + d * sign).collect::<Vec<_>>());
        assert!(moved(1.0) > least && moved(-1.0) > least);
        assert!((moved(1.0) - moved(-1.0)).abs() < 1e-9 * least.max(1.0), "a slope is left");
    }
}

#[test]
fn unmoved_vertices_stay_and_shapes_without_a_rigid_motion_go_straight() {
    let mut case = two_sheets();
    let mut next = numbers(5);
    case.end[..36].fill_with(|| Vec3::new(next(), next(), next()) * 5.0 + Vec3::Y * 30.0);
    let centre = case.end[..36].iter().sum::<Vec3>() / 36.0;
    let still = [40, 41, 47, 60];
    for v in still {
        case.end[v] = case.start[v];
    }
    for t in [0.1, 0.5, 0.77] {
        let x = case.at(t);
        assert!(still.iter().all(|&v| x[v] == case.start[v]));
        let straight = centroid(&case.start[..36]).lerp(centre, t);
        assert!(centroid(&x[..36]).distance(straight) < 1e-12);
    }
}

#[test]
fn vertices_without_triangles_follow_the_surface_and_those_at_rest_stay() {
    let mut case = bar(0.5, 0.0);
    let mut start = case.start.clone();
    start.extend([Vec3::new(7.0, 1.0, 2.0), Vec3::splat(-3.0)]);
    case = Case::new(
        start.clone(),
        case.mesh.triangles().to_vec(),
        [case.end, vec![Vec3::Z, Vec3::splat(-3.0)]].concat(),
    );
    for t in [0.0, 1e-9, 1.0 - 1e-9, 1.0] {
        let straight = start[start.len() - 2].lerp(Vec3::Z, t);
        assert!(case.at(t)[start.len() - 2].distance(straight) < 1e-7);
    }
    assert_eq!(case.at(0.25)[start.len() - 1], Vec3::splat(-3.0));
}

#[test]
fn row_31_and_37_identical_shapes_do_not_move() {
    let mut case = two_sheets();
    case.end = case.start.clone();
    let path = case.path(Rotation::Consistent);
    assert!(path.warnings().is_empty(), "{:?}", path.warnings());
    assert_eq!(at(&path, 0.3), case.start);
    assert_eq!(path.keyframes(1e-6, 32, &Job::default()).unwrap().times, [0.0, 1.0]);
}

#[test]
fn row_37_inverted_triangles_are_counted_and_a_sheet_stays_flat() {
    let mut case = spiral(0.7);
    // Pushes one vertex through the opposite edges of its ring: those triangles turn over.
    let v = 7 * 60 + 3;
    case.end[v] = case.end[v] + (case.end[v + 7] - case.end[v]) * 1.8;
    let path = case.path(Rotation::Consistent);
    assert!(path.warnings().iter().any(|w| w.contains("turn over")), "{:?}", path.warnings());
    let x = at(&path, 0.5);
    assert!(x.iter().all(|p| p.z == 0.0), "leaves its plane");
    assert!(case.edge_error(&x) < 0.05, "{}", case.edge_error(&x));

    // In space: one corner of a bent sheet folded over.
    let mut sheet = two_sheets();
    let (fold, hinge) = (sheet.end[0], (sheet.end[1] + sheet.end[6]) * 0.5);
    sheet.end[0] = hinge * 2.0 - fold;
    assert!(sheet.path(Rotation::Consistent).warnings().iter().any(|w| w.contains("turn over")));
}

#[test]
fn rows_4_and_5_scale_and_offset_do_not_matter() {
    let case = two_sheets();
    let known = case.at(0.4);
    for (scale, offset, tolerance) in
        [(1e-6, Vec3::ZERO, 1e-12), (1e20, Vec3::ZERO, 1e-12), (1.0, Vec3::splat(1e6), 1e-6)]
    {
        let map = |x: &[Vec3]| -> Vec<Vec3> { x.iter().map(|&p| p * scale + offset).collect() };
        let other = Case::new(map(&case.start), case.mesh.triangles().to_vec(), map(&case.end));
        let off = farthest(&other.at(0.4), &map(&known)) / scale;
        assert!(off < tolerance, "{scale}: {off:e}");
    }
}

#[test]
fn row_7_collapsed_triangles_stay_finite() {
    let mut case = two_sheets();
    // One vertex onto its neighbour at the end, and one whole piece onto a point.
    case.end[8] = case.end[9];
    for p in &mut case.end[36..] {
        *p = Vec3::new(5.0, 5.0, 5.0);
    }
    let path = case.path(Rotation::Consistent);
    assert!(path.warnings().iter().any(|w| w.starts_with("end: ") && w.contains("slivers")));
    let x = at(&path, 0.5);
    assert!(x.iter().all(|p| p.is_finite()));
    let extent = farthest(&case.start, &case.end);
    assert!(farthest(&x, &case.start) < 2.0 * extent, "thrown far away");
    let near = at(&path, 1.0 - 1e-9);
    assert!(farthest(&near, &case.end) < 1e-6);
}

#[test]
fn row_40_a_cancelled_job_stops() {
    let case = bar(1.5, 0.0);
    let path = case.path(Rotation::Consistent);
    let job = Job::default();
    job.cancel();
    assert!(matches!(path.at(&[0.5], &job), Err(Error::Cancelled)));
    assert!(matches!(path.keyframes(1e-3, 32, &job), Err(Error::Cancelled)));
    let again = Inbetween::new(case.mesh.clone(), &case.start, &case.end, InbetweenOptions::default(), &job);
    assert!(matches!(again, Err(Error::Cancelled)));
}

/// The largest distance of straight-line playback from the path, at times of the test's own.
fn playback_error(path: &Inbetween, times: &[f64]) -> f64 {
    let job = Job::default();
    let keys = path.at(times, &job).unwrap();
    let probes: Vec<f64> = (0..400).map(|k| (f64::from(k) + 0.37) / 400.0).collect();
    let shapes = path.at(&probes, &job).unwrap();
    let error = |(t, x): (&f64, &Vec<Vec3>)| {
        let k = times.partition_point(|key| key <= t) - 1;
        let share = (t - times[k]) / (times[k + 1] - times[k]);
        let line: Vec<Vec3> = keys[k].iter().zip(&keys[k + 1]).map(|(p, q)| p.lerp(*q, share)).collect();
        farthest(x, &line)
    };
    probes.iter().zip(&shapes).map(error).fold(0.0, f64::max)
}

#[test]
fn keyframes_of_a_rotation_are_as_many_as_its_chords_ask_for() {
    let mut case = bar(0.0, 0.0);
    let angle = 170f64.to_radians();
    let turn = rotation::exp(Vec3::X * angle);
    // Moved on, lest the vertices on the axis stay where they are.
    case.end = case.start.iter().map(|&p| turn * p + Vec3::ONE).collect();
    let path = case.path(Rotation::Consistent);
    let across = Vec3::new(0.0, 1.0, 1.0);
    let centre = (across + Vec3::X.cross(across) / 85f64.to_radians().tan()) * 0.5;
    let radius = case.start.iter().map(|p| (*p - centre).reject_from(Vec3::X).length()).fold(0.0, f64::max);
    // How far a point on the chord over the angle `a` is from the point of the arc at the same time.
    let chord = |a: f64| {
        let off = |s: f64| {
            ((1.0 - s + s * a.cos() - (s * a).cos()).powi(2) + (s * a.sin() - (s * a).sin()).powi(2)).sqrt()
        };
        (0..=1000).map(|k| off(f64::from(k) / 1000.0)).fold(0.0, f64::max)
    };
    for (segments, slack) in [(1.0, 1.02), (3.0, 1.05), (8.0, 1.05), (20.0, 1.1)] {
        let least = radius * chord(angle / segments);
        let keys = path.keyframes(least * slack, 32, &Job::default()).unwrap();
        assert_eq!(keys.times.len(), segments as usize + 1, "{keys:?}");
        assert!(keys.warnings.is_empty());
        let error = playback_error(&path, &keys.times);
        assert!(error <= least * slack && error <= keys.error * 1.001, "{error} {keys:?}");
        assert!(keys.error >= least * 0.999);
    }
}

#[test]
fn keyframes_keep_within_tolerance_and_cannot_spare_one() {
    let case = two_sheets();
    let path = case.path(Rotation::Consistent);
    let tolerance = 0.02;
    let keys = path.keyframes(tolerance, 32, &Job::default()).unwrap();
    assert!(playback_error(&path, &keys.times) <= tolerance);
    assert!(keys.times.len() > 4 && keys.times[0] == 0.0 && keys.times[keys.times.len() - 1] == 1.0);
    let fewer = path.keyframes(tolerance, keys.times.len() - 1, &Job::default()).unwrap();
    assert_eq!(fewer.times.len(), keys.times.len() - 1);
    assert!(fewer.error > tolerance && fewer.warnings.len() == 1, "{fewer:?}");
    for spared in 1..keys.times.len() - 1 {
        let mut times = keys.times.clone();
        times.remove(spared);
        assert!(playback_error(&path, &times) > tolerance);
    }
}

#[test]
fn a_path_keeps_the_volume_of_a_bar_without_lids() {
    let case = bar(1.5, 0.0);
    let options = InbetweenOptions { preserve_volume: true, ..Default::default() };
    let kept = Inbetween::new(case.mesh.clone(), &case.start, &case.end, options, &Job::default()).unwrap();
    assert!(kept.warnings().is_empty(), "{:?}", kept.warnings());
    // Written down by the divergence theorem ring by ring: the ends are flat, across the axis.
    let volume = |x: &[Vec3]| {
        let side = case.mesh.triangles().iter().map(|t| {
            let [p, q, r] = t.map(|v| x[v as usize]);
            p.dot(q.cross(r)) / 6.0
        });
        let end = |from: usize| -> f64 {
            let ring = &x[from..from + RING];
            let centre = centroid(ring);
            (0..RING).map(|k| centre.dot(ring[k].cross(ring[(k + 1) % RING])) / 6.0).sum()
        };
        side.sum::<f64>() + end(x.len() - RING) - end(0)
    };
    let (from, to) = (volume(&case.start), volume(&case.end));
    let lost = volume(&case.at(0.5)) / (0.5 * (from + to)) - 1.0;
    for t in [0.2, 0.5, 0.9] {
        let now = volume(&at(&kept, t));
        assert!((now - from * (1.0 - t) - to * t).abs() < 1e-9 * from.abs(), "{now} at {t}, lost {lost}");
    }
    assert!(lost.abs() > 1e-6, "nothing to restore: {lost:e}");
    let sheets = two_sheets();
    let options = InbetweenOptions { preserve_volume: true, ..Default::default() };
    let path = Inbetween::new(sheets.mesh.clone(), &sheets.start, &sheets.end, options, &Job::default());
    assert!(path.unwrap().warnings()[0].contains("open components"));
}

#[test]
fn averaged_turns_between_neighbours_come_out_whole() {
    for turns in [0.5, 1.5, 2.5] {
        let case = bar(turns, 0.0);
        let x = at(&case.path(Rotation::Relative), 0.5);
        let half = (180.0 * turns + 180.0).rem_euclid(360.0) - 180.0;
        let off = (end_turn(&case.start, &x) - half + 540.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 1.0, "{turns} turns: off by {off} degrees");
        assert!(case.edge_error(&x) < 0.01, "{}", case.edge_error(&x));
    }
}
