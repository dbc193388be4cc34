//! A layer of integer weights, laid out for the inner loops.

use super::rounding::{nearest, nearest_byte};
use crate::layer::{LANES, Layer, Rectifier};
use crate::packed::{Lanes, Packed, Pixel};

/// The largest magnitude of a weight's integer.
const LARGEST_WEIGHT: f32 = 127.0;
/// Inputs whose products one instruction sums.
pub(super) const TOGETHER: usize = 4;
/// The most inputs of an output: no sum of products overflows.
const MOST_INPUTS: usize = i32::MAX as usize / (255 * 127);

/// The weights of four inputs for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Quads(pub(super) [[i8; TOGETHER]; LANES]);

/// A layer's integer weights, in blocks of outputs; those past the last are 0.
#[derive(Clone, Debug)]
pub(super) enum Weights {
    /// `[block][y, x, input in fours]`, for instructions that sum products of bytes.
    Quads(Vec<Quads>),
    /// `[block][y, x, input]`, as floats, for all others.
    Rows(Vec<Lanes>),
}

/// A layer's weights as integers, and where its pixels lie.
#[derive(Clone, Debug)]
pub(super) struct PackedIntegers {
    pub(super) weights: Weights,
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

    /// Rounds the weights of a layer, to be multiplied `in_bytes` or as floats.
    pub(super) fn new(layer: &Packed, in_bytes: bool) -> Self {
        let blocks =
            || layer.blocks().map(|block| block.split_first().expect("a block begins with its biases"));
        let scales: Vec<Scales> =
            blocks().map(|(biases, matrix)| Scales { units: units(matrix), biases: biases.0 }).collect();
        let scaled = blocks().zip(&scales).map(|((_, matrix), scales)| (matrix, inverse(&scales.units)));
        let weights = match in_bytes {
            true => Weights::Quads(scaled.flat_map(|(matrix, scale)| quads(matrix, scale)).collect()),
            false => Weights::Rows(scaled.flat_map(|(matrix, scale)| rows(matrix, scale)).collect()),
        };
        Self {
            weights,
            scales,
            row_length: layer.row_length,
            row_step: layer.row_step,
            outputs: layer.outputs,
            pixels: layer.pixels.clone(),
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
        let mut quads = [[0; TOGETHER]; LANES];
        for (input, row) in rows.iter().enumerate() {
            for lane in 0..LANES {
                quads[lane][input] = nearest_byte(row.0[lane] * scale[lane]).cast_signed();
            }
        }
        Quads(quads)
    })
}

/// The rows of a block's inputs as integers.
fn rows(matrix: &[Lanes], scale: [f32; LANES]) -> impl Iterator<Item = Lanes> {
    matrix.iter().map(move |row| Lanes(std::array::from_fn(|lane| nearest(row.0[lane] * scale[lane]))))
}
