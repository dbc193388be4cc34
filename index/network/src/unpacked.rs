//! A network's layers with the weights of its file, one after the other.
//!
//! A layer is packed from here, a block of outputs at a time and all in the same memory: weights
//! which are kept as integers never lie in memory as floats but for one block. A process that
//! answers one question would spend much of its time on getting more.

use crate::architecture::Architecture;
use crate::lanes::Lanes;
use crate::layer::{LANES, Layer, Stored};
use crate::pixels::Borders;
use crate::weights::{self, Sums, WeightsError};

/// A layer that is yet to be packed.
#[derive(Debug)]
pub(crate) struct Unpacked<'a> {
    pub(crate) layer: &'a Layer,
    /// The borders of the buffers that its input and output lie in.
    pub(crate) borders: Borders,
    /// The layer whose output it reads; `None` reads the picture.
    pub(crate) source: Option<usize>,
    matrix: &'a [Stored],
    bias: &'a [Stored],
    /// Where its blocks are shown.
    block: &'a mut Vec<Lanes>,
    /// The largest magnitude of its inputs, and with them the sums of the blocks that were shown.
    input: f64,
    largest: f64,
}

/// Packs the layers of a network, with the weights in the order that [`Architecture`] describes.
/// `pack` is shown each layer once, and asks it for all of its blocks.
///
/// # Errors
/// Another number of weights than the layers have, weights that are not finite, and those with
/// which some input could make a layer's sums overflow.
pub(crate) fn pack_layers<T>(
    architecture: &Architecture,
    layers: &[Layer],
    weights: &[Stored],
    mut pack: impl FnMut(&mut Unpacked<'_>) -> T,
) -> Result<Vec<T>, WeightsError> {
    weights::check(layers, weights)?;
    let (mut rest, mut sums) = (weights, Sums::default());
    let most_inputs = layers.iter().map(Layer::inputs).max().unwrap_or(0);
    let mut block = Vec::with_capacity(1 + most_inputs);
    let mut packed = Vec::with_capacity(layers.len());
    for (at, layer) in layers.iter().enumerate() {
        let (parameters, after) = rest.split_at(layer.parameters());
        rest = after;
        let (matrix, bias) = parameters.split_at(layer.inputs() * layer.output_planes);
        let source = architecture.source(at);
        let borders = Borders::of_layer(layers, at, source);
        let input = sums.of_input(source);
        let mut unpacked =
            Unpacked { layer, borders, source, matrix, bias, block: &mut block, input, largest: 0.0 };
        packed.push(pack(&mut unpacked));
        sums.add(unpacked.largest)?;
    }
    Ok(packed)
}

impl Unpacked<'_> {
    /// Shows its blocks of outputs one after the other: the biases, then the rows of the matrix,
    /// `[y][x][input]`. Outputs past the last are 0.
    pub(crate) fn for_each_block(&mut self, mut pack: impl FnMut(&[Lanes])) {
        let outputs = self.layer.output_planes;
        self.block.clear();
        self.block.resize(1 + self.layer.inputs(), Lanes::ZERO);
        for first in (0..outputs).step_by(LANES) {
            let lanes = first..outputs.min(first + LANES);
            if lanes.len() < LANES {
                self.block.fill(Lanes::ZERO);
            }
            let rows = std::iter::once(self.bias).chain(self.matrix.chunks_exact(outputs));
            self.block.iter_mut().zip(rows).for_each(|(to, row)| to.widen(&row[lanes.clone()]));
            self.largest = self.largest.max(largest_sum(self.block, self.input));
            pack(self.block);
        }
    }
}

/// The largest magnitude of a block's sums, with inputs to `input`.
fn largest_sum(block: &[Lanes], input: f64) -> f64 {
    let (bias, matrix) = block.split_first().expect("a block begins with its biases");
    // Sums of millions of weights to 65504 are far from the largest `f32`.
    let mut sums = [0.0f32; LANES];
    for row in matrix {
        sums.iter_mut().zip(row.0).for_each(|(sum, weight)| *sum += weight.abs());
    }
    let sums = sums.into_iter().zip(bias.0);
    let reached = sums.map(|(sum, bias)| input * f64::from(sum) + f64::from(bias.abs()));
    reached.fold(0.0, f64::max)
}
