//! What tells the hand from the rest: nothing, a mask, joints, a depth picture, or that the picture
//! is segmented already.

use std::path::{Path, PathBuf};

use grasp_recognise::MaskSource;
use grasp_recognise::picture::{self, DecodeError};
use grasp_recognise::segment::Mask;
use grasp_recognise::segment::depth::DepthRange;
use numpy::{
    Element, PyArrayDescrMethods as _, PyArrayMethods as _, PyUntypedArray, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;

use crate::array::{contiguous, shown};
use crate::error::{self, parameter};
use crate::number::Integer;

/// A mask's values from here on are hand.
const INSIDE: u8 = 128;

/// What the caller says of the hand's place.
pub(crate) fn source(
    py: Python<'_>,
    mask: Option<&Bound<'_, PyAny>>,
    (landmarks, landmark_unit): (Option<&Bound<'_, PyAny>>, &str),
    segmented: bool,
    depth: Option<&Bound<'_, PyAny>>,
    depth_range: Option<(Integer, Integer)>,
) -> PyResult<MaskSource> {
    let given_ways = [mask.is_some(), landmarks.is_some(), segmented, depth.is_some()];
    if given_ways.into_iter().filter(|is_given| *is_given).count() > 1 {
        return Err(parameter("only one of mask, landmarks, segmented and depth can say where the hand is"));
    }
    if depth.is_some() != depth_range.is_some() {
        return Err(parameter("depth and depth_range, (near, far) in the depth picture's unit, go together"));
    }
    if segmented {
        return Ok(MaskSource::Segmented);
    }
    if let Some(places) = landmarks {
        return crate::landmarks::landmarks(places, landmark_unit).map(MaskSource::Landmarks);
    }
    if let Some(mask) = mask {
        return given(py, mask).map(MaskSource::Given);
    }
    if let (Some(depth), Some((near, far))) = (depth, depth_range) {
        let range: DepthRange = format!("{near}..{far}").parse().map_err(|_| {
            parameter(format!(
                "depth_range is ({near}, {far}): 1 <= near <= far <= 65535 is needed, as (400, 900)"
            ))
        })?;
        let (width, height, depth) = distances(py, depth)?;
        return Ok(MaskSource::Depth { width, height, depth, range });
    }
    Ok(MaskSource::Camera)
}

fn given(py: Python<'_>, mask: &Bound<'_, PyAny>) -> PyResult<Mask> {
    let Ok(array) = mask.cast::<PyUntypedArray>() else {
        let path = path_of(mask, "mask", "of bool or uint8")?;
        let (width, height, grey) = read(py, &path, "mask", |path| {
            picture::read(path).and_then(|bytes| picture::decode_grey(&bytes))
        })?;
        return Ok(Mask::from_grey(width, height, &grey));
    };
    let dtype = array.dtype();
    match (dtype.kind(), dtype.itemsize()) {
        (b'b', _) => {
            let (width, height, inside) = values::<bool>(array, "mask", "bool")?;
            Ok(Mask::from_values(width, height, &inside, |inside| inside))
        }
        (b'u', 1) => {
            let (width, height, grey) = values::<u8>(array, "mask", "uint8")?;
            let most = grey.iter().copied().max().unwrap_or(0);
            // A mask of zeros and ones would be an empty one.
            if (1..INSIDE).contains(&most) {
                return Err(parameter(format!(
                    "the mask's greatest value is {most}, and a hand is {INSIDE} or more: give it as bool (`mask > 0`), \
                     or with 0 and 255"
                )));
            }
            Ok(Mask::from_grey(width, height, &grey))
        }
        _ => Err(parameter(format!("a mask of the type {dtype}: bool, or uint8 with 0 and 255, is needed"))),
    }
}

fn distances(py: Python<'_>, depth: &Bound<'_, PyAny>) -> PyResult<(usize, usize, Vec<u16>)> {
    let Ok(array) = depth.cast::<PyUntypedArray>() else {
        let path = path_of(depth, "depth picture", "of uint16")?;
        return read(py, &path, "depth picture", |path| {
            picture::read(path).and_then(|bytes| picture::decode_grey16(&bytes))
        });
    };
    let dtype = array.dtype();
    if (dtype.kind(), dtype.itemsize()) != (b'u', 2) {
        return Err(parameter(format!(
            "a depth picture of the type {dtype}: uint16 is needed, 0 where nothing is seen"
        )));
    }
    values::<u16>(array, "depth picture", "uint16")
}

/// Width, height and values of an array of two dimensions.
fn values<T: Element + Copy>(
    array: &Bound<'_, PyUntypedArray>,
    what: &str,
    dtype: &str,
) -> PyResult<(usize, usize, Vec<T>)> {
    let [height, width] = *array.shape() else {
        return Err(parameter(format!("a {what} of the shape {}: (h, w) is needed", shown(array.shape()))));
    };
    let array = contiguous::<T>(array, dtype)?;
    Ok((width, height, array.readonly().as_slice()?.to_vec()))
}

fn path_of(value: &Bound<'_, PyAny>, what: &str, kind: &str) -> PyResult<PathBuf> {
    value.extract().map_err(|_| {
        parameter(format!(
            "a {what} is a path, or a NumPy array {kind} of the shape (h, w); this is {}",
            value.get_type()
        ))
    })
}

fn read<T: Send>(
    py: Python<'_>,
    path: &Path,
    what: &str,
    decode: impl FnOnce(&Path) -> Result<T, DecodeError> + Send,
) -> PyResult<T> {
    py.detach(|| decode(path)).map_err(|cause| error::unusable_source(what, path, cause))
}
