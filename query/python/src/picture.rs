//! What is to be recognised: a file, or an array of pixels that can be meant in one way only.

use std::path::PathBuf;

use grasp_recognise::picture::{MAX_PIXELS, Picture};
use numpy::{PyArrayDescrMethods as _, PyArrayMethods as _, PyUntypedArray, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::array::{contiguous, shown};
use crate::error::not_a_picture;

/// A picture as it was given.
pub(crate) enum Input {
    /// A file, to be read and decoded.
    File(PathBuf),
    /// Pixels.
    Pixels(Picture),
}

/// What records call a picture that came as an array.
const ARRAY: &str = "array";

impl Input {
    /// A picture that Python gives.
    pub(crate) fn new(image: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(array) = image.cast::<PyUntypedArray>() {
            return pixels(array).map(Self::Pixels);
        }
        image.extract().map(Self::File).map_err(|_| {
            let kind = image.get_type().to_string();
            not_a_picture(format!(
                "a picture is a path, or a NumPy array of uint8 of the shape (h, w, 3), RGB, or (h, w), grey; this is \
                 {kind}: convert it, a Pillow image by `numpy.asarray(image.convert(\"RGB\"))`"
            ))
        })
    }

    /// Its name in records.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Pixels(_) => ARRAY.to_owned(),
        }
    }

    /// Its name in messages, where it has one.
    pub(crate) fn file(&self) -> Option<String> {
        matches!(self, Self::File(_)).then(|| self.name())
    }
}

fn pixels(array: &Bound<'_, PyUntypedArray>) -> PyResult<Picture> {
    let shape = array.shape();
    let sides = shown(shape);
    let dtype = array.dtype();
    let is_bytes = dtype.kind() == b'u' && dtype.itemsize() == 1;
    if !is_bytes {
        return Err(not_a_picture(format!(
            "a picture of the type {dtype}: uint8 is needed, 0 to 255 a channel; convert it yourself, because only you \
             know its range"
        )));
    }
    let (height, width, channels) = match *shape {
        [height, width] => (height, width, 1),
        [height, width, 3] => (height, width, 3),
        [_, _, 4] => {
            return Err(not_a_picture(format!(
                "a picture of the shape {sides} has four channels: give (h, w, 3), RGB, by leaving the fourth out \
                 (`image[:, :, :3]`) where it is opacity"
            )));
        }
        [_, _, 1] => {
            return Err(not_a_picture(format!(
                "a picture of the shape {sides}: give a grey one as (h, w) (`image[:, :, 0]`)"
            )));
        }
        [3, _, _] => {
            return Err(not_a_picture(format!(
                "a picture of the shape {sides} seems to have its channels first: give (h, w, 3) \
                 (`image.transpose(1, 2, 0)`)"
            )));
        }
        _ => {
            return Err(not_a_picture(format!(
                "a picture of the shape {sides}: (h, w, 3), RGB, or (h, w), grey, is needed, one picture at a time"
            )));
        }
    };
    if width.saturating_mul(height) as u64 > MAX_PIXELS {
        return Err(not_a_picture(format!(
            "a picture of the shape {sides} is too large: shrink it to at most {} megapixels",
            MAX_PIXELS / 1_000_000
        )));
    }
    let array = contiguous::<u8>(array, "uint8")?;
    let bytes = array.readonly();
    let bytes = bytes.as_slice()?;
    let rgb = match channels {
        3 => bytes.as_chunks::<3>().0.to_vec(),
        _ => bytes.iter().map(|&grey| [grey; 3]).collect(),
    };
    Picture::new(width, height, rgb)
        .ok_or_else(|| not_a_picture(format!("a picture of the shape {sides} has no pixels")))
}
