//! Prints how many samples a second are learned from, by networks as the shipped ones, on each
//! number of threads that is given, or on one and on two.

use grasp_network::{Architecture, ArchitectureError, Convolution, Masks};
use grasp_train::{Batch, LossWeights, Target, Trainer};
use std::error::Error;
use std::time::Instant;

/// Places that are learned besides.
const JOINTS: usize = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<usize> =
        std::env::args().skip(1).map(|threads| threads.parse()).collect::<Result<_, _>>()?;
    let threads = if given.is_empty() { vec![1, 2] } else { given };
    let hand = [(5, 2, 24), (3, 2, 48), (3, 1, 64), (3, 2, 128), (3, 1, 128), (3, 1, 128)];
    let hand = architecture(48, 2, &hand, 16, None);
    let scene = [
        (5, 2, 16),
        (3, 2, 32),
        (3, 1, 40),
        (3, 2, 96),
        (3, 1, 104),
        (3, 1, 104),
        (3, 2, 160),
        (3, 1, 160),
        (3, 1, 176),
    ];
    let scene = architecture(64, 3, &scene, 17, Some(Masks { convolution: 5, count: 3, cells: 4 }));
    for (name, architecture) in [("hand", hand), ("scene", scene)] {
        let samples = 64;
        let batch = batch(&architecture, samples)?;
        for &threads in &threads {
            let rate = measure(&architecture, &batch, threads)?;
            println!("{name}, batches of {samples}, {threads} threads: {rate:.0} samples/s");
        }
    }
    Ok(())
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

fn batch(architecture: &Architecture, samples: usize) -> Result<Batch, ArchitectureError> {
    let target = |sample: usize| Target {
        class: sample as u32 % 6,
        stage: sample as u32 % 3,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        weights: LossWeights::ALL,
    };
    let values = |count: usize| (0..count).map(|i| (i * 7919 % 1009) as f32 / 1009.0).collect();
    let inputs = (architecture.side * architecture.side * architecture.planes) as usize;
    let masks = architecture.mask_side()?.pow(2) * architecture.masks.map_or(0, |masks| masks.count as usize);
    Ok(Batch {
        inputs: values(samples * inputs),
        targets: (0..samples).map(target).collect(),
        masks: values(samples * masks),
        joints: values(samples * 3 * JOINTS),
        ..Batch::default()
    })
}

/// Samples a second.
fn measure(architecture: &Architecture, batch: &Batch, threads: usize) -> Result<f64, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let mut trainer = Trainer::new(architecture, JOINTS, 1)?;
    pool.install(|| trainer.step(batch, 1e-3))?;
    // The best of a few: others may use the machine too.
    let mut best = f64::INFINITY;
    for _ in 0..15 {
        let start = Instant::now();
        pool.install(|| trainer.step(batch, 1e-3))?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(batch.targets.len() as f64 / best)
}
