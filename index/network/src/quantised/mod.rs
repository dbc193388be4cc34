//! Networks that compute in integers.

mod dispatch;
mod kernel;
mod packed;
mod prepared;
mod rounding;
mod winograd;

use std::fmt;

use crate::file::Contents;
use crate::layer::{Layer, Rectifier, Stored};
use crate::output::Output;
use crate::packed::Packed;
use crate::path::Path;
use crate::unpacked::{Unpacked, pack_layers};
use crate::weights::WeightsError;
use crate::{Architecture, ReadError, Scratch, file};
use dispatch::Integers;
use packed::PackedIntegers;
use winograd::Winograd;

/// A network whose convolutions are computed in integers of 8 bits: up to four times as fast
/// where a processor has instructions for that, with nearly the same outputs.
///
/// A weight is an integer of -127 to 127 times a factor of its output. Values that are not below 0,
/// as behind a rectifier, are integers of 0 to 255 times a 255th of the layer's largest. Products
/// are summed exactly. The first layer, whose inputs have either sign, and the heads are computed
/// in floats. (B. Jacob et al., "Quantization and Training of Neural Networks for Efficient
/// Integer-Arithmetic-Only Inference", CVPR 2018; here the factors of values follow each picture's,
/// so that no pictures are needed to choose them.)
///
/// One input has one output, to the last bit, on every processor, as a network's.
#[derive(Clone)]
pub struct QuantisedNetwork {
    architecture: Architecture,
    layers: Vec<Layer>,
    steps: Vec<Step>,
    /// For the picture, then for each layer's output: whether it is read as integers.
    is_rounded: Vec<bool>,
    path: Path,
}

/// A layer's weights, for any instructions.
enum Weights {
    Floats(Packed),
    Integers(PackedIntegers),
}

/// How a layer is computed.
#[derive(Clone, Debug)]
enum Step {
    Floats(Packed),
    /// In integers, window by window.
    Windows(PackedIntegers),
    /// In integers, tile by tile.
    Tiles(Winograd),
}

/// For the picture, then for each layer's output: whether it is read as integers.
fn is_rounded(architecture: &Architecture, layers: &[Layer]) -> Vec<bool> {
    let mut is_rounded = vec![false; layers.len() + 1];
    for (at, _) in layers.iter().enumerate().filter(|(_, layer)| layer.rectifier == Rectifier::Zero) {
        let mut readers = (0..layers.len()).filter(|reader| architecture.source(*reader) == Some(at));
        is_rounded[at + 1] = readers.all(|reader| PackedIntegers::is_supported(&layers[reader]));
    }
    is_rounded
}

impl Step {
    /// The fastest by these instructions.
    fn new(layer: &Layer, weights: Weights, path: Path) -> Self {
        match weights {
            Weights::Floats(weights) => Self::Floats(weights),
            Weights::Integers(weights) if !dispatch::sums_bytes(path) && Winograd::is_supported(layer) => {
                Self::Tiles(Winograd::new(&weights, layer))
            }
            Weights::Integers(weights) => Self::Windows(weights),
        }
    }
}

/// Rounds the weights of a layer that is computed in integers.
fn rounded(layer: &mut Unpacked<'_>, is_rounded: &[bool]) -> Weights {
    match reads_integers(layer.source, is_rounded) {
        true => Weights::Integers(PackedIntegers::new(layer)),
        false => Weights::Floats(Packed::new(layer)),
    }
}

/// Whether a layer is computed in integers that reads the output of layer `source`, or the picture.
fn reads_integers(source: Option<usize>, is_rounded: &[bool]) -> bool {
    source.is_some_and(|source| is_rounded[source + 1])
}

impl QuantisedNetwork {
    /// Reads the file of a network, to be computed in integers whatever it says, by the fastest
    /// [`Path`]. The weights themselves are not kept.
    ///
    /// # Errors
    /// Bytes that are no network's, of another version, cut short, or damaged, and weights that are
    /// not finite or so large that outputs might not be.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::read(bytes, Path::best())
    }

    /// The same, computed by these instructions.
    pub(crate) fn read(bytes: &[u8], path: Path) -> Result<Self, ReadError> {
        let Contents { architecture, layers, weights, .. } = file::decode(bytes)?;
        Ok(Self::new(architecture, layers, weights, path)?)
    }

    /// Of weights that are yet to be checked.
    pub(crate) fn new(
        architecture: Architecture,
        layers: Vec<Layer>,
        weights: &[Stored],
        path: Path,
    ) -> Result<Self, WeightsError> {
        let is_rounded = is_rounded(&architecture, &layers);
        let steps = pack_layers(&architecture, &layers, weights, |layer| {
            Step::new(layer.layer, rounded(layer, &is_rounded), path)
        })?;
        Ok(Self { architecture, layers, steps, is_rounded, path })
    }

    /// The network's shape.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// Computes one picture: `side * side * planes` values, row by row, the planes of a pixel
    /// together.
    ///
    /// # Panics
    /// Where `input` has another length.
    pub fn run<'a>(&self, scratch: &'a mut Scratch, input: &[f32]) -> Output<'a> {
        let in_bytes = dispatch::sums_bytes(self.path);
        scratch.fit(&self.layers, &self.is_rounded, in_bytes);
        let Scratch { buffers, bytes, words, units, tiles, .. } = scratch;
        buffers.set_input(input);
        for (at, step) in self.steps.iter().enumerate() {
            let source = self.architecture.source(at).map_or(0, |source| source + 1);
            let (before, from_here) = buffers.values.split_at_mut(at + 1);
            let Some(output) = from_here.first_mut() else { continue };
            match step {
                Step::Floats(layer) => self.path.compute(layer, &before[source], output),
                Step::Windows(layer) => {
                    let input = match in_bytes {
                        true => Integers::Bytes(&bytes[source], units[source]),
                        false => Integers::Words(&words[source], units[source]),
                    };
                    dispatch::run(self.path, layer, input, output);
                }
                Step::Tiles(layer) => {
                    dispatch::run_tiles(self.path, layer, (&words[source], units[source]), output, tiles);
                }
            }
            if self.is_rounded[at + 1] {
                units[at + 1] = match in_bytes {
                    true => dispatch::to_bytes(self.path, output, &mut bytes[at + 1]),
                    false => dispatch::to_words(self.path, output, &mut words[at + 1]),
                };
            }
        }
        buffers.output(&self.architecture)
    }
}

/// Without its weights, which nobody can read.
impl fmt::Debug for QuantisedNetwork {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("QuantisedNetwork")
            .field("architecture", &self.architecture)
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}
