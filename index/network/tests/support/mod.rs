//! Networks and pictures without a pattern, the same on every machine.
#![allow(dead_code, reason = "each test binary uses a part")]

use grasp_network::{Architecture, Convolution, Masks};
use proptest::prelude::*;

/// Numbers from -1 to 1 by a linear congruential generator.
pub(crate) struct Numbers(pub(crate) u64);

impl Iterator for Numbers {
    type Item = f32;

    fn next(&mut self) -> Option<f32> {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        Some((self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0)
    }
}

/// A network's shape of each kind of layer, with outputs of more and less than one block.
pub(crate) fn small() -> Architecture {
    Architecture {
        side: 9,
        planes: 2,
        convolutions: vec![
            Convolution { kernel: 5, stride: 2, outputs: 7 },
            Convolution { kernel: 3, stride: 1, outputs: 33 },
        ],
        embedding: 20,
        heads: 5,
        masks: None,
    }
}

/// The same with masks, read from a convolution whose output is padded for the next one.
pub(crate) fn masked() -> Architecture {
    Architecture { masks: Some(Masks { convolution: 0, count: 2, cells: 3 }), ..small() }
}

/// Weights of a size that keeps activations near 1.
pub(crate) fn weights(architecture: &Architecture, seed: u64) -> Vec<f32> {
    let mut numbers = Numbers(seed);
    let layers = architecture.layers().expect("a supported shape");
    let mut weights = Vec::new();
    for layer in layers {
        let scale = (3.0 / layer.inputs() as f32).sqrt();
        weights.extend(numbers.by_ref().take(layer.parameters()).map(|number| number * scale));
    }
    weights
}

/// A picture, of which many values are 0 as outside of a hand, and some are -0.
pub(crate) fn picture(architecture: &Architecture, seed: u64) -> Vec<f32> {
    let values = (architecture.side * architecture.side * architecture.planes) as usize;
    let blank = |number: f32| if number < -0.5 { number * 0.0 } else { number };
    Numbers(seed).take(values).map(blank).collect()
}

/// Networks with convolutions of these kernels and so many outputs, some of them with masks.
pub(crate) fn architectures<const N: usize>(
    kernels: [u32; N],
    outputs: impl Strategy<Value = u32>,
) -> impl Strategy<Value = Architecture> {
    let kernel = prop::sample::select(kernels.to_vec());
    let convolution = (kernel, 1..=2u32, outputs).prop_map(|(kernel, stride, outputs)| Convolution {
        kernel,
        stride,
        outputs,
    });
    let convolutions = prop::collection::vec(convolution, 0..=3);
    let masks = (0..3u32, 1..=3u32, 1..=5u32).prop_map(|(convolution, count, cells)| Masks {
        convolution,
        count,
        cells,
    });
    (1..=13u32, 1..=4u32, convolutions, 1..=70u32, 1..=40u32, prop::option::of(masks)).prop_map(
        |(side, planes, convolutions, embedding, heads, masks)| Architecture {
            side,
            planes,
            masks: masks.filter(|masks| (masks.convolution as usize) < convolutions.len()),
            convolutions,
            embedding,
            heads,
        },
    )
}
