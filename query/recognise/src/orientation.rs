//! The rotation `camera_from_hand` as four numbers and in words.

use grasp_index::{OrientationEstimate, euler_deg, mean_rotation, mirror_orientation, turned_orientation};
use nalgebra::{UnitQuaternion, Vector3};

use crate::Side;

/// A rotation as x, y, z, w, with w >= 0: q and -q are the same rotation, and only one of them is
/// written.
pub fn xyzw(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    let q = rotation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [q.i * sign, q.j * sign, q.k * sign, q.w * sign]
}

/// The orientation in a picture of a hand that was seen as `seen` after the picture was flipped for
/// a left hand and turned clockwise by `roll_deg` degrees.
pub(crate) fn in_picture(side: Side, roll_deg: f64, seen: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let level = turned_orientation(-roll_deg, seen);
    match side {
        Side::Right => level,
        Side::Left => mirror_orientation(&level),
    }
}

/// How far from an orientation another one may lie to count beside it: of a hand that is once seen
/// from before and once from behind, the mean is nobody's. Chosen on pictures of two hands
/// (docs/trials.md).
const NEAR_DEG: f64 = 40.0;

/// Makes an orientation the mean of itself and of those of the others that lie near it, where
/// `share` of their number is how much they count together, 0 to 1. Its spread stays that of the
/// neighbours about their own mean.
pub(crate) fn join_near(
    orientation: &mut OrientationEstimate,
    others: &[UnitQuaternion<f64>],
    share: impl Fn(usize) -> f64,
) {
    let own = orientation.rotation;
    let is_near = |other: &&UnitQuaternion<f64>| other.angle_to(&own) < NEAR_DEG.to_radians();
    let near: Vec<_> = others.iter().filter(is_near).collect();
    if !near.is_empty() {
        let share = share(near.len());
        let each = share / near.len() as f64;
        let near = near.into_iter().map(|rotation| (*rotation, each));
        let all: Vec<_> = std::iter::once((own, 1.0 - share)).chain(near).collect();
        orientation.rotation = mean_rotation(&all).unwrap_or(own);
    }
    orientation.euler_deg = euler_deg(&orientation.rotation);
}

/// Which side of the hand the camera sees, such as `the thumb side`.
///
/// The camera's direction is taken in the frame of the hand: x from the wrist to the knuckles, z
/// out of the back, y = z cross x, which is the thumb's side of a right hand and the little
/// finger's of a left one.
pub fn side_seen(camera_from_hand: &UnitQuaternion<f64>, side: Side) -> &'static str {
    let to_camera = camera_from_hand.inverse() * Vector3::new(0.0, 0.0, -1.0);
    let to_thumb = match side {
        Side::Right => to_camera.y,
        Side::Left => -to_camera.y,
    };
    let names = [
        (to_camera.z, "the back of the hand"),
        (-to_camera.z, "the palm"),
        (to_thumb, "the thumb side"),
        (-to_thumb, "the little-finger side"),
        (to_camera.x, "the fingertips"),
        (-to_camera.x, "the wrist"),
    ];
    names.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or("the hand", |(_, name)| name)
}

/// Where the fingers point in the picture, such as `up and left`, or `toward the camera`.
pub fn fingers_point(camera_from_hand: &UnitQuaternion<f64>) -> &'static str {
    let fingers = camera_from_hand * Vector3::x();
    if fingers.xy().norm() < 0.4 {
        return if fingers.z < 0.0 { "toward the camera" } else { "away from the camera" };
    }
    // y is down in the camera's frame; eight directions, counterclockwise from the right.
    let eighth = libm::atan2(-fingers.y, fingers.x) / std::f64::consts::FRAC_PI_4;
    match (eighth.round() as i64).rem_euclid(8) {
        0 => "right",
        1 => "up and right",
        2 => "up",
        3 => "up and left",
        4 => "left",
        5 => "down and left",
        6 => "down",
        _ => "down and right",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3};

    /// The rotation whose columns are the hand's axes as the camera sees them.
    fn seen(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> UnitQuaternion<f64> {
        let columns = [x.into(), y.into(), z.into()];
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&Matrix3::from_columns(&columns)))
    }

    #[test]
    fn turning_the_picture_turns_the_answer_back() {
        let seen = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0);
        // The hand as it was given, turned clockwise by 90 degrees, is what was recognised.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2) * seen;
        assert!(in_picture(Side::Right, 90.0, &turned).angle_to(&seen) < 1e-9);
        let left = mirror_orientation(&seen);
        assert!(in_picture(Side::Left, 90.0, &turned).angle_to(&left) < 1e-9);
    }

    #[test]
    fn a_right_hand_laid_flat_under_the_camera_shows_its_back() {
        // Fingers up in the picture, back toward the camera: the thumb of a right hand is then on
        // the left.
        let rotation = seen([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
        assert_eq!(side_seen(&rotation, Side::Right), "the back of the hand");
        assert_eq!(fingers_point(&rotation), "up");
    }

    #[test]
    fn a_hand_that_points_at_the_camera_shows_its_fingertips() {
        let rotation = seen([0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]);
        assert_eq!(side_seen(&rotation, Side::Right), "the fingertips");
        assert_eq!(fingers_point(&rotation), "toward the camera");
    }

    #[test]
    fn the_flipped_picture_of_a_thumb_side_shows_the_thumb_side_of_a_left_hand() {
        let right = seen([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        assert_eq!(side_seen(&right, Side::Right), "the thumb side");
        assert_eq!(fingers_point(&right), "right");
        let left = mirror_orientation(&right);
        assert_eq!(side_seen(&left, Side::Left), "the thumb side");
        assert_eq!(fingers_point(&left), "left");
    }
}
