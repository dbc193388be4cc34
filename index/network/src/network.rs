//! A network that is ready to run, and the memory that it runs in.

use crate::architecture::Architecture;
use crate::layer::{Layer, Stored};
use crate::masks::Masks;
use crate::packed::{Borders, Packed};
use crate::path::Path;
use crate::unpacked::Unpacked;
use crate::weights::{self, WeightsError};
use crate::{ReadError, file};
use half::f16;
use std::fmt;
use xxhash_rust::xxh3::xxh3_64;

/// A network with its weights.
///
/// One input has one output, to the last bit: on every processor, whichever [`Path`] computes it,
/// and whether the network was made from an array or read from its file.
#[derive(Clone)]
pub struct Network {
    architecture: Architecture,
    layers: Vec<Layer>,
    /// The same layers with their weights.
    packed: Vec<Packed>,
    path: Path,
    fingerprint: u64,
}

/// The memory that a network runs in: one for each thread, used again for each picture.
///
/// It fits itself to the network that it is used with.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// What the buffers fit.
    layers: Vec<Layer>,
    /// The picture, then the output of each layer, with the padding that the next layer needs: it
    /// stays 0.
    pub(crate) buffers: Vec<Vec<f32>>,
    /// The masks in [`Output`]'s order.
    masks: Vec<f32>,
}

/// What a network returns for one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<'a> {
    /// [`Architecture::embedding`] values.
    pub embedding: &'a [f32],
    /// [`Architecture::heads`] values.
    pub heads: &'a [f32],
    /// Logits `[mask][y][x]` of a side of [`Architecture::mask_side`]; empty without masks.
    pub masks: &'a [f32],
}

impl Network {
    /// The largest input, up or down. For inputs to here, [`Self::from_weights`] has made sure that
    /// no sum overflows: outputs are finite.
    pub const MAX_INPUT: f32 = weights::MAX_INPUT;

    /// A network of `weights` in the order that [`Architecture`] describes, which are rounded to
    /// `f16`, as a file holds them.
    ///
    /// # Errors
    /// An architecture that is not supported, another number of weights than
    /// [`Architecture::parameters`], and weights that are not finite as `f16` or so large that
    /// outputs might not be finite.
    pub fn from_weights(architecture: Architecture, weights: Vec<f32>) -> Result<Self, WeightsError> {
        let layers = architecture.layers()?;
        let rounded: Vec<Stored> =
            weights.iter().map(|weight| f16::from_f32(*weight).to_le_bytes()).collect();
        drop(weights);
        let fingerprint = xxh3_64(&file::encode(&architecture, &rounded));
        Self::new(architecture, layers, &rounded, fingerprint)
    }

    /// Reads what [`Self::to_bytes`] has written. Everything is checked: bytes from anywhere return
    /// a network or an error, in bounded time and memory.
    ///
    /// # Errors
    /// Bytes that are no network's, of another version, cut short, or damaged, and networks that
    /// [`Self::from_weights`] rejects.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadError> {
        let (architecture, layers, weights) = file::decode(bytes)?;
        Ok(Self::new(architecture, layers, weights, xxh3_64(bytes))?)
    }

    fn new(
        architecture: Architecture,
        layers: Vec<Layer>,
        weights: &[Stored],
        fingerprint: u64,
    ) -> Result<Self, WeightsError> {
        let packed = Unpacked::layers(&architecture, &layers, weights)?;
        let packed = packed.map(|layer| Ok(Packed::new(&layer?))).collect::<Result<_, WeightsError>>()?;
        Ok(Self { architecture, layers, packed, path: Path::best(), fingerprint })
    }

    /// The bytes of a file: see [`Self::from_bytes`]. They are put together anew: who only runs a
    /// network has its weights in memory once.
    pub fn to_bytes(&self) -> Vec<u8> {
        let stored: Vec<Stored> = self.stored().map(f16::to_le_bytes).collect();
        file::encode(&self.architecture, &stored)
    }

    /// XXH3 of [`Self::to_bytes`]: networks of the same fingerprint have the same outputs.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The weights in the order that [`Architecture`] describes, as [`Self::from_weights`] has
    /// rounded them.
    pub fn weights(&self) -> Vec<f32> {
        self.stored().map(f16::to_f32).collect()
    }

    /// The weights as a file has them.
    fn stored(&self) -> impl Iterator<Item = f16> {
        self.packed.iter().flat_map(Packed::parameters)
    }

    /// The network's shape.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// The same network, computed by other instructions than the fastest.
    #[must_use]
    pub fn with_path(mut self, path: Path) -> Self {
        self.path = path;
        self
    }

    /// The instructions that compute it.
    pub fn path(&self) -> Path {
        self.path
    }

    /// Computes one picture: `side * side * planes` values, row by row, the planes of a pixel
    /// together, each from `-`[`Self::MAX_INPUT`] to [`Self::MAX_INPUT`].
    ///
    /// # Panics
    /// Where `input` has another length.
    pub fn run<'a>(&self, scratch: &'a mut Scratch, input: &[f32]) -> Output<'a> {
        scratch.fit(&self.layers);
        scratch.set_input(input);
        for (at, layer) in self.packed.iter().enumerate() {
            let source = self.architecture.source(at).map_or(0, |source| source + 1);
            let (before, from_here) = scratch.buffers.split_at_mut(at + 1);
            if let (Some(input), Some(output)) = (before.get(source), from_here.first_mut()) {
                self.path.compute(layer, input, output);
            }
        }
        scratch.output(&self.architecture)
    }
}

/// Without its weights, which nobody can read.
impl fmt::Debug for Network {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Network")
            .field("architecture", &self.architecture)
            .field("fingerprint", &format_args!("{:016x}", self.fingerprint))
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Scratch {
    /// Makes the buffers of these layers, unless they are there. Returns whether it did.
    pub(crate) fn fit(&mut self, layers: &[Layer]) -> bool {
        // Buffers of the same sizes do not suffice: the zeros of the padding lie elsewhere.
        if self.layers == layers {
            return false;
        }
        let picture = layers.first().map(Layer::padded_values);
        let outputs = layers.iter().enumerate().map(|(at, layer)| {
            let side = layer.output_side + 2 * Borders::of_output(layers, at);
            side * side * layer.output_planes
        });
        self.buffers = picture.into_iter().chain(outputs).map(|values| vec![0.0; values]).collect();
        self.layers = layers.to_vec();
        true
    }

    /// Copies a picture into the first layer's padded input.
    pub(crate) fn set_input(&mut self, input: &[f32]) {
        let (Some(layer), Some(buffer)) = (self.layers.first(), self.buffers.first_mut()) else { return };
        assert_eq!(input.len(), layer.input_values(), "the values of a picture");
        let padding = layer.padding * layer.input_planes;
        let row = layer.input_side * layer.input_planes;
        let rows = buffer.chunks_exact_mut(row + 2 * padding).skip(layer.padding);
        for (padded, values) in rows.zip(input.chunks_exact(row)) {
            padded[padding..][..row].copy_from_slice(values);
        }
    }

    /// What the last layers have left in the buffers.
    pub(crate) fn output(&mut self, architecture: &Architecture) -> Output<'_> {
        self.spread(architecture.masks);
        let dense = self.buffers.get(architecture.convolutions.len() + 1..);
        match dense {
            Some([embedding, heads, ..]) => Output { embedding, heads, masks: &self.masks },
            _ => Output { embedding: &[], heads: &[], masks: &[] },
        }
    }

    /// Brings the outputs of the last layer, the masks', into the masks' order.
    fn spread(&mut self, masks: Option<Masks>) {
        let last = self.layers.last().zip(self.buffers.last());
        let Some((masks, (layer, values))) = masks.zip(last) else {
            self.masks.clear();
            return;
        };
        self.masks.resize(values.len(), 0.0);
        let cells = masks.cells as usize;
        for (from, to) in masks.runs(layer.output_side) {
            self.masks[to..][..cells].copy_from_slice(&values[from..][..cells]);
        }
    }
}

/// Networks with the same bytes.
impl PartialEq for Network {
    fn eq(&self, other: &Self) -> bool {
        let weights = self.stored().map(f16::to_bits);
        self.architecture == other.architecture && weights.eq(other.stored().map(f16::to_bits))
    }
}
