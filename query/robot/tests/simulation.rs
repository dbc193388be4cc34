//! Trials in the physics engine: what each grasp must hold, and that a trial repeats to the bit.

use grasp_robot::simulation::{Offset, Outcome, Plan, SCENES, Scene};
use grasp_robot::{ApproachSide, LiesAlong, Object, RobotError, RobotHand, Shape};
use nalgebra::{UnitQuaternion, Vector3};

fn plan(scene: &str) -> Plan {
    let scene = Scene::named(scene).unwrap();
    let hand = RobotHand::find("barrett").unwrap();
    Plan::new(&hand, scene.grasp, &scene.object().unwrap(), scene.from.turned()).unwrap()
}

fn off(x: f64, y: f64, degrees: f64) -> Offset {
    Offset { x, y, yaw: degrees.to_radians() }
}

#[test]
fn every_grasp_holds_its_own_object() {
    for scene in &SCENES {
        let outcome = plan(scene.name).run(Offset::default());
        assert!(outcome.success, "{}: {outcome:?}", scene.name);
        assert!(outcome.rise_mm > 140.0 && outcome.slip_mm < 5.0, "{}: {outcome:?}", scene.name);
    }
}

#[test]
fn a_wrap_forgives_two_centimetres_and_fifteen_degrees() {
    for scene in ["cylinder-upright", "cylinder-lying"] {
        for (x, y) in [(0.02, 0.02), (0.02, -0.02), (-0.02, 0.02), (-0.02, -0.02)] {
            let outcome = plan(scene).run(off(x, y, 0.0));
            assert!(outcome.success, "{scene} at {x} {y}: {outcome:?}");
        }
    }
    for scene in ["cylinder-lying", "box"] {
        for degrees in [-15.0, 15.0] {
            let outcome = plan(scene).run(off(0.0, 0.0, degrees));
            assert!(outcome.success, "{scene} at {degrees}: {outcome:?}");
        }
    }
}

#[test]
fn the_windows_that_strategies_warn_by_were_simulated() {
    let hand = RobotHand::find("barrett").unwrap();
    for (name, grasp) in &hand.grasp {
        assert!(!grasp.window.is_empty(), "{name}");
        for window in &grasp.window {
            let scene = Scene::named(&window.object).unwrap();
            assert_eq!((scene.grasp, scene.from), (name.as_str(), window.from));
            let object = scene.object().unwrap();
            let fingers = object.pose.inverse_transform_vector(&(window.from.turned() * Vector3::y()));
            let width = 2.0 * object.shape.half_chord(&fingers);
            assert!((width - window.width_m).abs() < 1e-6, "{}: {width}", window.object);
            assert_eq!(window.axis, Some(lies_along(&object, window.from)), "{}", window.object);
            let (most, yaw) = (window.position_m, window.yaw_rad.unwrap_or_default().to_degrees());
            // Of opposite corners and turns one each; the sweep tries them all.
            for error in [off(most, -most, 0.0), off(-most, -most, 0.0), off(0.0, 0.0, yaw)] {
                let outcome = plan(scene.name).run(error);
                assert!(outcome.success, "{}, {error:?}: {outcome:?}", scene.name);
            }
            let exact = plan(scene.name).run(Offset::default());
            let force = window.force_n.unwrap();
            assert!((force - exact.greatest_force_n).abs() <= 0.5, "{}: {exact:?}", scene.name);
            assert_eq!(held_tilted(&hand, scene, window.tilt_rad.unwrap()), 4, "{}", scene.name);
            // From above a roll is a yaw.
            assert_eq!(window.roll_rad.is_some(), window.from == ApproachSide::Side, "{}", scene.name);
            for turn in window.roll_rad.into_iter().flat_map(|roll| [-roll, roll]) {
                let turned = window.from.turned() * UnitQuaternion::new(Vector3::z() * turn);
                let outcome = Plan::new(&hand, scene.grasp, &object, turned).unwrap().run(Offset::default());
                assert!(outcome.success, "{}, turned by {turn}: {outcome:?}", scene.name);
            }
        }
    }
}

/// Along which axis of a palm that comes from there the object's own lies.
fn lies_along(object: &Object, from: ApproachSide) -> LiesAlong {
    let axis = match object.shape {
        Shape::Sphere { .. } => return LiesAlong::None,
        Shape::Cylinder { .. } => Vector3::z(),
        Shape::Box { size: [x, y, z] } => {
            assert!(x > y && x > z, "the longest side");
            Vector3::x()
        }
    };
    let in_palm = from.turned().inverse() * object.pose.rotation * axis;
    match (in_palm.x.abs() > 0.999, in_palm.z.abs() > 0.999) {
        (true, _) => LiesAlong::X,
        (_, true) => LiesAlong::Z,
        _ => panic!("{} lies askew: {in_palm}", object.name),
    }
}

/// An object on its table whose extent across the fingers is `width`, in metres.
fn as_wide(shape: &str, width: f64, mass: f64) -> Object {
    let (radius, lying) = (0.5 * width, format!("position = [0, 0, {}]", 0.5 * width));
    let rest = match shape {
        "upright" => format!("shape = 'cylinder'\nradius = {radius}\nheight = 0.16\nposition = [0, 0, 0.08]"),
        "disc" => format!("shape = 'disc'\nradius = {radius}\nheight = 0.03\nposition = [0, 0, 0.015]"),
        "block" => format!("shape = 'box'\nsize = [0.06, {width}, 0.04]\nposition = [0, 0, 0.02]"),
        "ball" => format!("shape = 'sphere'\nradius = {radius}\n{lying}"),
        other => panic!("there is no {other}"),
    };
    let text = format!("{rest}\nmass = {mass}\nquaternion_xyzw = [0, 0, 0, 1]\ntable = 0.0");
    Object::parse(shape, &text).unwrap()
}

#[test]
fn the_widest_objects_are_held_and_much_wider_ones_are_not() {
    use ApproachSide::{Side, Top};
    let hand = RobotHand::find("barrett").unwrap();
    let mut any = hand.clone();
    any.grasp.values_mut().for_each(|grasp| grasp.widest = None);
    let trials = [
        ("wrap", "upright", Side, 0.35, 0.240),
        ("wrap", "upright", Side, 0.70, 0.230),
        ("two-finger-thumb", "ball", Top, 0.35, 0.120),
        ("two-finger-thumb", "block", Top, 0.35, 0.130),
        ("precision-disc", "disc", Top, 0.35, 0.210),
    ];
    for (grasp, shape, from, mass, too_wide) in trials {
        let widest = hand.grasp_named(grasp).unwrap().widest.unwrap();
        // As wide as it says, but for a rounding.
        let object = as_wide(shape, widest - 1e-6, mass);
        let outcome = Plan::new(&hand, grasp, &object, from.turned()).unwrap().run(Offset::default());
        assert!(outcome.success, "{grasp} {shape} of {widest} m: {outcome:?}");
        let object = as_wide(shape, too_wide, mass);
        let refused = Plan::new(&hand, grasp, &object, from.turned());
        assert!(matches!(refused, Err(RobotError::TooWide { .. })), "{grasp} {shape} of {too_wide} m");
        let outcome = Plan::new(&any, grasp, &object, from.turned()).unwrap().run(Offset::default());
        assert!(!outcome.success, "{grasp} {shape} of {too_wide} m: {outcome:?}");
    }
}

#[test]
fn a_pinch_is_made_by_finger_tips_alone_and_a_disc_is_held_by_its_rim() {
    let tips = ["finger 1 distal", "finger 2 distal", "finger 3 distal"];
    for scene in ["block", "disc"] {
        assert_eq!(plan(scene).run(Offset::default()).links, tips, "{scene}");
    }
}

/// In how many of four directions the approach may be tilted by so much, in radians.
fn held_tilted(hand: &RobotHand, scene: &Scene, tilt: f64) -> usize {
    let (along, object) = (scene.from.turned(), scene.object().unwrap());
    let tilted = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        .map(|(x, y)| along * UnitQuaternion::new(Vector3::new(x, y, 0.0).normalize() * tilt));
    let plans = tilted.map(|turned| Plan::new(hand, scene.grasp, &object, turned).unwrap());
    plans.iter().filter(|plan| plan.run(Offset::default()).success).count()
}

#[test]
fn tips_that_stay_off_the_table_let_a_tilted_palm_hold_a_disc() {
    let disc = Scene::named("disc").unwrap();
    let mut hand = RobotHand::find("barrett").unwrap();
    let tilt = 7.0_f64.to_radians();
    assert_eq!(held_tilted(&hand, disc, tilt), 4);
    hand.grasp.get_mut("precision-disc").unwrap().table_reach = 0.0;
    assert_eq!(held_tilted(&hand, disc, tilt), 0);
}

#[test]
fn a_table_is_where_its_object_is() {
    let hand = RobotHand::find("barrett").unwrap();
    let scene = Scene::named("cylinder-upright").unwrap();
    let mut object = scene.object().unwrap();
    let near = Plan::new(&hand, scene.grasp, &object, scene.from.turned()).unwrap();
    object.pose.translation.x += 4.0;
    object.pose.translation.y -= 128.0;
    let far = Plan::new(&hand, scene.grasp, &object, scene.from.turned()).unwrap();
    let [near, far] = [near, far].map(|plan| plan.run(off(0.01, 0.0, 5.0)));
    assert!(far.success && (near.rise_mm - far.rise_mm).abs() < 0.1, "{near:?}\n{far:?}");
}

#[test]
fn a_hand_that_misses_lifts_nothing() {
    let outcome = plan("block").run(off(0.0, 0.15, 0.0));
    assert!(!outcome.success && !outcome.lifted && outcome.links.is_empty(), "{outcome:?}");
    assert!(outcome.rise_mm.abs() < 1.0 && outcome.contact_force_n == 0.0, "{outcome:?}");
}

#[test]
fn a_trial_repeats_to_the_bit_on_any_thread() {
    let plan = plan("sphere");
    let bits =
        |outcome: &Outcome| [outcome.rise_mm, outcome.slip_mm, outcome.contact_force_n].map(f64::to_bits);
    let here = plan.run(off(0.01, -0.005, 0.0));
    let there = std::thread::scope(|scope| scope.spawn(|| plan.run(off(0.01, -0.005, 0.0))).join().unwrap());
    assert_eq!(bits(&here), bits(&there));
    assert_eq!(here, there);
}

#[test]
fn a_held_object_resists_a_shake_and_a_wrench() {
    let quality = plan("cylinder-upright").quality(Offset::default()).unwrap();
    assert!(quality.epsilon > 0.05, "{quality:?}");
    assert!(quality.shake_m_s2.is_none_or(|acceleration| acceleration > 9.81), "{quality:?}");
    assert!(plan("block").quality(off(0.0, 0.15, 0.0)).is_none(), "nothing is held");
}

#[test]
fn what_cannot_be_simulated_is_said() {
    let turned = ApproachSide::Top.turned();
    let block = Scene::named("block").unwrap().object().unwrap();
    let gripper = RobotHand::find("parallel-gripper").unwrap();
    let error = Plan::new(&gripper, "parallel", &block, turned).unwrap_err();
    insta::assert_snapshot!(error, @r#"parallel-gripper has no model to simulate: take barrett, or a file with `model = "barrett"`"#);
    let barrett = RobotHand::find("barrett").unwrap();
    let error = Plan::new(&barrett, "hook", &block, turned).unwrap_err();
    insta::assert_snapshot!(error, @"barrett has no grasp `hook`: it has precision-disc, two-finger-thumb, wrap");
    let mut other = barrett.clone();
    other.limits.remove("bh_j32_joint");
    let error = Plan::new(&other, "wrap", &block, turned).unwrap_err();
    insta::assert_snapshot!(error, @"barrett has no joint bh_j32_joint, which the model that simulates it moves");
    let floating = Object { table: None, ..block };
    assert!(matches!(Plan::new(&barrett, "wrap", &floating, turned), Err(RobotError::NoTable { .. })));
}
