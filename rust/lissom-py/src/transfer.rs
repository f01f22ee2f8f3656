//! `lissom.fit_correspondence`, `lissom.start_fit`, `lissom.Transfer`.

use std::sync::Arc;

use lissom::transfer::{
    Correspondence, Fit, FitOptions, FitReport, Image, KeyQuality, Transfer, TransferOptions, Transferred,
    Unmatched, Weighting, fit_correspondence as fit,
};
use lissom::{Error, Fault, Job, Mesh, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::choice;
use crate::job::{PyJob, run_value};
use crate::mesh::PyMesh;
use crate::{arrays, job};

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyFit>()?;
    module.add_class::<PyTransfer>()?;
    module.add_class::<PyTransferred>()?;
    module.add_function(wrap_pyfunction!(fit_correspondence, module)?)?;
    module.add_function(wrap_pyfunction!(start_fit, module)?)?;
    module.add_function(wrap_pyfunction!(start_transfer, module)?)
}

/// A source pulled onto a target: `pairs` (p, 2) of source and target triangle; `image_triangles` (n_target,)
/// and `image_weights` (n_target, 3), where each target vertex lies on the source, -1 where nowhere;
/// `fitted_vertices` (n_source, 3) in the target's units, and `report`, a dict.
///
/// How good it is where: `distances` (n_source,) of the fitted vertices to the target and `image_distances`
/// (n_target,) of the target's vertices to their images, in the target's units, NaN where there is nothing;
/// `stretch` (m_source,), how much longer or narrower than the usual one each fitted triangle is, at least 1;
/// `flipped` (f,), the source triangles that face against the target.
#[pyclass(name = "Fit", module = "lissom", frozen)]
pub struct PyFit {
    #[pyo3(get)]
    pairs: Py<PyAny>,
    #[pyo3(get)]
    image_triangles: Py<PyAny>,
    #[pyo3(get)]
    image_weights: Py<PyAny>,
    matches: Correspondence,
    /// What it was made for.
    meshes: [Arc<Mesh>; 2],
    #[pyo3(get)]
    fitted_vertices: Py<PyAny>,
    #[pyo3(get)]
    distances: Py<PyAny>,
    #[pyo3(get)]
    image_distances: Py<PyAny>,
    #[pyo3(get)]
    stretch: Py<PyAny>,
    #[pyo3(get)]
    flipped: Py<PyAny>,
    #[pyo3(get)]
    report: Py<PyDict>,
}

fn report(py: Python<'_>, report: &FitReport) -> PyResult<Py<PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("distance_mean", report.distance_mean)?;
    dict.set_item("distance_max", report.distance_max)?;
    dict.set_item("distance_mean_percent", report.distance_mean_percent)?;
    dict.set_item("distance_max_percent", report.distance_max_percent)?;
    dict.set_item("flipped_triangles", report.flipped_triangles)?;
    dict.set_item("stretched_triangles", report.stretched_triangles)?;
    dict.set_item("unmatched_source_triangles", report.unmatched_source_triangles)?;
    dict.set_item("unmatched_target_triangles", report.unmatched_target_triangles)?;
    dict.set_item("unmatched_source_percent", report.unmatched_source_percent)?;
    dict.set_item("unmatched_target_percent", report.unmatched_target_percent)?;
    dict.set_item("rounds", report.rounds)?;
    dict.set_item("seconds", report.seconds)?;
    dict.set_item("warnings", &report.warnings)?;
    Ok(dict.unbind())
}

fn fitted(meshes: [Arc<Mesh>; 2]) -> impl FnOnce(Python<'_>, Fit) -> PyResult<Py<PyAny>> {
    move |py, fit| made(py, fit, meshes)
}

fn made(py: Python<'_>, fit: Fit, meshes: [Arc<Mesh>; 2]) -> PyResult<Py<PyAny>> {
    let pairs = arrays::from_pairs(py, &fit.matches.pairs)?;
    let images = &fit.matches.images;
    let triangle = |image: &Option<Image>| image.map_or(-1, |image| i64::from(image.triangle));
    let image_triangles = arrays::from_integers(py, images.iter().map(triangle));
    let weights: Vec<Vec3> = images.iter().map(|i| i.map_or(Vec3::ZERO, |i| i.weights)).collect();
    let image_weights = arrays::from_points(py, &weights)?;
    let made = PyFit {
        pairs,
        image_triangles,
        image_weights,
        fitted_vertices: arrays::from_points(py, &fit.fitted_vertices)?,
        distances: arrays::from_numbers(py, fit.distances),
        image_distances: arrays::from_numbers(py, fit.image_distances),
        stretch: arrays::from_numbers(py, fit.stretch),
        flipped: arrays::from_integers(py, fit.flipped.into_iter().map(i64::from)),
        report: report(py, &fit.report)?,
        matches: fit.matches,
        meshes,
    };
    Ok(Py::new(py, made)?.into_any())
}

type Work<T> = Box<dyn FnOnce(&Job) -> lissom::Result<T> + Send>;

fn fit_work(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    markers: &Bound<'_, PyAny>,
    options: FitOptions,
) -> PyResult<Work<Fit>> {
    let markers = arrays::pairs("markers", markers)?;
    let (source, target) = (source.get().0.clone(), target.get().0.clone());
    Ok(Box::new(move |job| fit(&source, &target, &markers, &options, job)))
}

fn mask(name: &str, vertices: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<u32>> {
    vertices.map_or(Ok(Vec::new()), |vertices| arrays::vertex_list(name, vertices))
}

/// Pulls `source` onto `target` and matches their triangles (Sumner & Popović 2004).
///
/// markers (k, 2): vertex of the source, vertex of the target that belongs to it. points (k, 3): where on the
/// target the source's vertices belong, in its units, where that is not at its vertices.
/// smoothness, identity, closest: the weights w_S, w_I and the largest w_C of the three terms; w_C rises
/// from 0 through `steps` weights, with `rounds` rounds of closest points at each. match_distance: how
/// far the centroid of a triangle may be from the other surface to have a match, as a fraction of the
/// target's diagonal. Meshes of the same triangles need no markers: with none, each vertex belongs to its like.
/// source_mask, target_mask (k,): vertices that match nothing, as the inside of a mouth.
///
/// Returns a Fit. Raises InvalidConstraint for no markers, indices out of range and vertices marked
/// twice, InvalidValue for options out of range.
#[pyfunction]
#[pyo3(signature = (source, target, markers, points=None, *, smoothness=1.0, identity=0.001, closest=5000.0, steps=6,
                    rounds=4, match_distance=0.02, source_mask=None, target_mask=None))]
#[expect(clippy::too_many_arguments, reason = "each is an option of the Python function")]
fn fit_correspondence(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    markers: &Bound<'_, PyAny>,
    points: Option<&Bound<'_, PyAny>>,
    smoothness: f64,
    identity: f64,
    closest: f64,
    steps: i64,
    rounds: i64,
    match_distance: f64,
    source_mask: Option<&Bound<'_, PyAny>>,
    target_mask: Option<&Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let py = source.py();
    let (steps, rounds) = (arrays::count(py, "steps", steps)?, arrays::count(py, "rounds", rounds)?);
    let points = points.map_or(Ok(Vec::new()), |points| arrays::points("points", points))?;
    let (source_mask, target_mask) = (mask("source_mask", source_mask)?, mask("target_mask", target_mask)?);
    let options = FitOptions {
        smoothness,
        identity,
        closest,
        steps,
        rounds,
        points,
        source_mask,
        target_mask,
        match_distance,
    };
    job::run(
        source.py(),
        fit_work(source, target, markers, options)?,
        fitted([source, target].map(|mesh| mesh.get().0.clone())),
    )
}

/// `fit_correspondence` in the background: returns a Job at once.
#[pyfunction]
#[pyo3(signature = (source, target, markers, points=None, *, smoothness=1.0, identity=0.001, closest=5000.0, steps=6,
                    rounds=4, match_distance=0.02, source_mask=None, target_mask=None))]
#[expect(clippy::too_many_arguments, reason = "each is an option of the Python function")]
fn start_fit(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    markers: &Bound<'_, PyAny>,
    points: Option<&Bound<'_, PyAny>>,
    smoothness: f64,
    identity: f64,
    closest: f64,
    steps: i64,
    rounds: i64,
    match_distance: f64,
    source_mask: Option<&Bound<'_, PyAny>>,
    target_mask: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyJob> {
    let py = source.py();
    let (steps, rounds) = (arrays::count(py, "steps", steps)?, arrays::count(py, "rounds", rounds)?);
    let points = points.map_or(Ok(Vec::new()), |points| arrays::points("points", points))?;
    let (source_mask, target_mask) = (mask("source_mask", source_mask)?, mask("target_mask", target_mask)?);
    let options = FitOptions {
        smoothness,
        identity,
        closest,
        steps,
        rounds,
        points,
        source_mask,
        target_mask,
        match_distance,
    };
    PyJob::start(
        fit_work(source, target, markers, options)?,
        fitted([source, target].map(|mesh| mesh.get().0.clone())),
    )
}

/// Shapes carried over: `vertices` (k, n_target, 3) float64 in the target's units, and `report`, a dict: the
/// "seconds" it took and how many "solve_seconds" of them went into back-substitution.
#[pyclass(name = "Transferred", module = "lissom", frozen, get_all)]
pub struct PyTransferred {
    vertices: Py<PyAny>,
    report: Py<PyDict>,
}

fn transferred(target: Arc<Mesh>) -> impl FnOnce(Python<'_>, Transferred) -> PyResult<Py<PyAny>> {
    move |py, result| {
        let vertices = arrays::from_poses(py, &result.poses, target.vertices().len())?;
        let report = PyDict::new(py);
        report.set_item("seconds", result.time.as_secs_f64())?;
        report.set_item("solve_seconds", result.solve_time.as_secs_f64())?;
        Ok(Py::new(py, PyTransferred { vertices, report: report.unbind() })?.into_any())
    }
}

/// A prepared transfer from one mesh to another; factored once, for any number of keys.
///
/// Transfer(source, target, fit, *, unmatched="follow", weighting="area", anchor=1.0, contact=False): `fit` is a
/// Fit, or a (p, 2) array of source and target triangles. `unmatched` says what components of the target without a match
/// do: "follow" the nearest matched surface rigidly, or "rest". `weighting` counts each target triangle by
/// its "area", or by its number of matches ("pairs", as the paper does). `anchor`, a length as a fraction of the
/// target's diagonal: below it gradients rule, beyond it displacements; lower suits shapes that are much alike.
/// `contact`: where surfaces of the source come together in a key, as lids do in a blink, those of the target do,
/// and slide around closed convex parts, as eyes are. A Fit made for meshes of other faces is refused.
///
/// Raises InvalidConstraint for no pairs or indices out of range, SolveFailed.
#[pyclass(name = "Transfer", module = "lissom", frozen)]
pub struct PyTransfer(Arc<Transfer>);

impl PyTransfer {
    fn work(&self, poses: &Bound<'_, PyAny>) -> PyResult<Work<Transferred>> {
        let poses = arrays::poses("poses", poses, self.0.source().vertices().len())?;
        let transfer = self.0.clone();
        Ok(Box::new(move |job| transfer.apply(&poses, job)))
    }

    fn quality_work(
        &self,
        poses: &Bound<'_, PyAny>,
        vertices: &Bound<'_, PyAny>,
    ) -> PyResult<Work<Vec<KeyQuality>>> {
        let poses = arrays::poses("poses", poses, self.0.source().vertices().len())?;
        let vertices = arrays::poses("vertices", vertices, self.0.target().vertices().len())?;
        let transfer = self.0.clone();
        Ok(Box::new(move |job| transfer.quality(&poses, &vertices, job)))
    }
}

#[pymethods]
impl PyTransfer {
    #[new]
    #[pyo3(signature = (source, target, fit, *, unmatched="follow", weighting="area", anchor=1.0, contact=false))]
    fn new(
        source: &Bound<'_, PyMesh>,
        target: &Bound<'_, PyMesh>,
        fit: &Bound<'_, PyAny>,
        unmatched: &str,
        weighting: &str,
        anchor: f64,
        contact: bool,
    ) -> PyResult<Self> {
        let work = prepare(source, target, fit, unmatched, weighting, anchor, contact)?;
        Ok(Self(Arc::new(run_value(source.py(), work)?)))
    }

    /// list of str: what is doubtful about the matches.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings().to_vec()
    }

    /// Carries poses (k, n_source, 3) over; returns an object with `vertices` (k, n_target, 3).
    ///
    /// Raises InvalidValue for values that are not finite, SolveFailed on overflow.
    fn apply(&self, poses: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        job::run(poses.py(), self.work(poses)?, transferred(self.0.target().clone()))
    }

    /// `apply` in the background: returns a Job at once.
    fn start(&self, poses: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        PyJob::start(self.work(poses)?, transferred(self.0.target().clone()))
    }

    /// What there is to say about `vertices` (k, n_target, 3), which `apply` has made of `poses` (k, n_source, 3).
    ///
    /// Returns a dict of (k,) arrays, 0 where a pose is the rest: `residual`, how far from the gradients asked
    /// for the result is, relative to them; `flipped_triangles`, target triangles that face against theirs;
    /// `contacts`, target vertices whose images meet another surface, and `contact_gap`, how much wider than
    /// on the source their mean distance is, in percent of the target's diagonal; `round_trip`, the root mean
    /// square error of carrying `vertices` back, relative to the displacement of the pose; `motion`, the largest
    /// displacement, in percent of the target's diagonal.
    ///
    /// Raises InvalidValue for values that are not finite or another number of poses, SolveFailed.
    fn quality(&self, poses: &Bound<'_, PyAny>, vertices: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        job::run(poses.py(), self.quality_work(poses, vertices)?, qualities)
    }

    /// `quality` in the background: returns a Job at once.
    fn start_quality(&self, poses: &Bound<'_, PyAny>, vertices: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        PyJob::start(self.quality_work(poses, vertices)?, qualities)
    }
}

fn qualities(py: Python<'_>, keys: Vec<KeyQuality>) -> PyResult<Py<PyAny>> {
    let numbers = |of: fn(&KeyQuality) -> f64| arrays::from_numbers(py, keys.iter().map(of));
    let counts = |of: fn(&KeyQuality) -> usize| arrays::from_integers(py, keys.iter().map(|k| of(k) as i64));
    let dict = PyDict::new(py);
    dict.set_item("residual", numbers(|key| key.residual))?;
    dict.set_item("flipped_triangles", counts(|key| key.flipped_triangles))?;
    dict.set_item("contacts", counts(|key| key.contacts))?;
    dict.set_item("contact_gap", numbers(|key| key.contact_gap))?;
    dict.set_item("round_trip", numbers(|key| key.round_trip))?;
    dict.set_item("motion", numbers(|key| key.motion))?;
    Ok(dict.into_any().unbind())
}

/// From the arguments of `Transfer` to the work that makes one.
fn prepare(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    fit: &Bound<'_, PyAny>,
    unmatched: &str,
    weighting: &str,
    anchor: f64,
    contact: bool,
) -> PyResult<Work<Transfer>> {
    let py = source.py();
    let (source, target) = (source.get().0.clone(), target.get().0.clone());
    let (matches, fits) = match fit.cast::<PyFit>() {
        Ok(fit) => {
            let PyFit { matches, meshes, .. } = fit.get();
            (matches.clone(), meshes[0].is_like(&source) && meshes[1].is_like(&target))
        }
        Err(_) => (Correspondence::of_pairs(arrays::pairs("fit", fit)?), true),
    };
    let kinds = [("follow", Unmatched::Follow), ("rest", Unmatched::Rest)];
    let unmatched = choice(py, "unmatched", unmatched, &kinds)?;
    let kinds = [("pairs", Weighting::Pairs), ("area", Weighting::Area)];
    let weighting = choice(py, "weighting", weighting, &kinds)?;
    let options = TransferOptions { unmatched, weighting, anchor, contact };
    Ok(Box::new(move |job| match fits {
        true => Transfer::new(source, target, &matches, options, job),
        false => {
            let problem = "was made for meshes of other faces: make it anew";
            Err(Error::InvalidConstraint(Fault::new("fit", problem)))
        }
    }))
}

/// `Transfer(...)` in the background: returns a Job whose result is the Transfer.
#[pyfunction]
#[pyo3(signature = (source, target, fit, *, unmatched="follow", weighting="area", anchor=1.0, contact=false))]
fn start_transfer(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    fit: &Bound<'_, PyAny>,
    unmatched: &str,
    weighting: &str,
    anchor: f64,
    contact: bool,
) -> PyResult<PyJob> {
    let convert = |py: Python<'_>, made| Ok(Py::new(py, PyTransfer(Arc::new(made)))?.into_any());
    PyJob::start(prepare(source, target, fit, unmatched, weighting, anchor, contact)?, convert)
}
