//! Fits, and the transfers made by them.

use std::sync::Arc;

use lissom::transfer::{
    Correspondence, Doubtful, Fit, FitOptions, Fitted, KeyQuality, SurfacePoint, Transfer, TransferOptions,
    Transferred, fit_correspondence, next_marker,
};
use lissom::{Error, Fault, Job, Mesh, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::PyJob;
use crate::mesh::PyMesh;
use crate::{arrays, fields, options};

/// What belongs together, and the meshes it was found for.
#[pyclass(name = "Fit", module = "lissom._native", frozen)]
pub struct PyFit {
    matches: Correspondence,
    meshes: [Arc<Mesh>; 2],
}

#[pymethods]
impl PyFit {
    /// (source vertex, target vertex) of the marker to add next, or None.
    fn next_marker(
        &self,
        py: Python<'_>,
        fitted: [Bound<'_, PyAny>; 3],
        markers: &Bound<'_, PyAny>,
        masks: [Bound<'_, PyAny>; 2],
    ) -> PyResult<Py<PyAny>> {
        let fitted = Fitted {
            vertices: arrays::points("fitted_vertices", &fitted[0])?,
            distances: arrays::numbers("distances", &fitted[1])?,
            distortion: arrays::numbers("distortion", &fitted[2])?,
        };
        let markers = arrays::pairs("markers", markers)?;
        let source_mask = arrays::vertex_list("source_mask", &masks[0])?;
        let target_mask = arrays::vertex_list("target_mask", &masks[1])?;
        let [source, target] = self.meshes.clone();
        let work =
            move |_: &Job| next_marker([&source, &target], &fitted, &markers, [&source_mask, &target_mask]);
        PyJob::start(work, |py, found| Ok(found.into_pyobject(py)?.into_any().unbind()))?.result(py)
    }
}

/// Fits `source` to `target`, without markers by their shapes: the job's result is (a `Fit`, arrays, report).
#[pyfunction]
pub fn start_fit(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    markers: Option<&Bound<'_, PyAny>>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let markers = markers.map(|markers| arrays::pairs("markers", markers)).transpose()?;
    let mut told = FitOptions::default();
    options::read("fit", options, &mut [&mut told])?;
    let meshes = [source, target].map(|mesh| mesh.get().0.clone());
    let [source, target] = meshes.clone();
    PyJob::start(
        move |job| fit_correspondence(&source, &target, markers.as_deref(), &told, job),
        move |py, fit| fitted(py, fit, meshes),
    )
}

fn fitted(py: Python<'_>, fit: Fit, meshes: [Arc<Mesh>; 2]) -> PyResult<Py<PyAny>> {
    let images = &fit.matches.images;
    let triangle = |image: &Option<SurfacePoint>| image.map_or(-1, |image| i64::from(image.triangle));
    let weights: Vec<Vec3> = images.iter().map(|i| i.map_or(Vec3::ZERO, |i| i.weights)).collect();
    let arrays = PyDict::new(py);
    arrays.set_item("pairs", arrays::from_pairs(py, &fit.matches.pairs)?)?;
    arrays.set_item("image_triangles", arrays::from_integers(py, images.iter().map(triangle)))?;
    arrays.set_item("image_weights", arrays::from_points(py, &weights)?)?;
    arrays.set_item("fitted_vertices", arrays::from_points(py, &fit.fitted_vertices)?)?;
    arrays.set_item("rest", arrays::from_points(py, &fit.rest)?)?;
    arrays.set_item("coefficients", arrays::from_numbers(py, fit.coefficients))?;
    arrays.set_item("distances", arrays::from_numbers(py, fit.distances))?;
    arrays.set_item("image_distances", arrays::from_numbers(py, fit.image_distances))?;
    arrays.set_item("distortion", arrays::from_numbers(py, fit.distortion))?;
    arrays.set_item("marker_distances", arrays::from_numbers(py, fit.marker_distances))?;
    let doubtful = fit.doubtful_markers;
    let numbers = |doubtful: &[Doubtful]| {
        arrays::from_integers(py, doubtful.iter().map(|doubtful| i64::from(doubtful.number)))
    };
    let percents = |doubtful: &[Doubtful]| {
        arrays::from_numbers(py, doubtful.iter().map(|doubtful| doubtful.percent).collect::<Vec<_>>())
    };
    let warnings = |doubtful: Vec<Doubtful>| -> Vec<String> {
        doubtful.into_iter().map(|doubtful| doubtful.warning).collect()
    };
    arrays.set_item("doubtful_markers", numbers(&doubtful))?;
    arrays.set_item("doubtful_percents", percents(&doubtful))?;
    arrays.set_item("doubtful_warnings", warnings(doubtful))?;
    arrays.set_item("curve_distances", arrays::from_numbers(py, fit.curve_distances))?;
    arrays.set_item("doubtful_curves", numbers(&fit.doubtful_curves))?;
    arrays.set_item("doubtful_curve_percents", percents(&fit.doubtful_curves))?;
    arrays.set_item("unmet_curves", numbers(&fit.unmet_curves))?;
    arrays.set_item("unmet_curve_percents", percents(&fit.unmet_curves))?;
    arrays.set_item("reordered_curves", numbers(&fit.reordered_curves))?;
    let of_curves = [fit.doubtful_curves, fit.unmet_curves, fit.reordered_curves];
    arrays.set_item("curve_warnings", warnings(of_curves.into_iter().flatten().collect()))?;
    arrays.set_item("flipped", arrays::from_integers(py, fit.flipped.into_iter().map(i64::from)))?;
    let report = fields!(py, fit.report; distance_mean, distance_max, distance_mean_percent,
        distance_max_percent, flipped_triangles, distorted_triangles, unmatched_source_triangles,
        unmatched_target_triangles, unmatched_source_percent, unmatched_target_percent, certainty, rounds, seconds,
        warnings);
    let own = Py::new(py, PyFit { matches: fit.matches, meshes })?;
    Ok((own, arrays, report).into_pyobject(py)?.into_any().unbind())
}

/// A prepared transfer.
#[pyclass(name = "Transfer", module = "lissom._native", frozen)]
pub struct PyTransfer(Arc<Transfer>);

/// Prepares a transfer by a `Fit` or pairs of triangles: the job's result is a `Transfer`.
#[pyfunction]
pub fn start_transfer(
    source: &Bound<'_, PyMesh>,
    target: &Bound<'_, PyMesh>,
    fit: &Bound<'_, PyAny>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let (source, target) = (source.get().0.clone(), target.get().0.clone());
    let (matches, fits) = match fit.cast::<PyFit>() {
        Ok(fit) => {
            let PyFit { matches, meshes } = fit.get();
            (matches.clone(), meshes[0].is_like(&source) && meshes[1].is_like(&target))
        }
        Err(_) => (Correspondence::of_pairs(arrays::pairs("fit", fit)?), true),
    };
    let mut told = TransferOptions::default();
    options::read("transfer", options, &mut [&mut told])?;
    let work = move |job: &_| match fits {
        true => Transfer::new(source, target, &matches, told, job),
        false => {
            let problem = "was made for meshes of other faces: make it anew";
            Err(Error::InvalidConstraint(Fault::new("fit", problem)))
        }
    };
    PyJob::start(work, |py, made| Ok(Py::new(py, PyTransfer(Arc::new(made)))?.into_any()))
}

#[pymethods]
impl PyTransfer {
    #[getter]
    fn warnings(&self) -> &[String] {
        self.0.warnings()
    }

    /// The job's result is (vertices, seconds, seconds of back-substitution).
    fn start_apply(&self, poses: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        let poses = arrays::poses("poses", poses, self.0.source().vertices().len())?;
        let (transfer, n) = (self.0.clone(), self.0.target().vertices().len());
        let convert = move |py: Python<'_>, result: Transferred| {
            let vertices = arrays::from_poses(py, &result.poses, n)?;
            let times = (result.time.as_secs_f64(), result.solve_time.as_secs_f64());
            Ok((vertices, times.0, times.1).into_pyobject(py)?.into_any().unbind())
        };
        PyJob::start(move |job| transfer.apply(&poses, job), convert)
    }

    /// The job's result is a dict of (k,) arrays, and of lists of k.
    fn start_quality(
        &self,
        poses: &Bound<'_, PyAny>,
        vertices: &Bound<'_, PyAny>,
        led: &Bound<'_, PyAny>,
    ) -> PyResult<PyJob> {
        let poses = arrays::poses("poses", poses, self.0.source().vertices().len())?;
        let vertices = arrays::poses("vertices", vertices, self.0.target().vertices().len())?;
        let transfer = self.0.clone();
        let led = arrays::vertex_list("led", led)?;
        PyJob::start(move |job| transfer.quality(&poses, &vertices, &led, job), qualities)
    }

    /// The job's result is (n_target, k) values.
    fn start_attributes(&self, values: &Bound<'_, PyAny>) -> PyResult<PyJob> {
        let (k, values) = arrays::channels("values", values, &[self.0.source().vertices().len()])?;
        let (transfer, n) = (self.0.clone(), self.0.target().vertices().len());
        PyJob::start(
            move |job| transfer.attributes(&values, k, job),
            move |py, found| arrays::from_channels(py, found, &[n, k]),
        )
    }

    /// The job's result is (m_target, 3, k) values.
    fn start_corner_attributes(
        &self,
        values: &Bound<'_, PyAny>,
        faces: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyJob> {
        let (k, values) = arrays::channels("values", values, &[self.0.source().input_triangles(), 3])?;
        let faces = faces.map(|faces| arrays::vertex_list("faces", faces)).transpose()?;
        let (transfer, m) = (self.0.clone(), self.0.target().input_triangles());
        PyJob::start(
            move |job| transfer.corner_attributes(&values, k, faces.as_deref(), job),
            move |py, found| arrays::from_channels(py, found, &[m, 3, k]),
        )
    }
}

fn qualities(py: Python<'_>, keys: Vec<KeyQuality>) -> PyResult<Py<PyAny>> {
    let numbers = |of: fn(&KeyQuality) -> f64| arrays::from_numbers(py, keys.iter().map(of));
    let counts = |of: fn(&KeyQuality) -> usize| arrays::from_integers(py, keys.iter().map(|k| of(k) as i64));
    let faces = |key: &KeyQuality| arrays::from_integers(py, key.faces.iter().map(|&t| i64::from(t)));
    let dict = PyDict::new(py);
    dict.set_item("verdict", keys.iter().map(|key| key.verdict.name()).collect::<Vec<_>>())?;
    dict.set_item("reasons", keys.iter().map(|key| key.reasons.clone()).collect::<Vec<_>>())?;
    dict.set_item("faces", keys.iter().map(faces).collect::<Vec<_>>())?;
    dict.set_item("flipped_triangles", counts(|key| key.flipped_triangles))?;
    dict.set_item("torn_triangles", counts(|key| key.torn_triangles))?;
    dict.set_item("contacts", counts(|key| key.contacts))?;
    dict.set_item("contact_gap", numbers(|key| key.contact_gap))?;
    dict.set_item("closing", numbers(|key| key.closing))?;
    dict.set_item("amplitude", numbers(|key| key.amplitude))?;
    dict.set_item("crooked", numbers(|key| key.crooked))?;
    dict.set_item("covered", numbers(|key| key.covered))?;
    dict.set_item("motion", numbers(|key| key.motion))?;
    dict.set_item("residual", numbers(|key| key.residual))?;
    Ok(dict.into_any().unbind())
}
