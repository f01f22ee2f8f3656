//! `lissom.Inbetween` and `lissom.Blend`.

use std::ffi::CString;
use std::sync::Arc;

use lissom::inbetween::{Blend, InbetweenOptions, Keyframes, Obstacle, Rotation, Route, Stretch};
use lissom::{Error, Fault, Job, Vec3};
use pyo3::exceptions::{PyRuntimeWarning, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::{PyJob, run_value};
use crate::mesh::PyMesh;
use crate::{arrays, errors, job};

/// The as-rigid-as-possible path from one shape of a mesh to another.
///
/// Inbetween(mesh, start, end, rotation="consistent", *, stretch="linear", refinement=0, through=(),
/// preserve_volume=False, clearance=None, clearance_end=None): start and end (n, 3) in the mesh's own units. Only the
/// triangles of the mesh matter, not its positions (Alexa et al. 2000; Baxter et al. 2008).
///
/// `rotation`: "consistent", where neighbouring triangles turn together, so that twists beyond half a turn come out whole;
/// "relative", where the turns between neighbours are interpolated and integrated, for several turns spread over a long
/// part; or "shortest", where each triangle turns by at most half a turn. `stretch`: "linear", or "logarithmic", by the same
/// factor in equal times. `refinement`: how many rounds of refitting the rotations to the stitched shape; lengths along
/// the path get two to four times better in 4 to 16. `through`: [(time, shape), ...] in ascending order, shapes to hit
/// exactly; speed may change there. `preserve_volume`: closed components keep theirs, in equal steps. `clearance`: a
/// closed Mesh in the same units that no vertex may enter deeper than at the deeper of its ends; `clearance_end` (k, 3),
/// where its vertices are at the end, if they move.
///
/// Raises InvalidValue for shapes that are not finite or all of whose points lie on a line.
#[pyclass(name = "Inbetween", module = "lissom", frozen)]
pub struct PyInbetween {
    path: Arc<Route>,
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

    fn keyframes_work(
        &self,
        py: Python<'_>,
        tolerance: Option<f64>,
        max_keys: i64,
        count: Option<i64>,
    ) -> PyResult<Work<Keyframes>> {
        let path = self.path.clone();
        match (tolerance, count) {
            (Some(tolerance), None) => {
                let max_keys = arrays::count(py, "max_keys", max_keys)?;
                Ok(Box::new(move |job| path.keyframes(tolerance, max_keys, job)))
            }
            (None, Some(count)) => {
                let count = arrays::count(py, "count", count)?;
                Ok(Box::new(move |job| path.keyframes_by_count(count, job)))
            }
            _ => Err(PyTypeError::new_err("keyframes: give either tolerance or count")),
        }
    }
}

/// The options of `Inbetween` as Python gives them, by name.
struct Options<'py>(Option<Bound<'py, PyDict>>);

const OPTIONS: [&str; 6] =
    ["stretch", "refinement", "through", "preserve_volume", "clearance", "clearance_end"];

impl<'py> Options<'py> {
    fn get(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(options) = &self.0 else { return Ok(None) };
        Ok(options.get_item(name)?.filter(|value| !value.is_none()))
    }

    fn read(&self, py: Python<'py>, rotation: &str) -> PyResult<InbetweenOptions> {
        for name in self.0.iter().flat_map(|options| options.keys()) {
            let name: String = name.extract()?;
            if !OPTIONS.contains(&name.as_str()) {
                let known = OPTIONS.join(", ");
                return Err(PyTypeError::new_err(format!("'{name}' is none of the options: {known}")));
            }
        }
        let rotations = [
            ("consistent", Rotation::Consistent),
            ("relative", Rotation::Relative),
            ("shortest", Rotation::Shortest),
        ];
        let stretches = [("linear", Stretch::Linear), ("logarithmic", Stretch::Logarithmic)];
        let stretch = match self.get("stretch")? {
            Some(given) => arrays::choice(py, "stretch", &given.extract::<String>()?, &stretches)?,
            None => Stretch::default(),
        };
        let refinement = match self.get("refinement")? {
            Some(given) => arrays::count(py, "refinement", given.extract()?)?,
            None => 0,
        };
        let preserve_volume = self.get("preserve_volume")?.map_or(Ok(false), |given| given.extract())?;
        let end = self.get("clearance_end")?.map(|p| arrays::points("clearance_end", &p)).transpose()?;
        let clearance = match self.get("clearance")? {
            Some(given) => {
                let mesh = given.cast::<PyMesh>().map_err(|_| {
                    PyTypeError::new_err("clearance: expected a lissom.Mesh, the surface to keep out of")
                })?;
                Some(Obstacle { mesh: mesh.get().0.clone(), end })
            }
            None if end.is_some() => {
                let problem = "needs clearance, the surface that it moves";
                return Err(errors::to_python(py, Error::InvalidValue(Fault::new("clearance_end", problem))));
            }
            None => None,
        };
        let rotation = arrays::choice(py, "rotation", rotation, &rotations)?;
        Ok(InbetweenOptions { rotation, stretch, refinement, preserve_volume, clearance })
    }

    fn through(&self) -> PyResult<Vec<(f64, Vec<Vec3>)>> {
        let Some(stops) = self.get("through")? else { return Ok(Vec::new()) };
        let expected =
            || PyTypeError::new_err("through: expected a list of (time, shape), shapes as (n, 3) arrays");
        let stop = |(k, item): (usize, PyResult<Bound<'py, PyAny>>)| {
            let (time, shape): (f64, Bound<'py, PyAny>) = item?.extract().map_err(|_| expected())?;
            Ok((time, arrays::points(&format!("through[{k}]"), &shape)?))
        };
        stops.try_iter().map_err(|_| expected())?.enumerate().map(stop).collect()
    }
}

/// From the arguments of `Inbetween` to the work that makes one.
fn prepare(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    rotation: &str,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Work<Route>> {
    let (start, end) = (arrays::points("start", start)?, arrays::points("end", end)?);
    let given = Options(options.cloned());
    let (options, through) = (given.read(mesh.py(), rotation)?, given.through()?);
    let mesh = mesh.get().0.clone();
    Ok(Box::new(move |job| Route::new(&mesh, &start, &end, &through, &options, job)))
}

/// `Inbetween(...)` in the background: returns a Job whose result is the Inbetween.
#[pyfunction]
#[pyo3(signature = (mesh, start, end, rotation="consistent", **options))]
pub fn start_inbetween(
    mesh: &Bound<'_, PyMesh>,
    start: &Bound<'_, PyAny>,
    end: &Bound<'_, PyAny>,
    rotation: &str,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyJob> {
    let vertices = mesh.get().0.vertices().len();
    let convert = move |py: Python<'_>, path| {
        Ok(Py::new(py, PyInbetween { path: Arc::new(path), vertices })?.into_any())
    };
    PyJob::start(prepare(mesh, start, end, rotation, options)?, convert)
}

#[pymethods]
impl PyInbetween {
    #[new]
    #[pyo3(signature = (mesh, start, end, rotation="consistent", **options))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        rotation: &str,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let vertices = mesh.get().0.vertices().len();
        let path = run_value(mesh.py(), prepare(mesh, start, end, rotation, options)?)?;
        Ok(Self { path: Arc::new(path), vertices })
    }

    /// list of str: slivers, triangles that turn over between start and end, mirrored or open components.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.path.warnings()
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

    /// The fewest times (k,), 0 and 1 and those of `through` among them, between which straight lines stay within
    /// `tolerance` (in the mesh's own units) of the path everywhere; at most `max_keys`, with a RuntimeWarning where these
    /// do not suffice. Or, given `count` instead, the `count` times with the least error; fewer where they do as well.
    #[pyo3(signature = (tolerance=None, max_keys=32, *, count=None))]
    fn keyframes(
        &self,
        py: Python<'_>,
        tolerance: Option<f64>,
        max_keys: i64,
        count: Option<i64>,
    ) -> PyResult<Py<PyAny>> {
        let keys = run_value(py, self.keyframes_work(py, tolerance, max_keys, count)?)?;
        for warning in keys.warnings {
            let text = CString::new(warning)?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
        }
        Ok(numpy::PyArray1::from_vec(py, keys.times).into_any().unbind())
    }

    /// `keyframes` in the background: returns a Job at once, whose result has `times` (k,) and `warnings`.
    #[pyo3(signature = (tolerance=None, max_keys=32, *, count=None))]
    fn start_keyframes(
        &self,
        py: Python<'_>,
        tolerance: Option<f64>,
        max_keys: i64,
        count: Option<i64>,
    ) -> PyResult<PyJob> {
        let convert = |py: Python<'_>, keys: Keyframes| {
            let times = numpy::PyArray1::from_vec(py, keys.times).into_any().unbind();
            Ok(Py::new(py, PyKeyframes { times, warnings: keys.warnings })?.into_any())
        };
        PyJob::start(self.keyframes_work(py, tolerance, max_keys, count)?, convert)
    }
}

/// Times of keys: `times` (k,) in 0-1, and `warnings`, where they do not suffice.
#[pyclass(name = "Keyframes", module = "lissom", frozen, get_all)]
pub struct PyKeyframes {
    times: Py<PyAny>,
    warnings: Vec<String>,
}

/// Several shapes of a mesh at once, as rigidly as possible, so that those that turn the same part do not collapse it.
///
/// Blend(mesh, start, shapes, *, refinement=0): start (n, 3) and shapes (k, n, 3) in the mesh's own units. Rotation vectors and
/// stretches of each triangle are combined linearly and stitched (compare Sumner et al. 2005).
///
/// Raises InvalidValue for shapes that are not finite or all of whose points lie on a line.
#[pyclass(name = "Blend", module = "lissom", frozen)]
pub struct PyBlend(Arc<Blend>);

#[pymethods]
impl PyBlend {
    #[new]
    #[pyo3(signature = (mesh, start, shapes, *, refinement=0))]
    fn new(
        mesh: &Bound<'_, PyMesh>,
        start: &Bound<'_, PyAny>,
        shapes: &Bound<'_, PyAny>,
        refinement: i64,
    ) -> PyResult<Self> {
        let py = mesh.py();
        let start = arrays::points("start", start)?;
        let shapes = arrays::poses("shapes", shapes, start.len())?;
        let refinement = arrays::count(py, "refinement", refinement)?;
        let mesh = mesh.get().0.clone();
        let blend = run_value(py, move |job| Blend::new(mesh, &start, &shapes, refinement, job))?;
        Ok(Self(Arc::new(blend)))
    }

    /// list of str: triangles that turn over between start and a shape.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings().to_vec()
    }

    /// Positions (n, 3) at weights (k,), any numbers: exactly `start` where all are zero, exactly a shape where its weight is
    /// one and the others zero.
    ///
    /// Raises InvalidValue for weights that are not finite or of another number.
    fn at(&self, weights: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let py = weights.py();
        let weights = arrays::numbers("weights", weights)?;
        let blend = self.0.clone();
        job::run(py, move |job| blend.at(&weights, job), |py, x| arrays::from_points(py, &x))
    }
}
