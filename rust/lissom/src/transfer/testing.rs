//! Meshes for the tests of this module.

use crate::{Mesh, Vec3};

/// Positions and triangles of an n x n grid with hills, on about one unit.
pub fn grid(n: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let at = |i: usize, j: usize| {
        let (x, y) = (i as f64 / (n - 1) as f64, j as f64 / (n - 1) as f64);
        Vec3::new(x + 0.02 * (9.0 * y).sin(), y, 0.2 * (3.0 * x).sin() * (4.0 * y + 0.5).cos())
    };
    let vertices = (0..n * n).map(|v| at(v % n, v / n)).collect();
    let triangles = (0..(n - 1) * (n - 1))
        .flat_map(|cell| {
            let v = (cell / (n - 1) * n + cell % (n - 1)) as u32;
            let n = n as u32;
            [[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]
        })
        .collect();
    (vertices, triangles)
}

/// [`grid`] as a mesh.
pub fn bumpy_grid(n: usize) -> Mesh {
    let (vertices, triangles) = grid(n);
    Mesh::new(vertices, triangles).unwrap()
}

/// A sphere with a nose, as `rings` circles of `around` vertices between two poles.
pub fn nosed_sphere(rings: usize, around: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    use std::f64::consts::{PI, TAU};
    let nose = |p: Vec3| p * (1.0 + 0.5 * (4.0 * (p.x - 1.0)).exp());
    let mut vertices = vec![Vec3::Z];
    for i in 1..=rings {
        let polar = PI * i as f64 / (rings + 1) as f64;
        for j in 0..around {
            let azimuth = TAU * j as f64 / around as f64;
            let (sin, cos) = polar.sin_cos();
            vertices.push(nose(Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)));
        }
    }
    vertices.push(-Vec3::Z);
    let at = |ring: usize, j: usize| (1 + (ring - 1) * around + j % around) as u32;
    let south = (vertices.len() - 1) as u32;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        triangles.push([at(rings, j + 1), at(rings, j), south]);
        for ring in 1..rings {
            triangles.push([at(ring, j), at(ring + 1, j), at(ring + 1, j + 1)]);
            triangles.push([at(ring, j), at(ring + 1, j + 1), at(ring, j + 1)]);
        }
    }
    (vertices, triangles)
}
