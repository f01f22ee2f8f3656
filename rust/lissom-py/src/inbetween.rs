//! Paths between shapes, their keys, and blends of shapes.

use std::sync::Arc;

use lissom::inbetween::{Blend, BlendOptions, InbetweenOptions, Keyframes, Route};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::PyJob;
use crate::mesh::PyMesh;
use crate::{arrays, fields, options};

/// A path.
#[pyclass(name = "Inbetween", module = "lissom._native", frozen)]
pub struct PyInbetween {
    path: Arc<Route>,
    vertices: usize,
}

/// Prepares a path: the job's result is an `Inbetween`.
#[pyfunction]
pub fn start_inbetween(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let (start, end) = (arrays::points("start", start)?, arrays::points("end", end)?);
    let mut told = InbetweenOptions::default();
    options::read("inbetween", options, &mut [&mut told])?;
    let through = std::mem::take(&mut told.through);
    let mesh = mesh.get().0.clone();
    let vertices = mesh.vertices().len();
    PyJob::start(
        move |job| Route::new(&mesh, &start, &end, &through, &told, job),
        move |py, path| Ok(Py::new(py, PyInbetween { path: Arc::new(path), vertices })?.into_any()),
    )
}

#[pymethods]
impl PyInbetween {
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.path.warnings()
    }

    /// The job's result is the positions.
    fn start_at(&self, times: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        let times = arrays::numbers("times", times)?;
        let (path, n) = (self.path.clone(), self.vertices);
        PyJob::start(move |job| path.at(&times, job), move |py, poses| arrays::from_poses(py, &poses, n))
    }

    /// The job's result is a dict.
    fn start_keyframes(
        &self,
        tolerance: Option<&Bound<'_, PyAny>>,
        max_keys: &Bound<'_, PyAny>,
        count: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyJob> {
        let path = self.path.clone();
        let convert = |py: Python<'_>, keys: Keyframes| {
            let keyframes = fields!(py, keys; error, warnings);
            keyframes.set_item("times", arrays::from_numbers(py, keys.times))?;
            Ok(keyframes.into_any().unbind())
        };
        match (tolerance, count) {
            (Some(tolerance), None) => {
                let tolerance = options::float("tolerance", tolerance)?;
                let max_keys = options::count("max_keys", max_keys)?;
                PyJob::start(move |job| path.keyframes(tolerance, max_keys, job), convert)
            }
            (None, Some(count)) => {
                let count = options::count("count", count)?;
                PyJob::start(move |job| path.keyframes_by_count(count, job), convert)
            }
            _ => Err(PyTypeError::new_err("keyframes: give either tolerance or count")),
        }
    }
}

/// Several shapes of a mesh at once.
#[pyclass(name = "Blend", module = "lissom._native", frozen)]
pub struct PyBlend(Arc<Blend>);

/// Prepares a blend: the job's result is a `Blend`.
#[pyfunction]
pub fn start_blend(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    shapes: &Bound<'_, PyAny>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let start = arrays::points("start", start)?;
    let shapes = arrays::poses("shapes", shapes, start.len())?;
    let mut told = BlendOptions::default();
    options::read("blend", options, &mut [&mut told])?;
    let mesh = mesh.get().0.clone();
    PyJob::start(
        move |job| Blend::new(mesh, &start, &shapes, told.refinement, job),
        |py, blend| Ok(Py::new(py, PyBlend(Arc::new(blend)))?.into_any()),
    )
}

#[pymethods]
impl PyBlend {
    #[getter]
    fn warnings(&self) -> &[String] {
        self.0.warnings()
    }

    /// The job's result is the positions.
    fn start_at(&self, weights: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        let weights = arrays::numbers("weights", weights)?;
        let blend = self.0.clone();
        PyJob::start(move |job| blend.at(&weights, job), |py, x| arrays::from_points(py, &x))
    }
}
