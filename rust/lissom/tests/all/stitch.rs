//! The stitcher: exactness, and equality with the system of fourth vertices that it replaces.

use std::sync::Arc;

use crate::common::{numbers, sheet};
use lissom::linear::Constraints;
use lissom::matrix::{dot, norm_squared};
use lissom::operators::gradient::deformation_gradients;
use lissom::stitch::{AtRest, HatGradients, Owners, Reference, Stitcher, Weights, edge_weights, turned};
use lissom::{Job, Mat3, Mesh, Quat, Vec3, rotation};

fn pin(mesh: &Mesh, pinned: &[usize]) -> Constraints {
    Constraints::hard(mesh.vertices().len(), |v| pinned.contains(&v))
}

fn of_triangles(mesh: &Arc<Mesh>, constraints: Constraints) -> Stitcher {
    let (owners, weights) = (Owners::Triangles, Weights::Cotangent);
    Stitcher::new(mesh.clone(), owners, weights, None, constraints, &Job::default()).unwrap()
}

/// Displacements that match one target matrix per triangle.
fn stitched(stitcher: &Stitcher, targets: &[Mat3], mut displacements: Vec<Vec3>) -> Vec<Vec3> {
    let changes: Vec<Mat3> = targets.iter().map(|&c| c - Mat3::IDENTITY).collect();
    stitcher.stitch(Reference::Rest, &changes, &mut displacements);
    displacements
}

#[test]
fn identity_targets_move_nothing_to_the_last_bit() {
    let mesh = Arc::new(sheet(20));
    let stitcher = of_triangles(&mesh, pin(&mesh, &[0]));
    let targets = vec![Mat3::IDENTITY; mesh.triangles().len()];
    let moved = stitched(&stitcher, &targets, vec![Vec3::ZERO; mesh.vertices().len()]);
    assert!(moved.iter().all(|&d| d == Vec3::ZERO));
}

#[test]
fn targets_of_a_real_pose_give_that_pose() {
    let mesh = Arc::new(sheet(20));
    let posed: Vec<Vec3> =
        mesh.rest().iter().map(|v| Vec3::new(v.x + v.y * v.y, v.y, v.z * 2.0 - v.x)).collect();
    let targets = deformation_gradients(&mesh, &posed);
    let stitcher = of_triangles(&mesh, pin(&mesh, &[5]));
    let mut given = vec![Vec3::ZERO; posed.len()];
    given[5] = posed[5] - mesh.rest()[5];
    let moved = stitched(&stitcher, &targets, given);
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
    let mesh = Arc::new(sheet(8));
    let mut next = numbers(3);
    let targets: Vec<Mat3> =
        mesh.triangles().iter().map(|_| Mat3::from_cols_array(&std::array::from_fn(|_| next()))).collect();
    let at = Vec3::new(0.4, -0.1, 0.2);
    let stitcher = of_triangles(&mesh, pin(&mesh, &[10]));
    let mut given = vec![Vec3::ZERO; mesh.vertices().len()];
    given[10] = at - mesh.rest()[10];
    let moved = stitched(&stitcher, &targets, given);
    let expected = with_fourth_vertices(&mesh, &targets, 10, at);
    for ((d, rest), expected) in moved.iter().zip(mesh.rest()).zip(&expected) {
        assert!((*rest + *d).distance(*expected) < 1e-10);
    }
}

#[test]
fn soft_constraints_approach_hard_ones() {
    let mesh = Arc::new(sheet(12));
    let n = mesh.vertices().len();
    let targets = vec![Mat3::IDENTITY; mesh.triangles().len()];
    let lifted = Vec3::Z * 0.1;
    let mut given = vec![Vec3::ZERO; n];
    given[77] = lifted;
    let hard = stitched(&of_triangles(&mesh, pin(&mesh, &[0, 77])), &targets, given.clone());
    let soft = |weight: f64| {
        let constraints = pin(&mesh, &[0]).with_soft([(77, weight)]);
        stitched(&of_triangles(&mesh, constraints), &targets, given.clone())
    };
    let far = |a: &[Vec3]| a.iter().zip(&hard).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(far(&soft(1e8)) < 1e-8);
    assert!(far(&soft(1e2)) > far(&soft(1e4)));
}

#[test]
fn floating_components_are_pinned_and_told() {
    let sheet = sheet(6);
    let apart = |v: &Vec3| *v + Vec3::Z * 100.0;
    let vertices = [sheet.vertices().to_vec(), sheet.vertices().iter().map(apart).collect()].concat();
    let shifted = sheet.triangles().iter().map(|t| t.map(|v| v + 36));
    let triangles = sheet.triangles().iter().copied().chain(shifted).collect();
    let mesh = Arc::new(Mesh::new(vertices, triangles).unwrap());
    let stitcher = of_triangles(&mesh, pin(&mesh, &[3]));
    assert_eq!(stitcher.floating(), [(36..72).collect::<Vec<u32>>()]);
    let turn = rotation::exp(Vec3::new(0.2, 0.9, -0.4));
    let moved =
        stitched(&stitcher, &vec![turn; mesh.triangles().len()], vec![Vec3::ZERO; mesh.vertices().len()]);
    assert_eq!((moved[3], moved[36]), (Vec3::ZERO, Vec3::ZERO));
    for &[i, j] in mesh.adjacency().edges() {
        let edge = |x: &dyn Fn(usize) -> Vec3| x(j as usize) - x(i as usize);
        let expected = turn * edge(&|v| mesh.rest()[v]);
        assert!(edge(&|v| mesh.rest()[v] + moved[v]).distance(expected) < 1e-12);
    }
}

#[test]
fn covariances_are_the_adjoint_of_the_divergence() {
    let mesh = Arc::new(sheet(12));
    let (n, m) = (mesh.rest().len(), mesh.triangles().len());
    let mut next = numbers(4);
    let mut vector = || Vec3::new(next(), next(), next());
    let x: Vec<Vec3> = (0..n).map(|_| vector()).collect();
    let own: Vec<HatGradients> = (0..m)
        .map(|_| {
            let (a, b) = (vector(), vector());
            [a, b, -a - b]
        })
        .collect();
    let own = |t: usize| [own[t], [Vec3::ZERO; 3]];
    let factors: Vec<f64> = (0..m).map(|t| 1.0 + (t % 5) as f64).collect();
    let uniform = vec![1.0; mesh.adjacency().edges().len()];
    let stretched = Reference::Edges { hats: &own, base: &x };
    for (owners, weights, reference) in [
        (Owners::Triangles, Weights::Cotangent, Reference::Rest),
        (Owners::Triangles, Weights::Scaled(&factors), Reference::Rest),
        (Owners::Triangles, Weights::Cotangent, stretched),
        (Owners::Edges, Weights::Cotangent, Reference::Rest),
        (Owners::Edges, Weights::Edges(&uniform), Reference::Rest),
        (Owners::Corners, Weights::Cotangent, Reference::Rest),
        (Owners::Corners, Weights::Scaled(&factors), Reference::Rest),
    ] {
        let job = Job::default();
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, None, pin(&mesh, &[0]), &job).unwrap();
        let covariances = stitcher.covariances(reference, &x);
        let matrices: Vec<Mat3> =
            covariances.iter().map(|_| Mat3::from_cols(vector(), vector(), vector())).collect();
        let divergence = stitcher.divergence(reference, &matrices);
        let left: f64 = divergence.iter().zip(&x).map(|(d, x)| d.dot(*x)).sum();
        let right: f64 = matrices.iter().zip(&covariances).map(|(c, k)| dot(*c, *k)).sum();
        assert!((left - right).abs() < 1e-9 * right.abs().max(1.0), "{owners:?} {weights:?}: {left} {right}");
    }
}

/// `sum_t sum_e w_te |e(x) - C_te e(v)|^2`, edge by edge; `target(triangle, corner)` of the edge opposite.
fn energy(mesh: &Mesh, x: &[Vec3], target: impl Fn(usize, usize) -> Mat3) -> f64 {
    let at = |t: usize, c: usize| {
        let [i, j] = [(c + 1) % 3, (c + 2) % 3].map(|c| mesh.triangles()[t][c] as usize);
        let asked = target(t, c) * (mesh.rest()[j] - mesh.rest()[i]);
        mesh.half_cotangents()[t][c] * (x[j] - x[i] - asked).length_squared()
    };
    (0..mesh.triangles().len()).flat_map(|t| (0..3).map(move |c| (t, c))).map(|(t, c)| at(t, c)).sum()
}

#[test]
fn the_gradient_is_that_of_the_energy_summed_edge_by_edge() {
    let mesh = Arc::new(sheet(7));
    let (n, job, mut next) = (mesh.rest().len(), Job::default(), numbers(6));
    let mut vector = || Vec3::new(next(), next(), next());
    let d: Vec<Vec3> = (0..n).map(|_| vector() * 0.1).collect();
    for owners in [Owners::Triangles, Owners::Edges, Owners::Corners] {
        let count = if owners == Owners::Triangles { mesh.triangles().len() } else { n };
        let targets: Vec<Mat3> = (0..count).map(|_| rotation::exp(vector())).collect();
        let changes: Vec<Mat3> = targets.iter().map(|&r| r - Mat3::IDENTITY).collect();
        let target = |t: usize, c: usize| {
            let own = |c: usize| targets[mesh.triangles()[t][c % 3] as usize];
            match owners {
                Owners::Triangles => targets[t],
                Owners::Edges => (own(c + 1) + own(c + 2)) * 0.5,
                Owners::Corners => (own(c) + own(c + 1) + own(c + 2)) * (1.0 / 3.0),
            }
        };
        let weights = Weights::Cotangent;
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, None, pin(&mesh, &[]), &job).unwrap();
        let gradient = stitcher.gradient(Reference::Rest, &changes, &d, &d);
        let direction: Vec<Vec3> =
            (0..n)
                .map(|v| {
                    if stitcher.system().constraints().slot(v as u32).is_some() {
                        vector()
                    } else {
                        Vec3::ZERO
                    }
                })
                .collect();
        let along = |h: f64| {
            let x: Vec<Vec3> = (0..n).map(|v| mesh.rest()[v] + d[v] + direction[v] * h).collect();
            energy(&mesh, &x, target)
        };
        let expected = (along(1e-4) - along(-1e-4)) / 2e-4;
        let found = 2.0 * gradient.iter().zip(&direction).map(|(g, s)| g.dot(*s)).sum::<f64>();
        assert!((found - expected).abs() < 1e-7 * expected.abs().max(1.0), "{owners:?}: {found} {expected}");
    }
}

#[test]
fn the_local_step_finds_the_energy_of_the_rotations_that_it_picks() {
    let mesh = Arc::new(sheet(7));
    let (n, job, mut next) = (mesh.rest().len(), Job::default(), numbers(8));
    let d: Vec<Vec3> = (0..n).map(|_| Vec3::new(next(), next(), next()) * 0.05).collect();
    let x: Vec<Vec3> = mesh.rest().iter().zip(&d).map(|(&v, &d)| v + d).collect();
    let clamped: Vec<f64> = edge_weights(&mesh, mesh.half_cotangents()).iter().map(|w| w.max(0.0)).collect();
    for (owners, weights) in
        [(Owners::Corners, Weights::Cotangent), (Owners::Edges, Weights::Edges(&clamped))]
    {
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, None, pin(&mesh, &[0]), &job).unwrap();
        let local = stitcher.local_step(Reference::Rest, &d, |_, c| rotation::nearest_rotation(c));
        let r = |v: u32| Mat3::IDENTITY + local.changes[v as usize];
        let rigid = |w: f64, [i, j]: [u32; 2], r: Mat3| {
            let edge = |x: &[Vec3]| x[j as usize] - x[i as usize];
            w * (edge(&x) - r * edge(mesh.rest())).length_squared()
        };
        // Cell by cell, each with one rotation.
        let cells: f64 = match owners {
            Owners::Edges => (mesh.adjacency().edges().iter().zip(&clamped))
                .map(|(&e, &w)| rigid(w, e, r(e[0])) + rigid(w, e, r(e[1])))
                .sum(),
            _ => (0..mesh.triangles().len())
                .flat_map(|t| (0..9).map(move |k| (t, k / 3, k % 3)))
                .map(|(t, edge, owner)| {
                    let corners = mesh.triangles()[t];
                    let ends = [corners[(edge + 1) % 3], corners[(edge + 2) % 3]];
                    rigid(mesh.half_cotangents()[t][edge], ends, r(corners[owner]))
                })
                .sum(),
        };
        assert!((local.energy * owners.per_edge() - cells).abs() < 1e-10 * local.size, "{owners:?}");
    }
}

#[test]
fn torques_are_the_gradient_of_the_energy_by_the_rotations() {
    let mesh = Arc::new(sheet(7));
    let (n, job, mut next) = (mesh.rest().len(), Job::default(), numbers(10));
    let mut vectors =
        |size: f64| -> Vec<Vec3> { (0..n).map(|_| Vec3::new(next(), next(), next()) * size).collect() };
    let (d, turns, direction) = (vectors(0.1), vectors(2.0), vectors(1.0));
    let rotations: Vec<Quat> = turns.iter().map(|&turn| Quat::from_scaled_axis(turn)).collect();
    for owners in [Owners::Edges, Owners::Corners] {
        let weights = Weights::Cotangent;
        let stitcher = Stitcher::new(mesh.clone(), owners, weights, None, pin(&mesh, &[0]), &job).unwrap();
        let rest = stitcher.covariances(Reference::Rest, mesh.rest());
        let at = |rotations: &[Quat], smoothing: f64| {
            let at_rest = AtRest { covariances: &rest, smoothing, nearest: rotation::nearest_rotation };
            stitcher.turning(at_rest, rotations, &d, |_| (Mat3::ZERO, 0.0))
        };
        let matrix = |i: usize| Mat3::from_quat(rotations[i]);
        let local = stitcher.local_step(Reference::Rest, &d, |i, _| matrix(i));
        assert!((at(&rotations, 0.0).energy - local.energy).abs() < 1e-10 * local.size, "{owners:?}");
        let apart = |i: usize| {
            let neighbours = stitcher.neighbours(i);
            neighbours.map(|(j, w)| w.max(0.0) * norm_squared(matrix(i) - matrix(j))).sum::<f64>()
        };
        let smooth = 0.2 * (0..n).map(apart).sum::<f64>();
        let added = at(&rotations, 0.2).energy - at(&rotations, 0.0).energy;
        assert!((added - smooth).abs() < 1e-10 * smooth, "{owners:?}: {added} {smooth}");
        let along = |h: f64| at(&turned(&rotations, &direction, h), 0.2).energy;
        let expected = (along(1e-4) - along(-1e-4)) / 2e-4;
        let torques = at(&rotations, 0.2).torques;
        let found = 2.0 * torques.iter().zip(&direction).map(|(t, o)| t.dot(*o)).sum::<f64>();
        assert!((found - expected).abs() < 1e-6 * expected.abs(), "{owners:?}: {found} {expected}");
    }
}

#[test]
fn blocks_of_right_hand_sides_agree_with_single_ones() {
    let mesh = Arc::new(sheet(12));
    let mut next = numbers(9);
    let sets: Vec<Vec<Mat3>> = (0..5)
        .map(|_| mesh.triangles().iter().map(|_| Mat3::from_diagonal(Vec3::splat(next()))).collect())
        .collect();
    let stitcher = of_triangles(&mesh, pin(&mesh, &[3]));
    let n = mesh.vertices().len();
    let rhs: Vec<Vec<Vec3>> = (sets.iter())
        .map(|set| set.iter().map(|&c| c - Mat3::IDENTITY).collect::<Vec<_>>())
        .map(|changes| stitcher.divergence(Reference::Rest, &changes))
        .collect();
    let mut block = vec![vec![Vec3::ZERO; n]; sets.len()];
    stitcher.system().solve(&rhs, &mut block);
    for (set, found) in sets.iter().zip(&block) {
        let single = stitched(&stitcher, set, vec![Vec3::ZERO; n]);
        for (a, b) in single.iter().zip(found) {
            assert!(a.distance(*b) < 1e-12);
        }
    }
}
