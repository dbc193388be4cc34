//! Our own hand, written as a model and read back: no artist's file is needed, and what must come
//! out is known.

use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::rig::{FINGERS, THUMB};
use super::{HandModel, HandModelError};
use crate::grasp::{GraspSet, Stage};
use crate::hand::{Digit, HandPose, HandShape, HandSurface, Skeleton};
use crate::mesh::surface_nets;
use crate::scene::{Look, SceneSpec};
use crate::view::ViewGrid;

type V = Vector3<f64>;

/// A rest pose in which no finger touches another.
const REST: HandPose = HandPose {
    digits: [
        [0.8, 0.4, 1.3, 0.1, 0.1],
        [0.12, 0.15, 0.15, 0.1, 0.0],
        [0.0, 0.15, 0.15, 0.1, 0.0],
        [-0.12, 0.15, 0.15, 0.1, 0.0],
        [-0.24, 0.15, 0.15, 0.1, 0.0],
    ],
};

/// A model as its two parts, so that a test can spoil either.
#[derive(Clone)]
struct File {
    document: Value,
    numbers: Vec<u8>,
}

impl File {
    /// The mean hand at rest, moved into a frame of the file's own; `told` gives the joints WebXR's
    /// axes.
    fn new(cell: f64, told: bool, into_file: &Matrix3<f64>) -> File {
        File::of(&HandShape::mean(), cell, told, into_file)
    }

    /// The same of another hand.
    fn of(shape: &HandShape, cell: f64, told: bool, into_file: &Matrix3<f64>) -> File {
        let skeleton = Skeleton::new(shape);
        let chains = skeleton.chains(&REST);
        let mut nodes = vec![json!({"name": "armature", "children": (1..=26).collect::<Vec<_>>()})];
        let shift = V::new(0.3, -0.2, 1.0);
        let mut node = |name: &str, at: &V, axes: Option<Matrix3<f64>>| {
            let at = into_file * at + shift;
            let mut node = json!({"name": name, "translation": [at.x, at.y, at.z]});
            // Mirrored axes are no rotation.
            if let Some(axes) = axes.filter(|_| into_file.determinant() > 0.0) {
                let turn =
                    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(into_file * axes));
                node["rotation"] = json!([turn.i, turn.j, turn.k, turn.w]);
            }
            nodes.push(node);
        };
        node("wrist", &V::zeros(), None);
        let mut bones: Vec<(usize, V, V)> =
            vec![(0, V::new(-0.02, 0.0, 0.0), skeleton.palm_point([0.3, 0.0, 0.0]))];
        let mut number = 1;
        for (digit, chain) in Digit::ALL.into_iter().zip(&chains) {
            let names: &[&str] = match digit {
                Digit::Thumb => &THUMB,
                _ => &FINGERS[digit as usize - 1],
            };
            let root = chain.points[0];
            if digit != Digit::Thumb {
                node(names[0], &root.component_mul(&V::new(0.3, 0.9, 1.0)), None);
                bones.push((number, root.component_mul(&V::new(0.2, 0.8, 1.0)), root));
                number += 1;
            }
            for (i, name) in names[names.len() - 4..].iter().enumerate() {
                let bone = i.min(2);
                let along = (chain.points[bone + 1] - chain.points[bone]).normalize();
                let across = chain.nail.cross(&(chain.points[3] - chain.points[2])).normalize();
                // x to the right, y out of the nail, z back along the bone.
                let axes = Matrix3::from_columns(&[-across, along.cross(&across), -along]);
                node(name, &chain.points[i], told.then_some(axes));
                if i < 3 {
                    bones.push((number, chain.points[i], chain.points[i + 1]));
                }
                number += 1;
            }
        }
        nodes.push(json!({"name": "skin", "mesh": 0, "skin": 0}));

        let surface = HandSurface::new(&skeleton, &REST, 0.02);
        let (low, high) = surface.bounds();
        let margin = V::repeat(2.0 * cell);
        let mesh = surface_nets(low - margin, high + margin, cell, &surface);
        let mut numbers = Vec::new();
        let mut views = Vec::new();
        let mut accessors = Vec::new();
        let mut add = |bytes: Vec<u8>, count: usize, component: u32, kind: &str| {
            views.push(json!({"buffer": 0, "byteOffset": numbers.len(), "byteLength": bytes.len()}));
            accessors.push(json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind}));
            numbers.extend(bytes);
            numbers.resize(numbers.len().next_multiple_of(4), 0);
        };
        let floats = |values: &mut dyn Iterator<Item = f64>| -> Vec<u8> {
            values.flat_map(|value| (value as f32).to_le_bytes()).collect()
        };
        let count = mesh.vertices.len();
        let places = mesh.vertices.iter().map(|v| into_file * v.cast::<f64>() + shift);
        add(floats(&mut places.flat_map(|v| [v.x, v.y, v.z])), count, 5126, "VEC3");
        let weights: Vec<[(usize, f64); 2]> =
            mesh.vertices.iter().map(|v| weigh(&bones, &v.cast())).collect();
        add(weights.iter().flat_map(|[a, b]| [a.0 as u8, b.0 as u8, 0, 0]).collect(), count, 5121, "VEC4");
        add(floats(&mut weights.iter().flat_map(|[a, b]| [a.1, b.1, 0.0, 0.0])), count, 5126, "VEC4");
        let corners: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        add(corners, 3 * mesh.triangles.len(), 5125, "SCALAR");
        let inverse = nodes[1..26].iter().flat_map(|node| {
            let three =
                |key: &str| serde_json::from_value::<[f64; 3]>(node[key].clone()).expect("three numbers");
            let turn = serde_json::from_value(node["rotation"].clone()).unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::from(turn));
            let joint = nalgebra::Isometry3::from_parts(three("translation").into(), turn);
            joint.inverse().to_homogeneous().as_slice().to_vec()
        });
        add(floats(&mut inverse.into_iter()), 25, 5126, "MAT4");
        let length = numbers.len();
        let document = json!({
            "asset": {"version": "2.0"}, "nodes": nodes,
            "skins": [{"joints": (1..=25).collect::<Vec<_>>(), "inverseBindMatrices": 4}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
            "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": length}],
        });
        File { document, numbers }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut text = self.document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = b"glTF".to_vec();
        let length = 28 + text.len() + self.numbers.len();
        for word in [2, length as u32, text.len() as u32, 0x4E4F_534A] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(text);
        bytes.extend((self.numbers.len() as u32).to_le_bytes());
        bytes.extend(0x004E_4942u32.to_le_bytes());
        bytes.extend(&self.numbers);
        bytes
    }

    fn read(&self) -> Result<HandModel, HandModelError> {
        HandModel::parse("test", &self.bytes())
    }

    /// What is said of the file once `spoil` has changed it.
    fn refused(&self, spoil: impl FnOnce(&mut File)) -> String {
        let mut spoiled = self.clone();
        spoil(&mut spoiled);
        let error = spoiled.read().expect_err("refused");
        let cause = std::error::Error::source(&error).map(|cause| format!(": {cause}"));
        format!("{error}{}", cause.unwrap_or_default())
    }
}

/// The two nearest bones, and by how much each moves a point.
fn weigh(bones: &[(usize, V, V)], p: &V) -> [(usize, f64); 2] {
    let distance = |(_, a, b): &(usize, V, V)| {
        let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        (p - a - (b - a) * t).norm()
    };
    let mut near: Vec<(f64, usize)> = bones.iter().map(|bone| (distance(bone), bone.0)).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share = 0.5 - ((near[1].0 - near[0].0) / 0.008).min(0.5);
    [(near[0].1, 1.0 - share), (near[1].1, share)]
}

/// A frame as other programs have them: fingers along -y, the back at x.
fn elsewhere() -> Matrix3<f64> {
    Matrix3::from_columns(&[-V::y(), -V::z(), V::x()])
}

fn spec(grasp: &str, model: Option<&Arc<HandModel>>) -> SceneSpec {
    let grasp = GraspSet::builtin().get(grasp).expect("a grasp").clone();
    let shape = model.map_or_else(HandShape::mean, |model| model.shape().clone());
    SceneSpec {
        hand_shape: Arc::new(shape),
        hand_model: model.cloned(),
        object: grasp.object.object(0.5),
        example: None,
        held: None,
        grasp: Arc::new(grasp),
        stage: Stage::Grasp,
        look: Look::default(),
        seed: 1,
    }
}

/// Intersection over union of the two hands' masks, the mean over views from everywhere.
fn likeness(a: &SceneSpec, b: &SceneSpec) -> f64 {
    let grid = ViewGrid { step_deg: 45.0, elevation_deg: [-45.0, 45.0], rolls_deg: vec![0.0] };
    let (a, b) = (a.build().expect("a scene"), b.build().expect("a scene"));
    let views = grid.views();
    let each = views.iter().map(|view| {
        let (a, b) = (a.render(view).grey, b.render(view).grey);
        let count =
            |is: fn(bool, bool) -> bool| a.iter().zip(&b).filter(|(a, b)| is(**a > 0, **b > 0)).count();
        count(|a, b| a && b) as f64 / count(|a, b| a || b) as f64
    });
    each.sum::<f64>() / views.len() as f64
}

#[test]
fn our_own_hand_comes_back_in_every_grasp() {
    for (told, into_file) in [(false, Matrix3::identity()), (true, elsewhere())] {
        let model = Arc::new(File::new(0.004, told, &into_file).read().expect("a hand"));
        assert!(!model.was_left());
        for grasp in &GraspSet::builtin() {
            let like = likeness(&spec(&grasp.name, None), &spec(&grasp.name, Some(&model)));
            assert!(like > 0.85, "{}: {like}", grasp.name);
        }
    }
}

/// A hand as long as the mean one whose palm, wrist and flesh are by `factor` broader and thicker.
fn as_long_but(factor: f64) -> HandShape {
    let mut shape = HandShape::mean();
    for digit in &mut shape.digits {
        (digit.breadth, digit.tip_breadth) = (digit.breadth * factor, digit.tip_breadth * factor);
    }
    let breadths = [&mut shape.palm_breadth, &mut shape.palm_thickness, &mut shape.wrist_breadth];
    for measure in breadths.into_iter().chain([&mut shape.wrist_thickness]) {
        *measure *= factor;
    }
    shape
}

#[test]
fn the_hand_is_measured() {
    let names = ["palm length", "palm breadth", "palm thickness", "wrist breadth", "wrist thickness"];
    // Where nothing was measured it would be as broad and as thick as a mean hand of its length.
    for factor in [0.75, 1.0, 1.3] {
        let own = as_long_but(factor);
        let model = File::of(&own, 0.003, true, &elsewhere()).read().expect("a hand");
        for (i, (measured, true_value)) in model.shape().measures().iter().zip(own.measures()).enumerate() {
            let off = measured / true_value - 1.0;
            let name = names.get(i).unwrap_or(&"digits");
            assert!(off.abs() < 0.15, "{factor}, {name}: {measured} for {true_value}");
        }
    }
}

#[test]
fn a_left_hand_is_mirrored() {
    let mirror = elsewhere() * Matrix3::from_diagonal(&V::new(1.0, -1.0, 1.0));
    let left = Arc::new(File::new(0.005, false, &mirror).read().expect("a hand"));
    let right = Arc::new(File::new(0.005, false, &elsewhere()).read().expect("a hand"));
    assert!(left.was_left());
    let like = likeness(&spec("abducted-thumb", Some(&right)), &spec("abducted-thumb", Some(&left)));
    assert!(like > 0.99, "{like}");
}

#[test]
fn the_units_of_an_armature_are_understood() {
    let plain = File::new(0.005, false, &elsewhere());
    let mut scaled = plain.clone();
    // Joints in centimetres under a node that scales them.
    scaled.document["nodes"][0]["scale"] = json!([0.01, 0.01, 0.01]);
    for node in scaled.document["nodes"].as_array_mut().expect("nodes").iter_mut().skip(1) {
        for value in node.get_mut("translation").and_then(Value::as_array_mut).into_iter().flatten() {
            *value = json!(value.as_f64().expect("a number") * 100.0);
        }
    }
    let matrices = scaled.document["bufferViews"][4]["byteOffset"].as_u64().expect("a number") as usize;
    for (i, bytes) in scaled.numbers[matrices..].chunks_exact_mut(4).enumerate() {
        // Of an inverse bind matrix, all but the last number undoes the scale.
        if i % 16 != 15 {
            let value = f32::from_le_bytes(bytes.try_into().expect("four bytes"));
            bytes.copy_from_slice(&(value * 100.0).to_le_bytes());
        }
    }
    let [a, b] = [plain, scaled].map(|file| Arc::new(file.read().expect("a hand")));
    let like = likeness(&spec("pinch", Some(&a)), &spec("pinch", Some(&b)));
    assert!(like > 0.99, "{like}");
}

#[test]
fn a_model_ends_where_its_mesh_does() {
    let model = Arc::new(File::new(0.004, false, &elsewhere()).read().expect("a hand"));
    assert!((model.cut(0.0).x + 0.012).abs() < 1e-9);
    assert!((model.cut(0.3).x + 0.032).abs() < 0.004, "{}", model.cut(0.3));
    for x in [-0.012, -0.03] {
        let mesh = model.posed(&REST, x);
        assert!(mesh.is_closed());
        assert!((2e-4..7e-4).contains(&mesh.volume()), "{}", mesh.volume());
    }
}

#[test]
fn pictures_follow_from_the_file() {
    let file = File::new(0.006, false, &elsewhere());
    let model = Arc::new(file.read().expect("a hand"));
    let again = Arc::new(file.read().expect("a hand"));
    let mut other = file.clone();
    other.document["asset"]["generator"] = json!("another");
    let other = Arc::new(other.read().expect("a hand"));
    let hash = |model| spec("pinch", Some(model)).params_hash();
    assert_eq!(hash(&model), hash(&again));
    assert_ne!(hash(&model), hash(&other));
    let view = &ViewGrid::default().views()[100];
    let picture = |model| spec("pinch", Some(model)).build().expect("a scene").render(view);
    assert_eq!(picture(&model), picture(&again));
}

#[test]
fn what_is_wrong_is_told_plainly() {
    let file = File::new(0.006, false, &elsewhere());
    let refused = |spoil: fn(&mut File)| file.refused(spoil);
    insta::assert_snapshot!(refused(|f| f.document["nodes"][25]["name"] = json!("little-tip")), @"it lacks 1 of the 25 joints of WebXR's hands: pinky-finger-tip; name the bones like these");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][26]["name"] = json!("wrist")), @"the joint wrist is there more than once: one hand a file");
    insta::assert_snapshot!(refused(|f| f.document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])), @"it needs the extension KHR_draco_mesh_compression: export it without compression and extensions");
    insta::assert_snapshot!(refused(|f| f.document["buffers"][0]["uri"] = json!("hand.bin")), @"its numbers lie outside the file (hand.bin): export it as one .glb");
    insta::assert_snapshot!(refused(|f| f.document["accessors"][0]["sparse"] = json!({"count": 1})), @"accessor 0 is sparse: export it without sparse accessors");
    insta::assert_snapshot!(refused(|f| f.document["accessors"][0]["count"] = json!(4_000_000_000u32)), @"it is damaged: accessor 0 has 4000000000 rows; 4000000 at most");
    insta::assert_snapshot!(refused(|f| f.document["accessors"][1]["componentType"] = json!(5130)), @"it is damaged: accessor 1 has numbers of the unknown type 5130");
    insta::assert_snapshot!(refused(|f| f.document["bufferViews"][3]["byteOffset"] = json!(u64::MAX)), @"it is damaged: accessor 3 lies outside the file's numbers");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][0]["children"] = json!([0])), @"it is damaged: some of its nodes go in a circle");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][0]["scale"] = json!([100, 100, 100])), @"it is 18.093 m long from the wrist to the middle fingertip: glTF is in metres, and a hand has 0.1 to 0.3 m");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][3]["rotation"] = json!([0, 0, 0, 0])), @"it is damaged: the place, rotation or scale of node 3 is out of range");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][12]["translation"][1] = json!(0.5)), @"it is 1.580 m long from the wrist to the middle fingertip: glTF is in metres, and a hand has 0.1 to 0.3 m");
    insta::assert_snapshot!(refused(|f| f.document["meshes"][0]["primitives"][0]["mode"] = json!(1)), @"its mesh is not made of triangles: triangulate it");
    insta::assert_snapshot!(refused(|f| f.document["nodes"][26]["skin"] = Value::Null), @"no mesh is bound to its joints: skin the mesh to them");
    insta::assert_snapshot!(refused(|f| f.numbers.truncate(1000)), @"it is damaged: accessor 4 lies outside the file's numbers");
    insta::assert_snapshot!(refused(|f| f.numbers[2..4].fill(0xff)), @"it is damaged: vertex 0 of a mesh has weights or joints that are out of range");
    let named = |name| HandModel::parse(name, &file.bytes()).expect_err("refused").to_string();
    insta::assert_snapshot!(named("../up"), @"a hand cannot be named `../up`: rename the file, using up to 64 of a-z, A-Z, 0-9, - and _, and not the name of a built-in hand");
    insta::assert_snapshot!(named("hand-7"), @"a hand cannot be named `hand-7`: rename the file, using up to 64 of a-z, A-Z, 0-9, - and _, and not the name of a built-in hand");
    let bytes = file.bytes();
    let parsed = |bytes: &[u8]| HandModel::parse("test", bytes).expect_err("refused").to_string();
    insta::assert_snapshot!(parsed(b"\x89PNG\r\n"), @"it is not a binary glTF file: export the hand as .glb");
    insta::assert_snapshot!(parsed(&bytes[..bytes.len() - 1]), @"it is damaged: truncated: 109076 bytes expected, 109075 found");
    let missing = HandModel::load("/nowhere/hand.glb").expect_err("missing");
    assert_eq!(missing.to_string(), "it cannot be read");
}

#[test]
fn no_damage_makes_it_panic() {
    let bytes = File::new(0.008, false, &elsewhere()).bytes();
    for length in (0..bytes.len()).step_by(97).chain(0..64) {
        assert!(HandModel::parse("test", &bytes[..length]).is_err(), "{length} bytes");
        // A file that was cut short and says so itself.
        let mut cut = bytes[..length].to_vec();
        if let Some(says) = cut.get_mut(8..12) {
            says.copy_from_slice(&(length as u32).to_le_bytes());
        }
        assert!(HandModel::parse("test", &cut).is_err(), "{length} bytes");
    }
    let view = &ViewGrid::default().views()[100];
    let mut usable = 0;
    for at in (0..bytes.len()).step_by(41) {
        for bit in [0, 6, 7] {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            let Ok(model) = HandModel::parse("test", &flipped) else { continue };
            usable += 1;
            if usable % 20 == 0 {
                let scene = spec("precision-disc", Some(&Arc::new(model))).build().expect("a scene");
                scene.render(view);
            }
        }
    }
    assert!(usable > 100, "{usable}");
}
