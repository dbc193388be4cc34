//! A network that is ready to run.

use crate::architecture::Architecture;
use crate::arithmetic::Arithmetic;
use crate::file::Contents;
use crate::layer::{Layer, Stored};
use crate::output::Output;
use crate::packed::Packed;
use crate::path::Path;
use crate::quantised::QuantisedNetwork;
use crate::scratch::Scratch;
use crate::unpacked::pack_layers;
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
    weights: Weights,
    path: Path,
    fingerprint: u64,
}

/// The weights, ready for what they are computed in.
#[derive(Clone)]
enum Weights {
    /// Those of each layer, from which the weights of the file can be made again.
    Floats(Vec<Packed>),
    Integers {
        stored: Vec<Stored>,
        network: Box<QuantisedNetwork>,
    },
}

impl Network {
    /// The largest magnitude of an input. For inputs to here, [`Self::from_weights`] has made sure
    /// that no sum overflows: outputs are finite.
    pub const MAX_INPUT: f32 = weights::MAX_INPUT;

    /// A network of `weights` in the order that [`Architecture`] describes, which are rounded to
    /// `f16`, as a file holds them; it is computed in floats.
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
        let arithmetic = Arithmetic::Floats;
        let fingerprint = xxh3_64(&file::encode(&architecture, arithmetic, &rounded));
        let contents = Contents { architecture, layers, arithmetic, weights: &rounded };
        Self::new(contents, fingerprint, Path::best())
    }

    /// The same weights, computed in integers: another network, with outputs and a file of its own.
    #[must_use]
    pub fn in_integers(self) -> Self {
        let stored: Vec<Stored> = self.stored().map(f16::to_le_bytes).collect();
        let Self { architecture, layers, path, .. } = self;
        let arithmetic = Arithmetic::Integers;
        let fingerprint = xxh3_64(&file::encode(&architecture, arithmetic, &stored));
        let contents = Contents { architecture, layers, arithmetic, weights: &stored };
        Self::new(contents, fingerprint, path).expect("the weights have been checked")
    }

    /// Reads what [`Self::to_bytes`] has written. Everything is checked: bytes from anywhere return
    /// a network or an error, in bounded time and memory.
    ///
    /// # Errors
    /// Bytes that are no network's, of another version, cut short, or damaged, and networks that
    /// [`Self::from_weights`] rejects.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadError> {
        Ok(Self::new(file::decode(bytes)?, xxh3_64(bytes), Path::best())?)
    }

    fn new(contents: Contents<'_>, fingerprint: u64, path: Path) -> Result<Self, WeightsError> {
        let Contents { architecture, layers, arithmetic, weights: stored } = contents;
        let weights = match arithmetic {
            Arithmetic::Floats => Weights::Floats(pack_layers(&architecture, &layers, stored, Packed::new)?),
            Arithmetic::Integers => {
                let network = QuantisedNetwork::new(architecture.clone(), layers.clone(), stored, path)?;
                Weights::Integers { stored: stored.to_vec(), network: Box::new(network) }
            }
        };
        Ok(Self { architecture, layers, weights, path, fingerprint })
    }

    /// The bytes of a file: see [`Self::from_bytes`]. They are put together anew: whoever only runs a
    /// network in floats has its weights in memory once.
    pub fn to_bytes(&self) -> Vec<u8> {
        let stored: Vec<Stored> = self.stored().map(f16::to_le_bytes).collect();
        file::encode(&self.architecture, self.arithmetic(), &stored)
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
        let (packed, stored): (&[_], &[_]) = match &self.weights {
            Weights::Floats(packed) => (packed, &[]),
            Weights::Integers { stored, .. } => (&[], stored),
        };
        let stored = stored.iter().map(|weight| f16::from_le_bytes(*weight));
        packed.iter().flat_map(Packed::parameters).chain(stored)
    }

    /// What it is computed in.
    pub fn arithmetic(&self) -> Arithmetic {
        match self.weights {
            Weights::Floats(_) => Arithmetic::Floats,
            Weights::Integers { .. } => Arithmetic::Integers,
        }
    }

    /// The network's shape.
    pub fn architecture(&self) -> &Architecture {
        &self.architecture
    }

    /// The same network, computed by other instructions than the fastest.
    #[must_use]
    pub fn with_path(mut self, path: Path) -> Self {
        self.path = path;
        // Integers are laid out for the instructions that sum their products.
        if self.arithmetic() == Arithmetic::Integers { self.in_integers() } else { self }
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
        let packed = match &self.weights {
            Weights::Floats(packed) => packed,
            Weights::Integers { network, .. } => return network.run(scratch, input),
        };
        scratch.fit(&self.layers, &[], false);
        let buffers = &mut scratch.buffers;
        buffers.set_input(input);
        for (at, layer) in packed.iter().enumerate() {
            let source = self.architecture.source(at).map_or(0, |source| source + 1);
            let (before, from_here) = buffers.values.split_at_mut(at + 1);
            if let (Some(input), Some(output)) = (before.get(source), from_here.first_mut()) {
                self.path.compute(layer, input, output);
            }
        }
        buffers.output(&self.architecture)
    }
}

/// Computed by the network's own [`Path`].
impl From<&Network> for QuantisedNetwork {
    fn from(network: &Network) -> Self {
        Self::read(&network.to_bytes(), network.path()).expect("a network has been checked")
    }
}

/// Without its weights, which nobody can read.
impl fmt::Debug for Network {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Network")
            .field("architecture", &self.architecture)
            .field("arithmetic", &self.arithmetic())
            .field("fingerprint", &format_args!("{:016x}", self.fingerprint))
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

/// Networks with the same bytes.
impl PartialEq for Network {
    fn eq(&self, other: &Self) -> bool {
        let weights = self.stored().map(f16::to_bits);
        (&self.architecture, self.arithmetic()) == (&other.architecture, other.arithmetic())
            && weights.eq(other.stored().map(f16::to_bits))
    }
}
