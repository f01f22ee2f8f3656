//! Array checks, in one place: every message names the argument.

use lissom::mesh::Plane;
use lissom::{Error, Fault, Mat3, Mat4, Vec3, memory};
use numpy::{
    PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

/// numpy's letters for the kinds of element that are taken.
#[derive(Clone, Copy)]
enum Kind {
    Float,
    Index,
}

/// Converts to a contiguous array of the native element type. Refuses what there is no room for: that array where it is
/// not given as such, and our copy of it.
fn native<'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
    kind: Kind,
) -> PyResult<(Vec<usize>, Bound<'py, PyUntypedArray>)> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|error| {
        PyTypeError::new_err(format!("{name}: cannot be made an array ({})", error.value(py)))
    })?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let letter: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let (taken, wanted, native, copied) = match kind {
        Kind::Float => ("fiu", "floating point numbers", numpy::dtype::<f64>(py), size_of::<f64>()),
        Kind::Index => ("iu", "integers", numpy::dtype::<i64>(py), size_of::<u32>()),
    };
    // An empty list has no type of its own.
    if !taken.contains(&letter) && array.len() > 0 {
        let found = array.getattr("dtype")?;
        return Err(PyTypeError::new_err(format!("{name}: expected {wanted}, got {found}")));
    }
    let is_native = array.dtype().is_equiv_to(&native) && array.is_c_contiguous();
    let each = copied + if is_native { 0 } else { native.itemsize() };
    memory::check(format!("a copy of {name}"), each as u128 * array.len() as u128)
        .map_err(errors::to_python)?;
    let options = PyDict::new(py);
    options.set_item("order", "C")?;
    options.set_item("copy", false)?;
    let shape = array.shape().to_vec();
    let array = array.call_method("astype", (native,), Some(&options))?;
    Ok((shape, array.cast_into::<PyUntypedArray>()?))
}

/// `(-1, 3)` as `(n, 3)`, `(-1, -1)` as `(n, m)`: lengths that are free are free of each other.
fn shown(shape: &[i64]) -> String {
    let mut free = ["n", "m"].into_iter();
    let mut axis = |d: i64| if d < 0 { free.next().unwrap_or("any").into() } else { d.to_string() };
    let axes: Vec<String> = shape.iter().map(|&d| axis(d)).collect();
    if axes.len() == 1 { format!("({},)", axes[0]) } else { format!("({})", axes.join(", ")) }
}

/// Refuses a shape that is not the expected one, where -1 stands for any length.
fn expect_shape(name: &str, shape: &[usize], expected: &[i64]) -> PyResult<()> {
    let fits = |(&given, &wanted): (&usize, &i64)| usize::try_from(wanted).map_or(true, |w| w == given);
    if shape.len() == expected.len() && shape.iter().zip(expected).all(fits) {
        return Ok(());
    }
    let given: Vec<i64> = shape.iter().map(|&d| d as i64).collect();
    let message = format!("{name}: expected shape {}, got {}", shown(expected), shown(&given));
    Err(PyValueError::new_err(message))
}

/// What `take` makes of a shape and of all numbers in one row.
fn floats<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    expected: &[i64],
    take: impl FnOnce(&[usize], &[f64]) -> T,
) -> PyResult<T> {
    let (shape, array) = native(name, value, Kind::Float)?;
    expect_shape(name, &shape, expected)?;
    let array = array.cast_into::<PyArrayDyn<f64>>()?;
    Ok(take(&shape, array.try_readonly()?.as_slice()?))
}

/// Rows of indices as given; one that does not fit 32 bits is refused by the class that `invalid` makes.
fn indices<const N: usize>(
    name: &str,
    value: &Bound<'_, PyAny>,
    invalid: fn(Fault) -> Error,
) -> PyResult<Vec<[u32; N]>> {
    let (shape, array) = native(name, value, Kind::Index)?;
    if shape != [0] {
        expect_shape(name, &shape, if N == 1 { &[-1] } else { &[-1, N as i64] })?;
    }
    let array = array.cast_into::<PyArrayDyn<i64>>()?;
    let array = array.try_readonly()?;
    let (rows, _) = array.as_slice()?.as_chunks::<N>();
    let bad = rows.iter().enumerate().filter(|(_, r)| r.iter().any(|&v| u32::try_from(v).is_err()));
    if let Some(fault) = Fault::at(name, "index negative or too large", bad.map(|(i, _)| i)) {
        return Err(errors::to_python(invalid(fault)));
    }
    Ok(rows.iter().map(|row| row.map(|v| v as u32)).collect())
}

fn to_points(values: &[f64]) -> Vec<Vec3> {
    values.chunks_exact(3).map(Vec3::from_slice).collect()
}

/// (n, 3) positions.
pub fn points(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    floats(name, value, &[-1, 3], |_, values| to_points(values))
}

/// (k, n, 3) poses of n vertices.
pub fn poses(name: &str, value: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Vec<Vec<Vec3>>> {
    // No poses at all have no vertices either.
    if value.len().is_ok_and(|count| count == 0) && value.getattr("ndim").map_or(Ok(1), |n| n.extract())? == 1
    {
        return Ok(Vec::new());
    }
    floats(name, value, &[-1, vertices as i64, 3], |_, values| {
        values.chunks_exact(3 * vertices.max(1)).map(to_points).collect()
    })
}

/// (k, n, 3) offsets of however many vertices.
pub fn modes(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<Vec3>>> {
    floats(name, value, &[-1, -1, 3], |shape, values| {
        values.chunks_exact(3 * shape[1].max(1)).map(to_points).collect()
    })
}

/// (n, k) or (n, 3, k) numbers, whose first axes are `of`; k, and all of them in one row.
pub fn channels(name: &str, value: &Bound<'_, PyAny>, of: &[usize]) -> PyResult<(usize, Vec<f64>)> {
    let expected: Vec<i64> = of.iter().map(|&d| d as i64).chain([-1]).collect();
    floats(name, value, &expected, |shape, values| (shape[of.len()], values.to_vec()))
}

/// (h, w) numbers; w, and all of them row by row.
pub fn grid(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(usize, Vec<f64>)> {
    floats(name, value, &[-1, -1], |shape, values| (shape[1], values.to_vec()))
}

/// (h, 4, 4) matrices, row by row as numpy has them.
pub fn matrices(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Mat4>> {
    floats(name, value, &[-1, 4, 4], |_, values| {
        values.chunks_exact(16).map(|m| Mat4::from_cols_slice(m).transpose()).collect()
    })
}

/// (k, 3, 3) linear maps, row by row as numpy has them.
pub fn maps(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Mat3>> {
    floats(name, value, &[-1, 3, 3], |_, values| {
        values.chunks_exact(9).map(|m| Mat3::from_cols_slice(m).transpose()).collect()
    })
}

/// (k,) numbers.
pub fn numbers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    floats(name, value, &[-1], |_, values| values.to_vec())
}

/// (m, 3) vertex indices.
pub fn triangles(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    indices(name, value, Error::InvalidMesh)
}

/// (k, 2) pairs of indices.
pub fn pairs(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 2]>> {
    indices(name, value, Error::InvalidConstraint)
}

/// (k,) vertex indices.
pub fn vertex_list(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    Ok(indices::<1>(name, value, Error::InvalidConstraint)?.into_flattened())
}

/// A sequence of (k,) vertex index arrays.
pub fn vertex_lists(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<u32>>> {
    let items = value.try_iter().map_err(|_| {
        PyTypeError::new_err(format!("{name}: expected a list of 1-D index arrays, one per handle"))
    })?;
    items.enumerate().map(|(i, item)| vertex_list(&format!("{name}[{i}]"), &item?)).collect()
}

/// A sequence of pairs of (k,) vertex index arrays.
pub fn curves(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[Vec<u32>; 2]>> {
    let expected = || {
        PyTypeError::new_err(format!(
            "{name}: expected a list of (source vertices, target vertices), each a 1-D index array"
        ))
    };
    let curve = |(i, item): (usize, PyResult<Bound<'_, PyAny>>)| {
        let sides: Vec<Bound<'_, PyAny>> =
            item?.try_iter().map_err(|_| expected())?.collect::<PyResult<_>>()?;
        let [source, target] = sides.as_slice() else { return Err(expected()) };
        let name = format!("{name}[{i}]");
        Ok([vertex_list(&name, source)?, vertex_list(&name, target)?])
    };
    value.try_iter().map_err(|_| expected())?.enumerate().map(curve).collect()
}

/// A sequence of (k,) numbers or None.
pub fn number_lists(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Option<Vec<f64>>>> {
    let items = value.try_iter().map_err(|_| {
        PyTypeError::new_err(format!("{name}: expected a list of 1-D arrays or None, one per handle"))
    })?;
    let list = |(i, item): (usize, PyResult<Bound<'_, PyAny>>)| {
        let item = item?;
        if item.is_none() { Ok(None) } else { numbers(&format!("{name}[{i}]"), &item).map(Some) }
    };
    items.enumerate().map(list).collect()
}

/// A sequence of (time, (n, 3) positions).
pub fn timed_shapes(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<(f64, Vec<Vec3>)>> {
    let expected =
        || PyTypeError::new_err(format!("{name}: expected a list of (time, shape), shapes as (n, 3) arrays"));
    let shape = |(k, item): (usize, PyResult<Bound<'_, PyAny>>)| {
        let (time, shape): (f64, Bound<'_, PyAny>) = item?.extract().map_err(|_| expected())?;
        Ok((time, points(&format!("{name}[{k}]"), &shape)?))
    };
    value.try_iter().map_err(|_| expected())?.enumerate().map(shape).collect()
}

/// (k, 2, 3): planes, each a point and a normal.
pub fn planes(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Plane>> {
    let planes = poses(name, value, 2)?;
    let made: Vec<Option<Plane>> = planes.iter().map(|plane| Plane::new(plane[0], plane[1])).collect();
    let bad = made.iter().enumerate().filter(|(_, plane)| plane.is_none()).map(|(i, _)| i);
    match Fault::at(name, "not a finite point and a normal other than zero", bad) {
        Some(fault) => Err(errors::to_python(Error::InvalidValue(fault))),
        None => Ok(made.into_iter().flatten().collect()),
    }
}

/// Refuses a sequence of another length.
pub fn expect_length(name: &str, given: usize, wanted: usize) -> PyResult<()> {
    if given == wanted {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name}: expected {wanted} items, got {given}")))
}

fn flat(points: &[Vec3]) -> impl Iterator<Item = f64> + '_ {
    points.iter().flat_map(|p| p.to_array())
}

/// Positions as an (n, 3) float64 array.
pub fn from_points(py: Python<'_>, points: &[Vec3]) -> PyResult<Py<PyAny>> {
    let array = PyArray::from_iter(py, flat(points)).reshape([points.len(), 3])?;
    Ok(array.into_any().unbind())
}

/// Poses as a (k, n, 3) float64 array.
pub fn from_poses(py: Python<'_>, poses: &[Vec<Vec3>], vertices: usize) -> PyResult<Py<PyAny>> {
    let values = poses.iter().flat_map(|p| flat(p));
    let array = PyArray::from_iter(py, values).reshape([poses.len(), vertices, 3])?;
    Ok(array.into_any().unbind())
}

/// Numbers as an array of this shape.
pub fn from_channels(py: Python<'_>, values: Vec<f64>, shape: &[usize]) -> PyResult<Py<PyAny>> {
    Ok(PyArray::from_vec(py, values).reshape(shape)?.into_any().unbind())
}

/// Rows of indices as a (k, N) int64 array.
fn from_rows<const N: usize>(py: Python<'_>, rows: &[[u32; N]]) -> PyResult<Py<PyAny>> {
    let values = rows.iter().flatten().map(|&v| i64::from(v));
    let array = PyArray::from_iter(py, values).reshape([rows.len(), N])?;
    Ok(array.into_any().unbind())
}

/// Linear maps as a (k, 3, 3) float64 array.
pub fn from_maps(py: Python<'_>, maps: &[Mat3]) -> PyResult<Py<PyAny>> {
    let values = maps.iter().flat_map(|m| m.transpose().to_cols_array());
    let array = PyArray::from_iter(py, values).reshape([maps.len(), 3, 3])?;
    Ok(array.into_any().unbind())
}

/// Pairs as a (k, 2) int64 array.
pub fn from_pairs(py: Python<'_>, pairs: &[[u32; 2]]) -> PyResult<Py<PyAny>> {
    from_rows(py, pairs)
}

/// Triangles as an (m, 3) int64 array.
pub fn from_triangles(py: Python<'_>, triangles: &[[u32; 3]]) -> PyResult<Py<PyAny>> {
    from_rows(py, triangles)
}

/// Numbers as a float64 array.
pub fn from_numbers(py: Python<'_>, values: impl IntoIterator<Item = f64>) -> Py<PyAny> {
    PyArray::from_iter(py, values).into_any().unbind()
}

/// Whole numbers as an int64 array.
pub fn from_integers(py: Python<'_>, values: impl IntoIterator<Item = i64>) -> Py<PyAny> {
    PyArray::from_iter(py, values).into_any().unbind()
}
