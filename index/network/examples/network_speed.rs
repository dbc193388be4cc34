//! How long a picture takes, on each path that this machine has, by the shipped network and by one
//! with masks: `cargo run -p grasp-network --example network_speed`.

use grasp_network::{Architecture, Convolution, Layer, Masks, Network, Path, Scratch};
use std::error::Error;
use std::time::{Duration, Instant};

/// Pictures that are timed, one by one.
const PICTURES: usize = 1001;

fn main() -> Result<(), Box<dyn Error>> {
    measure(architecture(48, 2, &[(5, 2, 16), (3, 2, 32), (3, 1, 48), (3, 2, 96), (3, 1, 96)], 15, None))?;
    println!();
    measure(architecture(
        64,
        3,
        &[(5, 2, 16), (3, 2, 32), (3, 1, 48), (3, 2, 96), (3, 1, 112), (3, 1, 112), (3, 2, 160)],
        17,
        Some(Masks { convolution: 5, count: 2, cells: 4 }),
    ))
}

fn architecture(
    side: u32,
    planes: u32,
    convolutions: &[(u32, u32, u32)],
    heads: u32,
    masks: Option<Masks>,
) -> Architecture {
    let convolution = |&(kernel, stride, outputs)| Convolution { kernel, stride, outputs };
    let convolutions = convolutions.iter().map(convolution).collect();
    Architecture { side, planes, convolutions, embedding: 128, heads, masks }
}

fn measure(architecture: Architecture) -> Result<(), Box<dyn Error>> {
    let multiply_adds: u64 = architecture.layers()?.iter().map(Layer::multiply_adds).sum();
    println!("{} weights, {multiply_adds} multiply-adds a picture\n", architecture.parameters()?);
    let weights = (0..architecture.parameters()?).map(|at| wave(at) * 0.1).collect();
    let inputs = (architecture.side * architecture.side * architecture.planes) as usize;
    let network = Network::from_weights(architecture, weights)?;
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
