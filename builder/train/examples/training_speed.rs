//! Prints how many samples a second are learned from, by the shipped network and by one with masks,
//! on each number of threads that is given, or on one and on two.

use grasp_network::{Architecture, ArchitectureError, Convolution, Masks};
use grasp_train::{Batch, LossWeights, Target, Trainer};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<usize> =
        std::env::args().skip(1).map(|threads| threads.parse()).collect::<Result<_, _>>()?;
    let threads = if given.is_empty() { vec![1, 2] } else { given };
    let plain = architecture(48, 2, &[(5, 2, 16), (3, 2, 32), (3, 1, 48), (3, 2, 96), (3, 1, 96)], 15, None);
    let masked = architecture(
        64,
        3,
        &[(5, 2, 16), (3, 2, 32), (3, 1, 48), (3, 2, 96), (3, 1, 112), (3, 1, 112), (3, 2, 160)],
        17,
        Some(Masks { convolution: 5, count: 2, cells: 4 }),
    );
    for (name, architecture, samples) in [("shipped", plain, 128), ("with masks", masked, 64)] {
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
    })
}

/// Samples a second.
fn measure(architecture: &Architecture, batch: &Batch, threads: usize) -> Result<f64, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let mut trainer = Trainer::new(architecture, 1)?;
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
