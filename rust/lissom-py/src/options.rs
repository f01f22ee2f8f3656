//! Options: what the core says of each, and what Python gives them.

use lissom::inbetween::{BlendOptions, InbetweenOptions};
use lissom::options::{Kind, OptionSet, Spec, Value};
use lissom::picture::PictureMeshOptions;
use lissom::pose::{CommonOptions, METHODS, MethodOptions, SolveOptions};
use lissom::transfer::{FitOptions, LearnOptions, TransferOptions};
use lissom::{Error, Fault};
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyTuple};

use crate::mesh::PyMesh;
use crate::{arrays, errors};

/// Who has options, and which.
fn owners() -> PyResult<Vec<(String, Vec<Spec>)>> {
    let common = [vec![MethodOptions::spec()], CommonOptions::default().own()].concat();
    let mut owners = vec![("pose".to_owned(), common)];
    owners.push(("pose.solve".to_owned(), SolveOptions::default().own()));
    for method in METHODS {
        let options = MethodOptions::named(method.value).map_err(errors::to_python)?;
        owners.push((format!("pose.{}", method.value), options.own()));
    }
    owners.push(("fit".to_owned(), FitOptions::default().own()));
    owners.push(("transfer".to_owned(), TransferOptions::default().own()));
    owners.push(("learn".to_owned(), LearnOptions::default().own()));
    owners.push(("inbetween".to_owned(), InbetweenOptions::default().own()));
    owners.push(("blend".to_owned(), BlendOptions::default().own()));
    owners.push(("image_mesh".to_owned(), PictureMeshOptions::default().own()));
    Ok(owners)
}

/// list of dict: what there is to say about each option of each owner.
#[pyfunction]
pub fn options(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for (owner, specs) in owners()? {
        for spec in specs {
            let dict = PyDict::new(py);
            let default = match spec.default {
                Some(Value::Bool(value)) => value.into_pyobject(py)?.to_owned().into_any(),
                Some(Value::Int(value)) => value.into_pyobject(py)?.into_any(),
                Some(Value::Float(value)) => value.into_pyobject(py)?.into_any(),
                Some(Value::Choice(value)) => value.into_pyobject(py)?.into_any(),
                _ => py.None().into_bound(py),
            };
            let bound = |bound: Option<f64>| match spec.kind {
                Kind::Int => bound.map(|bound| bound as i64).into_pyobject(py),
                _ => bound.into_pyobject(py),
            };
            let choices: Vec<_> = spec.choices.iter().map(|choice| (choice.value, choice.help)).collect();
            dict.set_item("name", spec.name)?;
            dict.set_item("kind", spec.kind.name())?;
            dict.set_item("default", default)?;
            dict.set_item("low", bound(spec.low)?)?;
            dict.set_item("high", bound(spec.high)?)?;
            dict.set_item("low_open", spec.low_open)?;
            dict.set_item("high_open", spec.high_open)?;
            dict.set_item("choices", PyTuple::new(py, choices)?)?;
            dict.set_item("unit", spec.unit)?;
            dict.set_item("help", spec.help)?;
            dict.set_item("when", spec.when)?;
            dict.set_item("owner", &owner)?;
            list.append(dict)?;
        }
    }
    Ok(list)
}

/// Sets `options` to what is `given` by name. What none of them knows is refused in the name of `owner`.
pub fn read(owner: &str, given: &Bound<'_, PyDict>, options: &mut [&mut dyn OptionSet]) -> PyResult<()> {
    let mut known = Vec::new();
    for set in options {
        // One that is set may lend others, which follow.
        let mut at = 0;
        while let Some(spec) = set.specs().into_iter().nth(at) {
            at += 1;
            known.push(spec.name);
            if let Some(given) = given.get_item(spec.name)?
                && let Some(value) = value(&spec, &given)?
            {
                set.set(spec.name, value).map_err(errors::to_python)?;
            }
        }
    }
    for name in given.keys() {
        let name: String = name.extract()?;
        if !known.contains(&name.as_str()) {
            let known = known.join(", ");
            return Err(PyTypeError::new_err(format!("'{owner}' has no option {name}; it has {known}")));
        }
    }
    Ok(())
}

/// What an option is given; None where that is nothing.
fn value(spec: &Spec, given: &Bound<'_, PyAny>) -> PyResult<Option<Value>> {
    let name = spec.name;
    Ok(Some(match spec.kind {
        Kind::Bool => Value::Bool(given.extract().map_err(|_| wrong(name, given, "True or False"))?),
        Kind::Int => Value::Int(number(name, given, "a whole number")?),
        Kind::Float => Value::Float(float(name, given)?),
        Kind::Choice => Value::Choice(text(name, given)?),
        _ if given.is_none() => return Ok(None),
        Kind::Vertices => Value::Vertices(arrays::vertex_list(name, given)?),
        Kind::Points => Value::Points(arrays::points(name, given)?),
        Kind::Curves => Value::Curves(arrays::curves(name, given)?),
        Kind::Mesh => {
            let expected = || PyTypeError::new_err(format!("{name}: expected a lissom.Mesh"));
            Value::Mesh(given.cast::<PyMesh>().map_err(|_| expected())?.get().0.clone())
        }
        Kind::Shapes => Value::Shapes(arrays::timed_shapes(name, given)?),
        Kind::Planes => Value::Planes(arrays::planes(name, given)?),
        Kind::Modes => Value::Modes(arrays::modes(name, given)?),
    }))
}

fn wrong(name: &str, given: &Bound<'_, PyAny>, expected: &str) -> PyErr {
    PyTypeError::new_err(format!("{name}: cannot be {given:?}, expected {expected}"))
}

fn number<'py, T>(name: &str, given: &Bound<'py, PyAny>, expected: &str) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    // numpy's own is none of Python's.
    if given.is_instance_of::<PyBool>() || given.get_type().name()?.to_string().starts_with("bool") {
        return Err(wrong(name, given, expected));
    }
    given.extract().map_err(|error: PyErr| match error.is_instance_of::<PyOverflowError>(given.py()) {
        true => errors::to_python(Error::InvalidValue(Fault::new(name, "is too large a number"))),
        false => wrong(name, given, expected),
    })
}

/// A name.
pub fn text(name: &str, given: &Bound<'_, PyAny>) -> PyResult<String> {
    given.extract().map_err(|_| wrong(name, given, "a name"))
}

/// A number.
pub fn float(name: &str, given: &Bound<'_, PyAny>) -> PyResult<f64> {
    number(name, given, "a number")
}

/// A count: a whole number that is not negative.
pub fn count(name: &str, given: &Bound<'_, PyAny>) -> PyResult<usize> {
    let count: i64 = number(name, given, "a whole number")?;
    let problem = || Fault::new(name, format!("must not be negative, got {count}"));
    usize::try_from(count).map_err(|_| errors::to_python(Error::InvalidValue(problem())))
}
