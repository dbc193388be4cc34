//! Which of a robot's grasps does for a human one, and how wide an object it takes.

use grasp_robot::{Object, RobotError, RobotHand, Strategy};

use super::{BOTTLE, bottle, camera, hand, seen, upright};

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
fn what_has_no_counterpart_is_said_with_what_would_mend_it() {
    let camera = camera();
    let refused = |hand: &RobotHand, grasp: &str| {
        Strategy::new(hand, &seen(grasp, upright(), &camera), &bottle(), &camera).unwrap_err().to_string()
    };
    let mut partial = hand("barrett");
    partial.map.remove("pinch");
    insta::assert_snapshot!(refused(&partial, "pinch"), @"barrett has no grasp for `pinch`: name one under [map] of its description");
    // Of an index with other classes: no description of a hand could name it.
    insta::assert_snapshot!(refused(&partial, "wave"), @"the human approach is known for the six grasps only, and `wave` is not one of them");
}
