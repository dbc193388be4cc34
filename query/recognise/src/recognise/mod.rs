//! From a picture to an answer: mask, hand image, descriptor, search, vote.

mod accept;
mod belief;
mod evidence;
mod hypothesis;
mod side;
mod source;
mod timings;
mod trust;
mod warning;

use std::time::Instant;

use grasp_index::{
    DESCRIBED_SIDE, Effort, HandImage, HandImageError, Index, SearchError, SearchOptions, VoteOptions,
};

pub use accept::{Accept, Doubt};
pub use evidence::Evidence;
pub use hypothesis::Hypothesis;
pub use side::{HandChoice, Side};
pub use source::{MaskSource, Prepared, SourceError};
pub use timings::Timings;
pub use trust::{Logistic, Term, Trust, logistic, temper};
pub use warning::Warning;

use crate::picture::{self, DecodeError};
use crate::segment::SegmentParams;

/// Rolls tried for each picture unless told otherwise: the picture as it is.
///
/// On development pictures 1, 8 and 12 rolls class equally well, upright hands (45, 46 and 44 % of 646, the hand given)
/// and photographs alike, but more rolls cost orientation (median error 12.6, 14.1 and 16.1 degrees) and time.
pub const DEFAULT_ROLLS: usize = 1;
/// How pictures are recognised.
#[derive(Clone, Debug)]
pub struct RecogniseOptions {
    /// Which hand the pictures show.
    pub hand: HandChoice,
    /// How many turns about the optical axis are tried, evenly over the circle, beside the one that the index's descriptors want
    /// ([`grasp_index::DescriptorParams::turn_deg`]); 1 tries none besides.
    pub rolls: usize,
    /// How many neighbours vote; `None` takes the index's own number.
    pub k: Option<usize>,
    /// How hard to look for neighbours.
    pub effort: Effort,
    /// How neighbours are weighed.
    pub vote: VoteOptions,
    /// When an answer is one.
    pub accept: Accept,
    /// Whether probabilities are tempered by the trust in a mask that was found by colour, and a hand of too little trust is unknown.
    pub temper: bool,
    /// The numbers of the segmentation.
    pub segment: SegmentParams,
}

impl Default for RecogniseOptions {
    fn default() -> Self {
        Self {
            hand: HandChoice::default(),
            rolls: DEFAULT_ROLLS,
            k: None,
            effort: SearchOptions::default().effort,
            vote: VoteOptions::default(),
            accept: Accept::default(),
            temper: true,
            segment: SegmentParams::default(),
        }
    }
}

/// Why a picture has no answer.
#[derive(Debug, thiserror::Error)]
pub enum RecogniseError {
    /// The bytes are no picture.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The mask or the depth picture does not fit.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Nothing in the picture looks like a hand.
    #[error(
        "no hand found: nothing in the picture has the colour and the size of a hand (a mask can be given with --mask)"
    )]
    NoHand,
    /// The hand is too small or its buffers do not fit.
    #[error(transparent)]
    Hand(HandImageError),
    /// The descriptor does not fit the index.
    #[error(transparent)]
    Search(#[from] SearchError),
}

impl RecogniseError {
    /// A short, stable name for JSON records.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Decode(error) => error.kind(),
            Self::Source(_) => "mask",
            Self::NoHand => "no_hand",
            Self::Hand(_) => "hand_too_small",
            Self::Search(_) => "search",
        }
    }

    /// Whether the picture is sound and merely shows no hand that can be recognised.
    pub fn is_rejection(&self) -> bool {
        matches!(self, Self::NoHand | Self::Hand(_))
    }
}

impl From<HandImageError> for RecogniseError {
    fn from(error: HandImageError) -> Self {
        match error {
            HandImageError::NoHand { .. } => Self::NoHand,
            other => Self::Hand(other),
        }
    }
}

/// An answer and all that led to it.
#[derive(Clone, Debug)]
pub struct Recognition {
    /// The picture and its mask.
    pub prepared: Prepared,
    /// The hand image, as the picture shows it.
    pub hand_image: HandImage,
    /// The best hypothesis about hand and roll, with its neighbours and their vote.
    pub best: Hypothesis,
    /// What picture and neighbours say about how far the answer can be relied on.
    pub evidence: Evidence,
    /// How far the neighbours' probabilities are trusted, 0..=1: those of the vote are tempered by it. `None` where the mask was given and is one.
    pub trust: Option<f64>,
    /// What should make a reader doubt the answer.
    pub warnings: Vec<Warning>,
    /// Why the class is unknown, where it is.
    pub doubt: Option<Doubt>,
    /// How long each step took.
    pub timings: Timings,
}

/// Recognises pictures by one index. It can be shared between threads.
#[derive(Debug)]
pub struct Recogniser<'a> {
    index: &'a Index,
    options: RecogniseOptions,
}

impl<'a> Recogniser<'a> {
    /// A recogniser over `index`.
    pub fn new(index: &'a Index, options: RecogniseOptions) -> Self {
        Self { index, options }
    }

    /// The index that answers come from.
    pub fn index(&self) -> &'a Index {
        self.index
    }

    /// Recognises an encoded picture ([`picture::FORMATS`]), whose hand `source` finds.
    ///
    /// # Errors
    /// [`RecogniseError`]: where the bytes are no picture, the picture shows no hand, or mask and picture do not fit.
    pub fn recognise(&self, bytes: &[u8], source: &MaskSource) -> Result<Recognition, RecogniseError> {
        let mut timings = Timings::default();
        let decoded = timings.time(|t| &mut t.decode_ms, || picture::decode(bytes))?;
        let prepared = timings.time(
            |t| &mut t.segmentation_ms,
            || Prepared::new(decoded.picture, decoded.is_jpeg, source, &self.options.segment),
        )?;
        let mut found = self.recognise_prepared(prepared, timings)?;
        let odd = decoded.warnings.iter().map(|warning| Warning::Decoding(warning.to_string()));
        found.warnings.splice(..0, odd);
        Ok(found)
    }

    /// Recognises a hand whose mask is known.
    ///
    /// # Errors
    /// As [`Self::recognise`].
    pub fn recognise_prepared(
        &self,
        prepared: Prepared,
        mut timings: Timings,
    ) -> Result<Recognition, RecogniseError> {
        let started = Instant::now();
        let hand_image = prepared.hand_image()?.shrunk_to(DESCRIBED_SIDE);
        timings.descriptor_ms += timings::milliseconds(started);
        let mut best = hypothesis::best(self.index, &hand_image, &self.options, &mut timings)?;
        let evidence = Evidence::of(self.index, &prepared, &best);
        // The weights' shares are not what trust was fitted with.
        let is_calibrated = !self.options.vote.has_own_width();
        let trust = Trust::built_in().of(&evidence).filter(|_| is_calibrated);
        let applied = trust.filter(|_| self.options.temper);
        let classes = best.vote.classes.len();
        if let Some(trust) = applied {
            for class in &mut best.vote.classes {
                class.probability = temper(class.probability, trust, classes);
            }
        }
        let doubt = self.options.accept.doubt(self.index, &best, applied, &self.options.vote);
        let warnings = Vec::new();
        let mut found = Recognition { prepared, hand_image, best, evidence, trust, warnings, doubt, timings };
        let is_measured = self.index.catalogue().calibration.measured.is_some();
        found.warnings = warning::of(&found, is_measured || !is_calibrated);
        Ok(found)
    }
}
