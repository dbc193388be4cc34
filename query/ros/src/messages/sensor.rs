//! `sensor_msgs`.

use serde::{Deserialize, Serialize};

use super::Message;
use super::standard::Header;

/// `sensor_msgs/Image`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Image {
    pub(crate) header: Header,
    /// Rows.
    pub(crate) height: u32,
    /// Pixels in a row.
    pub(crate) width: u32,
    pub(crate) encoding: String,
    /// Of no meaning where a channel is a byte, as in all encodings that are read.
    pub(crate) is_bigendian: u8,
    /// Bytes from one row to the next.
    pub(crate) step: u32,
    /// Not element by element: there are a million of them.
    #[serde(with = "serde_bytes")]
    pub(crate) data: Vec<u8>,
}

impl Message for Image {
    const TYPE: (&'static str, &'static str) = ("sensor_msgs", "Image");
}

/// `sensor_msgs/CompressedImage`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct CompressedImage {
    pub(crate) header: Header,
    pub(crate) format: String,
    #[serde(with = "serde_bytes")]
    pub(crate) data: Vec<u8>,
}

impl Message for CompressedImage {
    const TYPE: (&'static str, &'static str) = ("sensor_msgs", "CompressedImage");
}

/// `sensor_msgs/CameraInfo`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CameraInfo {
    pub(crate) header: Header,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) distortion_model: String,
    pub(crate) d: Vec<f64>,
    /// Row by row: the focal lengths and the principal point in pixels; all 0 before calibration.
    pub(crate) k: [f64; 9],
    pub(crate) r: [f64; 9],
    pub(crate) p: [f64; 12],
    pub(crate) binning_x: u32,
    pub(crate) binning_y: u32,
    pub(crate) roi: RegionOfInterest,
}

impl Message for CameraInfo {
    const TYPE: (&'static str, &'static str) = ("sensor_msgs", "CameraInfo");
}

/// `sensor_msgs/RegionOfInterest`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct RegionOfInterest {
    pub(crate) x_offset: u32,
    pub(crate) y_offset: u32,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) do_rectify: bool,
}
