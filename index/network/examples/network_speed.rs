//! How long a network's file takes to read, and a picture on each path that this machine has, in
//! floats as in integers, by both shipped networks, or by those in the files that are named:
//! `cargo run -p grasp-network --example network_speed [FILE...]`.

use grasp_network::{Layer, Network, Path, QuantisedNetwork, Scratch};
use std::error::Error;
use std::time::{Duration, Instant};

/// Pictures that are timed, one by one.
const PICTURES: usize = 1001;
/// How often a file is read.
const READINGS: usize = 21;
/// The descriptor's network, and the one that finds a hand.
const SHIPPED: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../builder/data/hand.network"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../query/recognise/data/scene.network"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let files = if named.is_empty() { SHIPPED.map(str::to_owned).to_vec() } else { named };
    for file in files {
        let bytes = std::fs::read(file)?;
        // Whatever the file says that it is computed in: both are measured.
        let network = Network::from_bytes(&bytes)?;
        let floats = Network::from_weights(network.architecture().clone(), network.weights())?;
        measure(&floats)?;
        measure_reading(&floats.to_bytes());
    }
    Ok(())
}

fn measure(network: &Network) -> Result<(), Box<dyn Error>> {
    let architecture = network.architecture();
    let multiply_adds: u64 = architecture.layers()?.iter().map(Layer::multiply_adds).sum();
    println!("\n{} weights, {multiply_adds} multiply-adds a picture\n", architecture.parameters()?);
    let inputs = (architecture.side * architecture.side * architecture.planes) as usize;
    let input: Vec<f32> = (0..inputs).map(|at| wave(at).max(0.0)).collect();

    println!("| path         | floats: median us a picture | fastest | integers: median | fastest |");
    println!("|--------------|-----------------------------|---------|------------------|---------|");
    for path in Path::available() {
        let network = network.clone().with_path(path);
        let quantised = QuantisedNetwork::from(&network);
        let (mut scratch, mut integers) = (Scratch::default(), Scratch::default());
        let [median, fastest] = times(PICTURES, || {
            std::hint::black_box(network.run(&mut scratch, std::hint::black_box(&input)));
        });
        let [median_of_integers, fastest_of_integers] = times(PICTURES, || {
            std::hint::black_box(quantised.run(&mut integers, std::hint::black_box(&input)));
        });
        println!(
            "| {:12} | {median:27.0} | {fastest:7.0} | {median_of_integers:16.0} | {fastest_of_integers:7.0} |",
            path.name()
        );
    }
    Ok(())
}

fn measure_reading(bytes: &[u8]) {
    // What is read is kept: a process that reads a network once has to be given its memory, too.
    let (mut floats, mut integers) = (Vec::new(), Vec::new());
    let [of_floats, _] = times(READINGS, || floats.push(Network::from_bytes(bytes)));
    let [of_integers, _] = times(READINGS, || integers.push(QuantisedNetwork::from_bytes(bytes)));
    println!("\nread in {of_floats:.0} us as floats, in {of_integers:.0} us as integers (medians)");
}

/// The median and the least of the times that something takes, in microseconds.
fn times(count: usize, mut run: impl FnMut()) -> [f64; 2] {
    let mut times: Vec<Duration> = (0..count)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort_unstable();
    [times[count / 2], times[0]].map(|time| time.as_secs_f64() * 1e6)
}

/// Numbers from -1 to 1 without a pattern that matters.
fn wave(at: usize) -> f32 {
    (at * 7919 % 2001) as f32 / 1000.0 - 1.0
}
