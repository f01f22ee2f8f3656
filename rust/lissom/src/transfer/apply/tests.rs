//! Keys carried over to other triangles, against what is known of them.

use super::*;
use crate::rotation;
use crate::transfer::testing::{bumpy_grid, grid, nosed_sphere};
use crate::transfer::{FitOptions, fit_correspondence};

fn prepare(source: Mesh, target: Mesh, pairs: &[[u32; 2]], options: TransferOptions) -> Transfer {
    let matches = Correspondence::of_pairs(pairs.to_vec());
    Transfer::new(Arc::new(source), Arc::new(target), &matches, options, &Job::default()).unwrap()
}

fn both_weightings() -> [TransferOptions; 2] {
    [Weighting::Pairs, Weighting::Area].map(|weighting| TransferOptions { weighting, ..Default::default() })
}

/// Two spheres with noses, of different triangles and size, and what belongs together.
fn spheres() -> (Mesh, Mesh, Vec<[u32; 2]>) {
    let (vertices, triangles) = nosed_sphere(12, 20);
    let source = Mesh::new(vertices, triangles).unwrap();
    let (vertices, triangles) = nosed_sphere(15, 28);
    let target = Mesh::new(vertices.iter().map(|&v| v * 40.0 + Vec3::X).collect(), triangles).unwrap();
    // The poles, and both ends of the x axis at the equator's nearest ring.
    let ring = |rings: usize, around: usize, j: usize| (1 + (rings / 2) * around + j) as u32;
    let markers = [
        [0, 0],
        [241, 421],
        [ring(12, 20, 0), ring(15, 28, 0)],
        [ring(12, 20, 5), ring(15, 28, 7)],
        [ring(12, 20, 10), ring(15, 28, 14)],
        [ring(12, 20, 15), ring(15, 28, 21)],
    ];
    let fit = fit_correspondence(&source, &target, Some(&markers), &FitOptions::default(), &Job::default());
    (source, target, fit.unwrap().matches.pairs)
}

fn posed(mesh: &Mesh, map: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    mesh.vertices().iter().map(|&v| map(v)).collect()
}

#[test]
fn row_31_a_key_that_moves_nothing_moves_nothing() {
    let (source, target, pairs) = spheres();
    let rest = source.vertices().to_vec();
    for options in both_weightings() {
        let transfer = prepare(copy(&source), copy(&target), &pairs, options);
        let result = transfer.apply(std::slice::from_ref(&rest), &Job::default()).unwrap().poses;
        assert_eq!(result[0], target.vertices(), "to the last bit");
    }
}

fn copy(mesh: &Mesh) -> Mesh {
    Mesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).unwrap()
}

#[test]
fn similarities_of_the_source_are_reproduced_on_other_triangles() {
    let (source, target, pairs) = spheres();
    let turn = rotation::exp(Vec3::new(0.4, -1.9, 0.8));
    let similarity = |p: Vec3| turn * p * 1.3 + Vec3::new(2.0, 3.0, -1.0);
    let shift = Vec3::new(0.5, 0.25, -0.125);
    let poses = [posed(&source, similarity), posed(&source, |p| p + shift)];
    for options in both_weightings() {
        let transfer = prepare(copy(&source), copy(&target), &pairs, options);
        let results = transfer.apply(&poses, &Job::default()).unwrap().poses;
        let scale = target.frame().scale;
        for &[i, j] in target.adjacency().edges() {
            let edge = |x: &[Vec3]| x[j as usize] - x[i as usize];
            let expected = turn * edge(target.vertices()) * 1.3;
            assert!((edge(&results[0]) - expected).length() < 1e-9 * scale);
        }
        // The target is 40 times as large, and moves as much further.
        for (moved, rest) in results[1].iter().zip(target.vertices()) {
            assert!((*moved - *rest - shift * 40.0).length() < 0.02 * 40.0 * shift.length());
            let like_the_first = results[1][0] - target.vertices()[0];
            assert!((*moved - *rest - like_the_first).length() < 1e-9 * scale);
        }
    }
}

#[test]
fn a_mesh_gives_itself_its_own_keys() {
    let mesh = bumpy_grid(10);
    let same: Vec<[u32; 2]> = (0..mesh.triangles().len() as u32).map(|t| [t, t]).collect();
    let everywhere = posed(&mesh, |p| p + Vec3::new(0.1 * p.y, (3.0 * p.x).sin() * 0.2, 0.3 * p.x * p.y));
    let partly = posed(&mesh, |p| p + Vec3::Z * 0.2 * (p.x - 0.5).max(0.0));
    for options in both_weightings() {
        let transfer = prepare(copy(&mesh), copy(&mesh), &same, options);
        let results = transfer.apply(&[everywhere.clone(), partly.clone()], &Job::default()).unwrap().poses;
        for (result, pose) in results.iter().zip([&everywhere, &partly]) {
            for (a, b) in result.iter().zip(pose) {
                assert!((*a - *b).length() < 1e-8);
            }
        }
    }
}

#[test]
fn what_does_not_move_on_the_source_stays_put_exactly() {
    let (source, target, pairs) = spheres();
    let pose = posed(&source, |p| if p.x > 0.6 { p + Vec3::new(p.x - 0.6, 0.0, 0.3) } else { p });
    for options in both_weightings() {
        let transfer = prepare(copy(&source), copy(&target), &pairs, options);
        let result = transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
        let moved = |v: usize| result[v] != target.vertices()[v];
        let behind = |v: usize| target.vertices()[v].x < 1.0;
        assert!((0..result.len()).filter(|&v| behind(v)).all(|v| !moved(v)));
        assert!((0..result.len()).any(|v| (result[v] - target.vertices()[v]).length() > 10.0));
    }
}

#[test]
fn unmatched_triangles_continue_what_is_around_them() {
    // A turn about the z axis is known on all triangles but a few, and goes on there.
    let mesh = bumpy_grid(10);
    let pairs: Vec<[u32; 2]> =
        (0..mesh.triangles().len() as u32).filter(|t| !(60..72).contains(t)).map(|t| [t, t]).collect();
    let turn = rotation::exp(Vec3::Z * 1.2);
    let pose = posed(&mesh, |p| turn * p);
    let transfer = prepare(copy(&mesh), copy(&mesh), &pairs, TransferOptions::default());
    let result = transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
    for (a, b) in result.iter().zip(&pose) {
        assert!((*a - *b).length() < 1e-6);
    }
}

#[test]
fn row_30_a_component_without_a_match_follows_rigidly_or_rests() {
    let (mut vertices, mut triangles) = grid(6);
    let source = bumpy_grid(6);
    let pairs: Vec<[u32; 2]> = (0..triangles.len() as u32).map(|t| [t, t]).collect();
    let (ball, faces) = nosed_sphere(4, 6);
    vertices.extend(ball.iter().map(|&p| p * 0.1 + Vec3::new(0.5, 0.5, 0.4)));
    triangles.extend(faces.iter().map(|t| t.map(|v| v + 36)));
    let target = Mesh::new(vertices, triangles).unwrap();
    let turn = rotation::exp(Vec3::new(0.5, 0.2, -0.9));
    let pose = posed(&source, |p| turn * p + Vec3::X);
    for (unmatched, text) in [(Unmatched::Follow, "rigidly"), (Unmatched::Rest, "at rest")] {
        let options = TransferOptions { unmatched, ..Default::default() };
        let transfer = prepare(copy(&source), copy(&target), &pairs, options);
        assert!(transfer.warnings()[0].contains(text) && transfer.warnings()[0].contains("1 in all"));
        let result = transfer.apply(std::slice::from_ref(&pose), &Job::default()).unwrap().poses.remove(0);
        for (&moved, &rest) in result.iter().zip(target.vertices()).skip(36) {
            let expected = if unmatched == Unmatched::Rest { rest } else { turn * rest + Vec3::X };
            assert!((moved - expected).length() < 1e-8);
        }
    }
}

#[test]
fn row_40_a_cancelled_job_stops() {
    let mesh = bumpy_grid(4);
    let pose = mesh.vertices().to_vec();
    let transfer = prepare(copy(&mesh), mesh, &[[0, 0]], TransferOptions::default());
    let job = Job::default();
    job.cancel();
    assert!(matches!(transfer.apply(&[pose], &job), Err(Error::Cancelled)));
}
