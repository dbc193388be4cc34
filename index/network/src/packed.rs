//! A layer laid out for the inner loops.

use crate::layer::{LANES, Layer, Rectifier, Stored};
use crate::unpacked::Unpacked;
use half::f16;
use half::slice::HalfFloatSliceExt;

/// The weights of one input for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    /// Of no weights.
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// Takes as many weights as there are; the others stay as they are.
    pub(crate) fn widen(&mut self, stored: &[Stored]) {
        let mut narrow = [f16::ZERO; LANES];
        let (narrow, lanes) = (&mut narrow[..stored.len()], &mut self.0[..stored.len()]);
        narrow.iter_mut().zip(stored).for_each(|(narrow, stored)| *narrow = f16::from_le_bytes(*stored));
        narrow.convert_to_f32_slice(lanes);
    }
}

/// Where an output pixel reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    /// The first value of its window in the input's buffer.
    pub(crate) input: usize,
    /// Its first value in the output's buffer, which has the padding of the next layer.
    pub(crate) output: usize,
}

/// Pixels of zeros on each side of the buffers that a layer reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Borders {
    /// At least the layer's own padding.
    pub(crate) input: usize,
    pub(crate) output: usize,
}

impl Borders {
    /// Pixels of zeros around the output of layer `at`: what the next layer needs.
    pub(crate) fn of_output(layers: &[Layer], at: usize) -> usize {
        layers.get(at + 1).map_or(0, |next| next.padding)
    }

    /// Values from a row of the input's buffer to the next.
    pub(crate) fn input_row(self, layer: &Layer) -> usize {
        (layer.input_side + 2 * self.input) * layer.input_planes
    }
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
    pub(crate) fn new(unpacked: &Unpacked<'_>) -> Self {
        let Unpacked { layer, borders, .. } = *unpacked;
        let mut weights = Vec::with_capacity(layer.padded_parameters() / LANES);
        unpacked.for_each_block(|block| weights.extend_from_slice(block));
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

    /// The blocks of outputs: the biases, then the rows of the matrix.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> impl Iterator<Item = &[Lanes]> {
        self.weights.chunks_exact(1 + self.inputs)
    }
}

/// Where a layer's output pixels read and write, row by row.
pub(crate) fn pixels(layer: &Layer, borders: Borders) -> Vec<Pixel> {
    let (side, border) = (layer.output_side, borders.output);
    // A layer that needs less padding than the buffer has begins inside of it.
    let inset = borders.input - layer.padding;
    let place = |y: usize, x: usize| Pixel {
        input: (y * layer.stride + inset) * borders.input_row(layer)
            + (x * layer.stride + inset) * layer.input_planes,
        output: ((y + border) * (side + 2 * border) + x + border) * layer.output_planes,
    };
    (0..side * side).map(|pixel| place(pixel / side, pixel % side)).collect()
}
