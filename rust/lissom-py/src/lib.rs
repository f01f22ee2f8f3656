//! The native part of the Python module `lissom`: check, release the interpreter, convert. No mathematics. Every
//! call that may take long returns a job; the Python layer waits for it, and gives results their types.

mod arrays;
mod errors;
mod geometry;
mod inbetween;
mod job;
mod learn;
mod mesh;
mod options;
mod picture;
mod pose;
mod transfer;

use pyo3::prelude::*;

/// A dict of fields of a struct, by their names.
macro_rules! fields {
    ($py:expr, $from:expr; $($field:ident),+) => {{
        let dict = pyo3::types::PyDict::new($py);
        $(dict.set_item(stringify!($field), &$from.$field)?;)+
        dict
    }};
}
pub(crate) use fields;

#[pymodule(name = "_native")]
fn native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    job::HOME.get_or_init(std::process::id);
    errors::register(module)?;
    module.add_class::<job::PyJob>()?;
    module.add_class::<mesh::PyMesh>()?;
    module.add_class::<pose::PyPose>()?;
    module.add_class::<transfer::PyFit>()?;
    module.add_class::<transfer::PyTransfer>()?;
    module.add_class::<inbetween::PyInbetween>()?;
    module.add_class::<inbetween::PyBlend>()?;
    module.add_function(wrap_pyfunction!(options::options, module)?)?;
    module.add_function(wrap_pyfunction!(pose::start_pose, module)?)?;
    module.add_function(wrap_pyfunction!(transfer::start_fit, module)?)?;
    module.add_function(wrap_pyfunction!(transfer::start_transfer, module)?)?;
    module.add_function(wrap_pyfunction!(learn::start_learn, module)?)?;
    module.add_function(wrap_pyfunction!(inbetween::start_inbetween, module)?)?;
    module.add_function(wrap_pyfunction!(inbetween::start_blend, module)?)?;
    module.add_function(wrap_pyfunction!(picture::start_image_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(geometry::rotation_vectors, module)?)?;
    module.add_function(wrap_pyfunction!(geometry::nearest_rotations, module)?)?;
    module.add_function(wrap_pyfunction!(geometry::components, module)?)?;
    module.add_function(wrap_pyfunction!(geometry::closest_points, module)?)?;
    module.add_function(wrap_pyfunction!(job::_panic, module)?)?;
    // What is public, the Python layer says.
    module.delattr("__all__")
}
