//! Small meshes and repeatable numbers for the tests.

use lissom::{Mesh, Vec3};

/// A repeatable stream of numbers in (-1, 1) (xorshift).
pub fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A bumpy open sheet of `side` x `side` vertices with irregular triangles.
pub fn sheet(side: u32) -> Mesh {
    let mut next = numbers(7);
    let vertices = (0..side * side)
        .map(|i| {
            let (x, y) = (f64::from(i % side), f64::from(i / side));
            Vec3::new(x + 0.3 * next(), y + 0.3 * next(), 2.0 * (0.5 * x).sin() + 0.2 * next())
        })
        .collect();
    let triangles = (0..side - 1)
        .flat_map(|y| (0..side - 1).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| (y + j) * side + x + i);
            if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect();
    Mesh::new(vertices, triangles).unwrap()
}
