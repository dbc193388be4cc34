//! The BarrettHand BH8-280 as rigid links, in the palm's frame (origin in the middle of the palm's
//! surface, z the approach).
//!
//! Sources of the numbers: BH8-262 manual (the kinematic rows), GraspIt! and JHU models (lengths,
//! limits), Barrett's support pages (coupling, masses), public MJCF scripts (inertias). Shapes are
//! round boxes of the measured extents.

use std::f32::consts::{FRAC_PI_2, PI};

use rapier3d::math::{Pose, Rotation, Vector};

/// Fingers; the last, the "thumb", does not spread.
pub(super) const FINGERS: usize = 3;
/// The joints' names in a HAND.toml, as Barrett's own URDF has them: of each finger the inner and
/// the distal one, then what spreads fingers 1 and 2.
pub(super) const INNER_JOINTS: [&str; FINGERS] = ["bh_j12_joint", "bh_j22_joint", "bh_j32_joint"];
pub(super) const DISTAL_JOINTS: [&str; FINGERS] = ["bh_j13_joint", "bh_j23_joint", "bh_j33_joint"];
pub(super) const SPREAD_JOINT: &str = "bh_j11_joint";
/// From an inner joint's axis to the distal joint's, in metres.
pub(super) const INNER_LENGTH: f32 = 0.070;
/// From the distal joint's axis to the end of the finger, in metres.
pub(super) const DISTAL_LENGTH: f32 = 0.058;
/// From the palm's middle axis (of finger 3; 1 and 2 stand beside it) to the inner joints' axes, in
/// metres.
const KNUCKLE_LENGTH: f32 = 0.050;
/// How far fingers 1 and 2 stand from the middle, in metres.
const HALF_BREADTH: f32 = 0.025;
/// The inner joints' axes over the palm's surface, in metres: 75.4 mm over the flange, the surface
/// 80 mm.
const AXIS_HEIGHT: f32 = -0.0046;
/// What an inner link is turned by when its joint says 0, in radians.
const INNER_REST: f32 = 2.46 * PI / 180.0;
/// The bend between both links when the distal joint says 0, in radians.
const DISTAL_REST: f32 = 42.46 * PI / 180.0;
/// The inner and the distal joint's greatest angle, in radians; the least is 0.
pub(super) const LIMITS: [f32; 2] = [140.0 * PI / 180.0, 48.0 * PI / 180.0];

/// A rigid part: its mass, inertia about its centre, and its boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// In kilograms.
    pub(super) mass: f32,
    /// The centre of mass in the part's frame, in metres.
    pub(super) centre: Vector,
    /// Along the part's axes, in kg m^2.
    pub(super) inertia: Vector,
    /// What it looks like and collides as.
    pub(super) solid: Solid,
}

/// A round box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    /// Of the middle in the part's frame, in metres.
    pub(super) middle: Vector,
    /// Half the extents, rounding included, in metres.
    pub(super) half: Vector,
    /// The edges' rounding, in metres.
    pub(super) round: f32,
}

/// The palm, the knuckles that do not move in a grasp included: the spread is held while the
/// fingers close.
pub(super) const PALM: Part = Part {
    mass: 0.609 + 3.0 * 0.141,
    centre: Vector::new(0.0, 0.0, -0.040),
    inertia: Vector::new(9.0e-4, 7.0e-4, 8.3e-4),
    // A box of the circle's area (radius 44.5 mm).
    solid: Solid {
        middle: Vector::new(0.0, 0.0, -0.040),
        half: Vector::new(0.0394, 0.0394, 0.040),
        round: 0.004,
    },
};

/// The round part about an inner joint's axis, in the finger's frame: it is fixed to the palm.
pub(super) const KNUCKLE: Solid =
    Solid { middle: Vector::ZERO, half: Vector::new(0.015, 0.015, 0.015), round: 0.010 };

/// In the link's frame: x the joint's axis, y along the link, z to the inner side.
pub(super) const INNER: Part = Part {
    mass: 0.0621,
    centre: Vector::new(0.0, 0.035, 0.0),
    inertia: Vector::new(4.33e-5, 4.8e-6, 4.44e-5),
    solid: Solid {
        middle: Vector::new(0.0, 0.037, 0.0),
        half: Vector::new(0.0095, 0.033, 0.0105),
        round: 0.004,
    },
};

/// As [`INNER`].
pub(super) const DISTAL: Part = Part {
    mass: 0.0416,
    centre: Vector::new(0.0, 0.025, 0.0),
    inertia: Vector::new(1.69e-5, 3.1e-6, 1.58e-5),
    // 19 mm thick at the base, 13 mm at the tip.
    solid: Solid {
        middle: Vector::new(0.0, 0.5 * DISTAL_LENGTH, 0.0),
        half: Vector::new(0.0115, 0.5 * DISTAL_LENGTH, 0.008),
        round: 0.005,
    },
};

/// Where a finger is fastened, in the palm's frame: x the inner joint's axis, y outward, z the
/// approach. `finger` from 0; `spread` in radians.
pub(super) fn finger_base(finger: usize, spread: f32) -> Pose {
    let (side, direction) = match finger {
        0 => (-1.0, -FRAC_PI_2 - spread),
        1 => (1.0, -FRAC_PI_2 + spread),
        _ => (0.0, FRAC_PI_2),
    };
    let outward = Vector::new(direction.cos(), direction.sin(), 0.0);
    let at = Vector::new(side * HALF_BREADTH, 0.0, AXIS_HEIGHT) + outward * KNUCKLE_LENGTH;
    // x = y cross z, so that a positive angle closes.
    Pose::from_parts(at, Rotation::from_rotation_z(direction - FRAC_PI_2))
}

/// The inner link in the finger's base, for its joint's angle.
pub(super) fn base_from_inner(angle: f32) -> Pose {
    Pose::from_rotation(Rotation::from_rotation_x(INNER_REST + angle))
}

/// The distal link in the inner link, for its joint's angle.
pub(super) fn inner_from_distal(angle: f32) -> Pose {
    Pose::from_parts(Vector::new(0.0, INNER_LENGTH, 0.0), Rotation::from_rotation_x(DISTAL_REST + angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of a finger in the palm's frame.
    fn tip(finger: usize, spread: f32, inner: f32, distal: f32) -> Vector {
        let link = finger_base(finger, spread) * base_from_inner(inner) * inner_from_distal(distal);
        link.transform_point(Vector::new(0.0, DISTAL_LENGTH, 0.0))
    }

    #[test]
    fn fingers_stand_where_the_manual_puts_them() {
        // The modified D-H rows, multiplied out by hand for an angle of 90 degrees less both rests:
        // the finger is straight up to the distal joint, and bent inward by 42.46 degrees beyond
        // it.
        let up = FRAC_PI_2 - INNER_REST;
        let bent = DISTAL_REST;
        for (finger, x, sign) in [(0, -0.025, -1.0), (1, 0.025, -1.0), (2, 0.0, 1.0)] {
            let expected =
                Vector::new(x, sign * (0.050 - 0.058 * bent.sin()), -0.0046 + 0.070 + 0.058 * bent.cos());
            assert!((tip(finger, 0.0, up, 0.0) - expected).length() < 1e-5, "finger {finger}");
        }
    }

    #[test]
    fn the_description_draws_the_fingers_that_are_simulated() {
        let hand = crate::RobotHand::find("barrett").unwrap();
        for (spread, inner, distal) in [(0.0, 0.75, 0.25), (PI / 3.0, 0.7, 0.233), (0.4, 2.0, 0.8)] {
            let mut posture = std::collections::BTreeMap::new();
            for finger in [1, 2, 3] {
                for (joint, value) in [(1, spread), (2, inner), (3, distal)] {
                    posture.insert(format!("bh_j{finger}{joint}_joint"), f64::from(value));
                }
            }
            for (at, finger) in hand.finger.iter().enumerate() {
                let points = finger.points(&posture);
                let tip = points.last().unwrap().coords.map(|metres| metres as f32);
                let off = tip - nalgebra::Vector3::from(self::tip(at, spread, inner, distal).to_array());
                assert!(off.norm() < 1e-4 && points.len() == 3, "finger {at}: {off}");
            }
        }
    }

    #[test]
    fn finger_2_mirrors_the_spread_of_finger_1() {
        for spread in [0.0, 0.4, PI / 3.0, PI] {
            let [one, two] = [0, 1].map(|finger| tip(finger, spread, 0.7, 0.2));
            assert!((one * Vector::new(-1.0, 1.0, 1.0) - two).length() < 1e-6);
            assert!((tip(2, spread, 0.7, 0.2) - tip(2, 0.0, 0.7, 0.2)).length() < 1e-9);
        }
        // At 60 degrees the fingers point 120 degrees apart.
        let outward = |finger| finger_base(finger, PI / 3.0).transform_vector(Vector::Y);
        assert!((outward(0).dot(outward(1)) + 0.5).abs() < 1e-5);
        assert!((outward(0).dot(outward(2)) + 0.5).abs() < 1e-5);
    }

    #[test]
    fn the_parts_weigh_what_the_hand_weighs() {
        let mass = PALM.mass + 3.0 * (INNER.mass + DISTAL.mass);
        assert!((mass - 1.343).abs() < 0.01, "{mass}");
    }
}
