//! From a picture to an answer: mask, hand image, descriptor, search, vote.

use std::borrow::Cow;
use std::time::Instant;

use grasp_index::{HandImage, Index};
use nalgebra::UnitQuaternion;

use crate::accept::Trusted;
use crate::doubtful;
use crate::error::RecogniseError;
use crate::evidence::Evidence;
use crate::hypothesis::{self, Hypothesis};
use crate::options::RecogniseOptions;
use crate::picture::{self, DecodeWarning, Decoded};
use crate::recognition::{Context, Recognition};
use crate::scene::{Prediction, join_orientation};
use crate::segment::Finder;
use crate::side::HandChoice;
use crate::source::{MaskSource, Prepared};
use crate::thorough::{self, VARIANTS, VariantAnswer};
use crate::timings::{self, Timings};
use crate::tracker::Tracker;
use crate::trust::{Trust, temper};
use crate::variant::Variant;
use crate::warning::Warning;

/// Recognises pictures by one index. It can be shared between threads.
#[derive(Debug)]
pub struct Recogniser<'a> {
    pub(crate) index: &'a Index,
    pub(crate) options: RecogniseOptions,
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
    /// [`RecogniseError`]: where the bytes are no picture, the picture shows no hand, or mask and
    /// picture do not fit.
    pub fn recognise(&self, bytes: &[u8], source: &MaskSource) -> Result<Recognition, RecogniseError> {
        let mut timings = Timings::default();
        let decoded = timings.time(|t| &mut t.decode_ms, || picture::decode(bytes))?;
        let prepared = timings.time(
            |t| &mut t.segmentation_ms,
            || Prepared::new(decoded.picture, decoded.is_jpeg, source, &self.options.segment),
        )?;
        let found = self.recognise_prepared(prepared, timings)?;
        Ok(with_oddities(found, &decoded.warnings))
    }

    /// Recognises the next frame of a video, which was decoded in `decode_ms`: the hand is looked
    /// for first where `tracker` has it from the frame before, and what is found there is nearly
    /// what a search of the frame by itself finds.
    ///
    /// # Errors
    /// As [`Self::recognise`].
    pub fn recognise_next(
        &self,
        decoded: Decoded,
        decode_ms: f64,
        tracker: &mut Tracker,
    ) -> Result<Recognition, RecogniseError> {
        let mut timings = Timings { decode_ms, ..Timings::default() };
        let prepared = timings.time(
            |t| &mut t.segmentation_ms,
            || Prepared::next(decoded.picture, tracker, &self.options.segment),
        )?;
        let found = self.recognise_prepared(prepared, timings)?;
        Ok(with_oddities(found, &decoded.warnings))
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
        let mut looked = self.look(&prepared, self.options.hand, &mut timings)?;
        let is_found_by_networks = prepared.scene.is_some();
        if self.options.thorough && is_found_by_networks {
            self.join_variants(&prepared, &mut looked, &mut timings);
        }
        let mut found = self.decide(prepared, looked, timings);
        if self.options.thorough && !is_found_by_networks {
            found.warnings.push(Warning::LookedAtOnce);
        }
        Ok(found)
    }

    /// Joins what variants of the picture say with what is said of it as it is.
    fn join_variants(&self, prepared: &Prepared, looked: &mut Looked, timings: &mut Timings) {
        let others: Vec<VariantAnswer> =
            VARIANTS.into_iter().filter_map(|variant| self.variant(prepared, variant, timings)).collect();
        // The hand stays that of the picture as it is: most variants are as often wrong where they
        // show the other one (docs/trials.md). But it may as well be that.
        if self.options.hand == HandChoice::Auto && thorough::most_show_other(looked.best.side, &others) {
            looked.best.rival = Some(0.0);
        }
        looked.no_grasp = thorough::join(&others, &mut looked.best.vote, looked.no_grasp);
        // Equation 4 as printed is the neighbours' alone.
        if !self.options.vote.euler_mean {
            looked.seen_in_variants = thorough::rotations(&others, looked.best.side);
            thorough::join_orientation(&looked.seen_in_variants, &mut looked.best.vote.orientation);
        }
    }

    /// What a variant of a picture says, where the same hand is found in it.
    fn variant(&self, prepared: &Prepared, variant: Variant, timings: &mut Timings) -> Option<VariantAnswer> {
        let shown = || Prepared::of_camera(variant.picture(&prepared.picture), &self.options.segment);
        let shown = timings.time(|t| &mut t.segmentation_ms, shown).ok()?;
        if !thorough::is_same_hand(&variant.mask(&prepared.mask), &shown.mask) {
            return None;
        }
        let looked = self.look(&shown, variant.hand(self.options.hand), timings).ok()?;
        Some(VariantAnswer::new(variant, &looked.best, looked.no_grasp))
    }

    /// What neighbours and networks say of a hand, before it is decided how far to believe it.
    fn look(
        &self,
        prepared: &Prepared,
        hand: HandChoice,
        timings: &mut Timings,
    ) -> Result<Looked, RecogniseError> {
        let started = Instant::now();
        let hand_image = prepared.hand_image()?.shrunk_to(self.index.catalogue().descriptor.described_side());
        timings.descriptor_ms += timings::milliseconds(started);
        let seen = timings.time(|t| &mut t.descriptor_ms, || self.prediction(prepared, &hand_image, hand));
        let seen_of = seen.as_deref();
        let mut best = hypothesis::best(self.index, &hand_image, seen_of, hand, &self.options, timings)?;
        let side = best.side;
        // Equation 4 as printed is the neighbours' alone.
        let rotations = seen.as_deref().filter(|_| !self.options.vote.euler_mean);
        let rotations = rotations.map(|seen| seen.rotations(side).to_vec()).unwrap_or_default();
        join_orientation(&rotations, &mut best.vote.orientation);
        let no_grasp = seen.map(|seen| seen.join(self.index, side, hand, &mut best.vote));
        // Without the thing, a hand that holds something may look as if it held nothing.
        let no_grasp = no_grasp.filter(|_| prepared.scene.is_some());
        Ok(Looked { hand_image, best, seen: rotations, seen_in_variants: Vec::new(), no_grasp })
    }

    /// How far what is said of a hand is believed, and what should make a reader doubt it.
    fn decide(&self, prepared: Prepared, looked: Looked, timings: Timings) -> Recognition {
        let Looked { hand_image, mut best, seen, seen_in_variants, no_grasp } = looked;
        let evidence = Evidence::of(self.index, &prepared, &best);
        // The weights' shares are not what trust was fitted with.
        let is_calibrated = !self.options.vote.has_own_width();
        let model = Trust::of_descriptor(&self.index.catalogue().descriptor, &self.options.segment.by);
        let trust = model.trust(&evidence).filter(|_| is_calibrated);
        let trusted = trust.filter(|_| self.options.temper).map(|trust| Trusted {
            trust,
            least: model.least,
            tempering: model.tempering(trust),
        });
        let tempering = trusted.map(|trusted| trusted.tempering);
        let classes = best.vote.classes.len();
        if let Some(tempering) = tempering {
            for class in &mut best.vote.classes {
                class.probability = temper(class.probability, tempering, classes);
            }
        }
        let doubt = self.options.accept.doubt(self.index, &best, trusted, &self.options.vote);
        let is_none = no_grasp.and_then(|probability| self.options.accept.none_of_the_grasps(probability));
        // Such a hand often looks like no class in particular. A prior or the frames before may
        // settle that doubt, but not this one: it goes first.
        let doubt = doubt.filter(|doubt| !doubt.is_unsure()).or(is_none).or(doubt);
        let warnings = Vec::new();
        let mut found = Recognition {
            prepared,
            hand_image,
            best,
            evidence,
            no_grasp,
            trust,
            tempering,
            seen,
            seen_in_variants,
            warnings,
            doubt,
            context: Context::Nothing,
            timings,
        };
        // Nor do probabilities hold for another number of neighbours than they were fitted to.
        let calibration = &self.index.catalogue().calibration;
        let has_own_k = self.options.k.is_some_and(|k| k != calibration.k as usize);
        let is_measured = calibration.measured.is_some() && !has_own_k;
        found.warnings = doubtful::warnings(&found, is_measured && is_calibrated);
        found
    }

    /// What the scene networks see, beside what the descriptor does: in a camera picture, and of a
    /// hand that is cut out, if hands are to be recognised by networks at all.
    fn prediction<'b>(
        &self,
        prepared: &'b Prepared,
        image: &HandImage,
        hand: HandChoice,
    ) -> Option<Cow<'b, Prediction>> {
        if let Some(scene) = &prepared.scene {
            return Some(Cow::Borrowed(&scene.prediction));
        }
        if !self.index.catalogue().descriptor.is_learned() || self.options.segment.by == Finder::Skin {
            return None;
        }
        let turn = image.upright_turn_deg().to_radians();
        let sides = hand.sides();
        let networks = &self.options.segment.networks;
        Prediction::of_cut_out(networks, &prepared.picture, &prepared.mask, turn, sides).map(Cow::Owned)
    }
}

/// What neighbours and networks say of a hand.
struct Looked {
    hand_image: HandImage,
    best: Hypothesis,
    /// How networks see the hand turned in the picture, by each of their looks.
    seen: Vec<UnitQuaternion<f64>>,
    /// How it is turned by other variants of the picture.
    seen_in_variants: Vec<UnitQuaternion<f64>>,
    /// How likely the hand is in none of the grasps.
    no_grasp: Option<f64>,
}

/// With what is odd about the picture first among what is to be doubted.
fn with_oddities(mut found: Recognition, odd: &[DecodeWarning]) -> Recognition {
    found.warnings.splice(..0, odd.iter().map(|warning| Warning::Decoding(warning.to_string())));
    found
}
