//! Writes the hands that the page of `grasp-query serve` turns: each grasp's posed hand and what it
//! holds, coarse and small.
//!
//! `cargo run --release -p grasp-renders --example hand_mesh -- query/serve/src/page/hand.mesh`
//!
//! Little-endian. u32: how many hands. For each, five u32: bytes of its name, vertices, triangles,
//! and how many of these vertices and triangles are the hand's, which come first (the others are
//! its object's); then the name; vertices as three i16 in tenths of a millimetre in the frame of
//! the hand, relative to its middle; triangles as three u16 corners.

use std::error::Error;

use grasp_renders::{GraspSet, HandShape, Look, Preset, RenderPlan};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args().nth(1).ok_or("say which file to write")?;
    let plan = RenderPlan {
        hand_shapes: vec![HandShape::preset("mean")?],
        grasps: GraspSet::builtin(),
        look: Look { arm: 0.0, forearm: 0.02, cell: 0.0055, ..Look::default() },
        ..RenderPlan::preset(Preset::Paper)
    };
    let scenes = plan.scenes();
    let mut bytes = u32::try_from(scenes.len())?.to_le_bytes().to_vec();
    for spec in scenes {
        let scene = spec.build()?;
        let (hand, hand_triangles) = scene.hand();
        let (object, object_triangles) = scene.occluders();
        let first = u32::try_from(hand.len())?;
        let name = spec.grasp.name.as_bytes();
        let vertices = hand.len() + object.len();
        let triangles = hand_triangles.len() + object_triangles.len();
        for count in [name.len(), vertices, triangles, hand.len(), hand_triangles.len()] {
            bytes.extend(u32::try_from(count)?.to_le_bytes());
        }
        bytes.extend(name);
        for value in hand.iter().chain(object).flat_map(|place| place.iter()) {
            bytes.extend(((value * 1e4).round() as i16).to_le_bytes());
        }
        let object_triangles = object_triangles.iter().map(|corners| corners.map(|corner| corner + first));
        for corner in hand_triangles.iter().copied().chain(object_triangles).flatten() {
            bytes.extend(u16::try_from(corner)?.to_le_bytes());
        }
    }
    std::fs::write(out, bytes)?;
    Ok(())
}
