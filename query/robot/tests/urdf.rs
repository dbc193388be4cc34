//! A gripper by its URDF: what the URDF says, what the file beside it adds, and what is missing.

use std::fs;
use std::path::{Path, PathBuf};

use grasp_recognise::Side;
use grasp_robot::{Camera, Object, ObservedHand, RobotError, RobotHand, Strategy};
use nalgebra::UnitQuaternion;

const URDF: &str = include_str!("urdf/slider.urdf");
const COMPANION: &str = include_str!("urdf/slider.toml");
/// The six human grasps.
const HUMANS: [&str; 6] =
    ["abducted-thumb", "large-diameter", "pinch", "power-sphere", "precision-disc", "small-diameter"];

/// A folder of its own that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("grasp-urdf-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn hand(&self, urdf: &str, companion: Option<&str>) -> Result<RobotHand, RobotError> {
        let path = self.0.join("slider.urdf");
        fs::write(&path, urdf).unwrap();
        let beside = self.0.join("slider.toml");
        match companion {
            Some(text) => fs::write(beside, text).unwrap(),
            None => {
                let _ = fs::remove_file(beside);
            }
        }
        RobotHand::find(path.to_str().unwrap())
    }

    /// The message, without the folder.
    fn error(&self, urdf: &str, companion: Option<&str>) -> String {
        let error = self.hand(urdf, companion).unwrap_err().to_string();
        error.replace(&format!("{}/", self.0.display()), "")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn shipped() -> RobotHand {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/urdf/slider.urdf");
    RobotHand::find(path.to_str().unwrap()).unwrap()
}

#[test]
fn a_gripper_of_one_joint_needs_no_postures() {
    let hand = shipped();
    assert_eq!((hand.name.as_str(), hand.wrist_link.as_str()), ("slider", "base"));
    assert_eq!(hand.wrist_from_palm, [0.0, 0.0, 0.07]);
    assert_eq!(hand.limits.iter().collect::<Vec<_>>(), [(&"left_slide".to_owned(), &[0.0, 0.035])]);
    assert_eq!(hand.touch_links, ["left_jaw", "left_tip", "right_jaw", "right_tip"]);
    for human in HUMANS {
        assert_eq!(hand.for_human(human).unwrap().0, "parallel");
    }
    // Both jaws go out by 35 mm from 5 mm beside the middle; the pads take 4 mm of each side.
    let grasp = hand.grasp_named("parallel").unwrap();
    assert!((grasp.widest.unwrap() - (0.072 - 0.005)).abs() < 1e-3, "{:?}", grasp.widest);
    assert_eq!(grasp.closed["left_slide"].at(0.0), 0.0);
    let opening = |width: f64| 2.0 * (0.005 + grasp.open["left_slide"].at(width) - 0.004);
    for width in [0.0, 0.02, 0.04] {
        assert!((opening(width) - width - 0.02).abs() < 1e-3, "{width}: {}", opening(width));
    }
    assert!((opening(0.067) - 0.072).abs() < 1e-3);
    // The tips are 70 mm before the body, 50 mm before the palm.
    assert!((grasp.standoff.at(0.04) - (0.05 - 0.02)).abs() < 1e-6);
}

#[test]
fn it_makes_a_strategy_like_any_other_hand() {
    let hand = shipped();
    let camera = Camera::parse("camera.toml", include_str!("../../data/objects/camera.toml")).unwrap();
    let block = "shape = 'box'\nsize = [0.03, 0.06, 0.04]\nposition = [0.5, 0.0, 0.5]\nquaternion_xyzw = [0, 0, 0, 1]";
    let block = Object::parse("block.toml", block).unwrap();
    let camera_from_hand = camera.world_from_camera.rotation.inverse() * UnitQuaternion::identity();
    let seen = ObservedHand { grasp: "pinch".into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 };
    let found = Strategy::new(&hand, &seen, &block, &camera).unwrap();
    assert!(found.feasible && (found.object_width - 0.03).abs() < 1e-9, "{:?}", found.problems);
    let tips: Vec<[f64; 3]> = found.layout.fingers.iter().map(|finger| *finger.last().unwrap()).collect();
    // Beside the block, at the height of its middle.
    assert!(
        (tips[0][0] - tips[1][0]).abs() > 0.05 && tips.iter().all(|[_, _, z]| (z - 0.5).abs() < 0.011),
        "{tips:?}"
    );
}

/// A block that hangs in the air, so wide across the fingers of a hand that comes from above, and
/// what a gripper does about it.
fn pinched(hand: &RobotHand, width: f64) -> Strategy {
    let camera = Camera::parse("camera.toml", include_str!("../../data/objects/camera.toml")).unwrap();
    let block = format!(
        "shape = 'box'\nsize = [{width}, 0.06, 0.04]\nposition = [0.5, 0.0, 0.5]\nquaternion_xyzw = [0, 0, 0, 1]"
    );
    let block = Object::parse("block.toml", &block).unwrap();
    let camera_from_hand = camera.world_from_camera.rotation.inverse();
    let seen = ObservedHand { grasp: "pinch".into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 };
    Strategy::new(hand, &seen, &block, &camera).unwrap()
}

#[test]
fn jaws_that_do_not_move_alike_have_the_object_between_them() {
    let folder = Folder::new("aside");
    let mimic = "<mimic joint=\"left_slide\" multiplier=\"1\" offset=\"0\"/>";
    // Fixed 5 mm beside the palm's middle; always 10 mm farther out than the other one; half as
    // far.
    let fixed =
        URDF.replace("name=\"right_slide\" type=\"prismatic\"", "name=\"right_slide\" type=\"fixed\"");
    let fixed = fixed.replace("upper=\"0.035\"", "upper=\"0.07\"").replace(mimic, "");
    let ahead =
        URDF.replace("offset=\"0\"", "offset=\"0.01\"").replacen("upper=\"0.035\"", "upper=\"0.025\"", 1);
    let half = URDF.replace("multiplier=\"1\"", "multiplier=\"0.5\"");
    for (name, urdf) in [("alike", URDF.to_owned()), ("fixed", fixed), ("ahead", ahead), ("half", half)] {
        let hand = folder.hand(&urdf, Some(COMPANION)).unwrap();
        let width = 0.03;
        let found = pinched(&hand, width);
        assert!(found.feasible && found.doubts().len() == 1, "{name}: {:?}", found.warnings);
        let mut tips: Vec<f64> =
            found.layout.fingers.iter().map(|finger| finger.last().unwrap()[0]).collect();
        tips.sort_by(f64::total_cmp);
        // As far from the tips' pads on either side.
        let [before, behind] = [0.5 - 0.5 * width - (tips[0] + 0.004), tips[1] - 0.004 - (0.5 + 0.5 * width)];
        assert!((before - behind).abs() < 1e-3 && before > 0.005, "{name}: {before} {behind}");
        assert_eq!(hand.grasp_named("parallel").unwrap().middle.at(width) == 0.0, name == "alike");
    }
}

#[test]
fn a_joint_moves_as_far_as_what_follows_it_can() {
    let folder = Folder::new("followers");
    let follower = |lower: &str, upper: &str, mimic: &str| {
        let (before, after) = URDF.split_once("name=\"right_slide\"").unwrap();
        let after = after
            .replacen("lower=\"0\" upper=\"0.035\"", &format!("lower=\"{lower}\" upper=\"{upper}\""), 1)
            .replace("multiplier=\"1\" offset=\"0\"", mimic);
        // What follows the other way round moves along the other direction.
        let backward = if mimic.contains("-1") { "<axis xyz=\"0 -1 0\"/>" } else { "<axis xyz=\"0 1 0\"/>" };
        let after = after.replace("<axis xyz=\"0 1 0\"/>", backward);
        folder.hand(&format!("{before}name=\"right_slide\"{after}"), Some(COMPANION))
    };
    let limits = |hand: Result<RobotHand, RobotError>| hand.unwrap().limits["left_slide"];
    let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() < 1e-12 && (b - d).abs() < 1e-12;
    let same = "multiplier=\"1\" offset=\"0\"";
    assert!(near(limits(follower("0", "0.035", same)), [0.0, 0.035]));
    assert!(near(limits(follower("0", "0.02", same)), [0.0, 0.02]));
    assert!(near(limits(follower("0.01", "1", same)), [0.01, 0.035]));
    // Half as far and from 5 mm on; the other way round.
    assert!(near(limits(follower("0", "0.015", "multiplier=\"0.5\" offset=\"0.005\"")), [0.0, 0.02]));
    assert!(near(limits(follower("-0.02", "0", "multiplier=\"-1\" offset=\"0\"")), [0.0, 0.02]));
    // Without a <limit> it follows wherever it is led.
    assert!(near(limits(follower("0", "0", same)), [0.0, 0.035]));
    // By 5 mm a gripper does not open for what it is to hold, and elsewhere it cannot go.
    assert!(follower("0", "0.005", same).unwrap_err().to_string().contains("open from"));
    // Copied from a leader to a follower that goes the other way.
    assert!(near(limits(follower("0", "0.035", "multiplier=\"-1\" offset=\"0\"")), [0.0, 0.035]));
}

#[test]
fn the_file_beside_it_may_say_more() {
    let folder = Folder::new("more");
    let more = format!(
        "{COMPANION}name = 'own'\nwrist_link = 'body'\n[map]\npinch = 'nip'\n[grasp.nip]\nabout = 'a nip'\nstandoff = 0.02\ntable_clearance = 0.06\nopen = {{ left_slide = 0.03 }}\nclosed = {{ left_slide = 0.0 }}\n"
    );
    let hand = folder.hand(URDF, Some(&more)).unwrap();
    assert_eq!((hand.name.as_str(), hand.wrist_link.as_str()), ("own", "body"));
    assert_eq!(hand.wrist_from_palm, [0.0, 0.0, 0.02]);
    assert_eq!(hand.for_human("pinch").unwrap().0, "nip");
    assert!(matches!(hand.for_human("power-sphere"), Err(RobotError::Unmapped { .. })));
}

#[test]
fn what_is_missing_or_wrong_is_said() {
    let folder = Folder::new("wrong");
    let free = URDF.replace("    <mimic joint=\"left_slide\" multiplier=\"1\" offset=\"0\"/>\n", "");
    let said = [
        folder.error(URDF, None),
        folder.error(URDF, Some("tips = ['left_tip']")),
        folder.error(URDF, Some(&COMPANION.replace("\"body\"", "\"boddy\""))),
        folder.error(URDF, Some(&COMPANION.replace("\"right_tip\"", "\"base_body\""))),
        folder.error(URDF, Some(&COMPANION.replace("[0, 1, 0]", "[0, 0, 2]"))),
        folder.error(URDF, Some(&COMPANION.replace("[0, 1, 0]", "[1, 0, 0]"))),
        folder.error(URDF, Some(&COMPANION.replace("\"left_tip\", \"right_tip\"", "\"body\""))),
        folder.error(URDF, Some(&COMPANION.replace("max_contact_force = 30.0", ""))),
        folder.error(&free, Some(COMPANION)),
        folder.error(&URDF.replace("upper=\"0.035\"", "upper=\"-1\""), Some(COMPANION)),
        folder.error(&URDF.replace("upper=\"0.035\"", "upper=\"1e30\""), Some(COMPANION)),
        folder.error(&URDF.replace("mimic joint=\"left_slide\"", "mimic joint=\"slide\""), Some(COMPANION)),
        folder.error(
            &URDF.replace("<child link=\"right_tip\"/>", "<child link=\"left_tip\"/>"),
            Some(COMPANION),
        ),
        folder.error(&URDF.replace("<link name=\"base\"/>", "<xacro:base/>"), Some(COMPANION)),
        folder.error("no URDF", Some(COMPANION)),
        folder.error(&"<robot>".repeat(100_000), Some(COMPANION)),
        folder.error("<robot name='r'/>", Some(COMPANION)),
    ];
    insta::assert_snapshot!(said.join("\n\n"));
    // As many as would fill the memory with what is made of them.
    let tips = format!("tips = [{}]", "'left_tip', ".repeat(33));
    let many = COMPANION.replace("tips = [\"left_tip\", \"right_tip\"]", &tips);
    assert!(
        folder
            .error(URDF, Some(&many))
            .ends_with("33 tips, where a hand has at most 32: name the last link of each finger")
    );
    // Every link is carried, in a circle.
    let circle = URDF
        .replace("<parent link=\"base\"/>", "<parent link=\"left_tip\"/>")
        .replace("<link name=\"base\"/>", "");
    assert!(folder.error(&circle, Some(COMPANION)).contains("no link carries all others"));
    // Cut short anywhere it is an error or a hand, never a panic.
    for at in (0..URDF.len()).step_by(37) {
        let _ = folder.hand(&URDF[..at], Some(COMPANION));
    }
}

#[test]
fn what_the_parser_of_xml_has_no_end_of_is_said_as_well() {
    let folder = Folder::new("hostile");
    let deep = "<a><?p</b?>".repeat(100_000) + &"</a>".repeat(100_000);
    let error = folder.error(&format!("<robot>{deep}</robot>"), Some(COMPANION));
    assert!(error.ends_with("its elements lie more than 100 deep in one another"), "{error}");
    let unbound = URDF
        .replace("<robot ", "<robot xmlns:xmlns='z' xmlns:p='u' ")
        .replace("<link name=\"base\"/>", "<p:link name=\"base\"/>");
    let error = folder.error(&unbound, Some(COMPANION));
    assert!(
        error.contains("its XML namespaces (xmlns, and attributes with a prefix) are more than a URDF needs"),
        "{error}"
    );
    // Those of a simulator are read.
    let usual = URDF.replace("<robot ", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' ");
    assert_eq!(folder.hand(&usual, Some(COMPANION)).unwrap().limits, shipped().limits);
}
