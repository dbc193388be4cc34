//! How a person's hand meets the object in each grasp: what a strategy imitates.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;

use grasp_recognise::Side;

/// A human grasp, in the frame of a right hand.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HumanGrasp {
    approach: [f64; 3],
    thumb: [f64; 3],
    centre: [f64; 3],
}

static GRASPS: LazyLock<BTreeMap<String, HumanGrasp>> = LazyLock::new(|| {
    toml::from_str(include_str!("../../data/human-grasps.toml")).expect("a test reads the same file")
});

impl HumanGrasp {
    /// The grasp of this name, if it is one of the six.
    pub(super) fn named(name: &str) -> Option<&'static Self> {
        GRASPS.get(name)
    }

    /// The names of all six.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        GRASPS.keys().map(String::as_str)
    }

    /// How a robot's palm is turned in the hand's frame that imitates the hand: its z is the hand's
    /// approach, its y points to the thumb's side.
    pub(super) fn hand_from_palm(&self, side: Side) -> UnitQuaternion<f64> {
        let z = mirrored(self.approach, side).normalize();
        let thumb = mirrored(self.thumb, side);
        let y = (thumb - z * thumb.dot(&z)).normalize();
        let axes = Matrix3::from_columns(&[y.cross(&z), y, z]);
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
    }

    /// Where the held object's middle lies in the hand's frame, in metres.
    pub(super) fn centre(&self, side: Side) -> Point3<f64> {
        mirrored(self.centre, side).into()
    }
}

fn mirrored([x, y, z]: [f64; 3], side: Side) -> Vector3<f64> {
    match side {
        Side::Right => Vector3::new(x, y, z),
        Side::Left => Vector3::new(x, -y, z),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_six_grasps_are_there_with_proper_rotations() {
        let names: Vec<&str> = HumanGrasp::names().collect();
        let six =
            ["abducted-thumb", "large-diameter", "pinch", "power-sphere", "precision-disc", "small-diameter"];
        assert_eq!(names, six);
        for grasp in GRASPS.values() {
            for side in [Side::Left, Side::Right] {
                let palm = grasp.hand_from_palm(side);
                assert!((palm * Vector3::z() - mirrored(grasp.approach, side).normalize()).norm() < 1e-9);
                // Right-handed: nothing of the axes was lost when they became a quaternion.
                assert!(
                    (palm * Vector3::x()).cross(&(palm * Vector3::y())).dot(&(palm * Vector3::z())) > 0.999
                );
            }
        }
    }

    #[test]
    fn a_left_hand_is_the_mirror_image() {
        let pinch = HumanGrasp::named("abducted-thumb").unwrap();
        let [right, left] = [Side::Right, Side::Left].map(|side| pinch.hand_from_palm(side) * Vector3::y());
        assert!((right.y + left.y).abs() < 1e-9 && (right.x - left.x).abs() < 1e-9 && right.y.abs() > 0.1);
    }
}
