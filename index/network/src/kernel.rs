//! The inner loops: plain Rust in one fixed order of summation, compiled once for each path.
//!
//! An output is its bias plus its products in the order y, x, input, each product rounded before it
//! is added. Vectors lie across outputs, so that their width does not touch that order, and Rust
//! never contracts a multiplication and an addition into one: all paths return the same bits.

use crate::architecture::Architecture;
use crate::lanes::Lanes;
use crate::layer::{LANES, Rectifier};
use crate::packed::Packed;

/// Computes a layer, `PIXELS` of its pixels at a time: their sums, [`LANES`] a pixel, should fit
/// into the registers of the path.
///
/// `input` and `output` have the borders that the layer was packed for; only the pixels inside the
/// output's are written.
#[inline(always)]
pub(crate) fn compute<const PIXELS: usize>(layer: &Packed, input: &[f32], output: &mut [f32]) {
    for (block, first) in layer.blocks().zip((0..).step_by(LANES)) {
        let width = LANES.min(layer.outputs - first);
        for group in layer.pixels.chunks(PIXELS) {
            // A last group that is smaller computes its last pixel several times.
            let starts = std::array::from_fn(|at| group[at.min(group.len() - 1)].input);
            // Of a block that is filled to no more than a half, the other half is not computed.
            let sums = match width {
                ..=HALF => sums::<PIXELS, HALF>(layer, block, input, starts),
                _ => sums::<PIXELS, LANES>(layer, block, input, starts),
            };
            for (pixel, sums) in group.iter().zip(sums) {
                let values = rectify(sums, layer.rectifier);
                write(&values, &mut output[pixel.output + first..][..width]);
            }
        }
    }
}

/// Half of a block's outputs.
const HALF: usize = LANES / 2;

/// The sums of the first `WIDTH` outputs of a block, for the windows that start at `starts` in
/// `input`.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "iterators become scalar instructions here")]
fn sums<const PIXELS: usize, const WIDTH: usize>(
    layer: &Packed,
    block: &[Lanes],
    input: &[f32],
    starts: [usize; PIXELS],
) -> [[f32; LANES]; PIXELS] {
    let mut sums = [block[0].0; PIXELS];
    for (y, weights) in block[1..].chunks_exact(layer.row_length).enumerate() {
        let windows: [&[f32]; PIXELS] =
            std::array::from_fn(|pixel| &input[starts[pixel] + y * layer.row_step..][..weights.len()]);
        for (at, weights) in weights.iter().enumerate() {
            for pixel in 0..PIXELS {
                let value = windows[pixel][at];
                // An indexed loop of these lengths becomes vector instructions that keep the sums
                // in registers. A zip became scalar ones, up to nine times slower: run
                // examples/network_speed.rs after a change.
                for lane in 0..WIDTH {
                    sums[pixel][lane] += value * weights.0[lane];
                }
            }
        }
    }
    sums
}

/// What follows the sums. Comparisons, because the sign of a zero from `max` is unspecified.
#[inline(always)]
pub(crate) fn rectify<const N: usize>(mut sums: [f32; N], rectifier: Rectifier) -> [f32; N] {
    // In loops, because a `map` of so many values becomes a call.
    match rectifier {
        Rectifier::Zero => {
            for sum in &mut sums {
                *sum = if *sum > 0.0 { *sum } else { 0.0 };
            }
        }
        Rectifier::Leaky => {
            for sum in &mut sums {
                *sum = if *sum > 0.0 { *sum } else { *sum * Architecture::LEAK };
            }
        }
        Rectifier::None => {}
    }
    sums
}

/// Writes as many of a block's outputs as there is room for: all of them, but of a last block.
#[inline(always)]
pub(crate) fn write<const N: usize>(values: &[f32; N], to: &mut [f32]) {
    match to.first_chunk_mut() {
        Some(whole) => *whole = *values,
        None => to.copy_from_slice(&values[..to.len()]),
    }
}
