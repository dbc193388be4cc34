//! What determines a descriptor.

use crate::hand_image::HandImage;
use rkyv::{Archive, Deserialize, Serialize};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// Counts changes of the code that change descriptors; part of [`DescriptorParams::fingerprint`].
const REVISION: u8 = 1;

/// How gradients are counted.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptorKind {
    /// The paper's form: every pixel with a gradient counts 1, in one bin of one cell; each cell's histogram sums to 1.
    Paper,
    /// A pixel counts by the magnitude of its gradient, shared linearly between the two nearest bins and the four
    /// nearest cells; each level sums to 1; then the square root of every value, so that the Euclidean distance
    /// becomes the Hellinger distance.
    Default,
    /// Vectors of `dim` values that came from elsewhere: how to describe a picture likewise is not known.
    Raw {
        /// Values of a vector, 1 to 65,536.
        dim: u32,
    },
}

/// Where in the hand image the descriptor's picture is sampled.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// The hand image's own pixels; cells divide its box, whatever its aspect.
    Native,
    /// The box stretched to a square of `side` pixels.
    Stretch {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
    /// The box scaled into a square of `side` pixels, aspect kept, centred.
    KeepAspect {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
    /// A square of `side` pixels centred on the mask's centroid and scaled by the mask's spread: a speck that
    /// stretches the box hardly moves it. What reaches far out is cut.
    Moments {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
    /// As [`Sampling::KeepAspect`], of the hand turned [upright](HandImage::upright_turn_deg): however a camera was rolled,
    /// the descriptor is about the same.
    Upright {
        /// Pixels a side, 8 to 1024.
        side: u16,
    },
}

/// What happens to the grey values inside the hand before gradients are taken.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub enum Tone {
    /// Grey as it is: a bright hand has a strong silhouette.
    AsIs,
    /// Mean and contrast are made the same for every hand, dark or light, dimly or brightly lit.
    Normalised {
        /// The standard deviation of the grey inside the hand, relative to its mean: 0 leaves the silhouette alone, 0 to 1.
        contrast: f32,
    },
}

/// Everything that determines a descriptor. Recorded in the index.
#[derive(Archive, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
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
    /// The names of descriptors of pictures.
    pub const NAMES: [&str; 3] = ["default", "upright", "paper"];

    /// The paper's descriptor: B = 4, L = 3, D = 84.
    pub fn paper() -> Self {
        Self { kind: DescriptorKind::Paper, bins: 4, levels: 3, sampling: Sampling::Native, tone: Tone::AsIs }
    }

    /// The default's values, of hands turned upright: for views with any roll, of which one then stands for all others that differ
    /// in nothing else. Where all cameras are level, turning throws away what that tells.
    pub fn upright() -> Self {
        Self { sampling: Sampling::Upright { side: 48 }, ..Self::default() }
    }

    /// Vectors of `dim` values that came from elsewhere.
    pub fn raw(dim: u32) -> Self {
        Self { kind: DescriptorKind::Raw { dim }, ..Self::paper() }
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

    /// One of [`Self::NAMES`], or `raw`.
    pub fn name(&self) -> &'static str {
        match self.kind {
            DescriptorKind::Paper => "paper",
            DescriptorKind::Default if matches!(self.sampling, Sampling::Upright { .. }) => "upright",
            DescriptorKind::Default => "default",
            DescriptorKind::Raw { .. } => "raw",
        }
    }

    /// The descriptor's length, the paper's D: `B` times the sum of `4^(L-l)` over the levels `l`, 84 for B = 4, L = 3.
    pub fn dim(&self) -> usize {
        let params = self.clamped();
        if let DescriptorKind::Raw { dim } = params.kind {
            return dim as usize;
        }
        let cells: usize = (0..params.levels).map(|level| 1 << (2 * level)).sum();
        params.bins as usize * cells
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`ParamsError`], naming the value out of range and what would do.
    pub fn validate(&self) -> Result<(), ParamsError> {
        let clamped = self.clamped();
        if let DescriptorKind::Raw { dim } = self.kind
            && self.kind != clamped.kind
        {
            return Err(ParamsError::Dim(dim));
        }
        if self.bins != clamped.bins {
            return Err(ParamsError::Bins(self.bins));
        }
        if self.levels != clamped.levels {
            return Err(ParamsError::Levels(self.levels));
        }
        match self.sampling {
            Sampling::Stretch { side }
            | Sampling::KeepAspect { side }
            | Sampling::Moments { side }
            | Sampling::Upright { side }
                if self.sampling != clamped.sampling =>
            {
                Err(ParamsError::Side(side))
            }
            _ => match self.tone {
                Tone::Normalised { contrast } if self.tone != clamped.tone => {
                    Err(ParamsError::Contrast(contrast))
                }
                _ => Ok(()),
            },
        }
    }

    /// The parameters with every value brought into its range.
    pub(super) fn clamped(&self) -> Self {
        let fit = |side: u16| side.clamp(8, 1024);
        Self {
            kind: match self.kind {
                DescriptorKind::Raw { dim } => DescriptorKind::Raw { dim: dim.clamp(1, 1 << 16) },
                kind => kind,
            },
            bins: self.bins.clamp(2, 32),
            levels: self.levels.clamp(1, 6),
            sampling: match self.sampling {
                Sampling::Native => Sampling::Native,
                Sampling::Stretch { side } => Sampling::Stretch { side: fit(side) },
                Sampling::KeepAspect { side } => Sampling::KeepAspect { side: fit(side) },
                Sampling::Moments { side } => Sampling::Moments { side: fit(side) },
                Sampling::Upright { side } => Sampling::Upright { side: fit(side) },
            },
            tone: match self.tone {
                Tone::AsIs => Tone::AsIs,
                // A NaN becomes 0 too.
                Tone::Normalised { contrast } => {
                    Tone::Normalised { contrast: if contrast > 0.0 { contrast.min(1.0) } else { 0.0 } }
                }
            },
        }
    }

    /// A number that differs wherever descriptors would: equal fingerprints mean that descriptors can be compared and reused.
    pub fn fingerprint(&self) -> u64 {
        let (sampling, side) = match self.sampling {
            Sampling::Native => (0u8, 0),
            Sampling::Stretch { side } => (1, side),
            Sampling::KeepAspect { side } => (2, side),
            Sampling::Moments { side } => (3, side),
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
        };
        let mut bytes = vec![REVISION, kind, sampling, tone];
        bytes.extend(self.bins.to_le_bytes());
        bytes.extend(self.levels.to_le_bytes());
        bytes.extend(side.to_le_bytes());
        bytes.extend(contrast.to_le_bytes());
        bytes.extend(dim.into_iter().flat_map(u32::to_le_bytes));
        xxh3_64(&bytes)
    }

    /// By how many degrees, clockwise on the picture, a hand image is turned before it is described: 0 unless [`Self::sampling`] is
    /// [`Sampling::Upright`]. What an index holds and answers are orientations of turned hands: [`crate::NewEntry::turned`] and
    /// [`crate::turned_orientation`] go from one to the other.
    #[must_use]
    pub fn turn_deg(&self, hand: &HandImage) -> f64 {
        match self.sampling {
            Sampling::Upright { .. } => hand.upright_turn_deg(),
            _ => 0.0,
        }
    }
}
