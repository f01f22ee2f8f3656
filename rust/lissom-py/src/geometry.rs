//! Geometry that the extension asks for beside the three jobs, and scripts may.

use lissom::geometry::surface::Surface;
use lissom::mesh::Components;
use lissom::rotation::{log, nearest_branch, nearest_rotation};
use lissom::{Error, Fault, Job, Mat3};
use pyo3::prelude::*;

use crate::job::PyJob;
use crate::{arrays, errors};

/// (k, 3): axis times angle of rotations (k, 3, 3), at most pi, or the branches nearest to `near` (k, 3).
#[pyfunction]
pub fn rotation_vectors(
    py: Python<'_>,
    rotations: &Bound<'_, PyAny>,
    near: Option<&Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let rotations = arrays::maps("rotations", rotations)?;
    let mut vectors: Vec<_> = rotations.into_iter().map(log).collect();
    if let Some(near) = near.map(|near| arrays::points("near", near)).transpose()? {
        arrays::expect_length("near", near.len(), vectors.len())?;
        vectors.iter_mut().zip(near).for_each(|(vector, near)| *vector = nearest_branch(*vector, near));
    }
    arrays::from_points(py, &vectors)
}

/// (k, 3, 3): the rotations nearest to linear maps (k, 3, 3).
#[pyfunction]
pub fn nearest_rotations(py: Python<'_>, maps: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
    let found: Vec<Mat3> = arrays::maps("maps", maps)?.into_iter().map(nearest_rotation).collect();
    arrays::from_maps(py, &found)
}

/// The number of the connected component of each of `count` vertices, from 0; -1 for one in no triangle.
#[pyfunction]
pub fn components(py: Python<'_>, count: usize, triangles: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
    let triangles = within(count, arrays::triangles("triangles", triangles)?)?;
    let work = move |_: &Job| Ok(Components::of(count, &triangles));
    let number = |components: &Components, v| components.of_vertex(v).map_or(-1, |c| c as i64);
    PyJob::start(work, move |py, found| Ok(arrays::from_integers(py, (0..count).map(|v| number(&found, v)))))?
        .result(py)
}

/// The points of a surface nearest to places (k, 3): triangles (k,), weights of their corners (k, 3), distances (k,).
#[pyfunction]
pub fn closest_points(
    py: Python<'_>,
    vertices: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    places: &Bound<'_, PyAny>,
) -> PyResult<Py<PyAny>> {
    let vertices = arrays::points("vertices", vertices)?;
    let triangles = within(vertices.len(), arrays::triangles("triangles", triangles)?)?;
    let places = arrays::points("places", places)?;
    let work = move |_: &Job| {
        let surface = Surface::of(&triangles, &vertices);
        let nothing = || Error::InvalidMesh(Fault::new("triangles", "no triangle to be near to"));
        places.iter().map(|&place| surface.closest_point(place).ok_or_else(nothing)).collect()
    };
    PyJob::start(work, |py, hits: Vec<_>| {
        let weights: Vec<_> = hits.iter().map(|hit| hit.weights).collect();
        let triangles = arrays::from_integers(py, hits.iter().map(|hit| hit.triangle as i64));
        let distances = arrays::from_numbers(py, hits.iter().map(|hit| hit.distance).collect::<Vec<_>>());
        Ok((triangles, arrays::from_points(py, &weights)?, distances).into_pyobject(py)?.into_any().unbind())
    })?
    .result(py)
}

fn within(count: usize, triangles: Vec<[u32; 3]>) -> PyResult<Vec<[u32; 3]>> {
    match Fault::out_of_range("triangles", triangles.iter().flatten(), count) {
        Some(fault) => Err(errors::to_python(Error::InvalidMesh(fault))),
        None => Ok(triangles),
    }
}
