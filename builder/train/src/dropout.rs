//! Dropout (Srivastava et al., 2014): in training, each value is left out with a fixed probability.

use crate::random::bits;

/// The share of values that are left out.
pub(crate) const RATE: f32 = 0.1;

/// Bits of one decision: four to a random number.
const BITS: u32 = 16;

/// Writes the values that stay, scaled up so that their expected sum stays too. Value `i` of the
/// sample `sample` of the batch is decided by the stream `key` alone, so that the same call on the
/// gradients is the way back.
pub(crate) fn drop_values(key: u64, sample: usize, inputs: &[f32], outputs: &mut [f32]) {
    const SCALE: f32 = 1.0 / (1.0 - RATE);
    const THRESHOLD: u64 = (RATE * (1u32 << BITS) as f32) as u64;
    let numbers = inputs.len().div_ceil(4);
    let quads = inputs.chunks(4).zip(outputs.chunks_mut(4));
    for (quad, (inputs, outputs)) in quads.enumerate() {
        let mut random = bits(key, (sample * numbers + quad) as u64);
        for (input, output) in inputs.iter().zip(outputs) {
            let stays = random & ((1 << BITS) - 1) >= THRESHOLD;
            *output = if stays { input * SCALE } else { 0.0 };
            random >>= BITS;
        }
    }
}
