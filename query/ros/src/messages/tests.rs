//! Messages against the bytes that CycloneDDS makes of the same values (`tests/golden.py`).

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::geometry::{Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, Vector3Stamped};
use super::moveit::{Grasp, GripperTranslation, JointTrajectory, JointTrajectoryPoint};
use super::sensor::{CameraInfo, CompressedImage, Image, RegionOfInterest};
use super::standard::{ColorRgba, Header, Time};
use super::vision::{
    BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesis, ObjectHypothesisWithPose, Point2D, Pose2D,
};
use super::visualization::{Marker, MarkerArray, MeshFile, UvCoordinate};
use super::*;

const GOLDEN: &str = include_str!("../../tests/golden.txt");

/// The bytes of a type's sample, behind the header that says how they are encoded.
fn golden(name: &str) -> Vec<u8> {
    let digits = GOLDEN.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')).unwrap();
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
    let bytes: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
    // Plain CDR, little-endian.
    assert_eq!(bytes[..4], [0, 1, 0, 0]);
    bytes[4..].to_vec()
}

#[track_caller]
fn check<M: Message + Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(message: &M) {
    let (package, name) = M::TYPE;
    let bytes = golden(&format!("{package}/{name}"));
    assert_eq!(cdr_encoding::to_vec::<M, LittleEndian>(message).unwrap(), bytes);
    let (read, length) = cdr_encoding::from_bytes::<M, LittleEndian>(&bytes).unwrap();
    assert_eq!((&read, length), (message, bytes.len()));
    for length in 0..bytes.len() {
        assert!(cdr_encoding::from_bytes::<M, LittleEndian>(&bytes[..length]).is_err(), "{length}");
    }
}

fn header() -> Header {
    Header { stamp: Time { sec: 7, nanosec: 80 }, frame_id: "cam".into() }
}

fn pose() -> Pose {
    Pose {
        position: Point { x: 1.0, y: 2.0, z: 3.0 },
        orientation: Quaternion { x: 0.5, y: -0.5, z: 0.5, w: -0.5 },
    }
}

fn compressed() -> CompressedImage {
    CompressedImage { header: header(), format: "jpeg".into(), data: vec![255, 216, 255] }
}

/// Half, one, one and a half and so on, from the number at `first` on.
fn numbers<const N: usize>(first: usize) -> [f64; N] {
    std::array::from_fn(|at| 0.5 * (first + at + 1) as f64)
}

#[test]
fn pictures_are_encoded_as_ros_does() {
    check(&Image {
        header: header(),
        height: 1,
        width: 2,
        encoding: "rgb8".into(),
        is_bigendian: 1,
        step: 7,
        data: (1..=7).collect(),
    });
    check(&compressed());
}

#[test]
fn a_camera_is_encoded_as_ros_does() {
    check(&CameraInfo {
        header: header(),
        height: 480,
        width: 640,
        distortion_model: "plumb_bob".into(),
        d: numbers::<5>(0).to_vec(),
        k: numbers(0),
        r: numbers(1),
        p: numbers(2),
        binning_x: 1,
        binning_y: 2,
        roi: RegionOfInterest { x_offset: 3, y_offset: 4, height: 5, width: 6, do_rectify: true },
    });
}

#[test]
fn a_pose_is_encoded_as_ros_does() {
    check(&PoseStamped { header: header(), pose: pose() });
}

#[test]
fn detections_are_encoded_as_ros_does() {
    let covariance = numbers::<36>(0);
    let covariance = std::array::from_fn(|row| std::array::from_fn(|column| covariance[6 * row + column]));
    let result = ObjectHypothesisWithPose {
        hypothesis: ObjectHypothesis { class_id: "pinch".into(), score: 0.75 },
        pose: PoseWithCovariance { pose: pose(), covariance },
    };
    let center = Pose2D { position: Point2D { x: 10.0, y: 20.0 }, theta: 0.25 };
    let detection = Detection2D {
        header: header(),
        results: vec![result],
        bbox: BoundingBox2D { center, size_x: 30.0, size_y: 40.0 },
        id: "a".into(),
    };
    check(&Detection2DArray { header: header(), detections: vec![detection] });
}

#[test]
fn markers_are_encoded_as_ros_does() {
    let marker = Marker {
        header: header(),
        ns: "hand".into(),
        id: 1,
        r#type: 5,
        action: 3,
        pose: pose(),
        scale: Point { x: 0.25, y: 0.5, z: 0.75 },
        color: ColorRgba { r: 0.25, g: 0.5, b: 0.75, a: 1.0 },
        lifetime: Time { sec: 1, nanosec: 2 },
        frame_locked: true,
        points: vec![Point { x: 4.0, y: 5.0, z: 6.0 }],
        colors: vec![ColorRgba { r: 1.0, g: 0.75, b: 0.5, a: 0.25 }],
        texture_resource: "t".into(),
        texture: compressed(),
        uv_coordinates: vec![UvCoordinate { u: 0.25, v: 0.75 }],
        text: "pinch".into(),
        mesh_resource: "m".into(),
        mesh_file: MeshFile { filename: "f".into(), data: vec![9] },
        mesh_use_embedded_materials: true,
    };
    check(&MarkerArray { markers: vec![marker] });
}

#[test]
fn a_grasp_is_encoded_as_ros_does() {
    let posture = |first: f64| JointTrajectory {
        header: header(),
        joint_names: vec!["one".into(), "three".into()],
        points: vec![JointTrajectoryPoint {
            positions: vec![first, 0.5],
            velocities: vec![1.5],
            accelerations: vec![2.5],
            effort: vec![3.5],
            time_from_start: Time { sec: 1, nanosec: 5 },
        }],
    };
    let translation = |least: f32| GripperTranslation {
        direction: Vector3Stamped { header: header(), vector: Point { x: 0.0, y: 0.5, z: 1.0 } },
        desired_distance: 0.5,
        min_distance: least,
    };
    check(&Grasp {
        id: "wrap".into(),
        pre_grasp_posture: posture(0.25),
        grasp_posture: posture(0.75),
        grasp_pose: PoseStamped { header: header(), pose: pose() },
        grasp_quality: 0.875,
        pre_grasp_approach: translation(0.125),
        post_grasp_retreat: translation(0.25),
        post_place_retreat: translation(0.375),
        max_contact_force: 15.0,
        allowed_touch_objects: vec!["cup".into()],
    });
}

#[test]
fn types_are_named_as_dds_names_them() {
    assert_eq!(Image::type_name().dds_msg_type(), "sensor_msgs::msg::dds_::Image_");
    assert_eq!(Detection2DArray::type_name().dds_msg_type(), "vision_msgs::msg::dds_::Detection2DArray_");
}
