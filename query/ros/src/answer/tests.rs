use std::path::PathBuf;

use nalgebra::Vector3;

use super::*;
use crate::messages::standard::Time;
use crate::messages::visualization::Marker;
use grasp::{NoGrasp, Robot};

fn header() -> Header {
    Header { stamp: Time { sec: 3, nanosec: 4 }, frame_id: "camera_optical".into() }
}

/// A right hand that comes to the bottle from its side, as the camera of the sample files sees it.
fn hand() -> Hand {
    let classes = [("large-diameter", 0.7), ("pinch", 0.3)].map(|(name, share)| (name.to_owned(), share));
    let sideways = UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::PI);
    Hand {
        header: header(),
        side: Side::Right,
        classes: classes.to_vec(),
        rectangle: Rectangle { centre: [320.0, 200.0], size: [100.0, 80.0] },
        rotation: sideways,
        spread_deg: 18.0,
        position: [0.1, 0.2, 0.8],
    }
}

fn described(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../data/objects").join(name)
}

fn robot(world: &str) -> Robot {
    let (object, camera) = (described("bottle.toml"), described("camera.toml"));
    Robot::read("barrett", [&object, &camera], None, world).unwrap()
}

#[test]
fn a_detection_has_all_classes_and_the_pictures_header() {
    let message = detection::message(&header(), Some(&hand()));
    assert_eq!(message.header, header());
    let [detection] = message.detections.as_slice() else { panic!("{message:?}") };
    let named: Vec<(&str, f64)> = detection
        .results
        .iter()
        .map(|result| (result.hypothesis.class_id.as_str(), result.hypothesis.score))
        .collect();
    assert_eq!(named, [("large-diameter", 0.7), ("pinch", 0.3)]);
    let pose = detection.results[0].pose;
    assert_eq!(pose.pose, hand().pose());
    assert_eq!(pose.covariance[0], [0.0; 6]);
    let each = 18f64.to_radians().powi(2) / 3.0;
    assert!((3..6).all(|axis| (pose.covariance[axis][axis] - each).abs() < 1e-12));
    assert_eq!((detection.bbox.center.position.x, detection.bbox.size_y), (320.0, 80.0));
}

#[test]
fn what_is_unknown_is_no_detection_and_takes_the_markers_away() {
    let message = detection::message(&header(), None);
    assert_eq!((message.header, message.detections.len()), (header(), 0));
    let markers = marker::message(&header(), None).markers;
    assert_eq!((markers.len(), markers[0].action), (1, Marker::DELETE_ALL));
}

#[test]
fn markers_show_the_axes_the_gripper_and_the_name() {
    let markers = marker::message(&header(), Some(&hand())).markers;
    let named: Vec<&str> = markers.iter().map(|marker| marker.ns.as_str()).collect();
    assert_eq!(named, ["hand", "name", "gripper", "approach"]);
    assert_eq!(markers[1].text, "large-diameter 70 % (right hand)");
    for marker in &markers {
        assert_eq!(marker.header, header());
        assert!(marker.colors.is_empty() || marker.colors.len() == marker.points.len());
        let is_line = marker.r#type == Marker::LINE_LIST;
        assert!(!is_line || marker.points.len() % 2 == 0);
    }
    // The robot's palm comes as the human one: its z is the approach of the recognised hand.
    let palm = rotation(&markers[3].pose.orientation).unwrap();
    let expected = hand().rotation * grasp_robot::hand_from_palm("large-diameter", Side::Right).unwrap();
    assert!(palm.angle_to(&expected) < 1e-9);
    let mut other = hand();
    other.classes = vec![("fist".into(), 1.0)];
    assert_eq!(marker::message(&header(), Some(&other)).markers.len(), 2);
}

#[test]
fn a_grasp_is_the_strategys_with_the_pictures_stamp() {
    let robot = robot("map");
    let rotations = (0..24).map(|step| {
        let about = UnitQuaternion::from_euler_angles(0.0, f64::from(step / 8), f64::from(step % 8) * 0.8);
        Hand { rotation: about, ..hand() }
    });
    let grasps: Vec<_> = rotations.map(|hand| robot.grasp(&hand, None)).collect();
    let feasible: Vec<_> = grasps.iter().flatten().collect();
    assert!(!feasible.is_empty(), "{grasps:?}");
    for grasp in feasible {
        assert_eq!(grasp.grasp_pose.header.frame_id, "map");
        assert_eq!(grasp.grasp_pose.header.stamp, header().stamp);
        assert!(!grasp.grasp_posture.joint_names.is_empty());
        assert_eq!(grasp.grasp_posture.joint_names.len(), grasp.grasp_posture.points[0].positions.len());
        assert!(grasp.pre_grasp_approach.desired_distance > 0.0);
        let turned = rotation(&grasp.grasp_pose.pose.orientation).unwrap();
        let approach = turned * Vector3::z();
        assert!(approach.norm() > 0.99);
    }
}

#[test]
fn an_object_is_where_its_pose_says_in_a_frame_that_is_known() {
    let robot = robot("world");
    let placed = |frame: &str, position: [f64; 3], w: f64| {
        let [x, y, z] = position;
        let orientation = geometry::Quaternion { w, ..geometry::Quaternion::default() };
        let pose = Pose { position: geometry::Point { x, y, z }, orientation };
        PoseStamped { header: Header { frame_id: frame.into(), ..Header::default() }, pose }
    };
    let of = |object: &PoseStamped| robot.grasp(&hand(), Some(object));
    let error = of(&placed("odom", [0.0; 3], 1.0)).unwrap_err().to_string();
    assert!(error.contains("\"odom\"") && error.contains("\"camera_optical\""), "{error}");
    assert!(matches!(of(&placed("world", [0.0; 3], 0.5)), Err(NoGrasp::Pose)));
    assert!(matches!(of(&placed("world", [f64::NAN; 3], 1.0)), Err(NoGrasp::Pose)));
    assert!(matches!(of(&placed("world", [0.0, 0.0, -0.5], 1.0)), Err(NoGrasp::Robot(_))));
    // Behind the camera, in its own frame and in the world.
    for behind in [placed("camera_optical", [0.0, 0.0, -0.4], 1.0), placed("world", [-0.5, 0.0, 0.3], 1.0)] {
        let error = of(&behind).unwrap_err();
        assert_eq!(error.kind(), "behind_camera");
        assert!(error.to_string().contains("behind it"), "{error}");
    }
    let sound = of(&placed("world", [0.5, 0.0, 0.3], 1.0));
    assert!(matches!(sound, Ok(_) | Err(NoGrasp::Infeasible(_))), "{sound:?}");
}

#[test]
fn a_quaternion_that_is_no_rotation_is_none() {
    assert!(rotation(&geometry::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }).is_none());
    assert!(rotation(&geometry::Quaternion { x: f64::NAN, y: 0.0, z: 0.0, w: 1.0 }).is_none());
    assert!(rotation(&geometry::Quaternion::default()).is_some());
}
