//! `visualization_msgs/MarkerArray`: the hand's axes, a gripper that comes as the hand came, and
//! the grasp's name.

use grasp_terminal::text::percent;
use nalgebra::UnitQuaternion;

use super::{Hand, quaternion};
use crate::messages::geometry::{Point, Pose};
use crate::messages::standard::{ColorRgba, Header, Time};
use crate::messages::visualization::{Marker, MarkerArray};

/// After this many seconds the markers of a camera that has stopped disappear.
const LIFETIME: Time = Time { sec: 1, nanosec: 0 };
/// The length of the axes, in metres: about that of the back of a hand.
const AXIS: f64 = 0.1;
/// Half the opening of the gripper, and the length of its fingers, in metres.
const GRIPPER: [f64; 2] = [0.04, 0.06];
/// From where the gripper comes, in metres before the hand.
const APPROACH: f64 = 0.2;

const RED: ColorRgba = ColorRgba { r: 0.9, g: 0.1, b: 0.1, a: 1.0 };
const GREEN: ColorRgba = ColorRgba { r: 0.1, g: 0.7, b: 0.1, a: 1.0 };
const BLUE: ColorRgba = ColorRgba { r: 0.2, g: 0.3, b: 1.0, a: 1.0 };
const ORANGE: ColorRgba = ColorRgba { r: 1.0, g: 0.6, b: 0.0, a: 1.0 };
const WHITE: ColorRgba = ColorRgba { r: 1.0, g: 1.0, b: 1.0, a: 1.0 };

/// The markers of a hand; what takes earlier ones away where the hand is unknown, or there is no
/// hand.
pub(crate) fn message(header: &Header, hand: Option<&Hand>) -> MarkerArray {
    let Some(hand) = hand else {
        let header = header.clone();
        return MarkerArray {
            markers: vec![Marker { header, action: Marker::DELETE_ALL, ..Marker::default() }],
        };
    };
    let mut markers = vec![axes(hand), name(hand)];
    // Grasps of an index that are none of the six have no approach.
    if let Ok(hand_from_palm) = grasp_robot::hand_from_palm(hand.grasp().0, hand.side) {
        let palm = hand.rotation * hand_from_palm;
        markers.extend([gripper(hand, &palm), approach(hand, &palm)]);
    }
    MarkerArray { markers }
}

fn marker(hand: &Hand, ns: &str, r#type: i32, rotation: &UnitQuaternion<f64>) -> Marker {
    let pose = Pose { orientation: quaternion(rotation), ..hand.pose() };
    Marker {
        header: hand.header.clone(),
        ns: ns.to_owned(),
        r#type,
        pose,
        color: WHITE,
        lifetime: LIFETIME,
        ..Marker::default()
    }
}

fn point(x: f64, y: f64, z: f64) -> Point {
    Point { x, y, z }
}

/// x to the middle knuckle in red, y to a right hand's thumb in green, z out of the back in blue.
fn axes(hand: &Hand) -> Marker {
    let origin = Point::default();
    let ends = [point(AXIS, 0.0, 0.0), point(0.0, AXIS, 0.0), point(0.0, 0.0, AXIS)];
    Marker {
        scale: point(0.008, 0.0, 0.0),
        points: ends.into_iter().flat_map(|end| [origin, end]).collect(),
        colors: [RED, GREEN, BLUE].into_iter().flat_map(|colour| [colour; 2]).collect(),
        ..marker(hand, "hand", Marker::LINE_LIST, &hand.rotation)
    }
}

/// Two fingers and the bar between them, closing along the palm's y around the hand's place.
fn gripper(hand: &Hand, palm: &UnitQuaternion<f64>) -> Marker {
    let [half, length] = GRIPPER;
    let (near, far) = (-length, 0.0);
    let left = [point(0.0, half, near), point(0.0, half, far)];
    let right = [point(0.0, -half, near), point(0.0, -half, far)];
    let bar = [left[0], right[0]];
    Marker {
        scale: point(0.012, 0.0, 0.0),
        color: ORANGE,
        points: [left, right, bar].concat(),
        ..marker(hand, "gripper", Marker::LINE_LIST, palm)
    }
}

/// An arrow along the palm's z.
fn approach(hand: &Hand, palm: &UnitQuaternion<f64>) -> Marker {
    Marker {
        // Of the shaft, of the head, and the head's length.
        scale: point(0.01, 0.02, 0.03),
        color: ORANGE,
        points: vec![point(0.0, 0.0, -APPROACH), point(0.0, 0.0, -GRIPPER[1])],
        ..marker(hand, "approach", Marker::ARROW, palm)
    }
}

fn name(hand: &Hand) -> Marker {
    let (grasp, probability) = hand.grasp();
    let mut text = Marker {
        // The height of its letters.
        scale: point(0.0, 0.0, 0.03),
        text: format!("{grasp} {} ({} hand)", percent(probability), hand.side),
        ..marker(hand, "name", Marker::TEXT_VIEW_FACING, &UnitQuaternion::identity())
    };
    // Above the axes: y points down.
    text.pose.position.y -= 1.3 * AXIS;
    text
}
