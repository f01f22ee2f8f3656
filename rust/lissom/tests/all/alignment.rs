//! Alignment without markers: shapes that it must find, and those that it must not be sure of.

use crate::common::{numbers, sheet};
use lissom::transfer::alignment::{Found, align};
use lissom::{Error, Job, Mat3, Mesh, Vec3, rotation};

type Parts = (Vec<Vec3>, Vec<[u32; 3]>);

/// A cube's faces in n x n cells, blown up to a sphere, then shaped.
fn ball(n: u32, shape: impl Fn(Vec3) -> Vec3) -> Parts {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (out, x) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
        for (out, y) in [(out, out.cross(x)), (-out, x.cross(out))] {
            let first = vertices.len() as u32;
            let along = |k: u32| f64::from(2 * k) / f64::from(n) - 1.0;
            for v in 0..(n + 1) * (n + 1) {
                vertices.push(shape(out + x * along(v % (n + 1)) + y * along(v / (n + 1))));
            }
            for cell in 0..n * n {
                let v = first + cell / n * (n + 1) + cell % n;
                triangles.extend([[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]]);
            }
        }
    }
    (vertices, triangles)
}

/// A sphere with three unequal bumps, which no rotation takes to itself.
fn lump(p: Vec3) -> Vec3 {
    let p = p.normalize();
    let bump = |x: f64, y: f64, z: f64| (4.0 * (p.dot(Vec3::new(x, y, z).normalize()) - 1.0)).exp();
    p * (1.0 + 0.7 * bump(1.0, 0.2, 0.0) + 0.4 * bump(0.1, 1.0, 0.3) + 0.3 * bump(-0.2, 0.3, -1.0))
}

fn mesh((vertices, triangles): Parts) -> Mesh {
    Mesh::new(vertices, triangles).unwrap()
}

/// The triangles whose corners are accepted; vertices stay.
fn part((vertices, triangles): Parts, accept: impl Fn(Vec3) -> bool) -> Parts {
    let kept = triangles.into_iter().filter(|t| t.iter().all(|&v| accept(vertices[v as usize])));
    let kept = kept.collect();
    (vertices, kept)
}

fn moved((vertices, triangles): Parts, turn: Mat3, scale: f64) -> Parts {
    (vertices.into_iter().map(|p| turn * p * scale + Vec3::new(3.0, -7.0, 20.0)).collect(), triangles)
}

fn found(source: &Mesh, target: &Mesh) -> Found {
    let [none, neither] = [source, target].map(|mesh| vec![false; mesh.rest().len()]);
    align(source, target, &none, &neither, 180.0, &Job::default()).unwrap()
}

/// Degrees between the rotation found and the true one, and the scale found over the true one.
fn errors(found: &Found, source: &Mesh, target: &Mesh, turn: Mat3, scale: f64) -> (f64, f64) {
    let own = found.scale * target.frame().scale / source.frame().scale;
    (rotation::log(turn.transpose() * found.rotation).length().to_degrees(), own / scale)
}

fn turns(count: usize) -> Vec<Mat3> {
    let mut next = numbers(11);
    (0..count).map(|_| rotation::exp(Vec3::new(next(), next(), next()) * 3.0)).collect()
}

#[test]
fn a_shape_is_found_in_any_place_and_size_and_triangulation() {
    let source = mesh(ball(16, lump));
    for (turn, scale) in turns(6).into_iter().zip([1e-2, 0.3, 1.0, 2.0, 30.0, 1e2]) {
        let target = mesh(moved(ball(13, lump), turn, scale));
        let found = found(&source, &target);
        let (angle, ratio) = errors(&found, &source, &target, turn, scale);
        assert!(angle < 1.0 && (ratio - 1.0).abs() < 0.01, "{angle} {ratio}");
        assert!(found.residual < 0.005 && found.certainty > 0.9, "{found:?}");
        for &p in source.vertices().iter().step_by(97) {
            let place = found.similarity.apply(source.frame().to_unit(p));
            let truth = target.frame().to_unit(turn * p * scale + Vec3::new(3.0, -7.0, 20.0));
            assert!(place.distance(truth) < 0.01);
        }
    }
}

#[test]
fn a_part_is_found_on_the_whole_and_the_whole_on_a_part() {
    let cut = || part(ball(16, lump), |p| p.x > -0.3);
    for turn in turns(4) {
        for (source, target) in [(cut(), ball(13, lump)), (ball(13, lump), cut())] {
            let (source, target) = (mesh(source), mesh(moved(target, turn, 2.0)));
            let found = found(&source, &target);
            let (angle, ratio) = errors(&found, &source, &target, turn, 2.0);
            assert!(angle < 3.0 && (ratio - 1.0).abs() < 0.03, "{angle} {ratio}");
            assert!(found.certainty > 0.5, "{found:?}");
        }
    }
}

#[test]
fn what_is_masked_takes_no_part() {
    let (mut vertices, mut triangles) = ball(13, lump);
    let first = vertices.len() as u32;
    let (more, others) = ball(4, |p| p * 3.0 + Vec3::new(0.0, 9.0, 0.0));
    vertices.extend(more);
    triangles.extend(others.iter().map(|t| t.map(|v| v + first)));
    let masked: Vec<bool> = (0..vertices.len()).map(|v| v >= first as usize).collect();
    let turn = turns(1)[0];
    let (source, target) = (mesh(ball(16, lump)), mesh(moved((vertices, triangles), turn, 1.0)));
    let none = vec![false; source.rest().len()];
    let found = align(&source, &target, &none, &masked, 180.0, &Job::default()).unwrap();
    let (angle, ratio) = errors(&found, &source, &target, turn, 1.0);
    assert!(angle < 1.0 && (ratio - 1.0).abs() < 0.01 && found.certainty > 0.9, "{angle} {ratio} {found:?}");
}

#[test]
fn of_symmetric_shapes_the_least_rotation_is_taken_and_not_trusted() {
    let turn = rotation::exp(Vec3::new(0.1, -0.1, 0.15));
    let sphere = |n: u32| ball(n, Vec3::normalize);
    let cube = |n: u32| ball(n, |p| p);
    for (source, target, own) in [(sphere(8), sphere(11), false), (cube(6), cube(5), true)] {
        let (source, target) = (mesh(source), mesh(moved(target, turn, 2.0)));
        let found = found(&source, &target);
        let (angle, ratio) = errors(&found, &source, &target, turn, 2.0);
        assert!(found.certainty < 0.1 && (ratio - 1.0).abs() < 0.02, "{ratio} {found:?}");
        assert!(if own { angle < 1.0 } else { angle < 15.0 }, "{angle}");
    }
}

#[test]
fn shapes_with_nothing_in_common_are_not_trusted() {
    let flat = sheet(12);
    let star = mesh(ball(16, |p| p.normalize() * (1.0 + 0.5 * (7.0 * p.x).sin() * (6.0 * p.y).cos())));
    let lump = mesh(ball(16, lump));
    for (source, target) in [(&flat, &lump), (&lump, &flat), (&star, &flat), (&flat, &star)] {
        let found = found(source, target);
        assert!(found.certainty < 0.25, "{found:?}");
        assert!(found.scale > 1e-3 && found.scale < 1e3);
    }
}

#[test]
fn there_and_back_is_nowhere() {
    let (source, target) = (mesh(ball(16, lump)), mesh(moved(ball(13, lump), turns(1)[0], 2.0)));
    let (there, back) = (found(&source, &target), found(&target, &source));
    for &p in source.rest().iter().step_by(97) {
        assert!(back.similarity.apply(there.similarity.apply(p)).distance(p) < 2e-3);
    }
}

#[test]
fn the_result_is_the_same_on_one_thread() {
    let (source, target) = (mesh(ball(9, lump)), mesh(moved(ball(7, lump), turns(1)[0], 2.0)));
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let [one, four] = [1, 4].map(|threads| pool(threads).install(|| found(&source, &target)));
    assert_eq!(format!("{one:?}"), format!("{four:?}"));
}

#[test]
fn degenerate_meshes_are_placed_somewhere_or_refused() {
    let triangle = || (vec![Vec3::ZERO, Vec3::X, Vec3::Y * 1e-3], vec![[0, 1, 2]]);
    let far = vec![Vec3::ZERO, Vec3::X * 1e-9, Vec3::Y * 1e-9, Vec3::X, Vec3::ZERO, Vec3::Y];
    let flat = vec![Vec3::ZERO, Vec3::X, Vec3::X * 0.5, Vec3::Y, Vec3::Y * 2.0, Vec3::Y * 3.0];
    let two = vec![[0, 1, 2], [3, 4, 5]];
    let square = part(ball(4, |p| p), |p| p.z == 1.0);
    let shapes = [triangle(), (far.clone(), two.clone()), square, ball(4, lump)].map(mesh);
    for source in &shapes {
        for target in &shapes {
            let found = found(source, target);
            let numbers = [found.scale, found.residual, found.certainty, found.rotation.determinant()];
            assert!(numbers.iter().all(|x| x.is_finite()) && found.scale > 0.0, "{found:?}");
            assert!((0.0..=1.0).contains(&found.certainty));
        }
    }
    let refused = |source: &Mesh, masked: &[bool]| {
        let none = vec![false; shapes[0].rest().len()];
        let fault = align(&shapes[0], source, &none, masked, 180.0, &Job::default()).unwrap_err();
        assert!(matches!(fault, Error::InvalidValue(fault) if fault.argument == "target_mask"));
    };
    refused(&shapes[3], &vec![true; shapes[3].rest().len()]);
    refused(&shapes[3], &[]);
    refused(&mesh((flat, two)), &[false; 6]);
    let job = Job::default();
    job.cancel();
    assert!(matches!(
        align(&shapes[0], &shapes[0], &[false; 3], &[false; 3], 180.0, &job),
        Err(Error::Cancelled)
    ));
}
