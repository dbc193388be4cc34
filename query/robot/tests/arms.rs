//! Arms that are solved step by step: that what they say is reached is, and that what they say is
//! not reached is not.

use grasp_recognise::Side;
use grasp_robot::{
    Arm, ArmMotion, Camera, Direction, Hindrance, Object, ObservedHand, Pose, RobotHand, Step, Strategy,
};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

const UR5E: &str = include_str!("../../data/arms/ur5e.toml");
const PANDA: &str = include_str!("../../data/arms/franka-panda.toml");

fn turn(axis: Vector3<f64>, angle: f64) -> Isometry3<f64> {
    Isometry3::rotation(axis * angle)
}

/// The flange of a UR5e in its base, by the maker's Denavit-Hartenberg rows (theta, d, a, alpha).
fn ur5e(joints: &[f64]) -> Isometry3<f64> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let rows = [
        (0.1625, 0.0, quarter),
        (0.0, -0.425, 0.0),
        (0.0, -0.3922, 0.0),
        (0.1333, 0.0, quarter),
        (0.0997, 0.0, -quarter),
        (0.0996, 0.0, 0.0),
    ];
    rows.iter().zip(joints).fold(Isometry3::identity(), |pose, ((d, a, alpha), theta)| {
        pose * turn(Vector3::z(), *theta) * Translation3::new(*a, 0.0, *d) * turn(Vector3::x(), *alpha)
    })
}

/// The flange of a Panda in its base, by the maker's rows after Craig (a, d, alpha, theta).
fn panda(joints: &[f64]) -> Isometry3<f64> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let rows = [
        (0.0, 0.333, 0.0),
        (0.0, 0.0, -quarter),
        (0.0, 0.316, quarter),
        (0.0825, 0.0, quarter),
        (-0.0825, 0.384, -quarter),
        (0.0, 0.0, quarter),
        (0.088, 0.0, quarter),
    ];
    let last = rows.iter().zip(joints).fold(Isometry3::identity(), |pose, ((a, d, alpha), theta)| {
        pose * turn(Vector3::x(), *alpha)
            * Translation3::new(*a, 0.0, 0.0)
            * turn(Vector3::z(), *theta)
            * Translation3::new(0.0, 0.0, *d)
    });
    last * Translation3::new(0.0, 0.0, 0.107)
}

type Forward = fn(&[f64]) -> Isometry3<f64>;

/// Each arm with its base on the world's origin, and the hand's wrist in its flange.
fn arms() -> [(Arm, Forward, Vec<[f64; 2]>); 2] {
    let placed = |text: &str, at: &str| {
        assert!(text.contains(at), "{at}");
        let text = text.replacen(at, "position = [0.0, 0.0, 0.0]", 1);
        let mount = text.rfind("quaternion_xyzw").unwrap();
        let text = text[..mount].to_owned() + "quaternion_xyzw = [0.0, 0.0, 0.0, 1.0]\n";
        let table: toml::Table = text.parse().unwrap();
        let limits = table["limits"].as_array().unwrap().iter().map(|ends| {
            let end = |at: usize| ends[at].as_float().unwrap();
            [end(0), end(1)]
        });
        (Arm::parse("arm.toml", &text).unwrap(), limits.collect())
    };
    let (one, one_limits) = placed(UR5E, "position = [0.0, 0.35, 0.0]");
    let (other, other_limits) = placed(PANDA, "position = [-0.10, -0.30, 0.0]");
    [(one, ur5e as Forward, one_limits), (other, panda as Forward, other_limits)]
}

fn pose(isometry: &Isometry3<f64>) -> Pose {
    let q = isometry.rotation.coords;
    Pose {
        frame: "world",
        position: isometry.translation.vector.into(),
        quaternion_xyzw: [q.x, q.y, q.z, q.w],
    }
}

/// The motion to a pose, from a millimetre before it.
fn reach(arm: &Arm, flange: &Isometry3<f64>) -> ArmMotion {
    let forward = flange.rotation * Vector3::z();
    let step = Step::Approach {
        from: pose(flange),
        to: pose(flange),
        direction: Direction { frame: "world".into(), vector: forward.into() },
        distance: 0.001,
        min_distance: 0.001,
    };
    arm.carry(&pose(flange), forward, &[step])
}

fn near(one: &Isometry3<f64>, other: &Isometry3<f64>) -> bool {
    (one.translation.vector - other.translation.vector).norm() < 1e-5
        && one.rotation.angle_to(&other.rotation) < 1e-5
}

#[test]
fn the_makers_own_figures_come_out() {
    // Stretched out, from the maker's rows; and the Panda's usual posture, as it reports it.
    let zero = ur5e(&[0.0; 6]).translation.vector;
    assert!((zero - Vector3::new(-0.8172, -0.2329, 0.0628)).norm() < 1e-9, "{zero}");
    let quarter = std::f64::consts::FRAC_PI_4;
    let ready = panda(&[0.0, -quarter, 0.0, -3.0 * quarter, 0.0, 2.0 * quarter, quarter]);
    assert!((ready.translation.vector - Vector3::new(0.3069, 0.0, 0.5902)).norm() < 1e-3, "{ready}");
}

#[test]
fn what_some_posture_reaches_is_reached_and_by_joints_within_their_limits() {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for (arm, forward, limits) in arms() {
        let mut missed = 0;
        for _ in 0..40 {
            // Not at a limit: the millimetre before it may be beyond.
            let joints: Vec<f64> =
                limits.iter().map(|[low, high]| low + (high - low) * (0.05 + 0.9 * random())).collect();
            let flange = forward(&joints);
            let motion = reach(&arm, &flange);
            let Some(last) = motion.waypoints.last() else {
                missed += 1;
                continue;
            };
            assert!(near(&forward(&last.joints), &flange), "{joints:?} {last:?}");
            for (joint, [low, high]) in last.joints.iter().zip(&limits) {
                assert!((low - 1e-5..=high + 1e-5).contains(joint), "{last:?}");
            }
        }
        assert_eq!(missed, 0, "of 40 {:?}", limits.len());
    }
}

#[test]
fn what_no_posture_reaches_says_why() {
    let [(ur5e_arm, forward, _), (panda_arm, _, _)] = arms();
    let far = Isometry3::translation(1.5, 0.0, 0.3);
    for arm in [&ur5e_arm, &panda_arm] {
        let end = reach(arm, &far).unreachable.unwrap();
        assert_eq!((end.step, end.distance, end.why), ("approach", 0.0, Hindrance::OutOfReach));
    }
    // A pose that only an elbow bent the other way than its limits allow reaches.
    let stiff = UR5E.replacen("position = [0.0, 0.35, 0.0]", "position = [0.0, 0.0, 0.0]", 1);
    let stiff = stiff.replacen("[-3.1416, 3.1416]", "[-0.2, -0.1]", 1);
    let arm = Arm::parse("stiff.toml", &stiff).unwrap();
    let bent = forward(&[0.3, -1.2, 1.5, -1.0, 1.2, 0.4]);
    let end = reach(&arm, &bent).unreachable.unwrap();
    assert_eq!((end.distance, end.why), (0.0, Hindrance::JointLimit));
}

#[test]
fn both_carry_a_hand_to_a_bottle_and_up() {
    let camera = Camera::parse("camera.toml", include_str!("../../data/objects/camera.toml")).unwrap();
    let bottle = Object::parse("bottle.toml", include_str!("../../data/objects/bottle.toml")).unwrap();
    // The thumb up, the palm coming along the world's x.
    let axes = Matrix3::from_columns(&[-Vector3::y(), Vector3::z(), -Vector3::x()]);
    let upright = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes));
    let camera_from_hand = camera.world_from_camera.rotation.inverse() * upright;
    let seen =
        ObservedHand { grasp: "large-diameter".into(), side: Side::Right, camera_from_hand, spread_deg: 8.0 };
    for (arm, hand, forward, base, mount) in [
        (
            "ur5e",
            "robotiq-2f-85",
            ur5e as Forward,
            Isometry3::translation(0.0, 0.35, 0.0),
            Isometry3::identity(),
        ),
        (
            "franka-panda",
            "franka-hand",
            panda as Forward,
            Isometry3::translation(-0.10, -0.30, 0.0),
            turn(Vector3::z(), -std::f64::consts::FRAC_PI_4),
        ),
    ] {
        let robot = RobotHand::built_in(hand).unwrap();
        let found = Strategy::new(&robot, &seen, &bottle, &camera).unwrap();
        let found = found.carried_by(&Arm::built_in(arm).unwrap());
        assert!(found.feasible, "{:?}", found.problems);
        let motion = found.arm.as_ref().unwrap();
        let [x, y, z, w] = found.wrist_in_world.quaternion_xyzw;
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let wrist = Isometry3::from_parts(found.wrist_in_world.position.into(), rotation);
        for waypoint in &motion.waypoints {
            let moved = match waypoint.step {
                "approach" => Vector3::x() * (waypoint.distance - robot.approach.distance),
                _ => Vector3::z() * waypoint.distance,
            };
            let expected = Translation3::from(moved) * wrist;
            assert!(near(&(base * forward(&waypoint.joints) * mount), &expected), "{arm} {waypoint:?}");
        }
        assert!(
            motion.waypoints.windows(2).all(|pair| {
                pair[0].joints.iter().zip(&pair[1].joints).all(|(a, b)| (a - b).abs() <= 0.5)
            })
        );
        // The same again: nothing is drawn by lot.
        let again = Strategy::new(&robot, &seen, &bottle, &camera).unwrap();
        assert_eq!(again.carried_by(&Arm::built_in(arm).unwrap()).arm, found.arm);
    }
}

#[test]
fn chains_that_are_none_say_what_is_needed() {
    let wrong = |from: &str, to: &str| {
        assert!(UR5E.contains(from), "{from}");
        Arm::parse("arm.toml", &UR5E.replacen(from, to, 1)).unwrap_err().to_string()
    };
    let messages = [
        wrong("joint = \"elbow_joint\"\n", ""),
        wrong("joint = \"elbow_joint\"\n", "joint = \"wrist_1_joint\"\n"),
        wrong("\"elbow_joint\", ", ""),
        wrong("at = [-0.425, 0.0, 0.0]", "at = [-425.0, 0.0, 0.0]"),
        wrong(
            "[mount]",
            "[geometry]\na1 = 0\na2 = 0\nb = 0\nc1 = 0\nc2 = 0\nc3 = 0\nc4 = 0\noffsets = [0, 0, 0, 0, 0, 0]\nsigns = [1, 1, 1, 1, 1, 1]\n[mount]",
        ),
        wrong("joint = \"wrist_3_joint\"", "axis = [0, 0, 0]\njoint = \"wrist_3_joint\""),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}

/// A joint that slides comes back by no turn: on a rail of 10 m, the middle of which lies farther
/// from the object than half a turn is long if it is taken for radians.
#[test]
fn an_arm_on_a_long_rail_stays_where_it_reaches() {
    let text = UR5E
        .replacen("joints = [", "joints = [\"rail\",", 1)
        .replacen("limits = [", "limits = [[0.0, 10.0],", 1)
        .replacen(
            "\n[[segment]]",
            "\n[[segment]]\njoint = \"rail\"\naxis = [1.0, 0.0, 0.0]\nslides = true\n[[segment]]",
            1,
        )
        .replacen("position = [0.0, 0.35, 0.0]", "position = [0.0, 0.0, 0.0]", 1);
    let arm = Arm::parse("rail.toml", &text).unwrap();
    let flange = Isometry3::from_parts(
        Translation3::new(0.6, 0.3, 0.4),
        UnitQuaternion::new(Vector3::y() * std::f64::consts::PI),
    );
    let motion = reach(&arm, &flange);
    assert!(motion.reachable, "{:?}", motion.unreachable);
    for waypoint in &motion.waypoints {
        let (rail, joints) = waypoint.joints.split_first().unwrap();
        let found = Translation3::new(*rail, 0.0, 0.0) * ur5e(joints);
        let back = flange * Translation3::new(0.0, 0.0, waypoint.distance - 0.001);
        assert!((0.0..2.0).contains(rail) && near(&found, &back), "{waypoint:?}");
    }
}
