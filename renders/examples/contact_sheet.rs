//! Writes a PNG with one row a grasp and one column a view, to look at.
//!
//! `cargo run --release -p grasp-renders --example contact_sheet -- OUT.png [HAND] [STAGE] [SIDE]`

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use grasp_renders::{GraspSet, HandShape, Look, Preset, RenderPlan, View};

/// Azimuth and elevation in degrees with the back of the hand up, and the same seen from the
/// thumb's side.
const VIEWS: [[f64; 3]; 10] = [
    [333.0, 59.0, 0.0],
    [230.0, 82.0, 0.0],
    [63.0, 63.0, 0.0],
    [34.0, 16.0, 0.0],
    [77.0, 14.0, 0.0],
    [244.0, 10.0, 0.0],
    [111.0, 33.0, 0.0],
    [90.0, -20.0, 0.0],
    [120.0, -50.0, 0.0],
    [30.0, -60.0, 0.0],
];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let arg = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_owned());
    let side: usize = arg(3, "128").parse()?;
    let plan = RenderPlan {
        hand_shapes: vec![HandShape::preset(&arg(1, "mean"))?],
        stages: vec![arg(2, "grasp").parse()?],
        grasps: GraspSet::builtin(),
        look: Look { side, ..Look::default() },
        ..RenderPlan::preset(Preset::Paper)
    };
    let scenes = plan.scenes();
    let width = side * VIEWS.len();
    let mut sheet = vec![0u8; width * side * scenes.len()];
    for (row, spec) in scenes.iter().enumerate() {
        // All grasps with the back of the hand up, to compare them.
        let mut spec = spec.clone();
        let mut grasp = (*spec.grasp).clone();
        grasp.up = nalgebra::Vector3::z();
        spec.grasp = grasp.into();
        let scene = spec.build()?;
        for (column, [azimuth_deg, elevation_deg, roll_deg]) in VIEWS.into_iter().enumerate() {
            let render = scene.render(&View { azimuth_deg, elevation_deg, roll_deg });
            for (y, line) in render.grey.chunks(side).enumerate() {
                let start = (row * side + y) * width + column * side;
                sheet[start..start + side].copy_from_slice(line);
            }
        }
    }
    let file = BufWriter::new(File::create(arg(0, "contact_sheet.png"))?);
    let mut encoder = png::Encoder::new(file, width as u32, (side * scenes.len()) as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(&sheet)?;
    Ok(())
}
