//! A layer of integer weights, laid out for the inner loops.

use std::borrow::Cow;

use super::rounding::nearest_byte;
use crate::lanes::Lanes;
use crate::layer::{LANES, Layer, Rectifier};
use crate::pixels::{Borders, Pixel, pixels};
use crate::unpacked::Unpacked;
use bytemuck::{AnyBitPattern, NoUninit};

/// The largest magnitude of a weight's integer.
const LARGEST_WEIGHT: f32 = 127.0;
/// Inputs whose products one instruction sums.
pub(super) const TOGETHER: usize = 4;
/// The most inputs of an output: no sum of products overflows.
const MOST_INPUTS: usize = i32::MAX as usize / (255 * 127);

/// The weights of four inputs for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug, AnyBitPattern, NoUninit)]
#[repr(C, align(64))]
pub(super) struct Quads(pub(super) [[i8; TOGETHER]; LANES]);

/// A layer's weights as integers, and where its pixels lie.
#[derive(Clone, Debug)]
pub(super) struct PackedIntegers {
    /// `[block][y, x, input in fours]`; those of outputs past the last are 0.
    pub(super) weights: Cow<'static, [Quads]>,
    /// For each block of outputs, what follows its sums.
    pub(super) scales: Vec<Scales>,
    /// Values of a window that lie together.
    pub(super) row_length: usize,
    /// Values from a row of the input's buffer to the next.
    pub(super) row_step: usize,
    /// Outputs of a pixel, without those that fill the last block.
    pub(super) outputs: usize,
    /// The output's pixels, row by row.
    pub(super) pixels: Vec<Pixel>,
    pub(super) rectifier: Rectifier,
}

/// What each output's integers count, and its bias.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub(super) units: [f32; LANES],
    pub(super) biases: [f32; LANES],
}

impl PackedIntegers {
    /// Whether a layer can be computed so: where its inputs come in fours, and their sums cannot
    /// overflow.
    pub(super) fn is_supported(layer: &Layer) -> bool {
        layer.input_planes.is_multiple_of(TOGETHER) && layer.inputs() <= MOST_INPUTS
    }

    /// Rounds the weights of a layer.
    pub(super) fn new(unpacked: &mut Unpacked<'_>) -> Self {
        let (layer, borders) = (unpacked.layer, unpacked.borders);
        let blocks = layer.output_planes.div_ceil(LANES);
        let mut scales = Vec::with_capacity(blocks);
        let mut weights = Vec::with_capacity(blocks * layer.inputs() / TOGETHER);
        unpacked.for_each_block(|block| {
            let (biases, matrix) = block.split_first().expect("a block begins with its biases");
            let units = units(matrix);
            weights.extend(quads(matrix, inverse(&units)));
            scales.push(Scales { units, biases: biases.0 });
        });
        Self::of_blocks(Cow::Owned(weights), scales, layer, borders)
    }

    /// A layer whose weights lie as they shall, with the scales of each block.
    pub(super) fn of_blocks(
        weights: Cow<'static, [Quads]>,
        scales: Vec<Scales>,
        layer: &Layer,
        borders: Borders,
    ) -> Self {
        Self {
            weights,
            scales,
            row_length: layer.kernel * layer.input_planes,
            row_step: borders.input_row(layer),
            outputs: layer.output_planes,
            pixels: pixels(layer, borders),
            rectifier: layer.rectifier,
        }
    }
}

/// What the integers of each output count: its largest weight becomes the largest integer.
fn units(matrix: &[Lanes]) -> [f32; LANES] {
    let mut largest = [0.0f32; LANES];
    for row in matrix {
        largest.iter_mut().zip(row.0).for_each(|(largest, weight)| *largest = largest.max(weight.abs()));
    }
    largest.map(|largest| largest / LARGEST_WEIGHT)
}

/// Integers a unit of a weight; 0 where all weights of an output are 0.
fn inverse(units: &[f32; LANES]) -> [f32; LANES] {
    units.map(|unit| if unit > 0.0 { 1.0 / unit } else { 0.0 })
}

/// The rows of a block's inputs as integers, four at a time.
fn quads(matrix: &[Lanes], scale: [f32; LANES]) -> impl Iterator<Item = Quads> {
    matrix.chunks_exact(TOGETHER).map(move |rows| {
        // The four integers of a lane as one number: so all lanes are computed together.
        let mut words = [0u32; LANES];
        for (input, row) in rows.iter().enumerate() {
            for lane in 0..LANES {
                words[lane] |= u32::from(nearest_byte(row.0[lane] * scale[lane])) << (8 * input);
            }
        }
        Quads(words.map(|word| word.to_le_bytes().map(u8::cast_signed)))
    })
}
