//! Flat meshes of pictures, which Python and Blender call images.

use lissom::picture::{Alpha, PictureMesh, PictureMeshOptions, picture_mesh};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::PyJob;
use crate::{arrays, fields, options};

/// The job's result is a dict.
#[pyfunction]
pub fn start_image_mesh(alpha: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>) -> PyResult<PyJob> {
    let (width, values) = arrays::grid("alpha", alpha)?;
    let mut told = PictureMeshOptions::default();
    options::read("image_mesh", options, &mut [&mut told])?;
    let convert = |py: Python<'_>, mesh: PictureMesh| {
        let made = fields!(py, mesh; warnings);
        made.set_item("vertices", arrays::from_points(py, &mesh.vertices)?)?;
        made.set_item("triangles", arrays::from_triangles(py, &mesh.triangles)?)?;
        let uv = mesh.uv.concat();
        made.set_item("uv", arrays::from_channels(py, uv, &[mesh.uv.len(), 2])?)?;
        Ok(made.into_any().unbind())
    };
    PyJob::start(move |job| picture_mesh(Alpha { values: &values, width }, &told, job), convert)
}
