//! A layer laid out for the inner loops.

use crate::lanes::Lanes;
use crate::layer::{LANES, Layer, Rectifier};
use crate::pixels::{Borders, Pixel, pixels};
use crate::unpacked::Unpacked;
use half::f16;

/// A layer's weights in blocks of outputs, and where its pixels lie.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    /// `[block][bias, then y, x, input][output of the block]`; outputs past the last are 0.
    weights: Vec<Lanes>,
    /// Values of a window.
    inputs: usize,
    /// Values of a window that lie together: the kernel's width times the input's planes.
    pub(crate) row_length: usize,
    /// Values from a row of the input's buffer to the next.
    pub(crate) row_step: usize,
    /// Outputs of a pixel, without those that fill the last block.
    pub(crate) outputs: usize,
    /// The output's pixels, row by row.
    pub(crate) pixels: Vec<Pixel>,
    /// What follows the sums.
    pub(crate) rectifier: Rectifier,
}

impl Packed {
    /// Packs a layer.
    pub(crate) fn new(unpacked: &mut Unpacked<'_>) -> Self {
        let mut weights = Vec::with_capacity(unpacked.layer.padded_parameters() / LANES);
        unpacked.for_each_block(|block| weights.extend_from_slice(block));
        Self::of_blocks(weights, unpacked.layer, unpacked.borders)
    }

    /// A layer whose weights lie as they shall, [`Layer::padded_parameters`] of them.
    pub(crate) fn of_blocks(weights: Vec<Lanes>, layer: &Layer, borders: Borders) -> Self {
        Self {
            weights,
            inputs: layer.inputs(),
            row_length: layer.kernel * layer.input_planes,
            row_step: borders.input_row(layer),
            outputs: layer.output_planes,
            pixels: pixels(layer, borders),
            rectifier: layer.rectifier,
        }
    }

    /// The parameters that it was made of: the matrix, then the bias.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = f16> {
        let rows = (1..=self.inputs).chain([0]);
        rows.flat_map(move |row| (0..self.outputs).map(move |output| self.parameter(row, output)))
    }

    /// A parameter of one output: its bias, then its row of the matrix.
    fn parameter(&self, row: usize, output: usize) -> f16 {
        let block = output / LANES * (1 + self.inputs);
        f16::from_f32(self.weights[block + row].0[output % LANES])
    }

    /// All blocks, as they lie.
    pub(crate) fn weights(&self) -> &[Lanes] {
        &self.weights
    }

    /// The blocks of outputs: the biases, then the rows of the matrix.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> impl Iterator<Item = &[Lanes]> {
        self.weights.chunks_exact(1 + self.inputs)
    }
}
