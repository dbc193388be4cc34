//! By which joints an arm carries the hand whose last three axes meet in a point.

use grasp_robot::{Arm, Hindrance, ProblemKind, Strategy, moveit};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::{bottle, camera, hand, isometry, kinds, seen, upright};

const ARM: &str = include_str!("../../../data/arms/kuka-kr6-r700.toml");

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
