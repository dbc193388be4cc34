//! A layer laid out for the inner loops.

use crate::layer::{LANES, Layer, Rectifier};

/// The weights of one input for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

/// Where an output pixel reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    /// The first value of its window in the padded input.
    pub(crate) input: usize,
    /// Its first value in the output, which is the padded input of the next layer.
    pub(crate) output: usize,
}

/// A layer's weights in blocks of outputs, and where its pixels lie.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    /// `[block][bias, then y, x, input][output of the block]`; outputs past the last are 0.
    weights: Vec<Lanes>,
    /// Values of a window.
    inputs: usize,
    /// Values of a window that lie together: the kernel's width times the input's planes.
    pub(crate) row_length: usize,
    /// Values from a row of the padded input to the next.
    pub(crate) row_step: usize,
    /// Outputs of a pixel, without those that fill the last block.
    pub(crate) outputs: usize,
    /// The output's pixels, row by row.
    pub(crate) pixels: Vec<Pixel>,
    /// What follows the sums.
    pub(crate) rectifier: Rectifier,
}

impl Packed {
    /// Packs a layer. `parameters` are its matrix and bias, [`Layer::parameters`] values;
    /// `output_padding` is the padding of the layer that reads its output.
    pub(crate) fn new(layer: &Layer, parameters: &[f32], output_padding: usize) -> Self {
        let outputs = layer.output_planes;
        let (matrix, bias) = parameters.split_at(layer.inputs() * outputs);
        let mut weights = Vec::with_capacity(layer.padded_parameters() / LANES);
        for first in (0..outputs).step_by(LANES) {
            for row in std::iter::once(bias).chain(matrix.chunks_exact(outputs)) {
                let block = &row[first..outputs.min(first + LANES)];
                let mut lanes = [0.0; LANES];
                lanes[..block.len()].copy_from_slice(block);
                weights.push(Lanes(lanes));
            }
        }
        Self {
            weights,
            inputs: layer.inputs(),
            row_length: layer.kernel * layer.input_planes,
            row_step: layer.padded_side() * layer.input_planes,
            outputs,
            pixels: pixels(layer, output_padding),
            rectifier: layer.rectifier,
        }
    }

    /// The blocks of outputs: the biases, then the rows of the matrix.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> impl Iterator<Item = &[Lanes]> {
        self.weights.chunks_exact(1 + self.inputs)
    }
}

fn pixels(layer: &Layer, output_padding: usize) -> Vec<Pixel> {
    let side = layer.output_side;
    let place = |y: usize, x: usize| Pixel {
        input: (y * layer.padded_side() + x) * layer.stride * layer.input_planes,
        output: ((y + output_padding) * (side + 2 * output_padding) + x + output_padding)
            * layer.output_planes,
    };
    (0..side * side).map(|pixel| place(pixel / side, pixel % side)).collect()
}
