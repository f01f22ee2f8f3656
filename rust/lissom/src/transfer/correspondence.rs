//! Correspondence: which places of the source and of the target belong together, in both directions.

use super::image::SurfacePoint;
use crate::{Error, Fault, Mat3, Mesh, Result};

/// A vertex of the target on a curve that the source has too, and its place there: so far along an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// The target's vertex.
    pub vertex: u32,
    /// The ends of the source's edge, ...
    pub edge: [u32; 2],
    /// ... and how much of it lies before the place.
    pub fraction: f64,
}

/// What a fit finds, and all that a transfer needs; triangles as the input of the meshes counts them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Correspondence {
    /// Source triangle and target triangle; many to many.
    pub pairs: Vec<[u32; 2]>,
    /// Where each target vertex lies on the source; may be empty.
    pub images: Vec<Option<SurfacePoint>>,
    /// Where each source vertex lies on the target; may be empty.
    pub back_images: Vec<Option<SurfacePoint>>,
    /// The curves that were marked, each with its vertices on the target in turn.
    pub curves: Vec<Vec<CurvePoint>>,
    /// The rotation by which the target lies turned against the source: displacements are to be turned by it.
    pub turn: Mat3,
    /// The meshes lie on each other as they are: motions keep their size.
    pub overlap: bool,
    /// The target faces the other way than the source: one of the two is inside out.
    pub inside_out: bool,
}

impl Correspondence {
    /// Pairs of triangles alone, as Sumner & Popović (2004) have them.
    pub fn of_pairs(pairs: Vec<[u32; 2]>) -> Self {
        Self { pairs, ..Self::default() }
    }

    /// The same in terms of the triangles in use; what lies on triangles that a mesh left out is left out.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for no pairs, indices out of range and images of another number.
    pub fn in_use(&self, source: &Mesh, target: &Mesh) -> Result<Self> {
        let pairs = pairs_in_use(source, target, &self.pairs)?;
        let images = images_in_use(source, target, &self.images)?;
        let back_images = images_in_use(target, source, &self.back_images)?;
        let curves = self.curves.clone();
        Ok(Self { pairs, images, back_images, curves, ..*self })
    }
}

/// For each triangle of the input, its place among those in use.
fn places(mesh: &Mesh) -> Vec<Option<u32>> {
    let mut places = vec![None; mesh.input_triangles()];
    for (place, &id) in (0u32..).zip(mesh.triangle_ids()) {
        places[id as usize] = Some(place);
    }
    places
}

fn pairs_in_use(source: &Mesh, target: &Mesh, pairs: &[[u32; 2]]) -> Result<Vec<[u32; 2]>> {
    for (side, (name, mesh)) in [("source", source), ("target", target)].into_iter().enumerate() {
        let m = mesh.input_triangles();
        let outside = (0..pairs.len()).filter(|&i| pairs[i][side] as usize >= m);
        let problem = format!("{name} triangle out of range, the mesh has {m}");
        if let Some(fault) = Fault::at("pairs", problem, outside) {
            return Err(Error::InvalidConstraint(fault));
        }
    }
    let [of_source, of_target] = [places(source), places(target)];
    let place = |&[s, t]: &[u32; 2]| Some([of_source[s as usize]?, of_target[t as usize]?]);
    let used: Vec<[u32; 2]> = pairs.iter().filter_map(place).collect();
    if used.is_empty() {
        let fault = Fault::new("pairs", "no source triangle is matched with a target triangle");
        return Err(Error::InvalidConstraint(fault));
    }
    Ok(used)
}

/// `images` of the vertices of `of` on the triangles of `on`; none at all stand for each vertex having none.
fn images_in_use(on: &Mesh, of: &Mesh, images: &[Option<SurfacePoint>]) -> Result<Vec<Option<SurfacePoint>>> {
    if images.is_empty() {
        return Ok(vec![None; of.vertices().len()]);
    }
    if images.len() != of.vertices().len() {
        let problem = format!("{} for a mesh of {} vertices", images.len(), of.vertices().len());
        return Err(Error::InvalidConstraint(Fault::new("images", problem)));
    }
    let m = on.input_triangles();
    let outside = (0..images.len()).filter(|&v| images[v].is_some_and(|image| image.triangle as usize >= m));
    if let Some(fault) = Fault::at("images", format!("triangle out of range, the mesh has {m}"), outside) {
        return Err(Error::InvalidConstraint(fault));
    }
    let places = places(on);
    let used = |image: &Option<SurfacePoint>| {
        let image = (*image)?;
        places[image.triangle as usize].map(|triangle| SurfacePoint { triangle, ..image })
    };
    Ok(images.iter().map(used).collect())
}
