//! From a recognised hand to what a robot does: geometry, warnings, the two hands, bad input.

use grasp_recognise::Side;
use grasp_robot::{
    Arm, Camera, Hindrance, Object, ObservedHand, ProblemKind, RobotError, RobotHand, Setting, Shape, Step,
    Strategy, moveit,
};
use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

const BOTTLE: &str = include_str!("../../data/objects/bottle.toml");
const ARM: &str = include_str!("../../data/arms/kuka-kr6-r700.toml");
const CAMERA: &str = include_str!("../../data/objects/camera.toml");

fn hand(name: &str) -> RobotHand {
    RobotHand::find(name).unwrap()
}

fn bottle() -> Object {
    Object::parse("bottle.toml", BOTTLE).unwrap()
}

fn camera() -> Camera {
    Camera::parse("camera.toml", CAMERA).unwrap()
}

/// A right hand round an upright bottle: the thumb up, the palm coming along the world's x.
fn upright() -> UnitQuaternion<f64> {
    // Columns: where the hand's x, y, z point in the world.
    let axes = Matrix3::from_columns(&[-Vector3::y(), Vector3::z(), -Vector3::x()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes))
}

fn seen(grasp: &str, world_from_hand: UnitQuaternion<f64>, camera: &Camera) -> ObservedHand {
    let camera_from_hand = camera.world_from_camera.rotation.inverse() * world_from_hand;
    ObservedHand { grasp: grasp.into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 }
}

fn isometry(pose: &grasp_robot::Pose) -> Isometry3<f64> {
    let [x, y, z, w] = pose.quaternion_xyzw;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(pose.position.into(), rotation)
}

fn close(a: Vector3<f64>, b: Vector3<f64>) -> bool {
    (a - b).norm() < 1e-6
}

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
    let disc = Object::parse("disc.toml", include_str!("../../data/objects/disc.toml")).unwrap();
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
fn another_hand_is_another_file() {
    let camera = camera();
    let seen = seen("pinch", upright(), &camera);
    let strategy = Strategy::new(&hand("parallel-gripper"), &seen, &bottle(), &camera).unwrap();
    assert_eq!(strategy.grasp, "parallel");
    assert_eq!(strategy.open["gripper_left_finger_joint"], 0.04);
    let wide = BOTTLE.replace("radius = 0.035", "radius = 0.05");
    let wide = Object::parse("wide.toml", &wide).unwrap();
    let error = Strategy::new(&hand("parallel-gripper"), &seen, &wide, &camera).unwrap_err();
    insta::assert_snapshot!(error, @"bottle is 100 mm wide where the fingers close, and parallel-gripper opens to 75 mm: approach it from another side");
}

#[test]
fn every_human_grasp_has_a_counterpart_as_in_the_paper() {
    let barrett = hand("barrett");
    let robot = |human: &str| barrett.for_human(human).unwrap().0;
    for human in ["large-diameter", "small-diameter", "abducted-thumb", "power-sphere"] {
        assert_eq!(robot(human), "wrap");
    }
    assert_eq!((robot("pinch"), robot("precision-disc")), ("two-finger-thumb", "precision-disc"));
    assert!(matches!(barrett.for_human("wave"), Err(RobotError::Unmapped { .. })));
}

#[test]
fn what_is_less_sure_than_the_grasp_tolerates_is_said() {
    let text = include_str!("../../data/robots/parallel-gripper.toml").to_owned()
        + "[[grasp.parallel.window]]\nposition_m = 0.005\nyaw_rad = 0.1\nobject = \"bottle\"\nwidth_m = 0.07\nfrom = \"side\"\nengine = \"none\"\n";
    let hand = RobotHand::parse("own.toml", &text).unwrap();
    let camera = camera();
    let strategy =
        Strategy::new(&hand, &seen("large-diameter", upright(), &camera), &bottle(), &camera).unwrap();
    insta::assert_snapshot!(strategy.warnings.join("\n"), @"
    the hand's position is known to +-10 mm, the grasp tolerates +-5 mm
    the hand's orientation is known to +-8 degrees, the grasp tolerates a yaw of +-6: take it as a first guess and correct it by touch
    ");
}

#[test]
fn a_thin_thing_is_tolerated_less_than_a_thick_one() {
    let mut camera = camera();
    camera.position_spread = Some(0.015);
    let warnings = |radius: &str| {
        let text = BOTTLE.replace("radius = 0.035", &format!("radius = {radius}"));
        let object = Object::parse("bottle.toml", &text).unwrap();
        let seen = seen("small-diameter", upright(), &camera);
        let strategy = Strategy::new(&hand("barrett"), &seen, &object, &camera).unwrap();
        (strategy.tolerated.map(|window| (window.position_m, window.object)), strategy.warnings.join("\n"))
    };
    let tolerated = |millimetres: f64, object: &str| Some((1e-3 * millimetres, object.to_owned()));
    assert_eq!(warnings("0.035"), (tolerated(30.0, "cylinder-upright"), String::new()));
    // As a stick, and between both: nobody tried.
    for radius in ["0.017", "0.025"] {
        let (window, warning) = warnings(radius);
        assert_eq!(window, tolerated(10.0, "stick"));
        assert_eq!(warning, "the hand's position is known to +-15 mm, the grasp tolerates +-10 mm");
    }
    let (window, warning) = warnings("0.05");
    assert_eq!(window, None);
    insta::assert_snapshot!(warning, @"what error the grasp tolerates is not known: simulated from the side were handle (28 mm), stick (34 mm), cylinder-upright (70 mm), and this is 101 mm wide");

    let disc = Object::parse("disc.toml", include_str!("../../data/objects/disc.toml")).unwrap();
    let flat = seen("precision-disc", UnitQuaternion::identity(), &camera);
    let strategy = Strategy::new(&hand("barrett"), &flat, &disc, &camera).unwrap();
    assert_eq!(strategy.tolerated.unwrap().tilt_rad, Some(0.122));
    insta::assert_snapshot!(strategy.warnings.join("\n"), @"the hand's orientation is known to +-8 degrees, the grasp tolerates a tilt of +-7: take it as a first guess and correct it by touch");
}

fn kinds(strategy: &Strategy) -> Vec<ProblemKind> {
    assert_eq!(strategy.feasible, strategy.problems.is_empty());
    // Who reads warnings alone reads of every problem, and who reads both reads nothing twice.
    let messages = strategy.problems.iter().map(|problem| &problem.message);
    assert!(strategy.warnings.iter().zip(messages.clone()).all(|(warning, message)| warning == message));
    assert!(strategy.doubts().iter().all(|doubt| messages.clone().all(|message| message != doubt)));
    strategy.problems.iter().map(|problem| problem.kind).collect()
}

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
    let text = include_str!("../../data/robots/parallel-gripper.toml");
    let bare: Vec<&str> = text.split("[[finger]]").collect();
    let bare = format!("{}[map]{}", bare[0], bare[2].split("[map]").nth(1).unwrap());
    let bare = RobotHand::parse("own.toml", &bare).unwrap();
    let strategy = Strategy::new(&bare, &seen("pinch", upright(), &camera), &bottle(), &camera).unwrap();
    assert!(strategy.feasible && strategy.layout.fingers.is_empty());
}

/// The hand that comes to the bottle from its side, tilted down by so much, in degrees.
fn tilted(degrees: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new(Vector3::y() * degrees.to_radians()) * upright()
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

#[test]
fn a_tilt_uses_up_what_is_tolerated() {
    let camera = camera();
    let of = |degrees: f64| {
        let seen = seen("power-sphere", tilted(degrees), &camera);
        Strategy::new(&hand("barrett"), &seen, &bottle(), &camera).unwrap()
    };
    let tilt = |degrees: f64| of(degrees).tolerated.and_then(|window| window.tilt_rad);
    assert!((tilt(0.0).unwrap() - 0.261).abs() < 1e-6);
    assert!((tilt(-10.0).unwrap() - (0.261 - 10.0_f64.to_radians())).abs() < 1e-6);
    assert!(of(10.0).quality.unwrap() < 0.6 * of(0.0).quality.unwrap());
    let far = of(32.0);
    assert!(far.feasible && far.tolerated.is_none() && far.quality.is_none(), "{:?}", far.problems);
    insta::assert_snapshot!(far.warnings.join("\n"), @"what error the grasp tolerates is not known: the hand is tilted by 32 degrees from how it came from the side in simulation, where up to 15 were held");

    // From its end, at the height of the table.
    let lying = BOTTLE.replace("0.0, 0.0, 0.0, 1.0", "0.0, 0.70710678, 0.0, 0.70710678");
    let lying = Object::parse("lying.toml", &lying).unwrap();
    let seen = seen("power-sphere", upright(), &camera);
    let found = Strategy::new(&hand("barrett"), &seen, &lying, &camera).unwrap();
    assert_eq!((found.tolerated, found.quality), (None, None));
    insta::assert_snapshot!(found.warnings.join("\n"), @"what error the grasp tolerates is not known: simulated from the side were handle (28 mm), stick (34 mm), cylinder-upright (70 mm), and none lay to the palm as this does");
}

#[test]
fn fingers_that_close_before_the_object_are_a_problem() {
    let camera = camera();
    let disc = include_str!("../../data/objects/disc.toml").replace("[0.0, 0.0, 0.015]", "[0.5, 0.0, 0.015]");
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
fn a_hand_that_lets_go_leaves_as_it_came() {
    let camera = camera();
    for name in ["barrett", "allegro"] {
        let seen = seen("large-diameter", upright(), &camera);
        let found = Strategy::new(&hand(name), &seen, &bottle(), &camera).unwrap();
        let message = moveit::message(&found, "cup.jpg");
        let way = |key: &str, axis: &str| message[key]["direction"]["vector"][axis].as_f64().unwrap();
        for axis in ["x", "y", "z"] {
            assert_eq!(way("post_place_retreat", axis), -way("pre_grasp_approach", axis), "{name}");
        }
        let [came, left] = ["pre_grasp_approach", "post_place_retreat"].map(|key| &message[key]);
        assert_eq!(left["direction"]["header"], came["direction"]["header"]);
        assert_eq!(left["desired_distance"], came["desired_distance"]);
        assert_eq!(message["post_grasp_retreat"]["direction"]["header"]["frame_id"], "world");
    }
}

#[test]
fn the_force_that_was_simulated_is_said_beside_the_one_that_is_described() {
    let camera = camera();
    let seen = seen("large-diameter", upright(), &camera);
    let grasp = |name: &str| {
        let strategy = Strategy::new(&hand(name), &seen, &bottle(), &camera).unwrap();
        let step = strategy.steps.into_iter().find_map(|step| match step {
            Step::Grasp { max_contact_force, simulated_force, .. } => {
                Some((max_contact_force, simulated_force))
            }
            _ => None,
        });
        step.unwrap()
    };
    assert_eq!(grasp("barrett"), (20.0, Some(110.0)));
    assert_eq!(grasp("parallel-gripper"), (40.0, None));
}

#[test]
fn moveit_gets_the_wrist_in_the_world() {
    let camera = camera();
    let strategy =
        Strategy::new(&hand("parallel-gripper"), &seen("pinch", upright(), &camera), &bottle(), &camera)
            .unwrap();
    insta::assert_snapshot!(moveit::yaml(&strategy, "cup.jpg"));
}

#[test]
fn no_description_takes_more_memory_than_it_may() {
    // A text that a parser makes seventy times as much of, and what it shows of a line.
    let long = format!("a = [{}]", "[],".repeat(100_000));
    insta::assert_snapshot!(Object::parse("long", &long).unwrap_err(), @"long is not a valid description of an object: 292 KiB: descriptions of at most 256 KiB are read");
    let line = format!("a = [{}]", "[],".repeat(1_000));
    assert!(Object::parse("line", &line).unwrap_err().to_string().len() < 500);
}

#[test]
fn bad_descriptions_say_what_is_needed() {
    let object = |text: &str| Object::parse("own.toml", text).unwrap_err().to_string();
    let mut said = vec![
        object(&BOTTLE.replace("radius = 0.035", "")),
        object(&BOTTLE.replace("radius = 0.035", "radius = nan")),
        object(&BOTTLE.replace("\"cylinder\"", "\"cone\"")),
        object(&BOTTLE.replace("0.0, 1.0]", "0.0, 2.0]")),
        object(&BOTTLE.replace("mass", "weight")),
        object(&format!("size = [0.1, 0.1, 0.1]\n{BOTTLE}")),
        object(&BOTTLE.replace("\"cylinder\"", "\"sphere\"")),
        object(&BOTTLE.replace("\"cylinder\"", "\"box\"")),
        object(&BOTTLE.replace("radius = 0.035", "radius = 1.5")),
        Camera::parse("own.toml", &CAMERA.replace("0.3", "nan")).unwrap_err().to_string(),
        RobotHand::find("shadow").unwrap_err().to_string(),
        RobotHand::find("no-such.toml").unwrap_err().to_string(),
    ];
    let sunk = Object::parse("own.toml", &BOTTLE.replace("0.08]", "0.03]")).unwrap();
    said.push(sunk.in_world(&camera()).unwrap_err().to_string());
    let barrett = include_str!("../../data/robots/barrett.toml");
    let hand = |text: &str| RobotHand::parse("own.toml", text).unwrap_err().to_string();
    said.push(hand(&barrett.replace("pinch = \"two-finger-thumb\"", "pinch = \"poke\"")));
    said.push(hand(&barrett.replace("bh_j32_joint = 2.0\n", "bh_j32_joint = 3.0\n")));
    said.push(hand(&barrett.replace("bh_j32_joint = 2.0\n", "")));
    said.push(hand(&barrett.replace("width_m = 0.025", "width_m = 0.0")));
    let approach = |distance: &str| {
        hand(
            &barrett.replace("approach = { distance = 0.12", &format!("approach = {{ distance = {distance}")),
        )
    };
    said.extend(["-0.1", "nan", "0.05"].map(approach));
    said.push(hand(&barrett.replace("bh_j32_joint = [0.0, 2.4435]", "bh_j32_joint = [0.0, 1e30]")));
    insta::assert_snapshot!(said.join("\n\n"));
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

/// A box, a cylinder or a ball.
fn shapes() -> [(&'static str, Shape); 3] {
    [
        ("shape = 'box'\nsize = [0.16, 0.06, 0.10]", Shape::Box { size: [0.16, 0.06, 0.10] }),
        (
            "shape = 'cylinder'\nradius = 0.035\nheight = 0.16",
            Shape::Cylinder { radius: 0.035, height: 0.16 },
        ),
        ("shape = 'sphere'\nradius = 0.04", Shape::Sphere { radius: 0.04 }),
    ]
}

proptest! {
    /// However object and hand are turned: what is drawn is where the strategy's own numbers say
    /// that it is.
    #[test]
    fn a_drawing_shows_what_the_strategy_says(
        which in 0..3_usize,
        object_turn in prop::array::uniform3(-3.1f64..3.1),
        hand_turn in prop::array::uniform3(-3.1f64..3.1),
        far in -0.1f64..0.1,
    ) {
        let (description, shape) = shapes()[which];
        let [a, b, c] = object_turn;
        let world_from_object = Isometry3::from_parts(
            Vector3::new(0.5, -0.2, 0.6).into(), UnitQuaternion::from_euler_angles(a, b, c));
        let q = world_from_object.rotation.coords;
        let text = format!(
            "{description}\nposition = [0.5, -0.2, 0.6]\nquaternion_xyzw = [{}, {}, {}, {}]", q.x, q.y, q.z, q.w);
        let object = Object::parse("turned.toml", &text).unwrap();
        let [a, b, c] = hand_turn;
        let mut camera = camera();
        let world_from_hand = UnitQuaternion::from_euler_angles(a, b, c);
        // Held beside its middle.
        let grip = world_from_object * Point3::new(far, 0.02, -0.01);
        let wrist = grip - world_from_hand * Vector3::new(0.089, 0.013, -0.059);
        camera.hand = Some(camera.world_from_camera.inverse() * wrist);
        let mut barrett = hand("barrett");
        // Whatever goes between the fingers.
        barrett.grasp.values_mut().for_each(|grasp| grasp.widest = None);
        let strategy =
            Strategy::new(&barrett, &seen("large-diameter", world_from_hand, &camera), &object, &camera).unwrap();
        let layout = &strategy.layout;

        let is_near = |one: &Isometry3<f64>, other: &Isometry3<f64>| {
            (one.translation.vector - other.translation.vector).norm() < 1e-6
                && one.rotation.angle_to(&other.rotation) < 1e-5
        };
        prop_assert!(is_near(&isometry(&layout.object.pose), &world_from_object));
        let palm = isometry(&strategy.palm_in_world);
        prop_assert!(is_near(&(world_from_object * isometry(&strategy.palm)), &palm));
        let Some((from, distance)) = strategy.steps.iter().find_map(|step| match step {
            Step::Approach { from, distance, .. } => Some((from, *distance)),
            _ => None,
        }) else { panic!("no approach") };
        let start = world_from_object * isometry(from) * Isometry3::translation(0.0, 0.0, 0.08);
        prop_assert!(is_near(&isometry(&layout.palm_at_start), &start));
        prop_assert!(((start.translation.vector - palm.translation.vector).norm() - distance).abs() < 1e-6);
        let lifted = isometry(&layout.palm_lifted).translation.vector - palm.translation.vector;
        prop_assert!(close(lifted, Vector3::new(0.0, 0.0, 0.15)));

        for view in &layout.views {
            let [right, up] = [view.right, view.up].map(Vector3::from);
            prop_assert!(right.z.abs() < 1e-6 && right.dot(&up).abs() < 1e-5);
            let flat = |point: Vector3<f64>| [point.dot(&right), point.dot(&up)];
            let far = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            prop_assert!(far(view.approach[0], flat(start.translation.vector)) < 5e-6);
            prop_assert!(far(view.approach[1], flat(palm.translation.vector)) < 5e-6);
            // In every direction of the drawing the outline reaches as far as the shape does, but
            // for a circle's corners.
            for angle in 0..24 {
                let (sin, cos) = f64::from(15 * angle).to_radians().sin_cos();
                let direction = right * cos + up * sin;
                let expected = world_from_object.translation.vector.dot(&direction)
                    + shape.reach(&world_from_object.inverse_transform_vector(&direction));
                let reach = view.object.iter().map(|[x, y]| x * cos + y * sin).fold(f64::MIN, f64::max);
                prop_assert!((expected - reach).abs() < 2.5e-4, "{} {expected} {reach}", view.name);
            }
            for (drawn, points) in view.fingers.iter().zip(&layout.fingers) {
                prop_assert_eq!(drawn.len(), 3);
                prop_assert!(drawn.iter().zip(points).all(|(at, point)| far(*at, flat((*point).into())) < 5e-6));
            }
            prop_assert!(view.palm.len() > 3 && view.palm.iter().all(|at| far(*at, view.approach[1]) < 0.1));
        }
        prop_assert_eq!(layout.fingers.len(), 3);
    }
}

fn arm() -> Arm {
    Arm::find("kuka-kr6-r700").unwrap()
}

/// The flange of a KR 6 R700 by the product of its joints' turns, as ROS-Industrial's description
/// of it lists them: origins and axes, link by link.
fn flange(joints: [f64; 6]) -> Isometry3<f64> {
    let links = [
        (Vector3::new(0.0, 0.0, 0.400), -Vector3::z()),
        (Vector3::new(0.025, 0.0, 0.0), Vector3::y()),
        (Vector3::new(0.315, 0.0, 0.0), Vector3::y()),
        (Vector3::new(0.0, 0.0, 0.035), -Vector3::x()),
        (Vector3::new(0.365, 0.0, 0.0), Vector3::y()),
        (Vector3::new(0.080, 0.0, 0.0), -Vector3::x()),
    ];
    let turn = |angle: f64, axis: Vector3<f64>| UnitQuaternion::new(axis * angle);
    let last = links.iter().zip(joints).fold(Isometry3::identity(), |pose, ((origin, axis), angle)| {
        pose * Isometry3::from_parts((*origin).into(), turn(angle, *axis))
    });
    // The flange's z points out of it.
    last * turn(std::f64::consts::FRAC_PI_2, Vector3::y())
}

#[test]
fn an_arm_carries_the_hand_along_the_way() {
    let camera = camera();
    let seen = seen("large-diameter", upright(), &camera);
    let strategy = Strategy::new(&hand("barrett"), &seen, &bottle(), &camera).unwrap().carried_by(&arm());
    let motion = strategy.arm.as_ref().unwrap();
    assert!(motion.reachable && motion.unreachable.is_none(), "{:?}", motion.unreachable);
    // The arm stands behind the world's origin.
    let grasp = Isometry3::translation(0.15, 0.0, 0.0) * isometry(&strategy.wrist_in_world);
    for waypoint in &motion.waypoints {
        let (step, along) = (waypoint.step, waypoint.distance);
        let moved = match step {
            "approach" => grasp * Vector3::z() * (along - 0.12),
            _ => Vector3::z() * along,
        };
        let found = flange(waypoint.joints[..].try_into().unwrap());
        assert!((found.translation.vector - grasp.translation.vector - moved).norm() < 1e-5, "{waypoint:?}");
        assert!(found.rotation.angle_to(&grasp.rotation) < 1e-5, "{waypoint:?}");
    }
    let ends: Vec<_> = motion.waypoints.iter().map(|waypoint| (waypoint.step, waypoint.distance)).collect();
    assert_eq!((ends[0], *ends.last().unwrap()), (("approach", 0.0), ("retreat", 0.15)));
    // To a micrometre and a microradian: what lies beyond is noise that differs between machines.
    let is_rounded = |value: &f64| (value * 1e6 - (value * 1e6).round()).abs() < 1e-6;
    assert!(motion.waypoints.iter().flat_map(|waypoint| &waypoint.joints).all(is_rounded));
    assert!(motion.waypoints.windows(2).all(|pair| {
        let turn = pair[0].joints.iter().zip(&pair[1].joints).map(|(a, b)| (a - b).abs());
        turn.fold(0.0, f64::max) <= 0.5
    }));
}

#[test]
fn an_arm_says_where_it_cannot_go_on() {
    let camera = camera();
    let carried = |description: &str| {
        let arm = Arm::parse("arm.toml", description).unwrap();
        let seen = seen("large-diameter", upright(), &camera);
        Strategy::new(&hand("barrett"), &seen, &bottle(), &camera).unwrap().carried_by(&arm)
    };
    let standing = |at: &str| ARM.replacen("[-0.15, 0.0, 0.0]", at, 1);
    let why = |strategy: &Strategy| strategy.arm.as_ref().unwrap().unreachable.clone().unwrap();
    // Two metres behind: not even the start. A little behind: the start, but not the bottle.
    let away = carried(&standing("[-2.0, 0.0, 0.0]"));
    assert_eq!(
        (why(&away).step, why(&away).distance, why(&away).why),
        ("approach", 0.0, Hindrance::OutOfReach)
    );
    assert!(away.warnings.iter().any(|warning| warning.starts_with("unreachable: kuka-kr6-r700")));
    assert_eq!(kinds(&away), [ProblemKind::Unreachable]);
    assert!(!away.arm.as_ref().unwrap().reachable && away.arm.as_ref().unwrap().waypoints.is_empty());
    let behind = carried(&standing("[-0.35, 0.0, 0.0]"));
    assert!(why(&behind).distance > 0.0 && why(&behind).why == Hindrance::OutOfReach, "{:?}", why(&behind));
    let stiff = ARM.replace("[-3.3161, 0.7853]", "[-3.3161, -3.0]");
    assert_eq!(why(&carried(&stiff)).why, Hindrance::JointLimit);
    assert!(moveit::yaml(&away, "a").contains("# warning: unreachable"));
}

#[test]
fn bad_arms_say_what_is_needed() {
    let wrong = |from: &str, to: &str| {
        assert!(ARM.contains(from), "{from}");
        Arm::parse("arm.toml", &ARM.replacen(from, to, 1)).unwrap_err().to_string()
    };
    let messages = [
        Arm::find("puma").unwrap_err().to_string(),
        wrong("c3 = 0.365", "c3 = -0.365"),
        wrong("a1 = 0.025", "a1 = nan"),
        wrong("signs = [-1,", "signs = [2,"),
        wrong("offsets = [0.0, -1.57079633,", "offsets = [0.0, 90.0,"),
        wrong("[-2.9670, 2.9670]", "[170.0, -170.0]"),
        wrong("quaternion_xyzw = [0.0, 0.0, 0.0, 1.0]", "quaternion_xyzw = [0.0, 0.0, 0.0, 2.0]"),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}
