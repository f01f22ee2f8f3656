//! `lissom.Inbetween`.

use std::ffi::CString;
use std::sync::Arc;

use lissom::inbetween::{Inbetween, InbetweenOptions, Rotation};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::job::run_value;
use crate::mesh::PyMesh;
use crate::{arrays, job};

/// The as-rigid-as-possible path from one shape of a mesh to another.
///
/// Inbetween(mesh, start, end, rotation="consistent"): start and end (n, 3) in the mesh's own units;
/// `rotation` is "consistent", where neighbouring triangles turn together, so that twists beyond half a
/// turn come out whole, or "shortest", where each turns by at most half a turn. Only the triangles of the
/// mesh matter, not its positions (Alexa et al. 2000; Baxter et al. 2008).
///
/// Raises InvalidValue for shapes that are not finite or all of whose points lie on a line.
#[pyclass(name = "Inbetween", module = "lissom", frozen)]
pub struct PyInbetween {
    path: Arc<Inbetween>,
    vertices: usize,
}

#[pymethods]
impl PyInbetween {
    #[new]
    #[pyo3(signature = (mesh, start, end, rotation="consistent"))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        rotation: &str,
    ) -> PyResult<Self> {
        let py = mesh.py();
        let (start, end) = (arrays::points("start", start)?, arrays::points("end", end)?);
        let kinds = [("consistent", Rotation::Consistent), ("shortest", Rotation::Shortest)];
        let options = InbetweenOptions { rotation: arrays::choice(py, "rotation", rotation, &kinds)? };
        let mesh = mesh.get().0.clone();
        let vertices = mesh.vertices().len();
        let path = run_value(py, move |job| Inbetween::new(mesh, &start, &end, options, job))?;
        Ok(Self { path: Arc::new(path), vertices })
    }

    /// list of str: slivers, and triangles that turn over between start and end.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.path.warnings().to_vec()
    }

    /// Positions (t, n, 3) at times (t,) in 0-1; exactly `start` at 0 and `end` at 1.
    ///
    /// Raises InvalidValue for times that are not within 0 and 1.
    fn at(&self, times: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let py = times.py();
        let times = arrays::numbers("times", times)?;
        let (path, n) = (self.path.clone(), self.vertices);
        let convert = move |py: Python<'_>, poses: Vec<_>| arrays::from_poses(py, &poses, n);
        job::run(py, move |job| path.at(&times, job), convert)
    }

    /// The fewest times (k,), 0 and 1 among them, between which straight lines stay within `tolerance` (in
    /// the mesh's own units) of the path everywhere; at most `max_keys`, with a RuntimeWarning where these
    /// do not suffice.
    #[pyo3(signature = (tolerance, max_keys=32))]
    fn keyframes(&self, py: Python<'_>, tolerance: f64, max_keys: usize) -> PyResult<Py<PyAny>> {
        let path = self.path.clone();
        let keys = run_value(py, move |job| path.keyframes(tolerance, max_keys, job))?;
        for warning in keys.warnings {
            let text = CString::new(warning)?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
        }
        Ok(numpy::PyArray1::from_vec(py, keys.times).into_any().unbind())
    }
}
