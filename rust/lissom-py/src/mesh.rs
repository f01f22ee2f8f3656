//! `lissom.Mesh`.

use std::sync::Arc;

use lissom::Mesh;
use pyo3::prelude::*;

use crate::{arrays, job};

/// A triangle mesh, checked once.
///
/// Mesh(vertices, triangles): vertices (n, 3) float in any units, triangles (m, 3) integers counted
/// from 0. Raises InvalidMesh for no vertices or faces, values that are not finite, indices out of range
/// and points that are all coincident or on one line, and says in `warnings` what was mended or is doubtful.
#[pyclass(name = "Mesh", module = "lissom", frozen)]
pub struct PyMesh(pub Arc<Mesh>);

#[pymethods]
impl PyMesh {
    #[new]
    fn new(py: Python<'_>, vertices: &Bound<'_, PyAny>, triangles: &Bound<'_, PyAny>) -> PyResult<Self> {
        let vertices = arrays::points("vertices", vertices)?;
        let triangles = arrays::triangles("triangles", triangles)?;
        let mesh = job::run_value(py, move |_| Mesh::new(vertices, triangles))?;
        Ok(Self(Arc::new(mesh)))
    }

    /// (n, 3) float64: the positions as given.
    #[getter]
    fn vertices(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        arrays::from_points(py, self.0.vertices())
    }

    /// Length of the diagonal of the bounding box, in the mesh's own units.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.0.frame().scale
    }

    /// Number of connected components.
    #[getter]
    fn components(&self) -> usize {
        self.0.components().count()
    }

    /// list of str: what was mended or is doubtful.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        arrays::from_strings(py, self.0.warnings())
    }

    fn __repr__(&self) -> String {
        format!("lissom.Mesh({} vertices, {} triangles)", self.0.vertices().len(), self.0.triangles().len())
    }
}
