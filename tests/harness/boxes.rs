//! A right hand made of boxes, one a bone, in a binary glTF file; no artist's work.

use serde_json::json;

const BONES: [[f32; 3]; 5] = [
    [0.047, 0.037, 0.031],
    [0.046, 0.027, 0.022],
    [0.050, 0.031, 0.023],
    [0.046, 0.030, 0.023],
    [0.038, 0.022, 0.020],
];
const ROOTS: [[f32; 3]; 5] = [
    [0.023, 0.024, -0.008],
    [0.082, 0.023, -0.001],
    [0.084, 0.000, 0.000],
    [0.079, -0.022, -0.002],
    [0.071, -0.040, -0.006],
];

/// The bytes of the file.
#[must_use]
pub fn hand() -> Vec<u8> {
    let mut nodes = vec![json!({"name": "wrist"})];
    // Of each box the joint, the way to its other end, and its half sides.
    let mut bodies =
        vec![(0u8, [-0.03f32, 0.0, 0.0], [0.0f32, 0.043, 0.013]), (0, [0.084, 0.0, 0.0], [0.0, 0.04, 0.012])];
    for (digit, name) in
        ["thumb", "index-finger", "middle-finger", "ring-finger", "pinky-finger"].iter().enumerate()
    {
        let mut joints = vec!["phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"];
        if digit == 0 {
            joints = vec!["metacarpal", "phalanx-proximal", "phalanx-distal", "tip"];
        } else {
            let at = ROOTS[digit].map(|x| 0.3 * x);
            nodes.push(json!({"name": format!("{name}-metacarpal"), "translation": at}));
        }
        let mut at = ROOTS[digit];
        for (i, joint) in joints.iter().enumerate() {
            nodes.push(json!({"name": format!("{name}-{joint}"), "translation": at}));
            let Some(length) = BONES[digit].get(i) else { continue };
            let (sin, cos) = (0.15 + 0.1 * i as f32).sin_cos();
            let along = if digit == 0 { [0.62, 0.62, -0.48] } else { [cos, 0.0, -sin] }.map(|x| x * length);
            bodies.push((nodes.len() as u8 - 1, along, [0.0, 0.008, 0.007]));
            at = [0, 1, 2].map(|axis| at[axis] + along[axis]);
        }
    }
    let (mut places, mut joints, mut weights, mut indices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (joint, along, half) in &bodies {
        let first = joints.len() as u16 / 4;
        for corner in 0..8u8 {
            let side = |bit: u8| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let end = 0.5 + 0.5 * side(0);
            let place = [0, 1, 2].map(|axis| along[axis] * end + half[axis] * side(axis as u8));
            places.extend(place.iter().flat_map(|x| x.to_le_bytes()));
            joints.extend([*joint, 0, 0, 0]);
            weights.extend([1f32, 0.0, 0.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
        }
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in faces {
            // A box that goes backwards would show its inner side.
            let face = if along[0] > 0.0 { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
            indices.extend(face.iter().flat_map(|i: &u16| (first + i).to_le_bytes()));
        }
    }
    let corners = 8 * bodies.len();
    nodes.push(json!({"mesh": 0, "skin": 0}));
    let parts = [
        (places, corners, 5126, "VEC3"),
        (joints, corners, 5121, "VEC4"),
        (weights, corners, 5126, "VEC4"),
        (indices, 36 * bodies.len(), 5123, "SCALAR"),
    ];
    let (mut numbers, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (part, count, kind, shape) in parts {
        views.push(json!({"buffer": 0, "byteOffset": numbers.len(), "byteLength": part.len()}));
        accessors.push(
            json!({"bufferView": views.len() - 1, "componentType": kind, "count": count, "type": shape}),
        );
        numbers.extend(part);
    }
    let document = json!({
        "asset": {"version": "2.0"}, "nodes": nodes, "bufferViews": views, "accessors": accessors,
        "skins": [{"joints": (0..25).collect::<Vec<_>>()}], "buffers": [{"byteLength": numbers.len()}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 28 + text.len() + numbers.len();
    let mut file = b"glTF".to_vec();
    let words =
        |file: &mut Vec<u8>, words: &[u32]| file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    words(&mut file, &[2, length as u32, text.len() as u32, 0x4E4F_534A]);
    file.extend(text);
    words(&mut file, &[numbers.len() as u32, 0x004E_4942]);
    file.extend(numbers);
    file
}
