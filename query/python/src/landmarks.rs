//! Where a tracker of the caller's has found the hand's joints.

use grasp_recognise::scene::{LandmarkUnit, Landmarks};
use numpy::{PyArrayDescrMethods as _, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::array::{as_array, contiguous, shown};
use crate::error::parameter;

/// The 21 places of an array of two or three numbers each, right, down and, which is left alone,
/// away.
pub(crate) fn landmarks(values: &Bound<'_, PyAny>, unit: &str) -> PyResult<Landmarks> {
    let unit = match unit {
        "pixel" => LandmarkUnit::Pixel,
        "share" => LandmarkUnit::Share,
        other => {
            return Err(parameter(format!("landmark_unit is {other:?}: \"pixel\" or \"share\" is needed")));
        }
    };
    let array = as_array(values, "landmarks")?;
    if !matches!(array.dtype().kind(), b'f' | b'i' | b'u') {
        return Err(parameter(format!("landmarks are of the type {}: numbers are needed", array.dtype())));
    }
    let [_, step @ (2 | 3)] = *array.shape() else {
        return Err(parameter(format!(
            "landmarks of the shape {}: (21, 2) or (21, 3) is needed, a row a joint",
            shown(array.shape())
        )));
    };
    let array = contiguous::<f64>(&array, "float64")?;
    let places: Vec<[f64; 2]> =
        array.readonly().as_slice()?.chunks_exact(step).map(|place| [place[0], place[1]]).collect();
    Landmarks::new(&places, unit).map_err(|cause| parameter(cause.to_string()))
}
