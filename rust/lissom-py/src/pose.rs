//! `lissom.Pose`.

use std::sync::{Arc, Mutex, PoisonError};

use lissom::Job;
use lissom::pose::{METHODS, Pose, Posed, Report, SolveOptions};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::job::{PyJob, run_value};
use crate::mesh::PyMesh;
use crate::{arrays, job};

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("POSE_METHODS", PyTuple::new(module.py(), METHODS)?)?;
    module.add_class::<PyPose>()?;
    module.add_class::<PyPosed>()
}

/// A posed mesh: `vertices` (n, 3) float64 in the mesh's own units, and `report`, a dict of
/// iterations, energy, converged, seconds and warnings.
#[pyclass(name = "Posed", module = "lissom", frozen, get_all)]
pub struct PyPosed {
    vertices: Py<PyAny>,
    report: Py<PyDict>,
}

fn report(py: Python<'_>, report: &Report) -> PyResult<Py<PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("iterations", report.iterations)?;
    dict.set_item("energy", report.energy)?;
    dict.set_item("converged", report.converged)?;
    dict.set_item("seconds", report.seconds)?;
    dict.set_item("warnings", &report.warnings)?;
    Ok(dict.unbind())
}

fn posed(py: Python<'_>, posed: Posed) -> PyResult<Py<PyAny>> {
    let vertices = arrays::from_points(py, &posed.vertices)?;
    let report = report(py, &posed.report)?;
    Ok(Py::new(py, PyPosed { vertices, report })?.into_any())
}

/// A mesh with handles, ready to be posed again and again.
///
/// Pose(mesh, handles, roi=None, method="arap"): `handles` is a list of 1-D vertex index arrays, one
/// per handle; `roi` the indices of the vertices that may move, None for all; `method` one of
/// POSE_METHODS. Binding factors the system; solving is then quick.
///
/// Raises InvalidConstraint for no or empty handles, a vertex in two handles, indices out of range and
/// an empty region, InvalidValue for an unknown method, SolveFailed where the system cannot be factored.
#[pyclass(name = "Pose", module = "lissom", frozen)]
pub struct PyPose {
    pose: Arc<Mutex<Pose>>,
    warnings: Vec<String>,
}

/// What the two ways to solve have in common: from arrays to a closure for a worker.
type Work = Box<dyn FnOnce(&Job) -> lissom::Result<Posed> + Send>;

impl PyPose {
    fn by_transforms(&self, transforms: &Bound<'_, PyAny>, options: SolveOptions) -> PyResult<Work> {
        let transforms = arrays::matrices("transforms", transforms)?;
        let pose = self.pose.clone();
        Ok(Box::new(move |job| {
            pose.lock().unwrap_or_else(PoisonError::into_inner).solve(&transforms, &options, job)
        }))
    }

    fn by_points(&self, targets: &Bound<'_, PyAny>, options: SolveOptions) -> PyResult<Work> {
        let targets = arrays::points("targets", targets)?;
        let pose = self.pose.clone();
        Ok(Box::new(move |job| {
            pose.lock().unwrap_or_else(PoisonError::into_inner).solve_points(&targets, &options, job)
        }))
    }
}

#[pymethods]
impl PyPose {
    #[new]
    #[pyo3(signature = (mesh, handles, roi=None, method="arap"))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        handles: &Bound<'_, PyAny>,
        roi: Option<&Bound<'_, PyAny>>,
        method: &str,
    ) -> PyResult<Self> {
        let handles = arrays::vertex_lists("handles", handles)?;
        let roi = roi.map(|roi| arrays::vertex_list("roi", roi)).transpose()?;
        let (shared, method) = (mesh.get().0.clone(), method.to_owned());
        let pose = run_value(mesh.py(), move |_| Pose::new(shared, handles, roi.as_deref(), &method))?;
        let warnings = pose.warnings().to_vec();
        Ok(Self { pose: Arc::new(Mutex::new(pose)), warnings })
    }

    /// list of str: what is doubtful about the mesh, the handles and the region.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Poses by one affine matrix per handle.
    ///
    /// transforms (h, 4, 4): rest to posed, in the mesh's own units, acting on column vectors.
    /// Iterative methods stop after `max_iterations`, or when an iteration lowers the energy by less than
    /// the fraction `tolerance`; with `warm_start` they go on from the previous pose.
    ///
    /// Returns an object with `vertices` (n, 3) and `report`. Raises InvalidConstraint for a wrong number
    /// of matrices and for values that are not finite.
    #[pyo3(signature = (transforms, *, max_iterations=SolveOptions::default().max_iterations,
                        tolerance=SolveOptions::default().tolerance, warm_start=true))]
    fn solve(
        &self,
        transforms: &Bound<'_, PyAny>,
        max_iterations: usize,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<Py<PyAny>> {
        let work = self.by_transforms(transforms, SolveOptions { max_iterations, tolerance, warm_start })?;
        job::run(transforms.py(), work, posed)
    }

    /// Poses by points: targets (k, 3), one row per handle vertex, handles in order.
    ///
    /// Each handle's rotation is estimated from its own vertices. Otherwise as `solve`.
    #[pyo3(signature = (targets, *, max_iterations=SolveOptions::default().max_iterations,
                        tolerance=SolveOptions::default().tolerance, warm_start=true))]
    fn solve_points(
        &self,
        targets: &Bound<'_, PyAny>,
        max_iterations: usize,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<Py<PyAny>> {
        let work = self.by_points(targets, SolveOptions { max_iterations, tolerance, warm_start })?;
        job::run(targets.py(), work, posed)
    }

    /// `solve` in the background: returns a Job at once.
    #[pyo3(signature = (transforms, *, max_iterations=SolveOptions::default().max_iterations,
                        tolerance=SolveOptions::default().tolerance, warm_start=true))]
    fn start(
        &self,
        transforms: &Bound<'_, PyAny>,
        max_iterations: usize,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<PyJob> {
        let work = self.by_transforms(transforms, SolveOptions { max_iterations, tolerance, warm_start })?;
        PyJob::start(work, posed)
    }
}
