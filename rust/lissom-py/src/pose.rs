//! Poses: bound, and solved by matrices or points.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use lissom::pose::{CommonOptions, Handle, MethodOptions, Pose, Posed, SolveOptions};
use lissom::{Error, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::{ELSEWHERE, PyJob};
use crate::mesh::PyMesh;
use crate::{arrays, errors, fields, options};

/// A pose that is bound.
#[pyclass(name = "Pose", module = "lissom._native", frozen)]
pub struct PyPose {
    pose: Arc<Mutex<Pose>>,
    /// The process that may use it; none where it was busy when that was forked, and waiting would be forever.
    process: Mutex<Option<u32>>,
    /// Unknowns, values and bytes of the factors, seconds.
    #[pyo3(get)]
    info: (usize, usize, usize, f64),
    #[pyo3(get)]
    warnings: Vec<String>,
}

/// Binds a pose: the job's result is a `Pose`.
#[pyfunction]
pub fn start_pose(
    mesh: &Bound<'_, PyMesh>,
    handles: &Bound<'_, PyAny>,
    roi: Option<&Bound<'_, PyAny>>,
    method: &Bound<'_, PyAny>,
    handle_weights: Option<&Bound<'_, PyAny>>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let handles = arrays::vertex_lists("handles", handles)?;
    let mut handles: Vec<Handle> = handles.into_iter().map(Handle::from).collect();
    if let Some(weights) = handle_weights {
        let lists = arrays::number_lists("handle_weights", weights)?;
        arrays::expect_length("handle_weights", lists.len(), handles.len())?;
        for (handle, list) in handles.iter_mut().zip(lists) {
            handle.membership = list;
        }
    }
    let roi = roi.map(|roi| arrays::vertex_list("roi", roi)).transpose()?;
    let method = &options::text("method", method)?;
    let mut bound = MethodOptions::named(method).map_err(errors::to_python)?;
    let mut common = CommonOptions::default();
    options::read(method, options, &mut [&mut bound, &mut common])?;
    let mesh = mesh.get().0.clone();
    PyJob::start(
        move |job| Pose::new(mesh, handles, roi.as_deref(), &common, &bound, job),
        |py, pose| {
            let info = pose.info();
            let info = (info.unknowns, info.nonzeros, info.bytes, info.seconds);
            let warnings = pose.warnings().to_vec();
            let process = Mutex::new(Some(std::process::id()));
            Ok(Py::new(py, PyPose { pose: Arc::new(Mutex::new(pose)), process, info, warnings })?.into_any())
        },
    )
}

fn solve_options(given: &Bound<'_, PyDict>) -> PyResult<SolveOptions> {
    let mut solve = SolveOptions::default();
    options::read("solve", given, &mut [&mut solve])?;
    Ok(solve)
}

/// (vertices, transforms, report)
fn posed(py: Python<'_>, posed: Posed) -> PyResult<Py<PyAny>> {
    let vertices = arrays::from_points(py, &posed.vertices)?;
    let rows = posed.transforms.iter().flat_map(|m| m.transpose().to_cols_array()).collect();
    let transforms = arrays::from_channels(py, rows, &[posed.transforms.len(), 4, 4])?;
    let report = fields!(py, posed.report; iterations, energy, converged, seconds, warnings);
    Ok((vertices, transforms, report).into_pyobject(py)?.into_any().unbind())
}

impl PyPose {
    /// The pose, to be locked on the thread of a job.
    fn shared(&self) -> PyResult<Arc<Mutex<Pose>>> {
        let mut process = self.process.lock().unwrap_or_else(PoisonError::into_inner);
        let own = std::process::id();
        if process.is_some_and(|process| process != own) {
            // The first use here: nobody of this process has locked it yet.
            *process = (!matches!(self.pose.try_lock(), Err(TryLockError::WouldBlock))).then_some(own);
        }
        let elsewhere = || errors::to_python(Error::SolveFailed(format!("the pose is {ELSEWHERE}")));
        process.map(|_| self.pose.clone()).ok_or_else(elsewhere)
    }
}

#[pymethods]
impl PyPose {
    fn start_solve(
        &self,
        transforms: &Bound<'_, PyAny>,
        turns: Option<&Bound<'_, PyAny>>,
        by_itself: Option<&Bound<'_, PyAny>>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<PyJob> {
        let options = solve_options(options)?;
        let transforms = arrays::matrices("transforms", transforms)?;
        let turns: Option<Vec<Vec3>> = turns.map(|turns| arrays::points("turns", turns)).transpose()?;
        let by_itself = by_itself.map(|handles| arrays::vertex_list("by_itself", handles)).transpose()?;
        let by_itself = by_itself.unwrap_or_default();
        let pose = self.shared()?;
        let work = move |job: &_| {
            let mut pose = pose.lock().unwrap_or_else(PoisonError::into_inner);
            pose.solve(&transforms, turns.as_deref(), &by_itself, &options, job)
        };
        PyJob::start(work, posed)
    }

    fn start_solve_points(&self, targets: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>) -> PyResult<PyJob> {
        let options = solve_options(options)?;
        let targets = arrays::points("targets", targets)?;
        let pose = self.shared()?;
        let work = move |job: &_| {
            pose.lock().unwrap_or_else(PoisonError::into_inner).solve_points(&targets, &options, job)
        };
        PyJob::start(work, posed)
    }
}
