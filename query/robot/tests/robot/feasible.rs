//! What cannot be right, as a problem or as an error.

use grasp_robot::{Camera, Object, ProblemKind, RobotError, RobotHand, Setting, Strategy};
use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::{BOTTLE, CAMERA, bottle, camera, hand, kinds, seen, upright};

#[test]
fn what_cannot_be_right_is_a_problem() {
    let of = |grasp: &str, turned: UnitQuaternion<f64>, object: &Object, camera: &Camera| {
        Strategy::new(&hand("barrett"), &seen(grasp, turned, camera), object, camera).unwrap()
    };
    let camera = camera();
    let sound = of("large-diameter", upright(), &bottle(), &camera);
    assert_eq!(kinds(&sound), []);
    // Within +-30 mm at a standard deviation of 10 mm, and a tilt of +-15 degrees at one of 8.
    assert!((sound.quality.unwrap() - 0.9973 * 0.9973 * 0.938).abs() < 2e-3, "{:?}", sound.quality);

    // From below, through the table.
    let below = of("large-diameter", UnitQuaternion::new(Vector3::x() * 3.0), &bottle(), &camera);
    assert_eq!((kinds(&below), below.quality), (vec![ProblemKind::BelowTable], Some(0.0)));
    // From the side to something that lies: the fingers close across its axis, one of them under
    // it.
    let lying = BOTTLE.replace("[0.50, 0.0, 0.08]", "[0.50, 0.0, 0.035]");
    let lying = lying.replace("[0.0, 0.0, 0.0, 1.0]", "[0.70710678, 0.0, 0.0, 0.70710678]");
    let lying = Object::parse("lying.toml", &lying).unwrap();
    let flat = Matrix3::from_columns(&[-Vector3::z(), -Vector3::y(), -Vector3::x()]);
    let flat = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&flat));
    let sideways = of("large-diameter", flat, &lying, &camera);
    assert_eq!(kinds(&sideways), [ProblemKind::BelowTable]);
    // Millimetres where metres are asked for.
    let mut astray = camera.clone();
    astray.hand = Some(Point3::new(-60.0, 20.0, 750.0));
    let astray = of("large-diameter", upright(), &bottle(), &astray);
    assert_eq!(kinds(&astray), [ProblemKind::HandAway]);
    let said = [&below, &sideways, &astray].map(|strategy| strategy.warnings.join("\n"));
    insta::assert_snapshot!(said.join("\n\n"));
    // A hand of one's own without a description of its fingers.
    let text = include_str!("../../../data/robots/parallel-gripper.toml");
    let bare: Vec<&str> = text.split("[[finger]]").collect();
    let bare = format!("{}[map]{}", bare[0], bare[2].split("[map]").nth(1).unwrap());
    let bare = RobotHand::parse("own.toml", &bare).unwrap();
    let strategy = Strategy::new(&bare, &seen("pinch", upright(), &camera), &bottle(), &camera).unwrap();
    assert!(strategy.feasible && strategy.layout.fingers.is_empty());
}

#[test]
fn fingers_that_close_before_the_object_are_a_problem() {
    let camera = camera();
    let disc =
        include_str!("../../../data/objects/disc.toml").replace("[0.0, 0.0, 0.015]", "[0.5, 0.0, 0.015]");
    let disc = Object::parse("disc.toml", &disc).unwrap();
    let of = |degrees: f64| {
        let turned = UnitQuaternion::new(Vector3::y() * degrees.to_radians());
        Strategy::new(&hand("barrett"), &seen("precision-disc", turned, &camera), &disc, &camera).unwrap()
    };
    assert_eq!(kinds(&of(7.0)), []);
    // The table keeps the palm away: it stays 110 mm above it and, tilted so, 44 mm more.
    let tilted = of(36.0);
    assert_eq!(kinds(&tilted), [ProblemKind::PalmAway]);
    insta::assert_snapshot!(tilted.warnings[0], @"the palm would stay 107 mm away from disc, and its fingers, closing, come no nearer than 32 mm to it from both sides: check the positions of hand, camera and object, or approach it less tilted");
}

#[test]
fn what_is_wider_than_the_fingers_open_is_refused() {
    let camera = camera();
    let tank = "name = 'tank'\nshape = 'cylinder'\nradius = 0.2\nheight = 0.5\nposition = [0.7, 0.0, 0.25]\nquaternion_xyzw = [0, 0, 0, 1]\ntable = 0.0";
    let tank = Object::parse("tank.toml", tank).unwrap();
    let seen = seen("power-sphere", upright(), &camera);
    let error = Strategy::new(&hand("barrett"), &seen, &tank, &camera).unwrap_err();
    insta::assert_snapshot!(error, @"tank is 400 mm wide where the fingers close, and barrett opens to 175 mm: approach it from another side");
    // A hand of one's own that does not say how wide it opens.
    let mut own = hand("barrett");
    own.grasp.values_mut().for_each(|grasp| grasp.widest = None);
    let found = Strategy::new(&own, &seen, &tank, &camera).unwrap();
    assert_eq!(kinds(&found), [ProblemKind::InObject]);
    insta::assert_snapshot!(found.warnings[0], @"tank does not go between the open fingers, which would be 25 mm inside it: take a hand that opens wider, or approach it from another side");
}

#[test]
fn an_object_behind_the_camera_is_refused() {
    // As the camera of the sample files, but looking the other way.
    let behind =
        CAMERA.replace("[-0.59637, 0.59637, -0.37993, 0.37993]", "[-0.59637, -0.59637, 0.37993, 0.37993]");
    assert_ne!(behind, CAMERA);
    let behind = Camera::parse("camera.toml", &behind).unwrap();
    let seen = seen("power-sphere", upright(), &behind);
    let error = Strategy::new(&hand("barrett"), &seen, &bottle(), &behind).unwrap_err();
    assert_eq!(error.kind(), "behind_camera");
    insta::assert_snapshot!(error, @"bottle is at z = -0.514 m in the camera's frame, behind it, where no picture shows it: check position and quaternion_xyzw of camera and object; the camera's z points forward, its x right and its y down in the picture");
    let error = Setting::new(hand("barrett"), bottle(), behind).unwrap_err();
    assert!(matches!(error, RobotError::BehindCamera { .. }), "{error}");
}

#[test]
fn a_hand_behind_the_camera_is_refused() {
    let of = |hand: &str| {
        let text = CAMERA.replace("# hand = [-0.06, 0.02, 0.75]", hand);
        assert_ne!(text, CAMERA);
        Camera::parse("camera.toml", &text)
    };
    assert!(of("hand = [-0.06, 0.02, 0.75]").is_ok());
    assert!(of("hand = [0.0, 0.0, 0.0]").is_err());
    let error = of("hand = [-0.06, 0.02, -0.75]").unwrap_err();
    insta::assert_snapshot!(error, @"camera.toml is not a valid description of a camera: hand is at z = -0.75 m in the camera's frame, behind it, where no picture shows it: its z points forward, its x right and its y down in the picture");
}
