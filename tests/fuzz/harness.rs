//! What is done with bytes that anyone may have made: a function for each format that is read.
//!
//! Each returns whether the bytes were accepted. What is wrong with them is for the readers to
//! find; a panic, a hang or memory without bound is what a fuzzer reports. The targets of
//! cargo-fuzz call them, and so do the bounded property tests beside them (`bounded.rs`).

// The index's own tests use files made to deceive in the same way.
#[path = "../../index/tests/support/hostile.rs"]
mod hostile;

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use grasp_index::Index;
use grasp_index::npy::{NpyHeader, NpyType};
use grasp_labels::{REMARK, Table};
use grasp_network::{Network, QuantisedNetwork, Scratch};
use grasp_picture::Frames;
use grasp_recognise::Side;
use grasp_recognise::scene::Landmarks;
use grasp_renders::render_set::Manifest;
use grasp_renders::{GraspSet, HandModel, HandShape, Look, SceneSpec, Stage, View};
use grasp_robot::{Arm, Camera, Object, ObservedHand, RobotHand, Strategy};
use grasp_serve::form::Form;
use nalgebra::UnitQuaternion;
use xxhash_rust::xxh3::xxh3_64;

/// Larger pictures are decoded as smaller ones are, only slower.
const MOST_PIXELS: u64 = 1 << 16;
/// Larger pictures are looked at by a network as smaller ones are, only slower.
const MOST_VALUES: usize = 1 << 12;
/// What parts a URDF from the file beside it, in one input.
pub const BESIDE: &str = "\n<!-- beside -->\n";

static GRASPS: LazyLock<GraspSet> = LazyLock::new(GraspSet::builtin);
const BOTTLE: &str = include_str!("../../query/data/objects/bottle.toml");
const CAMERA: &str = include_str!("../../query/data/objects/camera.toml");

/// An index, as it is and with its hashes made right: a fuzzer does not guess those.
pub fn index(data: &[u8]) -> bool {
    let mut is_accepted = false;
    let mut signed = data.to_vec();
    hostile::sign(&mut signed);
    for bytes in [data, &signed] {
        if let Ok(index) = Index::from_bytes(bytes) {
            hostile::use_all(&index);
            is_accepted = true;
        }
    }
    is_accepted
}

/// An array in NumPy's format: what is read has the shape that its header says.
pub fn npy(data: &[u8]) -> bool {
    let mut is_accepted = false;
    for element in [NpyType::F32, NpyType::U32] {
        let mut rest = data;
        let Ok(header) = NpyHeader::read(&mut rest, element) else { continue };
        let written = header.to_bytes();
        let again = NpyHeader::read(&mut &written[..], element).expect("what is written is read");
        assert_eq!((again.rows, again.columns), (header.rows, header.columns));
        if element == NpyType::F32
            && let Ok(values) = header.read_values(&mut rest)
        {
            assert_eq!(values.len() as u64, header.rows * header.columns);
            assert!(values.iter().all(|value| value.is_finite()));
        }
        is_accepted = true;
    }
    is_accepted
}

/// A hand model in a binary glTF file.
pub fn glb(data: &[u8]) -> bool {
    let Ok(model) = HandModel::parse("fuzz", data) else { return false };
    assert_eq!(model.shape().name, "fuzz");
    true
}

/// A stream of pictures, and each of them.
pub fn stream(data: &[u8]) -> bool {
    let mut is_accepted = false;
    let mut frames = Frames::new(data);
    for frame in frames.by_ref().map_while(Result::ok) {
        assert!(!frame.bytes.is_empty() && frame.skipped <= data.len() as u64);
        let sides = grasp_picture::dimensions(&frame.bytes);
        if sides.is_ok_and(|(width, height)| u64::from(width) * u64::from(height) <= MOST_PIXELS) {
            is_accepted |= grasp_picture::decode(&frame.bytes).is_ok();
        }
    }
    assert!(frames.skipped_at_end() <= data.len() as u64);
    is_accepted
}

/// A form that a service is sent: the first line is its content type, the rest its body.
pub fn form(data: &[u8]) -> bool {
    let end = data.iter().position(|&byte| byte == b'\n').unwrap_or(data.len());
    let (kind, body) = (&data[..end], data.get(end + 1..).unwrap_or_default());
    let Ok(mut form) = Form::new(&String::from_utf8_lossy(kind), body.to_vec().into()) else {
        return false;
    };
    let mut bytes = 0;
    let mut parts = 0;
    while let Ok(Some(part)) = form.next_part() {
        bytes += part.content.len();
        assert!(bytes <= body.len(), "no byte is in two parts");
        parts += 1;
    }
    parts > 0
}

/// The file of a network, as it is and with its length and hash made right; what is read is run.
pub fn network(data: &[u8]) -> bool {
    let mut signed = data.to_vec();
    if let (Some(length), bytes) = (data.len().checked_sub(8), &mut signed)
        && length >= 24
    {
        bytes[16..24].copy_from_slice(&(length as u64 + 8).to_le_bytes());
        let hash = xxh3_64(&bytes[..length]);
        bytes[length..].copy_from_slice(&hash.to_le_bytes());
    }
    let mut is_accepted = false;
    for bytes in [data, &signed] {
        let Ok(network) = Network::from_bytes(bytes) else {
            assert!(QuantisedNetwork::from_bytes(bytes).is_err());
            continue;
        };
        is_accepted = true;
        assert_eq!(network.to_bytes(), bytes);
        let architecture = network.architecture();
        let values = (architecture.side * architecture.side * architecture.planes) as usize;
        if values <= MOST_VALUES {
            let (picture, mut scratch) = (vec![0.5; values], Scratch::default());
            assert!(is_finite(&network.run(&mut scratch, &picture)));
            let quantised = QuantisedNetwork::from_bytes(bytes).expect("the same bytes are a network");
            assert!(is_finite(&quantised.run(&mut scratch, &picture)));
        }
    }
    is_accepted
}

/// A table of labels, of vectors or of renders.
pub fn labels(data: &[u8]) -> bool {
    let _ = Manifest::parse(data, PathBuf::from("manifest.csv"), &GRASPS);
    let Ok(mut table) = Table::new(data, Some(REMARK)) else { return false };
    let mut is_accepted = false;
    for _ in 0..=data.len() {
        match table.advance() {
            Ok(false) => return is_accepted,
            Ok(true) => {
                assert_eq!(table.fields().count(), table.columns().count());
                let Ok(row) = table.row() else { continue };
                let orientation = row.orientation();
                is_accepted |= orientation.is_ok();
                assert!(is_finite(&(row.azimuth, row.elevation, row.roll, orientation.ok())));
            }
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
    panic!("a table has no more lines than bytes");
}

/// Landmarks of a hand, in pictures of several sizes.
pub fn landmarks(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let Ok(landmarks) = serde_json::from_str::<Landmarks>(&text) else { return false };
    for (width, height) in [(1, 1), (640, 480), (10_000, 3)] {
        if let Ok(joints) = landmarks.of_picture(width, height) {
            assert!(is_finite(&joints), "{joints:?}");
        }
    }
    true
}

/// The description of a robot hand, an arm, an object or a camera, in a setting of sound ones.
pub fn robot(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let hand = RobotHand::parse("fuzz", &text);
    let [object, bottle] = [&text[..], BOTTLE].map(|text| Object::parse("fuzz", text));
    let [camera, usual] = [&text[..], CAMERA].map(|text| Camera::parse("fuzz", text));
    let arm = Arm::parse("fuzz", &text);
    let is_accepted = hand.is_ok() || object.is_ok() || camera.is_ok() || arm.is_ok();
    if is_accepted {
        let hand = hand.unwrap_or_else(|_| RobotHand::built_in("barrett").expect("a built-in hand"));
        let object = object.or(bottle).expect("a sound object");
        let camera = camera.or(usual).expect("a sound camera");
        grasps_of(&hand, &object, &camera, arm.ok().as_ref());
    }
    is_accepted
}

/// A gripper's URDF and, behind [`BESIDE`], the file beside it.
pub fn urdf(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let (urdf, beside) = text.split_once(BESIDE).unwrap_or((&text, ""));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("hand.urdf");
    std::fs::write(&path, urdf).expect("a file");
    std::fs::write(path.with_extension("toml"), beside).expect("a file");
    let Ok(hand) = RobotHand::find(&path.display().to_string()) else { return false };
    let object = Object::parse("bottle", BOTTLE).expect("a sound object");
    let camera = Camera::parse("camera", CAMERA).expect("a sound camera");
    grasps_of(&hand, &object, &camera, None);
    true
}

/// What a hand does for all human grasps, and an arm for one of them, because it takes long: an
/// error, or a strategy in numbers.
fn grasps_of(hand: &RobotHand, object: &Object, camera: &Camera, arm: Option<&Arm>) {
    for human in GRASPS.iter().take(if arm.is_some() { 1 } else { GRASPS.len() }) {
        for (side, turn) in [(Side::Right, 0.3), (Side::Left, -2.0)] {
            let camera_from_hand = UnitQuaternion::from_euler_angles(turn, 0.4, 1.0 - turn);
            let grasp = human.name.clone();
            let seen = ObservedHand { grasp, side, camera_from_hand, spread_deg: 8.0 };
            let Ok(strategy) = Strategy::new(hand, &seen, object, camera) else { continue };
            let strategy = match arm {
                Some(arm) => strategy.carried_by(arm),
                None => strategy,
            };
            assert!(is_finite(&strategy), "{strategy:?}");
        }
    }
}

/// Grasps as the data have them, each of which is posed, meshed and drawn.
pub fn grasps(data: &[u8]) -> bool {
    let text = String::from_utf8_lossy(data);
    let Ok(grasps) = GraspSet::parse(&text) else { return false };
    let hand_shape = Arc::new(HandShape::mean());
    let view = View { azimuth_deg: 40.0, elevation_deg: 30.0, roll_deg: 10.0 };
    // The coarsest mesh that there is.
    let look = Look { cell: 0.01, ..Look::default() };
    for (grasp, stage) in grasps.iter().zip([Stage::Grasp, Stage::Close, Stage::Reach].into_iter().cycle()) {
        let spec = SceneSpec {
            hand_shape: Arc::clone(&hand_shape),
            hand_model: None,
            grasp: Arc::new(grasp.clone()),
            stage,
            object: grasp.object.object(0.5),
            example: grasp.examples.first().cloned(),
            held: None,
            look: look.clone(),
            seed: 1,
        };
        let render = spec.build().expect("the look is sound").render(&view);
        assert!(is_finite(&render.camera_from_hand), "{}", grasp.name);
    }
    true
}

/// Whether all numbers of a value are finite, by how it is printed: so none of its fields is
/// forgotten. What stands in quotation marks is text.
fn is_finite(value: &impl std::fmt::Debug) -> bool {
    let printed = format!("{value:?}").replace("\\\"", "");
    let unquoted = printed.split('"').step_by(2);
    !unquoted
        .flat_map(|part| part.split(|c: char| !c.is_alphabetic()))
        .any(|word| matches!(word, "NaN" | "inf"))
}
