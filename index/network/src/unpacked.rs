//! A network's layers with the weights of its file, one after the other.
//!
//! A layer is packed from here, a block of outputs at a time, so that weights which are kept as
//! integers never lie in memory as floats but for one block: a process that answers one question
//! would spend much of its time on getting that memory.

use crate::architecture::Architecture;
use crate::lanes::Lanes;
use crate::layer::{LANES, Layer, Stored};
use crate::pixels::Borders;
use crate::weights::{self, Sums, WeightsError};

/// A layer that is yet to be packed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unpacked<'a> {
    pub(crate) layer: &'a Layer,
    /// The borders of the buffers that its input and output lie in.
    pub(crate) borders: Borders,
    /// The layer whose output it reads; `None` reads the picture.
    pub(crate) source: Option<usize>,
    matrix: &'a [Stored],
    bias: &'a [Stored],
}

impl<'a> Unpacked<'a> {
    /// The layers of a network, with the weights in the order that [`Architecture`] describes. They
    /// are checked: an error takes the place of a layer where some input could make its sums
    /// overflow.
    ///
    /// # Errors
    /// Another number of weights than the layers have, and weights that are not finite.
    pub(crate) fn layers(
        architecture: &'a Architecture,
        layers: &'a [Layer],
        weights: &'a [Stored],
    ) -> Result<impl Iterator<Item = Result<Self, WeightsError>>, WeightsError> {
        weights::check(layers, weights)?;
        let (mut rest, mut sums) = (weights, Sums::default());
        let layer = move |(at, layer): (usize, &'a Layer)| {
            let (parameters, after) = rest.split_at(layer.parameters());
            rest = after;
            let (matrix, bias) = parameters.split_at(layer.inputs() * layer.output_planes);
            let source = architecture.source(at);
            let borders = Borders {
                input: source.map_or(layer.padding, |source| Borders::of_output(layers, source)),
                output: Borders::of_output(layers, at),
            };
            let unpacked = Self { layer, borders, source, matrix, bias };
            sums.add(source, |input| unpacked.largest_sum(input)).map(|()| unpacked)
        };
        Ok(layers.iter().enumerate().map(layer))
    }

    /// Shows its blocks of outputs one after the other: the biases, then the rows of the matrix,
    /// `[y][x][input]`. Outputs past the last are 0.
    pub(crate) fn for_each_block(&self, mut pack: impl FnMut(&[Lanes])) {
        let outputs = self.layer.output_planes;
        let mut block = vec![Lanes::ZERO; 1 + self.layer.inputs()];
        for first in (0..outputs).step_by(LANES) {
            let lanes = first..outputs.min(first + LANES);
            if lanes.len() < LANES {
                block.fill(Lanes::ZERO);
            }
            let rows = std::iter::once(self.bias).chain(self.matrix.chunks_exact(outputs));
            block.iter_mut().zip(rows).for_each(|(to, row)| to.widen(&row[lanes.clone()]));
            pack(&block);
        }
    }

    /// What the sums can reach, up or down, with inputs to `input`.
    fn largest_sum(&self, input: f64) -> f64 {
        let mut largest = 0.0f64;
        self.for_each_block(|block| {
            let (bias, matrix) = block.split_first().expect("a block begins with its biases");
            // Sums of millions of weights to 65504 are far from the largest `f32`.
            let mut sums = [0.0f32; LANES];
            for row in matrix {
                sums.iter_mut().zip(row.0).for_each(|(sum, weight)| *sum += weight.abs());
            }
            let sums = sums.into_iter().zip(bias.0);
            let reached = sums.map(|(sum, bias)| input * f64::from(sum) + f64::from(bias.abs()));
            largest = reached.fold(largest, f64::max);
        });
        largest
    }
}
