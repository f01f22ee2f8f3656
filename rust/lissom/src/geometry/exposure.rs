//! Exposure: how much of the space in front of a surface is open, as ambient occlusion measures it (Zhukov, Iones & Kronin
//! 1998, An Ambient Light Illumination Model).

use super::surface::Surface;
use super::triangle::normal_and_area;
use crate::{Job, Result, Vec3};

/// Rays all around; half of them go to the outer side of a triangle.
const RAYS: usize = 64;

/// Cosine: flatter rays run along the surface, and meet the next bump whatever is there.
const FLAT: f64 = 0.1;

/// So far in front of a triangle its rays begin, in unit coordinates.
const OFF: f64 = 1e-5;

/// Of each triangle: the part of the rays from its centre to its outer side that nothing is in the way of, 0 to 1.
/// Vertices are in unit coordinates.
///
/// # Errors
///
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn exposures(vertices: &[Vec3], triangles: &[[u32; 3]], job: &Job) -> Result<Vec<f64>> {
    // A ray is stopped by either side of a triangle.
    let both: Vec<[u32; 3]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    let surface = Surface::of(&both, vertices);
    let rays = around();
    let exposure = |t: usize| {
        let corners = triangles[t].map(|v| vertices[v as usize]);
        let (normal, _) = normal_and_area(corners);
        let origin = (corners[0] + corners[1] + corners[2]) / 3.0 + OFF * normal;
        let outward = rays.iter().filter(|ray| ray.dot(normal) > FLAT);
        let [all, open] = outward.fold([0.0, 0.0], |[all, open], &ray| {
            [all + 1.0, open + f64::from(u8::from(surface.exit(origin, ray, |_| true).is_none()))]
        });
        open / f64::max(all, 1.0)
    };
    job.in_batches(triangles.len(), exposure)
}

/// Directions that are spread evenly (a spiral by the golden angle: Swinbank & Purser 2006, Fibonacci grids).
fn around() -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let ray = |k: usize| {
        let height = 1.0 - (2 * k + 1) as f64 / RAYS as f64;
        let (sine, cosine) = (golden * k as f64).sin_cos();
        let wide = (1.0 - height * height).sqrt();
        Vec3::new(wide * cosine, wide * sine, height)
    };
    (0..RAYS).map(ray).collect()
}
