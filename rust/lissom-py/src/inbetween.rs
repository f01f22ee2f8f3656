//! `lissom.Inbetween`.

use std::ffi::CString;
use std::sync::Arc;

use lissom::inbetween::{Inbetween, InbetweenOptions, Rotation, Stretch};
use lissom::{Job, Vec3};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::job::{PyJob, run_value};
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

type Work<T> = Box<dyn FnOnce(&Job) -> lissom::Result<T> + Send>;
type Convert = Box<dyn FnOnce(Python<'_>, Vec<Vec<Vec3>>) -> PyResult<Py<PyAny>> + Send>;

impl PyInbetween {
    fn work(&self, times: &Bound<'_, PyAny>) -> PyResult<(Work<Vec<Vec<Vec3>>>, Convert)> {
        let times = arrays::numbers("times", times)?;
        let (path, n) = (self.path.clone(), self.vertices);
        Ok((
            Box::new(move |job| path.at(&times, job)),
            Box::new(move |py, poses| arrays::from_poses(py, &poses, n)),
        ))
    }
}

/// The options of `Inbetween` as Python gives them.
struct Options<'a> {
    rotation: &'a str,
    stretch: &'a str,
    refinement: i64,
}

impl Options<'_> {
    fn read(&self, py: Python<'_>) -> PyResult<InbetweenOptions> {
        let rotations = [
            ("consistent", Rotation::Consistent),
            ("relative", Rotation::Relative),
            ("shortest", Rotation::Shortest),
        ];
        let stretches = [("linear", Stretch::Linear), ("logarithmic", Stretch::Logarithmic)];
        Ok(InbetweenOptions {
            rotation: arrays::choice(py, "rotation", self.rotation, &rotations)?,
            stretch: arrays::choice(py, "stretch", self.stretch, &stretches)?,
            refinement: arrays::count(py, "refinement", self.refinement)?,
        })
    }
}

/// From the arguments of `Inbetween` to the work that makes one.
fn prepare(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    options: &Options<'_>,
) -> PyResult<Work<Inbetween>> {
    let (start, end) = (arrays::points("start", start)?, arrays::points("end", end)?);
    let options = options.read(mesh.py())?;
    let mesh = mesh.get().0.clone();
    Ok(Box::new(move |job| Inbetween::new(mesh, &start, &end, options, job)))
}

/// `Inbetween(...)` in the background: returns a Job whose result is the Inbetween.
#[pyfunction]
#[pyo3(signature = (mesh, start, end, rotation="consistent", *, stretch="linear", refinement=0))]
pub fn start_inbetween(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    rotation: &str,
    stretch: &str,
    refinement: i64,
) -> PyResult<PyJob> {
    let options = Options { rotation, stretch, refinement };
    let vertices = mesh.get().0.vertices().len();
    let convert = move |py: Python<'_>, path| {
        Ok(Py::new(py, PyInbetween { path: Arc::new(path), vertices })?.into_any())
    };
    PyJob::start(prepare(mesh, start, end, &options)?, convert)
}

#[pymethods]
impl PyInbetween {
    #[new]
    #[pyo3(signature = (mesh, start, end, rotation="consistent", *, stretch="linear", refinement=0))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        rotation: &str,
        stretch: &str,
        refinement: i64,
    ) -> PyResult<Self> {
        let options = Options { rotation, stretch, refinement };
        let vertices = mesh.get().0.vertices().len();
        let path = run_value(mesh.py(), prepare(mesh, start, end, &options)?)?;
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
        let (work, convert) = self.work(times)?;
        job::run(times.py(), work, convert)
    }

    /// `at` in the background: returns a Job at once.
    fn start(&self, times: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        let (work, convert) = self.work(times)?;
        PyJob::start(work, convert)
    }

    /// The fewest times (k,), 0 and 1 among them, between which straight lines stay within `tolerance` (in
    /// the mesh's own units) of the path everywhere; at most `max_keys`, with a RuntimeWarning where these
    /// do not suffice.
    #[pyo3(signature = (tolerance, max_keys=32))]
    fn keyframes(&self, py: Python<'_>, tolerance: f64, max_keys: i64) -> PyResult<Py<PyAny>> {
        let max_keys = arrays::count(py, "max_keys", max_keys)?;
        let path = self.path.clone();
        let keys = run_value(py, move |job| path.keyframes(tolerance, max_keys, job))?;
        for warning in keys.warnings {
            let text = CString::new(warning)?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
        }
        Ok(numpy::PyArray1::from_vec(py, keys.times).into_any().unbind())
    }
}
