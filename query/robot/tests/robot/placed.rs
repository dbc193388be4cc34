//! Where the palm goes.

use grasp_recognise::Side;
use grasp_robot::{Object, Strategy};
use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::{BOTTLE, bottle, camera, close, hand, isometry, seen, tilted, upright};

#[test]
fn the_palm_comes_from_where_the_human_hand_came() {
    let camera = camera();
    let strategy =
        Strategy::new(&hand("barrett"), &seen("power-sphere", upright(), &camera), &bottle(), &camera)
            .unwrap();
    assert_eq!((strategy.grasp.as_str(), strategy.human_grasp.as_str()), ("wrap", "power-sphere"));
    let palm = isometry(&strategy.palm_in_world);
    assert!(close(palm * Vector3::z(), Vector3::x()), "the approach is the human hand's");
    // Radius 35 mm and 10 mm between palm and bottle, at the height of its middle.
    assert!(close(palm.translation.vector, Vector3::new(0.50 - 0.045, 0.0, 0.08)), "{palm}");
    // The robot's thumb is on the side of the human's wrist, across the upright axis.
    assert!(close(palm * Vector3::y(), Vector3::y()));
    assert!((strategy.object_width - 0.07).abs() < 1e-6);
    // The wrist is a flange behind the palm; both frames are turned alike.
    let wrist = isometry(&strategy.wrist_in_world);
    assert!(close(wrist * Point3::new(0.0, 0.0, 0.08) - Point3::origin(), palm.translation.vector));
    assert_eq!(strategy.wrist.frame, "object");
}

#[test]
fn a_hand_from_above_stays_clear_of_the_table() {
    let camera = camera();
    let axes = Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()]);
    let flat = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes));
    let text = BOTTLE.replace("[0.50, 0.0, 0.08]", "[0.50, 0.0, 0.035]").replace(
        "[0.0, 0.0, 0.0, 1.0]",
        // Lying along the world's y.
        "[0.70710678, 0.0, 0.0, 0.70710678]",
    );
    let lying = Object::parse("lying.toml", &text).unwrap();
    let seen = seen("large-diameter", flat, &camera);
    let strategy = Strategy::new(&hand("barrett"), &seen, &lying, &camera).unwrap();
    let palm = isometry(&strategy.palm_in_world);
    assert!(close(palm * Vector3::z(), -Vector3::z()));
    assert!((palm.translation.z - 0.125).abs() < 1e-6, "80 mm would do for the object: {palm}");
}

#[test]
fn a_tilted_palm_stays_higher_for_the_tips_on_its_low_side() {
    let camera = camera();
    let disc = Object::parse("disc.toml", include_str!("../../../data/objects/disc.toml")).unwrap();
    for degrees in [0.0_f64, 10.0, 30.0] {
        let tilt = degrees.to_radians();
        let seen = seen("precision-disc", UnitQuaternion::new(Vector3::y() * tilt), &camera);
        let strategy = Strategy::new(&hand("barrett"), &seen, &disc, &camera).unwrap();
        let height = 0.110 * tilt.cos() + 0.075 * tilt.sin();
        let palm = isometry(&strategy.palm_in_world);
        assert!((palm.translation.z - height).abs() < 1e-6, "{degrees} degrees: {palm}");
    }
}

#[test]
fn a_known_hand_position_moves_the_grip_along_the_object() {
    let mut camera = camera();
    let seen = seen("large-diameter", upright(), &camera);
    let assumed = Strategy::new(&hand("barrett"), &seen, &bottle(), &camera).unwrap();
    assert_eq!(assumed.estimate.hand_position, "assumed");
    // A wrist whose grip is 30 mm above the bottle's middle.
    let grip = Vector3::new(0.50, 0.0, 0.11);
    let wrist = grip - upright() * Vector3::new(0.089, 0.013, -0.059);
    camera.hand = Some(camera.world_from_camera.inverse() * Point3::from(wrist));
    let given = Strategy::new(&hand("barrett"), &seen, &bottle(), &camera).unwrap();
    assert_eq!(given.estimate.hand_position, "given");
    let [a, b] = [&assumed, &given].map(|strategy| isometry(&strategy.palm_in_world).translation.vector);
    assert!((b - a - Vector3::new(0.0, 0.0, 0.03)).norm() < 1e-6, "{a} {b}");
}

#[test]
fn no_part_of_a_tilted_palm_is_in_the_object() {
    let camera = camera();
    let barrett = hand("barrett");
    for degrees in [0.0_f64, 15.0, 32.0] {
        let found =
            Strategy::new(&barrett, &seen("power-sphere", tilted(degrees), &camera), &bottle(), &camera)
                .unwrap();
        let palm = isometry(&found.palm);
        let down = (isometry(&found.palm_in_world) * Vector3::z()).z;
        assert!((down + degrees.to_radians().sin()).abs() < 1e-6, "{down}");
        // Ten millimetres of air before the nearest point of its face, along the approach.
        let rim = |angle: f64, ahead: f64| {
            let (sin, cos) = angle.sin_cos();
            let point = palm * Point3::new(barrett.palm_radius * cos, barrett.palm_radius * sin, ahead);
            bottle().shape.distance(&point)
        };
        let nearest = |ahead: f64| {
            (0..360).map(|degrees| rim(f64::from(degrees).to_radians(), ahead)).fold(f64::INFINITY, f64::min)
        };
        assert!(nearest(0.0099) > 0.0, "{degrees}");
        assert!(degrees == 0.0 || nearest(0.0101) == 0.0, "{degrees}");
    }
}

proptest! {
    /// However the hand is turned: the palm looks along the approach, a standoff before the
    /// surface, and left and right are mirror images.
    #[test]
    fn the_palm_always_faces_the_object(angles in prop::array::uniform3(-3.1f64..3.1), left: bool) {
        let camera = camera();
        let mut ball = Object::parse("ball", "shape = 'sphere'\nradius = 0.03\nposition = [0.4, 0.1, 0.5]\nquaternion_xyzw = [0, 0, 0, 1]").unwrap();
        ball.table = None;
        let [a, b, c] = angles;
        let mut seen = seen("large-diameter", UnitQuaternion::from_euler_angles(a, b, c), &camera);
        if left {
            seen.side = Side::Left;
        }
        let strategy = Strategy::new(&hand("barrett"), &seen, &ball, &camera).unwrap();
        let palm = isometry(&strategy.palm);
        prop_assert!((palm.translation.vector + 0.04 * (palm * Vector3::z())).norm() < 1e-9);
        prop_assert!((Vector3::from(strategy.approach_vector.vector) - palm * Vector3::z()).norm() < 1e-9);
    }
}
