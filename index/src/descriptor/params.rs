//! What determines a descriptor.

use super::planes::{PLANES_REVISION, PLANES_SOURCE_SIDE};
use crate::hand_image::{DESCRIBED_SIDE, HandImage};
use grasp_network::Network;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// Counts changes of the code that change descriptors; part of [`DescriptorParams::fingerprint`].
const REVISION: u8 = 1;

/// How gradients are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptorKind {
    /// The paper's form: every pixel with a gradient counts 1, in one bin of one cell; each cell's
    /// histogram sums to 1.
    Paper,
    /// A pixel counts by the magnitude of its gradient, shared linearly between the two nearest
    /// bins and the four nearest cells; each level sums to 1; then the square root of every value,
    /// so that the Euclidean distance becomes the Hellinger distance. What `default` and `upright`
    /// have in common: they differ in [`Sampling`].
    Default,
    /// Vectors of `dim` values that came from elsewhere: how to describe a picture likewise is not
    /// known.
    Raw {
        /// Values of a vector, 1 to 65,536.
        dim: u32,
    },
    /// What a network makes of the [planes](super::planes()) of the hand: `dim` values, its
    /// embedding. The pyramid's parameters are ignored.
    Learned {
        /// The network's fingerprint.
        network: u64,
        /// Values of an embedding, 1 to 1024.
        dim: u32,
    },
}

/// Where in the hand image the descriptor's picture is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// The hand image's own pixels; cells divide its box, whatever its aspect.
    Native,
    /// The box scaled into a square of `side` pixels, aspect kept, centred.
    KeepAspect {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
    /// As [`Sampling::KeepAspect`], of the hand turned [upright](HandImage::upright_turn_deg):
    /// however a camera was rolled, the descriptor is about the same.
    Upright {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
}

/// What happens to the grey values inside the hand before gradients are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tone {
    /// Grey as it is: a bright hand has a strong silhouette.
    AsIs,
    /// Mean and contrast are made the same for every hand, dark or light, dimly or brightly lit.
    Normalised {
        /// The standard deviation of the grey inside the hand, relative to its mean: 0 leaves the
        /// silhouette alone, 0 to 1.
        contrast: f32,
    },
}

/// Everything that determines a descriptor. Recorded in the index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescriptorParams {
    /// How gradients are counted.
    pub kind: DescriptorKind,
    /// The paper's B: bins a histogram, 2 to 32.
    pub bins: u32,
    /// The paper's L: levels of the pyramid, 1 to 6.
    pub levels: u32,
    /// Where the picture is sampled.
    pub sampling: Sampling,
    /// How its grey is prepared.
    pub tone: Tone,
}

/// Parameters that make no descriptor.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ParamsError {
    /// Too few or too many bins.
    #[error("{0} bins: 2 to 32 are supported, and the paper uses 4")]
    Bins(u32),
    /// Embeddings too short or too long.
    #[error("embeddings of {0} values: 1 to 1024 are supported")]
    Embedding(u32),
    /// A network that takes other pictures than hands are shown as.
    #[error(
        "a network for pictures of {side} x {side} pixels and {planes} planes: hands are shown to one \
         for 48 x 48 pixels and 2 planes, as `grasp-builder train` makes it"
    )]
    Input {
        /// Pixels a side that it takes.
        side: u32,
        /// Planes that it takes.
        planes: u32,
    },
    /// A learned descriptor without the network that computes it.
    #[error(
        "a learned descriptor needs its network, of fingerprint {0:016x}: take it from an index that \
         carries it, or from its file"
    )]
    Network(u64),
    /// Vectors too short or too long.
    #[error("vectors of {0} values: 1 to 65,536 are supported")]
    Dim(u32),
    /// Too few or too many levels.
    #[error("{0} levels: 1 to 6 are supported, and the paper uses 3")]
    Levels(u32),
    /// A picture too small or too large.
    #[error("a descriptor picture of {0} pixels a side: 8 to 1024 are supported")]
    Side(u16),
    /// A contrast that is no contrast.
    #[error("a contrast of {0}: 0 to 1 is supported")]
    Contrast(f32),
}

impl Default for DescriptorParams {
    fn default() -> Self {
        Self {
            kind: DescriptorKind::Default,
            bins: 4,
            levels: 4,
            sampling: Sampling::KeepAspect { side: 48 },
            tone: Tone::Normalised { contrast: 0.12 },
        }
    }
}

impl DescriptorParams {
    /// The names of descriptors of pictures, as they stand in files and on command lines. The one
    /// called `default` was the default before there was `upright`, which most presets of the
    /// program that builds indexes take; the name stays, because indexes and scripts hold it.
    pub const NAMES: [&str; 3] = ["default", "upright", "paper"];

    /// The paper's descriptor: B = 4, L = 3, D = 84.
    pub fn paper() -> Self {
        Self { kind: DescriptorKind::Paper, bins: 4, levels: 3, sampling: Sampling::Native, tone: Tone::AsIs }
    }

    /// The default's values, of hands turned upright: for views with any roll, of which one then
    /// stands for all others that differ in nothing else. Where all cameras are level, turning
    /// throws away what that shows.
    pub fn upright() -> Self {
        Self { sampling: Sampling::Upright { side: 48 }, ..Self::default() }
    }

    /// Vectors of `dim` values that came from elsewhere.
    pub fn raw(dim: u32) -> Self {
        Self { kind: DescriptorKind::Raw { dim }, ..Self::paper() }
    }

    /// The embedding of a network.
    pub fn learned(network: &Network) -> Self {
        let dim = network.architecture().embedding;
        Self { kind: DescriptorKind::Learned { network: network.fingerprint(), dim }, ..Self::upright() }
    }

    /// Whether pictures can be described: not as vectors are that came from elsewhere.
    pub fn describes_pictures(&self) -> bool {
        !matches!(self.kind, DescriptorKind::Raw { .. })
    }

    /// The parameters that a name stands for: one of [`Self::NAMES`].
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "paper" => Some(Self::paper()),
            "default" => Some(Self::default()),
            "upright" => Some(Self::upright()),
            _ => None,
        }
    }

    /// Whether the values are a network's.
    pub fn is_learned(&self) -> bool {
        matches!(self.kind, DescriptorKind::Learned { .. })
    }

    /// One of [`Self::NAMES`], or `raw`.
    pub fn name(&self) -> &'static str {
        match self.kind {
            DescriptorKind::Paper => "paper",
            DescriptorKind::Default if matches!(self.sampling, Sampling::Upright { .. }) => "upright",
            DescriptorKind::Default => "default",
            DescriptorKind::Raw { .. } => "raw",
            DescriptorKind::Learned { .. } => "learned",
        }
    }

    /// The descriptor's length, the paper's D: `B` times the sum of `4^(L-l)` over the levels `l`,
    /// 84 for B = 4, L = 3.
    pub fn dim(&self) -> usize {
        if let DescriptorKind::Raw { dim } | DescriptorKind::Learned { dim, .. } = self.kind {
            return dim as usize;
        }
        // Parameters may be out of range: such a length is no descriptor's, but it is no overflow
        // either.
        let cells = |level: u32| 4usize.saturating_pow(level);
        let all = (0..self.levels.min(usize::BITS)).map(cells).fold(0, usize::saturating_add);
        all.saturating_mul(self.bins as usize)
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`ParamsError`], naming the value out of range and what would do.
    pub fn validate(&self) -> Result<(), ParamsError> {
        match self.kind {
            DescriptorKind::Raw { dim } if !(1..=1 << 16).contains(&dim) => {
                return Err(ParamsError::Dim(dim));
            }
            DescriptorKind::Learned { dim, .. } if !(1..=1024).contains(&dim) => {
                return Err(ParamsError::Embedding(dim));
            }
            _ => {}
        }
        if !(2..=32).contains(&self.bins) {
            return Err(ParamsError::Bins(self.bins));
        }
        if !(1..=6).contains(&self.levels) {
            return Err(ParamsError::Levels(self.levels));
        }
        match self.sampling {
            Sampling::KeepAspect { side } | Sampling::Upright { side } if !(8..=1024).contains(&side) => {
                return Err(ParamsError::Side(side));
            }
            _ => {}
        }
        match self.tone {
            Tone::Normalised { contrast } if !(0.0..=1.0).contains(&contrast) => {
                Err(ParamsError::Contrast(contrast))
            }
            _ => Ok(()),
        }
    }

    /// A number that differs wherever descriptors would: equal fingerprints mean that descriptors
    /// can be compared and reused.
    pub fn fingerprint(&self) -> u64 {
        let (sampling, side) = match self.sampling {
            Sampling::Native => (0u8, 0),
            // 1 and 3 were ways that are gone.
            Sampling::KeepAspect { side } => (2, side),
            Sampling::Upright { side } => (4, side),
        };
        let (tone, contrast) = match self.tone {
            Tone::AsIs => (0u8, 0.0),
            Tone::Normalised { contrast } => (1, contrast),
        };
        let (kind, dim) = match self.kind {
            DescriptorKind::Paper => (0u8, None),
            DescriptorKind::Default => (1, None),
            DescriptorKind::Raw { dim } => (2, Some(dim)),
            DescriptorKind::Learned { dim, .. } => (3, Some(dim)),
        };
        let mut bytes = vec![REVISION, kind, sampling, tone];
        bytes.extend(self.bins.to_le_bytes());
        bytes.extend(self.levels.to_le_bytes());
        bytes.extend(side.to_le_bytes());
        bytes.extend(contrast.to_le_bytes());
        bytes.extend(dim.into_iter().flat_map(u32::to_le_bytes));
        if let DescriptorKind::Learned { network, .. } = self.kind {
            bytes.push(PLANES_REVISION);
            bytes.extend(network.to_le_bytes());
        }
        xxh3_64(&bytes)
    }

    /// The longest side, in pixels, at which a hand image is described: larger ones are
    /// [shrunk](HandImage::shrunk_to), so that all are described at one scale.
    #[must_use]
    pub fn described_side(&self) -> usize {
        match self.kind {
            DescriptorKind::Learned { .. } => PLANES_SOURCE_SIDE,
            _ => DESCRIBED_SIDE,
        }
    }

    /// By how many degrees, clockwise on the picture, a hand image is turned before it is
    /// described: 0 unless [`Self::sampling`] is [`Sampling::Upright`]. What an index holds and
    /// answers are orientations of turned hands: [`crate::NewEntry::turned`] and
    /// [`crate::turned_orientation`] go from one to the other.
    #[must_use]
    pub fn turn_deg(&self, hand: &HandImage) -> f64 {
        match self.sampling {
            Sampling::Upright { .. } => hand.upright_turn_deg(),
            _ => 0.0,
        }
    }
}
