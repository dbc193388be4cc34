//! How long a picture takes, on each path that this machine has, by both shipped networks, or by
//! those in the files that are named:
//! `cargo run -p grasp-network --example network_speed [FILE...]`.

use grasp_network::{Layer, Network, Path, Scratch};
use std::error::Error;
use std::time::{Duration, Instant};

/// Pictures that are timed, one by one.
const PICTURES: usize = 1001;
/// The descriptor's network, and the one that finds a hand.
const SHIPPED: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../builder/data/hand.network"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../query/recognise/data/scene.network"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let files = if named.is_empty() { SHIPPED.map(str::to_owned).to_vec() } else { named };
    for file in files {
        measure(&Network::from_bytes(&std::fs::read(file)?)?)?;
    }
    Ok(())
}

fn measure(network: &Network) -> Result<(), Box<dyn Error>> {
    let architecture = network.architecture();
    let multiply_adds: u64 = architecture.layers()?.iter().map(Layer::multiply_adds).sum();
    println!("\n{} weights, {multiply_adds} multiply-adds a picture\n", architecture.parameters()?);
    let inputs = (architecture.side * architecture.side * architecture.planes) as usize;
    let input: Vec<f32> = (0..inputs).map(|at| wave(at).max(0.0)).collect();

    println!("| path     | median us a picture | fastest |");
    println!("|----------|---------------------|---------|");
    for path in Path::available() {
        let network = network.clone().with_path(path);
        let mut scratch = Scratch::default();
        let mut times: Vec<Duration> = (0..PICTURES)
            .map(|_| {
                let start = Instant::now();
                std::hint::black_box(network.run(&mut scratch, std::hint::black_box(&input)));
                start.elapsed()
            })
            .collect();
        times.sort_unstable();
        let micros = |time: Duration| time.as_secs_f64() * 1e6;
        let (median, fastest) = (micros(times[PICTURES / 2]), micros(times[0]));
        println!("| {:8} | {median:19.0} | {fastest:7.0} |", path.name());
    }
    Ok(())
}

/// Numbers from -1 to 1 without a pattern that matters.
fn wave(at: usize) -> f32 {
    (at * 7919 % 2001) as f32 / 1000.0 - 1.0
}
