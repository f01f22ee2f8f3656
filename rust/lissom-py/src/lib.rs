//! The Python module `lissom`.
use pyo3::prelude::*;

/// Pose, transfer and interpolate triangle meshes.
#[pymodule(name = "lissom")]
fn lissom_py(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
