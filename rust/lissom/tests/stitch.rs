//! The stitcher: exactness, and equality with the system of fourth vertices that it replaces.

mod common;

use common::{numbers, sheet};
use lissom::linear::Constraints;
use lissom::operators::gradient::deformation_gradients;
use lissom::stitch::Stitcher;
use lissom::{Error, Job, Mat3, Mesh, Vec3};

fn pin(mesh: &Mesh, pinned: &[usize]) -> Constraints {
    Constraints::hard(mesh.vertices().len(), |v| pinned.contains(&v))
}

#[test]
fn identity_targets_move_nothing_to_the_last_bit() {
    let mesh = sheet(20);
    let stitcher = Stitcher::new(&mesh, pin(&mesh, &[0]), &Job::default()).unwrap();
    let mut moved = vec![Vec3::ZERO; mesh.vertices().len()];
    stitcher.solve(&mesh, &vec![Mat3::IDENTITY; mesh.triangles().len()], &mut moved);
    assert!(moved.iter().all(|&d| d == Vec3::ZERO));
}

#[test]
fn targets_of_a_real_pose_give_that_pose() {
    let mesh = sheet(20);
    let posed: Vec<Vec3> =
        mesh.rest().iter().map(|v| Vec3::new(v.x + v.y * v.y, v.y, v.z * 2.0 - v.x)).collect();
    let targets = deformation_gradients(&mesh, &posed);
    let stitcher = Stitcher::new(&mesh, pin(&mesh, &[5]), &Job::default()).unwrap();
    let mut moved = vec![Vec3::ZERO; posed.len()];
    moved[5] = posed[5] - mesh.rest()[5];
    stitcher.solve(&mesh, &targets, &mut moved);
    for ((d, rest), expected) in moved.iter().zip(mesh.rest()).zip(&posed) {
        assert!((*rest + *d).distance(*expected) < 1e-10);
    }
}

/// Sumner & Popović's system: unknown vertices and one fourth vertex per triangle, rows
/// `sqrt(area) (V^-T x = C^T)`, solved densely.
fn with_fourth_vertices(mesh: &Mesh, targets: &[Mat3], pinned: usize, at: Vec3) -> Vec<Vec3> {
    let (n, m) = (mesh.rest().len(), mesh.triangles().len());
    let mut normal = faer::Mat::<f64>::zeros(n + m, n + m);
    let mut rhs = faer::Mat::<f64>::zeros(n + m, 3);
    for (t, (triangle, target)) in mesh.triangles().iter().zip(targets).enumerate() {
        let [a, b, c] = triangle.map(|v| mesh.rest()[v as usize]);
        let cross = (b - a).cross(c - a);
        let inverse = Mat3::from_cols(b - a, c - a, cross / cross.length().sqrt()).inverse();
        let rows = [inverse.row(0), inverse.row(1), inverse.row(2)];
        let nodes = [triangle[0] as usize, triangle[1] as usize, triangle[2] as usize, n + t];
        let weights = [-(rows[0] + rows[1] + rows[2]), rows[0], rows[1], rows[2]];
        let area = mesh.areas()[t];
        for (&i, wi) in nodes.iter().zip(weights) {
            for (&j, wj) in nodes.iter().zip(weights) {
                normal[(i, j)] += area * wi.dot(wj);
            }
            let asked = *target * wi;
            for axis in 0..3 {
                rhs[(i, axis)] += area * asked[axis];
            }
        }
    }
    for i in 0..n + m {
        for axis in 0..3 {
            rhs[(i, axis)] -= normal[(i, pinned)] * at[axis];
        }
    }
    for i in 0..n + m {
        normal[(i, pinned)] = 0.0;
        normal[(pinned, i)] = 0.0;
    }
    normal[(pinned, pinned)] = 1.0;
    for axis in 0..3 {
        rhs[(pinned, axis)] = at[axis];
    }
    let x = faer::linalg::solvers::Solve::solve(&normal.partial_piv_lu(), &rhs);
    (0..n).map(|i| Vec3::new(x[(i, 0)], x[(i, 1)], x[(i, 2)])).collect()
}

#[test]
fn fourth_vertices_drop_out_exactly() {
    let mesh = sheet(8);
    let mut next = numbers(3);
    let targets: Vec<Mat3> =
        mesh.triangles().iter().map(|_| Mat3::from_cols_array(&std::array::from_fn(|_| next()))).collect();
    let at = Vec3::new(0.4, -0.1, 0.2);
    let stitcher = Stitcher::new(&mesh, pin(&mesh, &[10]), &Job::default()).unwrap();
    let mut moved = vec![Vec3::ZERO; mesh.vertices().len()];
    moved[10] = at - mesh.rest()[10];
    stitcher.solve(&mesh, &targets, &mut moved);
    let expected = with_fourth_vertices(&mesh, &targets, 10, at);
    for ((d, rest), expected) in moved.iter().zip(mesh.rest()).zip(&expected) {
        assert!((*rest + *d).distance(*expected) < 1e-10);
    }
}

#[test]
fn soft_constraints_approach_hard_ones() {
    let mesh = sheet(12);
    let n = mesh.vertices().len();
    let targets = vec![Mat3::IDENTITY; mesh.triangles().len()];
    let lifted = Vec3::Z * 0.1;
    let mut hard = vec![Vec3::ZERO; n];
    hard[77] = lifted;
    Stitcher::new(&mesh, pin(&mesh, &[0, 77]), &Job::default()).unwrap().solve(&mesh, &targets, &mut hard);
    let soft = |weight: f64| {
        let constraints = pin(&mesh, &[0]).with_soft([(77, weight)]);
        let stitcher = Stitcher::new(&mesh, constraints, &Job::default()).unwrap();
        let mut x = vec![Vec3::ZERO; n];
        x[77] = lifted;
        stitcher.solve(&mesh, &targets, &mut x);
        x
    };
    let far = |a: &[Vec3]| a.iter().zip(&hard).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(far(&soft(1e8)) < 1e-8);
    assert!(far(&soft(1e2)) > far(&soft(1e4)));
}

#[test]
fn a_floating_component_is_an_error_not_a_panic() {
    let mesh = sheet(6);
    let free = Constraints::hard(mesh.vertices().len(), |_| false);
    match Stitcher::new(&mesh, free, &Job::default()) {
        // The regularised retry may stand on rounding; what counts is that it is finite then.
        Ok(stitcher) => {
            let mut moved = vec![Vec3::ZERO; mesh.vertices().len()];
            stitcher.solve(&mesh, &vec![Mat3::IDENTITY; mesh.triangles().len()], &mut moved);
            assert!(moved.iter().all(|d| d.is_finite()));
        }
        Err(error) => assert!(matches!(error, Error::SolveFailed(_))),
    }
}

#[test]
fn blocks_of_right_hand_sides_agree_with_single_ones() {
    let mesh = sheet(12);
    let mut next = numbers(9);
    let sets: Vec<Vec<Mat3>> = (0..5)
        .map(|_| mesh.triangles().iter().map(|_| Mat3::from_diagonal(Vec3::splat(next()))).collect())
        .collect();
    let stitcher = Stitcher::new(&mesh, pin(&mesh, &[3]), &Job::default()).unwrap();
    let n = mesh.vertices().len();
    let mut block = lissom::linear::Columns::zeros(n, 15);
    let mut rhs = lissom::linear::Columns::zeros(n, 15);
    for (set, columns) in sets.iter().zip(rhs.data_mut().chunks_mut(3 * n)) {
        let changes: Vec<Mat3> = set.iter().map(|&c| c - Mat3::IDENTITY).collect();
        stitcher.ask(&mesh, &changes, columns);
    }
    stitcher.system().solve(&rhs, &mut block);
    for (k, set) in sets.iter().enumerate() {
        let mut single = vec![Vec3::ZERO; n];
        stitcher.solve(&mesh, set, &mut single);
        for (a, b) in single.iter().zip(block.vectors(k)) {
            assert!(a.distance(b) < 1e-12);
        }
    }
}
