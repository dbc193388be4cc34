//! Prints how many samples a second are learned from, on each number of threads that is given, or
//! on one and on two.

use grasp_network::{Architecture, Convolution};
use grasp_train::{Batch, LossWeights, Target, Trainer};
use std::error::Error;
use std::time::Instant;

const SAMPLES: usize = 128;

fn main() -> Result<(), Box<dyn Error>> {
    let convolutions = [(5, 2, 16), (3, 2, 32), (3, 1, 48), (3, 2, 96), (3, 1, 96)]
        .map(|(kernel, stride, outputs)| Convolution { kernel, stride, outputs });
    let architecture =
        Architecture { side: 48, planes: 2, convolutions: convolutions.to_vec(), embedding: 128, heads: 15 };
    let target = |sample: usize| Target {
        class: sample as u32 % 6,
        stage: sample as u32 % 3,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        weights: LossWeights::ALL,
    };
    let batch = Batch {
        inputs: (0..SAMPLES * 48 * 48 * 2).map(|i| (i * 7919 % 1009) as f32 / 1009.0).collect(),
        targets: (0..SAMPLES).map(target).collect(),
    };
    let given: Vec<usize> =
        std::env::args().skip(1).map(|threads| threads.parse()).collect::<Result<_, _>>()?;
    for threads in if given.is_empty() { vec![1, 2] } else { given } {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let mut trainer = Trainer::new(&architecture, 1)?;
        pool.install(|| trainer.step(&batch, 1e-3))?;
        // The best of a few: others may use the machine too.
        let mut best = f64::INFINITY;
        for _ in 0..15 {
            let start = Instant::now();
            pool.install(|| trainer.step(&batch, 1e-3))?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{threads} threads: {:.0} samples/s", SAMPLES as f64 / best);
    }
    Ok(())
}
