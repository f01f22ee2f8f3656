//! The core's errors as Python exceptions, exhaustively.

use lissom::{Error as CoreError, Fault};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};

create_exception!(lissom, Error, PyException, "Everything that lissom raises by itself.");
create_exception!(lissom, InvalidMesh, Error, "The mesh cannot be worked with.");
create_exception!(
    lissom,
    InvalidConstraint,
    Error,
    "Handles, markers, targets or a region contradict the mesh or each other."
);
create_exception!(lissom, SolveFailed, Error, "The linear algebra gave up, or the result overflowed.");
create_exception!(lissom, Cancelled, Error, "The job was cancelled; nothing has changed.");
create_exception!(lissom, InternalError, Error, "A bug in lissom: please report it with its message.");

static INVALID_VALUE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static OUT_OF_MEMORY: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// An exception that is a `lissom.Error` and one of Python's too, which the macro cannot express.
fn both<'py>(
    py: Python<'py>,
    class: &'py PyOnceLock<Py<PyType>>,
    name: &str,
    doc: &str,
    other: Bound<'py, PyType>,
) -> PyResult<&'py Bound<'py, PyType>> {
    let make = || {
        let dict = PyDict::new(py);
        dict.set_item("__module__", "lissom")?;
        dict.set_item("__doc__", doc)?;
        let bases = (py.get_type::<Error>(), other);
        let made = py.get_type::<PyType>().call1((name, bases, dict))?;
        Ok::<_, PyErr>(made.cast_into::<PyType>()?.unbind())
    };
    Ok(class.get_or_try_init(py, make)?.bind(py))
}

fn invalid_value(py: Python<'_>) -> PyResult<&Bound<'_, PyType>> {
    let doc = "An option or a number is out of its range.";
    both(py, &INVALID_VALUE, "InvalidValue", doc, py.get_type::<PyValueError>())
}

fn out_of_memory(py: Python<'_>) -> PyResult<&Bound<'_, PyType>> {
    let doc =
        "It would take more memory (`needed` bytes) than there is (`available`); nothing was allocated.";
    both(py, &OUT_OF_MEMORY, "OutOfMemory", doc, py.get_type::<PyMemoryError>())
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    module.add("InvalidMesh", py.get_type::<InvalidMesh>())?;
    module.add("InvalidConstraint", py.get_type::<InvalidConstraint>())?;
    module.add("InvalidValue", invalid_value(py)?)?;
    module.add("OutOfMemory", out_of_memory(py)?)?;
    module.add("SolveFailed", py.get_type::<SolveFailed>())?;
    module.add("Cancelled", py.get_type::<Cancelled>())?;
    module.add("InternalError", py.get_type::<InternalError>())
}

/// The exception for an error of the core.
pub fn to_python(error: CoreError) -> PyErr {
    Python::attach(|py| located_in(py, error))
}

fn located_in(py: Python<'_>, error: CoreError) -> PyErr {
    let message = error.to_string();
    match error {
        CoreError::InvalidMesh(fault) => located(py, InvalidMesh::new_err(message), &fault),
        CoreError::InvalidConstraint(fault) => located(py, InvalidConstraint::new_err(message), &fault),
        CoreError::InvalidValue(fault) => match invalid_value(py) {
            Ok(class) => located(py, PyErr::from_type(class.clone(), message), &fault),
            Err(error) => error,
        },
        CoreError::SolveFailed(_) => SolveFailed::new_err(message),
        CoreError::OutOfMemory { needed, available, .. } => {
            let sized = || {
                let error = PyErr::from_type(out_of_memory(py)?.clone(), message);
                error.value(py).setattr("needed", needed)?;
                error.value(py).setattr("available", available)?;
                Ok(error)
            };
            sized().unwrap_or_else(|error| error)
        }
        CoreError::Cancelled => Cancelled::new_err(message),
    }
}

/// Adds the attributes `argument`, `indices` (the first offenders) and `count`.
fn located(py: Python<'_>, error: PyErr, fault: &Fault) -> PyErr {
    let value = error.value(py);
    let set = || {
        value.setattr("argument", &fault.argument)?;
        value.setattr("indices", &fault.indices)?;
        value.setattr("count", fault.count)
    };
    match set() {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// The exception for a caught panic.
pub fn from_panic(payload: &(dyn std::any::Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    InternalError::new_err(format!("a bug in lissom: {}", text.unwrap_or_else(|| "unknown".into())))
}
