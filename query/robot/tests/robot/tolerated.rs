//! What error a grasp tolerates.

use grasp_robot::{Object, RobotHand, Strategy};
use nalgebra::UnitQuaternion;

use super::{BOTTLE, bottle, camera, hand, seen, tilted, upright};

#[test]
fn what_is_less_sure_than_the_grasp_tolerates_is_said() {
    let text = include_str!("../../../data/robots/parallel-gripper.toml").to_owned()
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

    let disc = Object::parse("disc.toml", include_str!("../../../data/objects/disc.toml")).unwrap();
    let flat = seen("precision-disc", UnitQuaternion::identity(), &camera);
    let strategy = Strategy::new(&hand("barrett"), &flat, &disc, &camera).unwrap();
    assert_eq!(strategy.tolerated.unwrap().tilt_rad, Some(0.122));
    insta::assert_snapshot!(strategy.warnings.join("\n"), @"the hand's orientation is known to +-8 degrees, the grasp tolerates a tilt of +-7: take it as a first guess and correct it by touch");
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
