//! How long a camera picture takes from its bytes to its answer, step by step, found by the scene
//! network and found by colour, side by side, on one core:
//! `cargo run --release -p grasp-recognise --example picture_speed INDEX [PICTURE...]`.
//!
//! Both ways take turns, so that what else the machine does slows both alike; medians and fastest
//! of [`ROUNDS`].

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use grasp_index::Index;
use grasp_recognise::networks::Networks;
use grasp_recognise::picture::{self, WORKING_SIDE};
use grasp_recognise::scene;
use grasp_recognise::segment::{Finder, SegmentParams, segment};
use grasp_recognise::{MaskSource, RecogniseOptions, Recogniser, Timings};

/// How often each picture is recognised in each way.
const ROUNDS: usize = 101;
/// A step, and how long it took.
type Step = (&'static str, f64);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let index = Index::open(&arguments.next().ok_or("name an index: picture_speed INDEX [PICTURE...]")?)?;
    let mut pictures: Vec<PathBuf> = arguments.collect();
    if pictures.is_empty() {
        pictures
            .push([env!("CARGO_MANIFEST_DIR"), "../../tests/pictures/camera/09-pinch.jpg"].iter().collect());
    }
    for path in pictures {
        measure(&index, &path).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

fn measure(index: &Index, path: &std::path::Path) -> Result<(), Box<dyn Error>> {
    let bytes = std::fs::read(path)?;
    let (width, height) = picture::dimensions(&bytes)?;
    let ways = [Finder::Scene, Finder::Skin];
    let mut rounds: [Vec<Vec<Step>>; 2] = Default::default();
    for _ in 0..ROUNDS {
        for (by, rounds) in ways.iter().zip(&mut rounds) {
            rounds.push(once(index, &bytes, by)?);
        }
    }
    println!("\n{}, {width} x {height}, {} bytes; ms, median (fastest)\n", path.display(), bytes.len());
    println!("| step                     |   scene network |          colour |");
    println!("|--------------------------|-----------------|-----------------|");
    let [scene, skin] = rounds;
    let names: Vec<&str> = scene.first().into_iter().flatten().map(|(name, _)| *name).collect();
    for (at, name) in names.into_iter().enumerate() {
        let [scene, skin] = [&scene, &skin].map(|rounds| {
            let mut times: Vec<f64> = rounds.iter().map(|steps| steps[at].1).collect();
            times.sort_unstable_by(f64::total_cmp);
            format!("{:.2} ({:.2})", times[ROUNDS / 2], times[0])
        });
        println!("| {name:24} | {scene:>15} | {skin:>15} |");
    }
    Ok(())
}

/// The steps of one recognition; then parts of its segmentation, done once more by themselves.
fn once(index: &Index, bytes: &[u8], by: &Finder) -> Result<Vec<Step>, Box<dyn Error>> {
    let mut options = RecogniseOptions::default();
    options.segment.by = by.clone();
    let started = Instant::now();
    let found = Recogniser::new(index, options).recognise(bytes, &MaskSource::Camera)?;
    let all = milliseconds(started);
    let Timings { decode_ms, segmentation_ms, descriptor_ms, search_ms, vote_ms } = found.timings;

    let decoded = picture::decode(bytes)?.picture;
    let started = Instant::now();
    let small = decoded.shrunk_to(WORKING_SIDE);
    let shrinking = milliseconds(started);
    let started = Instant::now();
    if *by == Finder::Scene {
        std::hint::black_box(scene::find(&Networks::default(), &small));
    }
    let finding = milliseconds(started);
    let started = Instant::now();
    std::hint::black_box(segment(&small, &SegmentParams::default()));
    let cutting = milliseconds(started);
    Ok(vec![
        ("decode", decode_ms),
        ("segmentation", segmentation_ms),
        ("- shrink", shrinking),
        ("- find by the network", finding),
        ("- cut out by colour", cutting),
        ("describe", descriptor_ms),
        ("search", search_ms),
        ("vote", vote_ms),
        ("all", all),
    ])
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
