//! The trainer as a whole, against a plain reference in f64.

mod checkpoint;
mod gradient;
mod learning;
mod reference;
mod warm_start;

use crate::{Batch, LossWeights, Target, Trainer, rotation_of};
use grasp_network::{Architecture, Convolution, Masks};

/// Small, with every kind of layer: both strides, kernels that reach over the border, an odd side.
fn small() -> Architecture {
    let convolutions = [(5, 2, 3), (3, 1, 4), (3, 2, 5)].map(|(kernel, stride, outputs)| Convolution {
        kernel,
        stride,
        outputs,
    });
    let convolutions = convolutions.to_vec();
    Architecture { side: 7, planes: 2, convolutions, embedding: 6, heads: 13, masks: None }
}

/// The same with masks of 8 x 8 values that are read from a convolution in the middle.
fn masked() -> Architecture {
    Architecture { masks: Some(Masks { convolution: 1, count: 2, cells: 2 }), ..small() }
}

fn trainer(seed: u64) -> Trainer {
    Trainer::new(&small(), 0, seed).expect("a supported architecture")
}

fn masked_trainer(seed: u64) -> Trainer {
    Trainer::new(&masked(), JOINTS, seed).expect("a supported architecture")
}

/// Joints that the masked networks learn.
const JOINTS: usize = 2;

/// A batch with joints anywhere, and masks of any shares, of which a few samples have none or count
/// twice.
fn masked_batch(samples: usize, seed: u64) -> Batch {
    let mut batch = batch(samples, seed);
    let random = |index: usize| crate::random::symmetric(!seed, index as u64);
    batch.masks = (0..samples * 2 * 8 * 8).map(|index| (random(index) + 1.0) / 2.0).collect();
    batch.joints = (0..samples * 3 * JOINTS).map(|index| random(2_000_000 + index)).collect();
    for (target, weight) in batch.targets.iter_mut().zip([1.0, 0.0, 1.0, 2.0].into_iter().cycle()) {
        target.weights.masks = weight;
        target.weights.joints = 2.0 - weight;
    }
    batch
}

/// Some samples, of which a few have no class or count differently.
fn batch(samples: usize, seed: u64) -> Batch {
    let random = |index: usize| crate::random::symmetric(seed, index as u64);
    let inputs = 7 * 7 * 2;
    let target = |sample: usize| Target {
        class: sample as u32 % 4,
        stage: sample as u32 % 3,
        rotation: rotation_of([0, 1, 2, 3, 4, 5].map(|i| random(1_000_000 + sample * 6 + i))),
        weights: match sample % 5 {
            0 => LossWeights { class: 0.0, ..LossWeights::ALL },
            1 => LossWeights { class: 2.0, stage: 0.5, rotation: 0.0, ..LossWeights::ALL },
            _ => LossWeights::ALL,
        },
    };
    Batch {
        inputs: (0..samples * inputs).map(random).collect(),
        targets: (0..samples).map(target).collect(),
        ..Batch::default()
    }
}
