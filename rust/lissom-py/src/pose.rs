//! `lissom.Pose`.

use std::sync::{Arc, Mutex, PoisonError};

use lissom::Job;
use lissom::pose::{
    Handle, Hold, Info, METHODS, MethodOptions, Pose, Posed, Report, SolveOptions, arap, laplacian,
    laplacian_fitted, multiresolution, poisson, rotation_invariant, thin_shell,
};
use lissom::{Error, Fault, Vec3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::job::{PyJob, run_value};
use crate::mesh::PyMesh;
use crate::{arrays, errors, job};

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("POSE_METHODS", PyTuple::new(module.py(), METHODS)?)?;
    module.add_class::<PyPose>()?;
    module.add_class::<PyPosed>()?;
    module.add_function(wrap_pyfunction!(start_pose, module)?)
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

/// Keyword options, taken one by one; what is left over at the end was not asked for.
struct Options<'py> {
    method: String,
    given: Bound<'py, PyDict>,
    known: Vec<&'static str>,
}

impl<'py> Options<'py> {
    fn value<T: for<'a> FromPyObject<'a, 'py>>(&mut self, name: &'static str, default: T) -> PyResult<T> {
        self.known.push(name);
        match self.given.get_item(name)? {
            None => Ok(default),
            Some(value) => {
                self.given.del_item(name)?;
                let wrong = || PyTypeError::new_err(format!("{name}: cannot be {value:?}"));
                value.extract::<T>().map_err(|_| wrong())
            }
        }
    }

    fn choice<T: Copy>(&mut self, name: &'static str, kinds: &[(&str, T)]) -> PyResult<T> {
        let given = self.value(name, kinds[0].0.to_owned())?;
        arrays::choice(self.given.py(), name, &given, kinds)
    }

    /// Options that every method has.
    fn hold(&mut self) -> PyResult<Hold> {
        let soft = self.choice("constraints", &[("hard", false), ("soft", true)])?;
        let weight = self.value("weight", 1.0)?;
        Ok(if soft { Hold::Soft(weight) } else { Hold::Hard })
    }

    fn weights(&mut self, default: laplacian::Weights) -> PyResult<laplacian::Weights> {
        let mut kinds =
            [("cotangent", laplacian::Weights::Cotangent), ("uniform", laplacian::Weights::Uniform)];
        kinds.sort_by_key(|kind| kind.1 != default);
        self.choice("weights", &kinds)
    }

    /// The options of the method that `argument` names.
    fn method(&mut self, argument: &'static str, name: &str) -> PyResult<MethodOptions> {
        Ok(match name {
            "laplacian" => {
                let default = laplacian::Options::default();
                MethodOptions::Laplacian(laplacian::Options { weights: self.weights(default.weights)? })
            }
            "laplacian_fitted" => {
                let default = laplacian_fitted::Options::default();
                let weights = self.weights(default.weights)?;
                let scale = self.value("scale", default.scale)?;
                MethodOptions::LaplacianFitted(laplacian_fitted::Options { weights, scale })
            }
            "rotation_invariant" => {
                use rotation_invariant::{Frames, Interpolation};
                let frames = [("uniform", Frames::Uniform), ("principal", Frames::Principal)];
                let interpolation =
                    [("rotation_vector", Interpolation::RotationVector), ("matrix", Interpolation::Matrix)];
                MethodOptions::RotationInvariant(rotation_invariant::Options {
                    weights: self.weights(laplacian::Weights::Cotangent)?,
                    frames: self.choice("frames", &frames)?,
                    interpolation: self.choice("interpolation", &interpolation)?,
                    project: self.value("project", true)?,
                })
            }
            "thin_shell" => {
                let default = thin_shell::Options::default();
                MethodOptions::ThinShell(thin_shell::Options {
                    stretching: self.value("k_s", default.stretching)?,
                    bending: self.value("k_b", default.bending)?,
                    border: self.value("border", default.border)?,
                })
            }
            "poisson" => {
                let default = poisson::Options::default();
                MethodOptions::Poisson(poisson::Options { border: self.value("border", default.border)? })
            }
            "multiresolution" => {
                use multiresolution::{Details, Options};
                let default = Options::default();
                let details = [("gradients", Details::Gradients), ("offsets", Details::Offsets)];
                let smoothing = self.value("smoothing", default.smoothing)?;
                let details = self.choice("details", &details)?;
                let base: String = self.value("base", "poisson".to_owned())?;
                // All further options are the base's.
                let base = Box::new(self.method("base", &base)?);
                MethodOptions::Multiresolution(Options { base, smoothing, details })
            }
            "arap" => {
                let kinds =
                    [("spokes_and_rims", arap::Cells::SpokesAndRims), ("spokes", arap::Cells::Spokes)];
                MethodOptions::Arap(arap::Options {
                    cells: self.choice("cells", &kinds)?,
                    rotation_smoothing: self.value("rotation_smoothing", 0.0)?,
                    smoothness: self.value("smoothness", 0.0)?,
                })
            }
            other => {
                let problem = format!("no method named '{other}', there are {}", METHODS.join(", "));
                let error = Error::InvalidValue(Fault::new(argument, problem));
                return Err(errors::to_python(self.given.py(), error));
            }
        })
    }

    fn finish(self) -> PyResult<()> {
        let Some(name) = self.given.keys().iter().next() else { return Ok(()) };
        let (method, known) = (self.method, self.known.join(", "));
        Err(PyTypeError::new_err(format!("Pose: '{method}' has no option {name}; it has {known}")))
    }
}

/// A mesh with handles, ready to be posed again and again.
///
/// Pose(mesh, handles, roi=None, method="arap", handle_weights=None, **options): `handles` is a list of
/// 1-D vertex index arrays, one per handle; `roi` the indices of the vertices that may move, None for
/// all; `method` one of POSE_METHODS; `handle_weights`, if given, a list of one array per handle (or None)
/// of how much each of its vertices belongs to it, above 0 and at most 1. Binding factors the system;
/// solving is then quick.
///
/// Every method has constraints="hard" | "soft" and weight=1.0 (of soft constraints). Further options:
/// laplacian: weights="cotangent" | "uniform".
/// laplacian_fitted: weights="uniform" | "cotangent"; scale=True, whether details may grow as they turn.
/// thin_shell: k_s=1.0 and k_b=2.0, the resistance to stretching and to bending of a mesh whose box has the
/// diagonal 1; border=0 | 1 | 2, whether the free surface meets the rest in position, slope or curvature.
/// rotation_invariant: weights="cotangent" | "uniform" (the thesis), frames="uniform" | "principal",
/// interpolation="rotation_vector" | "matrix" (the thesis), project=True (matrices to rotations).
/// poisson: border=0 | 1 | 2, the order of smoothness of the blending weights.
/// multiresolution: base="poisson" or any other method, whose options may be given too; smoothing=0.2, the
/// wave length below which shape is detail, as a fraction of the diagonal; details="gradients" | "offsets".
/// arap: cells="spokes_and_rims" | "spokes"; rotation_smoothing=0.0, how much neighbours' rotations must
/// agree; smoothness=0.0, up to below 1, how much curvature counts against lengths (0.1 takes the spike off
/// a single moved vertex).
///
/// Raises InvalidConstraint for no or empty handles, a vertex in two handles, indices out of range and
/// an empty region, InvalidValue for an unknown method or option value, SolveFailed where the system
/// cannot be factored even with a little added to its diagonal, OutOfMemory where its factor does not fit in
/// what the machine has left, or in the environment variable LISSOM_MEMORY_LIMIT, in bytes.
#[pyclass(name = "Pose", module = "lissom", frozen)]
pub struct PyPose {
    pose: Arc<Mutex<Pose>>,
    info: Info,
    warnings: Vec<String>,
}

fn solve_options(
    py: Python<'_>,
    max_iterations: i64,
    tolerance: f64,
    warm_start: bool,
) -> PyResult<SolveOptions> {
    let max_iterations = arrays::count(py, "max_iterations", max_iterations)?;
    Ok(SolveOptions { max_iterations, tolerance, warm_start })
}

/// From arrays to a closure for a worker.
type Work<T> = Box<dyn FnOnce(&Job) -> lissom::Result<T> + Send>;

/// From the arguments of `Pose` to the work that binds one.
fn prepare(
    mesh: &Bound<'_, PyMesh>,
    handles: &Bound<'_, PyAny>,
    roi: Option<&Bound<'_, PyAny>>,
    method: &str,
    handle_weights: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Work<Pose>> {
    let py = mesh.py();
    let mut handles: Vec<Handle> =
        arrays::vertex_lists("handles", handles)?.into_iter().map(Handle::from).collect();
    if let Some(weights) = handle_weights {
        let lists = arrays::number_lists("handle_weights", weights)?;
        arrays::expect_length("handle_weights", lists.len(), handles.len())?;
        for (handle, list) in handles.iter_mut().zip(lists) {
            handle.membership = list;
        }
    }
    let roi = roi.map(|roi| arrays::vertex_list("roi", roi)).transpose()?;
    let given = options.map_or_else(|| Ok(PyDict::new(py)), |given| given.copy())?;
    let mut options = Options { method: method.to_owned(), given, known: Vec::new() };
    let (method, hold) = (options.method("method", method)?, options.hold()?);
    options.finish()?;
    let mesh = mesh.get().0.clone();
    Ok(Box::new(move |job| Pose::new(mesh, handles, roi.as_deref(), hold, &method, job)))
}

/// `Pose(...)` in the background: returns a Job whose result is the Pose.
#[pyfunction]
#[pyo3(signature = (mesh, handles, roi=None, method="arap", handle_weights=None, **options))]
fn start_pose(
    mesh: &Bound<'_, PyMesh>,
    handles: &Bound<'_, PyAny>,
    roi: Option<&Bound<'_, PyAny>>,
    method: &str,
    handle_weights: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyJob> {
    let convert = |py: Python<'_>, pose: Pose| Ok(Py::new(py, PyPose::from(pose))?.into_any());
    PyJob::start(prepare(mesh, handles, roi, method, handle_weights, options)?, convert)
}

impl From<Pose> for PyPose {
    fn from(pose: Pose) -> Self {
        Self { info: pose.info(), warnings: pose.warnings().to_vec(), pose: Arc::new(Mutex::new(pose)) }
    }
}

impl PyPose {
    fn by_transforms(
        &self,
        transforms: &Bound<'_, PyAny>,
        turns: Option<&Bound<'_, PyAny>>,
        options: SolveOptions,
    ) -> PyResult<Work<Posed>> {
        let transforms = arrays::matrices("transforms", transforms)?;
        let turns: Option<Vec<Vec3>> = turns.map(|turns| arrays::points("turns", turns)).transpose()?;
        let pose = self.pose.clone();
        Ok(Box::new(move |job| {
            let mut pose = pose.lock().unwrap_or_else(PoisonError::into_inner);
            pose.solve(&transforms, turns.as_deref(), &options, job)
        }))
    }

    fn by_points(&self, targets: &Bound<'_, PyAny>, options: SolveOptions) -> PyResult<Work<Posed>> {
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
    #[pyo3(signature = (mesh, handles, roi=None, method="arap", handle_weights=None, **options))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        handles: &Bound<'_, PyAny>,
        roi: Option<&Bound<'_, PyAny>>,
        method: &str,
        handle_weights: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let work = prepare(mesh, handles, roi, method, handle_weights, options)?;
        Ok(run_value(mesh.py(), work)?.into())
    }

    /// dict of what binding made, all systems of the method together: `unknowns`, `factor_nonzeros` (values
    /// kept, zeros that fill up blocks included), `factor_bytes` (with indices; what a solve reads twice) and
    /// `bind_seconds`.
    #[getter]
    fn info(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("unknowns", self.info.unknowns)?;
        dict.set_item("factor_nonzeros", self.info.nonzeros)?;
        dict.set_item("factor_bytes", self.info.bytes)?;
        dict.set_item("bind_seconds", self.info.seconds)?;
        Ok(dict.unbind())
    }

    /// list of str: what is doubtful about the mesh, the handles, the region and the system.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Poses by one affine matrix per handle.
    ///
    /// transforms (h, 4, 4): rest to posed, in the mesh's own units, acting on column vectors.
    /// turns (h, 3): rotation vectors (axis times angle, radians) that say by how many whole turns each
    /// handle rotates; a matrix alone says at most half a turn.
    /// Iterative methods stop after `max_iterations`, or when an iteration lowers the energy by less than
    /// the fraction `tolerance`; with `warm_start` they go on from the previous pose.
    ///
    /// Returns an object with `vertices` (n, 3) and `report`. Raises InvalidConstraint for a wrong number
    /// of matrices and for values that are not finite.
    #[pyo3(signature = (transforms, *, turns=None, max_iterations=200,
                        tolerance=1e-6, warm_start=true))]
    fn solve(
        &self,
        transforms: &Bound<'_, PyAny>,
        turns: Option<&Bound<'_, PyAny>>,
        max_iterations: i64,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<Py<PyAny>> {
        let work = self.by_transforms(
            transforms,
            turns,
            solve_options(transforms.py(), max_iterations, tolerance, warm_start)?,
        )?;
        job::run(transforms.py(), work, posed)
    }

    /// Poses by points: targets (k, 3), one row per handle vertex, handles in order.
    ///
    /// Each handle's rotation is estimated from its own vertices. Otherwise as `solve`.
    #[pyo3(signature = (targets, *, max_iterations=200,
                        tolerance=1e-6, warm_start=true))]
    fn solve_points(
        &self,
        targets: &Bound<'_, PyAny>,
        max_iterations: i64,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<Py<PyAny>> {
        let work =
            self.by_points(targets, solve_options(targets.py(), max_iterations, tolerance, warm_start)?)?;
        job::run(targets.py(), work, posed)
    }

    /// `solve` in the background: returns a Job at once.
    #[pyo3(signature = (transforms, *, turns=None, max_iterations=200,
                        tolerance=1e-6, warm_start=true))]
    fn start(
        &self,
        transforms: &Bound<'_, PyAny>,
        turns: Option<&Bound<'_, PyAny>>,
        max_iterations: i64,
        tolerance: f64,
        warm_start: bool,
    ) -> PyResult<PyJob> {
        let work = self.by_transforms(
            transforms,
            turns,
            solve_options(transforms.py(), max_iterations, tolerance, warm_start)?,
        )?;
        PyJob::start(work, posed)
    }
}
