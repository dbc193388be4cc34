//! Writes the hands that the page of `grasp-query serve` turns: each grasp's posed hand, coarse and small.
//!
//! `cargo run --release -p grasp-renders --example hand_mesh -- query/src/serve/page/hand.mesh`
//!
//! Little-endian. u32: how many hands. For each: u32 bytes of its name, u32 vertices, u32 triangles; the name; vertices as
//! three i16 in tenths of a millimetre in the frame of the hand, relative to its middle; triangles as three u16 corners.

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
        let (vertices, triangles) = scene.hand();
        let name = spec.grasp.name.as_bytes();
        for count in [name.len(), vertices.len(), triangles.len()] {
            bytes.extend(u32::try_from(count)?.to_le_bytes());
        }
        bytes.extend(name);
        for value in vertices.iter().flat_map(|place| place.iter()) {
            bytes.extend(((value * 1e4).round() as i16).to_le_bytes());
        }
        for corner in triangles.iter().flatten() {
            bytes.extend(u16::try_from(*corner)?.to_le_bytes());
        }
    }
    std::fs::write(out, bytes)?;
    Ok(())
}
