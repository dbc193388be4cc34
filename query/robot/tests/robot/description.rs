//! Descriptions that are none.

use grasp_robot::{Camera, Object, RobotHand};

use super::{BOTTLE, CAMERA, camera};

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
    let barrett = include_str!("../../../data/robots/barrett.toml");
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
