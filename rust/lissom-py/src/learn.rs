//! What corrected keys teach the others.

use lissom::transfer::{Corrected, LearnOptions, Learned, learn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::PyJob;
use crate::mesh::PyMesh;
use crate::{arrays, options};

/// Learns from the keys at `places` of `vertices`, which were corrected to `corrected`: the job's result is a dict.
#[pyfunction]
pub fn start_learn(
    mesh: &Bound<'_, PyMesh>,
    vertices: &Bound<'_, PyAny>,
    places: &Bound<'_, PyAny>,
    corrected: &Bound<'_, PyAny>,
    options: &Bound<'_, PyDict>,
) -> PyResult<PyJob> {
    let mesh = mesh.get().0.clone();
    let n = mesh.vertices().len();
    let poses = arrays::poses("vertices", vertices, n)?;
    let places = arrays::vertex_list("corrected", places)?;
    let wanted = arrays::poses("corrected", corrected, n)?;
    arrays::expect_length("corrected", wanted.len(), places.len())?;
    let mut told = LearnOptions::default();
    options::read("learn", options, &mut [&mut told])?;
    let corrected: Vec<Corrected> =
        places.into_iter().zip(wanted).map(|(key, pose)| Corrected { key, pose }).collect();
    PyJob::start(
        move |job| learn(&mesh, &poses, &corrected, told, job),
        move |py, found: Learned| {
            let dict = PyDict::new(py);
            dict.set_item("vertices", arrays::from_poses(py, &found.poses, n)?)?;
            dict.set_item("changes", arrays::from_numbers(py, found.changes))?;
            dict.set_item("foretold", arrays::from_numbers(py, found.foretold))?;
            dict.set_item("seconds", found.time.as_secs_f64())?;
            dict.set_item("warnings", found.warnings)?;
            Ok(dict.into_any().unbind())
        },
    )
}
