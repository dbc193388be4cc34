//! Writes a PNG of camera pictures, a row a grasp, to look at.
//!
//! `cargo run --release -p grasp-renders --example camera_sheet -- OUT.png [SEED] [COLUMNS]`

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use grasp_renders::{
    Framing, PosedHand, Preset, Randomised, RenderPlan, SceneSpec, Stage, View, presented_grasps,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pixels a side of a picture.
const SIDE: usize = 128;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: u64| args.get(i).map_or(Ok(default), |arg| arg.parse());
    let (seed, columns) = (number(1, 1)?, number(2, 14)? as usize);
    let plan = RenderPlan { stages: vec![Stage::Grasp], ..RenderPlan::preset(Preset::Paper) };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scenes: Vec<SceneSpec> = plan.scenes();
    let rows = plan.grasps.len();
    let width = columns * SIDE;
    let mut sheet = vec![0u8; 3 * width * rows * SIDE];
    for (row, grasp) in plan.grasps.iter().enumerate() {
        let of_grasp: Vec<_> = scenes.iter().filter(|spec| spec.grasp.name == grasp.name).collect();
        let ways: Vec<_> = presented_grasps().iter().filter(|way| way.name == grasp.name).collect();
        for column in 0..columns {
            let mut spec = of_grasp[rng.next_u64() as usize % of_grasp.len()].clone();
            // Every other one is held up to the camera.
            if column % 2 == 1 && !ways.is_empty() {
                spec.grasp = ways[rng.next_u64() as usize % ways.len()].clone();
                spec.object = spec.grasp.object.object((rng.next_u64() % 100) as f64 / 100.0);
                (spec.example, spec.held) = (None, None);
            }
            let scene = PosedHand::build(&spec)?.dressed(true, Randomised::ALL, rng.next_u64());
            let layers = scene.layers(&View::random(&mut rng), 3.0);
            let picture = layers.paint(&Framing::thing(&layers, &mut rng), SIDE, &mut rng);
            for (y, line) in picture.rgb.chunks(3 * SIDE).enumerate() {
                let start = 3 * ((row * SIDE + y) * width + column * SIDE);
                let bytes = line.iter().map(|value| (value * 255.0).round() as u8);
                sheet[start..start + 3 * SIDE].iter_mut().zip(bytes).for_each(|(to, from)| *to = from);
            }
        }
    }
    let file = BufWriter::new(File::create(args.first().map_or("camera_sheet.png", String::as_str))?);
    let mut encoder = png::Encoder::new(file, width as u32, (rows * SIDE) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&sheet)?;
    Ok(())
}
