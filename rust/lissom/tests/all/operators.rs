//! The operators against each other and against values worked out by hand.

use crate::common::{numbers, sheet};
use lissom::matrix::outer;
use lissom::operators::cotangent::cotangent_laplacian;
use lissom::operators::divergence::divergence;
use lissom::operators::gradient::deformation_gradients;
use lissom::operators::graph::graph_laplacian;
use lissom::operators::hat_gradients;
use lissom::operators::mass::lumped_mass;
use lissom::{Mat3, Mesh, Vec3};

#[test]
fn cotangent_laplacian_is_the_divergence_of_the_gradient() {
    let mesh = sheet(30);
    let hats = hat_gradients(&mesh);
    let mut next = numbers(1);
    let field: Vec<Vec3> = mesh.rest().iter().map(|_| Vec3::new(next(), next(), next())).collect();
    // grad x = sum_c x_c g_c^T / area, whose divergence is G^T M G x.
    let gradients: Vec<Mat3> = (mesh.triangles().iter().zip(&hats).zip(mesh.areas()))
        .map(|((t, g), &area)| (0..3).map(|c| outer(field[t[c] as usize], g[c])).sum::<Mat3>() * (1.0 / area))
        .collect();
    let expected = divergence(mesh.triangles(), &hats, &gradients, mesh.rest().len());
    let laplacian = cotangent_laplacian(&mesh);
    for axis in 0..3 {
        let column: Vec<f64> = field.iter().map(|v| v[axis]).collect();
        for (found, expected) in laplacian.times(&column).iter().zip(&expected) {
            assert!((found - expected[axis]).abs() < 1e-11);
        }
    }
}

#[test]
fn hand_computed_right_triangle() {
    // Legs of 1: half cotangents 0 (right angle) and 1/2, area 1/2; the box has diagonal sqrt 2.
    let mesh = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
    let rows: Vec<(u32, u32, f64)> = cotangent_laplacian(&mesh).entries().collect();
    let expected = [(0, 0, 1.0), (1, 0, -0.5), (2, 0, -0.5), (1, 1, 0.5), (2, 1, 0.0), (2, 2, 0.5)];
    for ((i, j, found), (k, l, value)) in rows.into_iter().zip(expected) {
        assert_eq!((i, j), (k, l));
        assert!((found - value).abs() < 1e-14);
    }
    assert!(lumped_mass(&mesh).iter().all(|m| (m - 0.25 / 3.0).abs() < 1e-14));
    let degrees: Vec<f64> = graph_laplacian(&mesh).entries().filter(|e| e.0 == e.1).map(|e| e.2).collect();
    assert_eq!(degrees, [2.0, 2.0, 2.0]);
}

#[test]
fn deformation_gradients_of_a_rotation_are_that_rotation() {
    let mesh = sheet(15);
    let rotation = lissom::rotation::exp(Vec3::new(0.3, -1.2, 2.0));
    let posed: Vec<Vec3> = mesh.rest().iter().map(|&v| rotation * v + Vec3::ONE).collect();
    for q in deformation_gradients(&mesh, &posed) {
        assert!((q - rotation).to_cols_array().iter().all(|x| x.abs() < 1e-10));
    }
}

#[test]
fn total_mass_is_total_area() {
    let mesh = sheet(25);
    let (mass, area) = (lumped_mass(&mesh).iter().sum::<f64>(), mesh.areas().iter().sum::<f64>());
    assert!((mass - area).abs() < 1e-12);
}
