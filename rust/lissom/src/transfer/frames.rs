//! Frames: how the target's surface lies turned against the source's, place by place.
//!
//! ```text
//!     C' = R C R^T        R = the rotation of the map from the image of a triangle to the triangle
//! ```
//!
//! A brow that slopes otherwise is raised along its own slope. `R` is averaged over [`REACH`] by diffusion, weighted
//! by area, so that it follows the shape of the face and not the noise of the fit; the mean of rotations is the rotation
//! nearest to the mean of their matrices (Moakher 2002, Means and Averaging in the Group of Rotations).

use rayon::prelude::*;

use crate::rotation::nearest_rotation;
use crate::{Mat3, Mesh};

/// How far it is averaged, in unit coordinates.
const REACH: f64 = 0.05;

/// Most rounds of diffusion: very fine meshes are averaged over less.
const MOST_ROUNDS: f64 = 400.0;

/// `R` of every triangle of `target`, by the map from the image of each to it; `None` where there is no image.
pub fn rotations(target: &Mesh, maps: &[Option<Mat3>]) -> Vec<Mat3> {
    let triangles = target.triangles();
    // Sums of the matrices and of their weights spread alike, so that what has no image follows what is around it.
    let weigh = |(map, &area): (&Option<Mat3>, &f64)| {
        map.map_or((Mat3::ZERO, 0.0), |map| (nearest_rotation(map) * area, area))
    };
    let mut own: Vec<(Mat3, f64)> = maps.par_iter().zip(target.areas()).map(weigh).collect();
    let mean_area = target.area() / triangles.len() as f64;
    // Each round goes about the length of an edge.
    let rounds = (REACH * REACH / mean_area.max(f64::MIN_POSITIVE)).clamp(1.0, MOST_ROUNDS) as usize;
    let counts: Vec<f64> =
        (0..target.rest().len()).map(|v| target.adjacency().corners_of(v).len().max(1) as f64).collect();
    for _ in 0..rounds {
        let mut at = vec![(Mat3::ZERO, 0.0); target.rest().len()];
        for (corners, &(matrix, weight)) in triangles.iter().zip(&own) {
            for &v in corners {
                let (sum, weights) = at[v as usize];
                at[v as usize] = (sum + matrix, weights + weight);
            }
        }
        own = (triangles.par_iter())
            .map(|corners| {
                let third = corners.map(|v| 1.0 / (3.0 * counts[v as usize]));
                let [a, b, c] = corners.map(|v| at[v as usize]);
                (
                    a.0 * third[0] + b.0 * third[1] + c.0 * third[2],
                    a.1 * third[0] + b.1 * third[1] + c.1 * third[2],
                )
            })
            .collect();
    }
    let rotation = |&(sum, weight): &(Mat3, f64)| {
        if weight > 0.0 { nearest_rotation(sum * (1.0 / weight)) } else { Mat3::IDENTITY }
    };
    own.par_iter().map(rotation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::testing::bumpy_grid;
    use crate::{Vec3, rotation};

    #[test]
    fn one_turn_everywhere_is_that_turn_also_where_nothing_is_known() {
        let mesh = bumpy_grid(9);
        let turn = rotation::exp(Vec3::new(0.3, -0.2, 0.5));
        let maps: Vec<_> = (0..mesh.triangles().len()).map(|t| (t % 7 != 0).then_some(turn * 1.7)).collect();
        for found in rotations(&mesh, &maps) {
            assert!(rotation::log(found.transpose() * turn).length() < 1e-6);
        }
        assert!(rotations(&mesh, &vec![None; maps.len()]).iter().all(|&r| r == Mat3::IDENTITY));
    }
}
