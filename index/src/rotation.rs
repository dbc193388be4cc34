//! Rotations: the paper's three angles, and the orientation of a left hand.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// The angles `[roll, pitch, yaw]` of a rotation, in degrees, about the fixed axes x, y and z in
/// that order: `R = Rz(yaw) * Ry(pitch) * Rx(roll)`. Pitch lies in [-90, 90], the others in (-180,
/// 180].
pub fn euler_deg(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let (roll, pitch, yaw) = rotation.euler_angles();
    [roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees()]
}

/// The rotation with these angles; the inverse of [`euler_deg`].
pub fn from_euler_deg(angles: [f64; 3]) -> UnitQuaternion<f64> {
    let [roll, pitch, yaw] = angles.map(f64::to_radians);
    UnitQuaternion::from_euler_angles(roll, pitch, yaw)
}

/// The rotation whose matrix has about these first two columns, as networks answer with it: the
/// first is brought to unit length, the second made perpendicular to it (Y. Zhou et al., *On the
/// Continuity of Rotation Representations in Neural Networks*, CVPR 2019). `None` where they are
/// parallel, or one is nothing.
pub fn from_columns([ax, ay, az, bx, by, bz]: [f32; 6]) -> Option<UnitQuaternion<f64>> {
    let [first, second] = [[ax, ay, az], [bx, by, bz]].map(|v| Vector3::from(v.map(f64::from)));
    let first = first.try_normalize(1e-9)?;
    let second = (second - first * first.dot(&second)).try_normalize(1e-9)?;
    let matrix = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)))
}

/// The orientation `camera_from_hand` after the picture was turned clockwise by `turn_deg` degrees.
#[must_use]
pub fn turned_orientation(turn_deg: f64, camera_from_hand: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_deg.to_radians()) * camera_from_hand
}

/// The orientation `camera_from_hand` of a left hand whose flipped picture was recognised as a
/// right hand with the orientation `camera_from_right`, and the reverse.
///
/// `camera_from_left = M R S`: M = diag(-1, 1, 1) flips the picture back, S = diag(1, -1, 1) turns
/// a right hand's frame into a left one's (x to the middle knuckle and z out of the back stay, y =
/// z cross x holds for both hands).
pub fn mirror_orientation(camera_from_right: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    // M is -Rx(180 degrees) and S is -Ry(180 degrees); the signs cancel.
    let turn_x = Quaternion::new(0.0, 1.0, 0.0, 0.0);
    let turn_y = Quaternion::new(0.0, 0.0, 1.0, 0.0);
    UnitQuaternion::new_normalize(turn_x * camera_from_right.quaternion() * turn_y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn two_columns_make_a_rotation() {
        let rotation = from_euler_deg([20.0, -40.0, 130.0]);
        let matrix = rotation.to_rotation_matrix();
        let [a, b] = [0, 1].map(|column| matrix.matrix().column(column).into_owned());
        // Too long, and not quite perpendicular.
        let (a, b) = (3.0 * a, 0.5 * b + 0.2 * a);
        let columns = from_columns([a.x, a.y, a.z, b.x, b.y, b.z].map(|v| v as f32)).unwrap();
        assert!(columns.angle_to(&rotation) < 1e-6);
        assert_eq!(from_columns([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), None);
        assert_eq!(from_columns([1.0, 0.0, 0.0, -2.0, 0.0, 0.0]), None);
    }

    proptest! {
        #[test]
        fn mirroring_is_the_product_of_the_two_reflections(r in -180.0..180.0f64, p in -90.0..90.0f64, y in -180.0..180.0f64) {
            let right = from_euler_deg([r, p, y]);
            let flip_picture = Matrix3::from_diagonal(&[-1.0, 1.0, 1.0].into());
            let flip_hand = Matrix3::from_diagonal(&[1.0, -1.0, 1.0].into());
            let expected = flip_picture * right.to_rotation_matrix().matrix() * flip_hand;
            let left = mirror_orientation(&right);
            prop_assert!((left.to_rotation_matrix().matrix() - expected).norm() < 1e-12);
            prop_assert!(mirror_orientation(&left).angle_to(&right) < 1e-6);
        }

        #[test]
        fn angles_come_back(r in -179.0..179.0f64, p in -89.0..89.0f64, y in -179.0..179.0f64) {
            let back = euler_deg(&from_euler_deg([r, p, y]));
            for (got, expected) in back.iter().zip([r, p, y]) {
                prop_assert!((got - expected).abs() < 1e-6, "{back:?}");
            }
        }
    }

    #[test]
    fn the_angles_turn_about_fixed_axes_x_then_y_then_z() {
        let rotation = from_euler_deg([90.0, 0.0, 90.0]);
        // Rx(90) takes y to z; Rz(90) leaves z alone.
        let y = rotation * nalgebra::Vector3::y();
        assert!((y - nalgebra::Vector3::z()).norm() < 1e-12, "{y}");
    }
}
