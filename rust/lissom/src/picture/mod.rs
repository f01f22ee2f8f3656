//! A flat mesh of a picture: what its alpha leaves of the plane, in triangles that deform well.
//!
//! The outline is the contour of the alpha at a threshold (marching squares), simplified within a tolerance; it is
//! filled with a lattice of equilateral triangles and refined until no angle is small (Ruppert 1995; Chew 1989).
//! Triangulation and refinement are those of the crate `spade`, which one file knows.

mod alpha;
mod contour;
mod options;
mod simplify;
mod triangulate;

use glam::DVec2;

pub use alpha::Alpha;
pub use options::PictureMeshOptions;

use crate::options::OptionSet;
use crate::{Error, Fault, Job, Result, Vec3, memory};

/// Edges of the default length along the side of a square as large as the opaque area; none is less than a pixel.
const EDGES: f64 = 25.0;

/// A flat mesh and where its vertices are in the picture.
#[derive(Debug, Clone)]
pub struct PictureMesh {
    /// In pixels: x to the right and y up from the lower left corner of the picture, z = 0.
    pub vertices: Vec<Vec3>,
    /// Counterclockwise.
    pub triangles: Vec<[u32; 3]>,
    /// From the lower left corner (0, 0) to the upper right (1, 1).
    pub uv: Vec<[f64; 2]>,
    /// What was left out or is doubtful.
    pub warnings: Vec<String>,
}

/// The mesh of what is at least as opaque as the threshold.
///
/// Pixel (0, 0) is the upper left one; its value holds at its centre, and alpha is linear between. No angle is below
/// [`triangulate::ANGLE`] degrees but near tips of the outline that are sharper than 60.
///
/// # Errors
///
/// [`Error::InvalidValue`] for a picture without pixels, values that are not within 0-1, indexed row by row, options
/// out of range, and where nothing is opaque; [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn picture_mesh(alpha: Alpha<'_>, options: &PictureMeshOptions, job: &Job) -> Result<PictureMesh> {
    options.check()?;
    alpha.check()?;
    job.report(0.0, "Outline");
    let mut contours = contour::contours(alpha, options.threshold, job)?;
    if contours.is_empty() {
        let most = alpha.values.iter().copied().fold(0.0, f64::max);
        return Err(nothing(format!(
            "no pixel is as opaque as the threshold; the most opaque has {most:.3}"
        )));
    }
    let found = contours.len();
    contours.retain(|ring| area(ring).abs() >= options.smallest);
    let specks = found - contours.len();
    let opaque: f64 = contours.iter().map(|ring| area(ring)).sum();
    // Where an island is left out and what is in it is not, too.
    if opaque <= 0.0 {
        let smallest = options.smallest;
        return Err(nothing(format!("nothing opaque is as large as {smallest} square pixels")));
    }
    let mut warnings = Vec::new();
    if specks > 0 {
        let least = options.smallest;
        let what = if specks == 1 { "speck or hole" } else { "specks and holes" };
        warnings.push(format!("{specks} {what} of less than {least} square pixels left out"));
    }
    let edge = if options.edge > 0.0 { options.edge } else { (opaque.sqrt() / EDGES).max(1.0) };
    let points: usize = contours.iter().map(Vec::len).sum();
    memory::check("the triangles", triangulate::bytes(opaque, edge, points))?;

    job.part("Outline")?;
    let outlines = simplify::simplified(&contours, options.tolerance, job)?;
    job.part("Triangles")?;
    let mut mesh = triangulate::triangulated(&outlines, edge, job)?;
    if !mesh.complete {
        warnings
            .push("Some triangles are thinner than they should be: choose a larger edge or tolerance".into());
    }
    let size = DVec2::new(alpha.width as f64, alpha.height() as f64);
    // Points on the border are divided with rounding.
    mesh.points.iter_mut().for_each(|point| *point = point.clamp(DVec2::ZERO, size));
    Ok(PictureMesh {
        uv: mesh.points.iter().map(|&p| (p / size).to_array()).collect(),
        vertices: mesh.points.iter().map(|p| p.extend(0.0)).collect(),
        triangles: mesh.triangles,
        warnings,
    })
}

fn nothing(problem: String) -> Error {
    Error::InvalidValue(Fault::new("alpha", problem))
}

/// The signed area of a ring, positive where it goes counterclockwise.
fn area(ring: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    0.5 * ring.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}
