//! NumPy's arrays as they are read: rows of vectors without a copy where they lie as is needed, and
//! otherwise with one.

use numpy::{Element, PyArrayMethods as _};
use numpy::{
    PyArrayDescrMethods as _, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods as _,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::IntoPyDict as _;

use crate::error::parameter;

/// Vectors in rows.
pub(crate) struct Rows<'py> {
    array: PyReadonlyArrayDyn<'py, f32>,
    /// How many there are.
    pub(crate) count: usize,
    /// Values of a row.
    pub(crate) dim: usize,
    /// There is one row only, which is no array of rows.
    is_one: bool,
    /// What messages call them.
    what: &'static str,
}

impl<'py> Rows<'py> {
    /// The rows of `values`, or the only one where it has one dimension and `may_be_one`. `what`
    /// names them in messages. An array of float32 that lies row by row is not copied.
    pub(crate) fn new(values: &Bound<'py, PyAny>, what: &'static str, may_be_one: bool) -> PyResult<Self> {
        let array = as_f32(values, what)?;
        let (count, dim) = match *array.shape() {
            [count, dim] => (count, dim),
            [dim] if may_be_one => (1, dim),
            ref shape => {
                let one = if may_be_one { " or (dim,)" } else { "" };
                return Err(parameter(format!(
                    "{what} have the shape {}: (n, dim){one} is needed, a row a vector",
                    shown(shape)
                )));
            }
        };
        let is_one = array.ndim() == 1;
        Ok(Self { array: array.readonly(), count, dim, is_one, what })
    }

    /// How Python gets at a value, counted over all rows.
    pub(crate) fn place(&self, at: usize) -> String {
        let (what, dim) = (self.what, self.dim.max(1));
        match self.is_one {
            true => format!("{what}[{at}]"),
            false => format!("{what}[{}][{}]", at / dim, at % dim),
        }
    }

    /// All values, row by row.
    pub(crate) fn values(&self) -> PyResult<&[f32]> {
        Ok(self.array.as_slice()?)
    }
}

/// As float32 in C order.
fn as_f32<'py>(values: &Bound<'py, PyAny>, what: &str) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    if let Ok(array) = values.cast::<PyArrayDyn<f32>>()
        && is_plain(array)
    {
        return Ok(array.clone());
    }
    let array = as_array(values, what)?;
    let dtype = array.dtype();
    if !matches!(dtype.kind(), b'f' | b'i' | b'u') {
        return Err(parameter(format!(
            "{what} are of the type {dtype}: real numbers are needed, best float32"
        )));
    }
    // NumPy would make a row of a single number.
    if array.ndim() == 0 {
        return Err(parameter(format!("{what} are a single number: an array of vectors is needed")));
    }
    contiguous::<f32>(&array, "float32")
}

/// `values`, which messages call `what`, as an array of any type.
pub(crate) fn as_array<'py>(values: &Bound<'py, PyAny>, what: &str) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = values.py();
    let array = py.import("numpy")?.call_method1("asarray", (values,)).map_err(|cause| {
        // NumPy's words are about arrays of any kind.
        match cause.is_instance_of::<PyValueError>(py) {
            true => parameter(format!("{what} are no array: rows of numbers, all of one length, are needed")),
            false => cause,
        }
    })?;
    Ok(array.cast_into::<PyUntypedArray>()?)
}

/// The same array in C order, aligned and in the machine's byte order, copied where it is not.
pub(crate) fn contiguous<'py, T: Element>(
    array: &Bound<'py, PyUntypedArray>,
    dtype: &str,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    if let Ok(array) = array.cast::<PyArrayDyn<T>>()
        && is_plain(array)
    {
        return Ok(array.clone());
    }
    let py = array.py();
    let options = [("dtype", dtype), ("order", "C")].into_py_dict(py)?;
    Ok(py.import("numpy")?.call_method("array", (array,), Some(&options))?.cast_into::<PyArrayDyn<T>>()?)
}

fn is_plain<T: Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    // Of an array that lies row by row, a slice is refused only where it is not aligned.
    array.is_c_contiguous() && array.try_readonly().is_ok_and(|array| array.as_slice().is_ok())
}

/// A shape as Python writes it.
pub(crate) fn shown(shape: &[usize]) -> String {
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &sides[..] {
        [only] => format!("({only},)"),
        sides => format!("({})", sides.join(", ")),
    }
}
