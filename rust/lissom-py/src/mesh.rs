//! `lissom.Mesh`.

use std::sync::Arc;

use lissom::{Job, Mesh};
use pyo3::prelude::*;

use crate::job::PyJob;
use crate::{arrays, options};

/// A triangle mesh, checked once.
///
/// Mesh(vertices, triangles, *, weld=None): vertices (n, 3) float in any units, triangles (m, 3) integers counted
/// from 0. `weld` is a distance in the same units: vertices that close together count as one, as at seams or
/// where each triangle has its own; 0.0 joins those in the very same place. Results keep the number and the
/// order of the vertices. Raises InvalidMesh for no vertices or faces, values that are not finite, indices out of range
/// and points that are all coincident or on one line, and says in `warnings` what was mended or is doubtful.
#[pyclass(name = "Mesh", module = "lissom", frozen)]
pub struct PyMesh(pub Arc<Mesh>);

#[pymethods]
impl PyMesh {
    #[new]
    #[pyo3(signature = (vertices, triangles, *, weld=None))]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        weld: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<Self>> {
        let weld = weld.map(|weld| options::float("weld", weld)).transpose()?;
        let vertices = arrays::points("vertices", vertices)?;
        let triangles = arrays::triangles("triangles", triangles)?;
        let work = move |_: &Job| Mesh::welded(vertices, triangles, weld);
        let job = PyJob::start(work, |py, mesh| Ok(Py::new(py, Self(Arc::new(mesh)))?.into_any()))?;
        Ok(job.result(py)?.into_bound(py).cast_into::<Self>()?.unbind())
    }

    /// (n, 3) float64: the positions as given.
    #[getter]
    fn vertices(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        arrays::from_points(py, self.0.vertices())
    }

    /// Length of the diagonal of the bounding box, in the mesh's own units.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.0.frame().scale
    }

    /// Number of connected components.
    #[getter]
    fn components(&self) -> usize {
        self.0.components().count()
    }

    /// (n,) int64: the number of the connected component of each vertex, from 0; -1 for one in no face.
    #[getter]
    fn component_of_vertex(&self, py: Python<'_>) -> Py<PyAny> {
        let (components, vertices) = (self.0.components(), self.0.vertices().len());
        let representative = |v| self.0.representative(v as u32) as usize;
        let number = |v| components.of_vertex(representative(v)).map_or(-1, |c| c as i64);
        arrays::from_integers(py, (0..vertices).map(number))
    }

    /// (k,) int64: the vertices on open borders, ascending; those of welded seams are none.
    #[getter]
    fn border(&self, py: Python<'_>) -> Py<PyAny> {
        arrays::from_integers(py, self.0.border().into_iter().map(i64::from))
    }

    /// (n,) float64: how far each vertex is from the nearest of `vertices`, (k,) indices, along edges, in the mesh's
    /// own units; inf where no edges lead. Raises InvalidConstraint for no vertices and indices out of range.
    fn edge_distances(&self, py: Python<'_>, vertices: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let sources = arrays::vertex_list("vertices", vertices)?;
        let mesh = self.0.clone();
        let work = move |_: &Job| mesh.edge_distances(&sources);
        PyJob::start(work, |py, distances| Ok(arrays::from_numbers(py, distances)))?.result(py)
    }

    /// `limit_stretch` in the background.
    #[pyo3(signature = (shapes, limit=None, held=None))]
    fn start_limit_stretch(
        &self,
        shapes: &Bound<'_, PyAny>,
        limit: Option<&Bound<'_, PyAny>>,
        held: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyJob> {
        let n = self.0.vertices().len();
        let shapes = arrays::poses("shapes", shapes, n)?;
        let limit = limit.map_or(Ok(3.0), |limit| options::float("limit", limit))?;
        let held = held.map_or(Ok(Vec::new()), |held| arrays::vertex_list("held", held))?;
        let mesh = self.0.clone();
        let work = move |job: &Job| mesh.limit_stretch(&shapes, limit, &held, job);
        PyJob::start(work, move |py, found| arrays::from_poses(py, &found, n))
    }

    /// (k, n, 3) float64: `shapes` (k, n, 3) with no edge longer than `limit` times what it is at rest, but those
    /// between two of the vertices that are `held`, (h,) indices. Raises InvalidConstraint for indices out of range.
    #[pyo3(signature = (shapes, limit=None, held=None))]
    fn limit_stretch(
        &self,
        py: Python<'_>,
        shapes: &Bound<'_, PyAny>,
        limit: Option<&Bound<'_, PyAny>>,
        held: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        self.start_limit_stretch(shapes, limit, held)?.result(py)
    }

    /// `linings` in the background.
    fn start_linings(&self) -> PyResult<PyJob> {
        let mesh = self.0.clone();
        let integers =
            |py: Python<'_>, found: Vec<u32>| Ok(arrays::from_integers(py, found.into_iter().map(i64::from)));
        PyJob::start(move |job: &Job| mesh.linings(job), integers)
    }

    /// (k,) int64: the input triangles that line a pocket, as mouth bags and eye sockets do.
    fn linings(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.start_linings()?.result(py)
    }

    /// list of str: what was mended or is doubtful.
    #[getter]
    fn warnings(&self) -> &[String] {
        self.0.warnings()
    }

    fn __repr__(&self) -> String {
        format!("lissom.Mesh({} vertices, {} triangles)", self.0.vertices().len(), self.0.triangles().len())
    }
}
