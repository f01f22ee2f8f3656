//! The Python module `lissom`: check, release the interpreter, convert. No mathematics.

mod arrays;
mod errors;
mod inbetween;
mod job;
mod mesh;
mod pose;
mod transfer;

use pyo3::prelude::*;

/// Pose, transfer and interpolate triangle meshes.
///
/// Positions are float64 arrays of shape (n, 3) in the mesh's own units, indices are integer arrays
/// counted from 0. Other float and integer arrays, in any memory layout, are converted.
#[pymodule(name = "lissom")]
fn lissom_py(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    job::HOME.get_or_init(std::process::id);
    errors::register(module)?;
    module.add_class::<job::PyJob>()?;
    module.add_class::<mesh::PyMesh>()?;
    pose::register(module)?;
    transfer::register(module)?;
    module.add_class::<inbetween::PyInbetween>()?;
    module.add_class::<inbetween::PyBlend>()?;
    module.add_class::<inbetween::PyKeyframes>()?;
    module.add_function(wrap_pyfunction!(inbetween::start_inbetween, module)?)?;
    module.add_function(wrap_pyfunction!(job::_panic, module)?)
}
