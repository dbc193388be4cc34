//! `visualization_msgs`.

use serde::{Deserialize, Serialize};

use super::Message;
use super::geometry::{Point, Pose};
use super::sensor::CompressedImage;
use super::standard::{ColorRgba, Header, Time};

/// `visualization_msgs/MarkerArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MarkerArray {
    pub(crate) markers: Vec<Marker>,
}

impl Message for MarkerArray {
    const TYPE: (&'static str, &'static str) = ("visualization_msgs", "MarkerArray");
}

/// `visualization_msgs/Marker`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Marker {
    pub(crate) header: Header,
    pub(crate) ns: String,
    pub(crate) id: i32,
    pub(crate) r#type: i32,
    pub(crate) action: i32,
    pub(crate) pose: Pose,
    pub(crate) scale: Point,
    pub(crate) color: ColorRgba,
    pub(crate) lifetime: Time,
    pub(crate) frame_locked: bool,
    pub(crate) points: Vec<Point>,
    pub(crate) colors: Vec<ColorRgba>,
    pub(crate) texture_resource: String,
    pub(crate) texture: CompressedImage,
    pub(crate) uv_coordinates: Vec<UvCoordinate>,
    pub(crate) text: String,
    pub(crate) mesh_resource: String,
    pub(crate) mesh_file: MeshFile,
    pub(crate) mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A type: an arrow between two points.
    pub(crate) const ARROW: i32 = 0;
    /// A type: a line between each two points.
    pub(crate) const LINE_LIST: i32 = 5;
    /// A type: text that faces whoever looks.
    pub(crate) const TEXT_VIEW_FACING: i32 = 9;
    /// An action: all markers of the topic go.
    pub(crate) const DELETE_ALL: i32 = 3;
}

/// `visualization_msgs/UVCoordinate`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct UvCoordinate {
    pub(crate) u: f32,
    pub(crate) v: f32,
}

/// `visualization_msgs/MeshFile`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct MeshFile {
    pub(crate) filename: String,
    #[serde(with = "serde_bytes")]
    pub(crate) data: Vec<u8>,
}
