//! Every robot hand that comes with the program, in all six grasps: what it does is sane, or it
//! says what it cannot do and what comes nearest.

use std::collections::BTreeMap;

use grasp_recognise::Side;
use grasp_robot::{Camera, Object, ObservedHand, RobotError, RobotHand, Shape, Strategy, moveit};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

const CAMERA: &str = include_str!("../../data/objects/camera.toml");
/// Half of a finger's thickness, in metres: of the thinnest and of the thickest.
const THIN: f64 = 0.003;
const THICK: f64 = 0.015;

/// Hangs in the air. The hand comes from above with its fingers along the world's x, against which
/// the thumb closes.
fn object(shape: &str) -> Object {
    let text = format!("name = 'thing'\n{shape}\nposition = [0.5, 0.0, 0.5]\n");
    let text = if text.contains("quaternion") { text } else { text + "quaternion_xyzw = [0, 0, 0, 1]\n" };
    Object::parse("thing.toml", &text).unwrap()
}

/// What people hold so; no wider than 70 mm, and across the closing fingers.
fn held(human: &str) -> Object {
    let lying = |radius: f64| {
        object(&format!(
            "shape = 'cylinder'\nradius = {radius}\nheight = 0.16\nquaternion_xyzw = [0.70710678, 0.0, 0.0, 0.70710678]"
        ))
    };
    match human {
        "large-diameter" => lying(0.035),
        "small-diameter" => lying(0.017),
        "abducted-thumb" => lying(0.010),
        "pinch" => object("shape = 'box'\nsize = [0.025, 0.06, 0.04]"),
        "power-sphere" => object("shape = 'sphere'\nradius = 0.035"),
        "precision-disc" => object("shape = 'disc'\nradius = 0.035\nheight = 0.03"),
        other => panic!("{other} is none of the six"),
    }
}

const SIX: [&str; 6] =
    ["large-diameter", "small-diameter", "abducted-thumb", "pinch", "power-sphere", "precision-disc"];

fn strategy(hand: &RobotHand, human: &str, object: &Object) -> Result<Strategy, RobotError> {
    let camera = Camera::parse("camera.toml", CAMERA).unwrap();
    let camera_from_hand = camera.world_from_camera.rotation.inverse();
    let seen = ObservedHand { grasp: human.into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 };
    Strategy::new(hand, &seen, object, &camera)
}

fn isometry(pose: &grasp_robot::Pose) -> Isometry3<f64> {
    let [x, y, z, w] = pose.quaternion_xyzw;
    let quaternion = Quaternion::new(w, x, y, z);
    assert!((quaternion.norm() - 1.0).abs() < 1e-9, "{pose:?}");
    Isometry3::from_parts(pose.position.into(), UnitQuaternion::new_unchecked(quaternion))
}

/// Points along a line that are at most so far apart as is thin.
fn along(line: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let part = |pair: &[Point3<f64>]| {
        let (from, to) = (pair[0], pair[1]);
        let steps = ((to - from).norm() / THIN).ceil().max(1.0) as u32;
        (0..=steps)
            .map(move |step| from + (to - from) * f64::from(step) / f64::from(steps))
            .collect::<Vec<_>>()
    };
    line.windows(2).flat_map(part).collect()
}

/// How near the fingers come to an object that lies in the palm's frame: each finger by itself.
fn distances(
    hand: &RobotHand,
    posture: &BTreeMap<String, f64>,
    shape: &Shape,
    palm_from_object: &Isometry3<f64>,
) -> Vec<f64> {
    let near = |finger: &Vec<Point3<f64>>| {
        let points = along(finger);
        let distance = |point: &Point3<f64>| shape.distance(&palm_from_object.inverse_transform_point(point));
        points.iter().map(distance).fold(f64::INFINITY, f64::min)
    };
    hand.fingers(posture).iter().map(near).collect()
}

#[test]
fn every_hand_opens_before_the_object_and_closes_on_it_from_both_sides() {
    for name in RobotHand::names() {
        let hand = RobotHand::built_in(name).unwrap();
        assert_eq!(hand.name, name);
        for human in SIX {
            let thing = held(human);
            let found =
                strategy(&hand, human, &thing).unwrap_or_else(|error| panic!("{name} {human}: {error}"));
            assert!(found.feasible, "{name} {human}: {:?}", found.problems);
            let (robot, grasp) = hand.for_human(human).unwrap();
            assert_eq!(found.grasp, robot);
            assert!(grasp.widest.is_none_or(|widest| found.object_width <= widest));
            for posture in [&found.open, &found.closed] {
                assert!(posture.keys().eq(hand.limits.keys()), "{name} {human}");
                for (joint, value) in posture {
                    let [low, high] = hand.limits[joint];
                    assert!((low..=high).contains(value), "{name} {human}: {joint} = {value}");
                }
            }

            // Palm and wrist are one body, the palm looks along the approach, and the fingers are
            // on both sides of what they grasp.
            let (palm, wrist) = (isometry(&found.palm), isometry(&found.wrist));
            let approach = Vector3::from(found.approach_vector.vector);
            assert!((palm * Vector3::z() - approach).norm() < 1e-9, "{name} {human}");
            let down = isometry(&found.palm_in_world) * Vector3::z();
            assert!((down + Vector3::z()).norm() < 1e-9, "{name} {human}: {down}");
            let fixed = (wrist.inverse() * palm).translation.vector;
            assert!((fixed - Vector3::from(hand.wrist_from_palm)).norm() < 1e-9, "{name} {human}");
            let tips: Vec<f64> =
                hand.fingers(&found.open).iter().filter_map(|finger| Some(finger.last()?.y)).collect();
            assert!(
                tips.iter().any(|y| *y > 0.005) && tips.iter().any(|y| *y < -0.005),
                "{name} {human}: {tips:?}"
            );

            // Open, the fingers pass the object on the whole way to it.
            let palm_from_object = palm.inverse();
            for part in 0..=12 {
                let back = hand.approach.distance * f64::from(part) / 12.0;
                let ahead = Isometry3::translation(0.0, 0.0, back) * palm_from_object;
                let near = distances(&hand, &found.open, &thing.shape, &ahead);
                assert!(near.iter().all(|metres| *metres > THIN), "{name} {human} {back}: {near:?}");
            }
            // On the way to the closed posture fingers of both sides meet it.
            let mut nearest = vec![f64::INFINITY; tips.len()];
            for part in 0..=20 {
                let share = f64::from(part) / 20.0;
                let closing = found
                    .open
                    .iter()
                    .map(|(joint, from)| (joint.clone(), from + share * (found.closed[joint] - from)));
                let near = distances(&hand, &closing.collect(), &thing.shape, &palm_from_object);
                nearest = nearest.iter().zip(near).map(|(least, metres)| least.min(metres)).collect();
            }
            let meets =
                |side: f64| tips.iter().zip(&nearest).any(|(y, metres)| side * y > 0.0 && *metres < THICK);
            assert!(meets(1.0) && meets(-1.0), "{name} {human}: {nearest:?} of {tips:?}");
        }
    }
}

/// What people hold so, as wide as `width`, in metres, across the closing fingers.
fn as_wide(human: &str, width: f64) -> Object {
    match human {
        "pinch" => object(&format!("shape = 'box'\nsize = [{width}, 0.06, 0.04]")),
        "precision-disc" => object(&format!("shape = 'disc'\nradius = {}\nheight = 0.03", 0.5 * width)),
        "power-sphere" => object(&format!("shape = 'sphere'\nradius = {}", 0.5 * width)),
        _ => object(&format!(
            "shape = 'cylinder'\nradius = {}\nheight = 0.16\nquaternion_xyzw = [0.70710678, 0.0, 0.0, 0.70710678]",
            0.5 * width
        )),
    }
}

/// How near the middle lines of open fingers come to an object on the whole way to it, in metres.
fn passed(hand: &RobotHand, found: &Strategy, shape: &Shape) -> f64 {
    let palm_from_object = isometry(&found.palm).inverse();
    let near = (0..=12).flat_map(|part| {
        let back = hand.approach.distance * f64::from(part) / 12.0;
        distances(hand, &found.open, shape, &(Isometry3::translation(0.0, 0.0, back) * palm_from_object))
    });
    near.fold(f64::INFINITY, f64::min)
}

#[test]
fn what_is_as_wide_as_a_grasp_takes_goes_between_its_open_fingers() {
    for name in RobotHand::names() {
        let hand = RobotHand::built_in(name).unwrap();
        // But one that every hand takes as a large diameter, askew by 27 degrees.
        for human in SIX.into_iter().filter(|human| *human != "abducted-thumb") {
            let widest = hand.for_human(human).unwrap().1.widest;
            let widest = widest.unwrap_or_else(|| panic!("{name} {human}: no widest object"));
            // Across a cylinder fingers lie somewhat askew, as the human's do: to them it is wider.
            let [thing, wider] = [0.99, 1.02].map(|share| as_wide(human, share * widest));
            let found = strategy(&hand, human, &thing).unwrap();
            assert!(found.feasible && found.object_width <= widest, "{name} {human}: {:?}", found.problems);
            let near = passed(&hand, &found, &thing.shape);
            assert!(near > 0.0, "{name} {human}: {near}");
            let refused = strategy(&hand, human, &wider).unwrap_err();
            assert!(matches!(refused, RobotError::TooWide { .. }), "{name} {human}: {refused}");
        }
    }
}

/// As the comment in barrett.toml says: 5 mm and half of a tip's thickness on either side.
#[test]
fn what_the_barrett_hand_takes_at_most_follows_from_where_its_fingers_are() {
    let mut hand = RobotHand::built_in("barrett").unwrap();
    let widest = |hand: &RobotHand, human: &str| hand.for_human(human).unwrap().1.widest.unwrap();
    let [pinch, disc, wrap] = ["pinch", "precision-disc", "power-sphere"].map(|human| widest(&hand, human));
    hand.grasp.values_mut().for_each(|grasp| grasp.widest = None);
    for (human, widest) in [("pinch", pinch), ("precision-disc", disc)] {
        let passed = |width: f64| {
            let thing = as_wide(human, width);
            passed(&hand, &strategy(&hand, human, &thing).unwrap(), &thing.shape)
        };
        let (near, wider) = (passed(widest), passed(widest + 0.010));
        assert!(near > 0.013 && wider < 0.013, "{human}: {near}, {wider}");
    }
    // Where the tip of finger 3 first meets a round thing: beyond its middle, or before.
    let reaches_middle = |width: f64| {
        let found = strategy(&hand, "power-sphere", &as_wide("power-sphere", width)).unwrap();
        let middle = isometry(&found.palm).inverse() * Point3::origin();
        let met = (0..=200).find_map(|part| {
            let share = f64::from(part) / 200.0;
            let closing = found
                .open
                .iter()
                .map(|(joint, from)| (joint.clone(), from + share * (found.closed[joint] - from)));
            let tip = *hand.fingers(&closing.collect())[2].last().unwrap();
            ((tip - middle).norm() < 0.5 * width + 0.008).then_some(tip)
        });
        met.unwrap().z > middle.z
    };
    assert!(reaches_middle(wrap) && !reaches_middle(wrap + 0.005));
}

#[test]
fn what_a_hand_cannot_do_is_said_with_what_it_does_instead() {
    let mut said = Vec::new();
    for name in RobotHand::names() {
        let hand = RobotHand::built_in(name).unwrap();
        for human in SIX {
            let found = strategy(&hand, human, &held(human)).unwrap();
            if let Some(instead) = &found.instead {
                let warning = found.warnings.iter().find(|warning| warning.ends_with(instead.as_str()));
                said.push(warning.unwrap().clone());
            }
        }
    }
    // Two fingers are no five; three and four do what the paper asks of them.
    insta::assert_snapshot!(said.join("\n"));

    let ball = object("shape = 'sphere'\nradius = 0.04");
    let takes = |name: &str| strategy(&RobotHand::built_in(name).unwrap(), "power-sphere", &ball);
    let refused: Vec<String> =
        RobotHand::names().filter_map(|name| takes(name).err().map(|error| error.to_string())).collect();
    // A box that is narrow the other way.
    let plank = object("shape = 'box'\nsize = [0.2, 0.05, 0.05]");
    let across = strategy(&RobotHand::built_in("franka-hand").unwrap(), "pinch", &plank).unwrap_err();
    // Nothing opens so wide.
    let crate_ = object("shape = 'box'\nsize = [0.5, 0.5, 0.5]");
    let never = strategy(&RobotHand::built_in("allegro").unwrap(), "large-diameter", &crate_).unwrap_err();
    insta::assert_snapshot!([refused.join("\n"), across.to_string(), never.to_string()].join("\n"));
}

#[test]
fn the_pads_of_the_2f_85_stay_parallel_and_open_by_its_stroke() {
    let hand = RobotHand::built_in("robotiq-2f-85").unwrap();
    let pads = |joint: f64| {
        let fingers = hand.fingers(&[("finger_joint".to_owned(), joint)].into());
        let ends = fingers.iter().map(|finger| [finger[finger.len() - 2], finger[finger.len() - 1]]);
        ends.collect::<Vec<_>>()
    };
    for joint in [0.0, 0.3, 0.8] {
        for [from, to] in pads(joint) {
            assert!(((to - from) - Vector3::new(0.0, 0.0, 0.0375)).norm() < 1e-6, "{joint}: {from} {to}");
        }
    }
    let opening = |joint: f64| (pads(joint)[0][1].y - pads(joint)[1][1].y).abs();
    assert!((opening(0.0) - 0.085).abs() < 0.0015, "{}", opening(0.0));
    assert!(opening(0.8) < 0.003, "{}", opening(0.8));
    // As the posture by the object's width says.
    for width in [0.0, 0.02, 0.03, 0.05, 0.08] {
        let open = hand.grasp_named("parallel").unwrap().open["finger_joint"].at(width);
        assert!(opening(open) > width + 0.005, "{width}: {}", opening(open));
    }
}

#[test]
fn a_wrist_that_is_turned_another_way_is_named_so_in_a_message() {
    let hand = RobotHand::built_in("allegro").unwrap();
    let found = strategy(&hand, "large-diameter", &held("large-diameter")).unwrap();
    let yaml = moveit::yaml(&found, "cup.jpg");
    // Its palm looks along the wrist's x.
    let approach = yaml.split("pre_grasp_approach:").nth(1).unwrap();
    let vector = approach.split("vector:").nth(1).unwrap();
    let part = |axis: &str| -> f64 {
        let rest = vector.split(&format!("{axis}: ")).nth(1).unwrap();
        rest.lines().next().unwrap().trim().parse().unwrap()
    };
    assert_eq!([part("x"), part("y"), part("z")], [1.0, 0.0, 0.0]);
    assert!(approach.contains("frame_id: \"base_link\""), "{approach}");
}
