//! Numbers as Python has them: of any size. One that is too large for anything is a parameter that
//! cannot be, and not an overflow.

use std::fmt;
use std::ops::RangeInclusive;

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;

use crate::error::parameter;

/// An integer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integer(Option<i128>);

impl Integer {
    /// The same as another type has it; `None` where it does not fit.
    pub(crate) fn get<T: TryFrom<i128>>(self) -> Option<T> {
        T::try_from(self.0?).ok()
    }
}

impl fmt::Display for Integer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(value) => value.fmt(f),
            None => f.write_str("an integer of more than 128 bits"),
        }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Integer {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match value.extract() {
            Ok(value) => Ok(Self(Some(value))),
            Err(cause) if is_overflow(value.py(), &cause) => Ok(Self(None)),
            Err(cause) => Err(cause),
        }
    }
}

/// How many of something are wanted, which is a parameter of that name.
pub(crate) fn count(name: &str, value: &Bound<'_, PyAny>, range: &RangeInclusive<usize>) -> PyResult<usize> {
    let value: Integer = value.extract()?;
    let (least, most) = (range.start(), range.end());
    let wrong = || parameter(format!("{name} is {value}: an integer from {least} to {most} is needed"));
    value.get().filter(|count| range.contains(count)).ok_or_else(wrong)
}

/// A real number; an infinity where it is larger than those.
pub(crate) fn real(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    match value.extract() {
        Err(cause) if is_overflow(value.py(), &cause) => {
            Ok(if value.lt(0)? { f64::NEG_INFINITY } else { f64::INFINITY })
        }
        extracted => extracted,
    }
}

fn is_overflow(py: Python<'_>, cause: &PyErr) -> bool {
    cause.is_instance_of::<PyOverflowError>(py)
}
