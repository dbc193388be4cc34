//! Scores labelled pictures: the paper's Section VII with one command.

pub mod calibration;
pub mod confusion;
pub mod errors;
pub mod labels;
pub mod report;
pub mod spread;

use std::path::{Path, PathBuf};
use std::time::Instant;

use grasp_index::{HandImage, NETWORK_STAGES};
use nalgebra::UnitQuaternion;

use grasp_answer::record::UNKNOWN;
use grasp_recognise::picture::{self, Decoded, Picture};
use grasp_recognise::segment::{Mask, SegmentParams};
use grasp_recognise::{
    Evidence, MaskSource, Prepared, RecogniseError, Recogniser, Recognition, Side, Timings,
};
use labels::{Kind, Label};

/// What became of one labelled picture.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The label.
    pub label: Label,
    /// What was recognised, or why nothing was.
    pub result: Result<Guess, Miss>,
    /// Time for the picture from its file to the answer, in milliseconds; 0 where it was not looked
    /// at.
    pub ms: f64,
    /// Intersection over union of the segmentation and the labelled mask, before the forearm is cut
    /// off and after.
    pub iou: Option<Iou>,
}

/// Overlap with a labelled mask, 0..=1 each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iou {
    /// Of skin, forearm included.
    pub skin: f64,
    /// Of the hand, cut at the wrist.
    pub hand: f64,
}

/// An answer, as far as it is scored.
#[derive(Clone, Debug)]
pub struct Guess {
    /// The class, or [`UNKNOWN`].
    pub grasp: String,
    /// The probability of the most probable class.
    pub probability: f64,
    /// The probability of every class, by name, most probable first.
    pub classes: Vec<(String, f64)>,
    /// How likely it reaches, closes and grasps, where the index knows.
    pub stages: Option<[f64; NETWORK_STAGES.len()]>,
    /// The hand.
    pub hand: Side,
    /// `camera_from_hand`.
    pub orientation: UnitQuaternion<f64>,
    /// How far the neighbours disagree about it, in degrees.
    pub spread_deg: f64,
    /// The distance of the nearest entry.
    pub nearest: f64,
    /// What picture and neighbours say about how far it can be relied on.
    pub evidence: Evidence,
    /// How far it is trusted, 0..=1; `None` where the mask was given.
    pub trust: Option<f64>,
}

/// Why there is no answer.
#[derive(Clone, Debug)]
pub struct Miss {
    /// Whether the picture is sound and merely shows no hand that was found.
    pub is_rejection: bool,
    /// What happened.
    pub message: String,
}

/// Recognises one labelled picture and scores its segmentation.
///
/// `folder` is what the table's paths are relative to. A segmented picture is multiplied by its
/// labelled mask, which removes JPEG ringing; a camera picture is, only where `labelled_masks` asks
/// for it.
pub fn score(recogniser: &Recogniser<'_>, folder: &Path, label: Label, labelled_masks: bool) -> Outcome {
    let path = resolve(folder, &label.file);
    let labelled = labelled_mask(folder, &label);
    let started = Instant::now();
    let read = picture::read(&path).map_err(RecogniseError::from).map_err(|error| miss(&error));
    let (mut iou, mut ms) = (None, 0.0);
    let result = read.and_then(|bytes| {
        let mask = labelled?;
        let source = source_of(label.kind, mask.clone(), labelled_masks);
        let found = recogniser.recognise(&bytes, &source);
        ms = started.elapsed().as_secs_f64() * 1e3;
        if let (MaskSource::Camera, Some(mask)) = (&source, &mask) {
            iou = overlap(&found, mask);
        }
        found.map(|found| guess(recogniser, &found)).map_err(|error| miss(&error))
    });
    Outcome { label, result, ms, iou }
}

/// The hand image H of a labelled picture, in full size, as `segment` finds it; a mask is used as
/// in [`score`].
///
/// # Errors
/// [`Miss`]: where the picture or its mask cannot be used, or no hand is found.
pub fn hand_image(
    folder: &Path,
    label: &Label,
    labelled_masks: bool,
    segment: &SegmentParams,
) -> Result<HandImage, Miss> {
    let source = source_of(label.kind, labelled_mask(folder, label)?, labelled_masks);
    let bytes = picture::read(&resolve(folder, &label.file)).map_err(|error| miss(&error.into()))?;
    let prepared = Prepared::decode(&bytes, &source, segment);
    prepared.and_then(|prepared| prepared.hand_image()).map_err(|error| miss(&error))
}

/// A labelled picture in its colours, and its hand's mask: the labelled one, or what is not black
/// where there is none.
///
/// # Errors
/// [`Miss`]: where the picture or its mask cannot be used, or no hand is found.
pub fn labelled_hand(folder: &Path, label: &Label) -> Result<(Picture, Mask), Miss> {
    let mask = labelled_mask(folder, label)?;
    let source = mask.map_or(MaskSource::Segmented, MaskSource::SegmentedAnd);
    let bytes = picture::read(&resolve(folder, &label.file)).map_err(|error| miss(&error.into()))?;
    let prepared = Prepared::decode(&bytes, &source, &SegmentParams::default());
    prepared.map(|prepared| (prepared.picture, prepared.mask)).map_err(|error| miss(&error))
}

/// A labelled picture, decoded, and where its hand's mask comes from, as in [`score`].
///
/// # Errors
/// [`Miss`]: where the picture or its mask cannot be read.
pub fn labelled_picture(
    folder: &Path,
    label: &Label,
    labelled_masks: bool,
) -> Result<(Decoded, MaskSource), Miss> {
    let source = source_of(label.kind, labelled_mask(folder, label)?, labelled_masks);
    let decoded = picture::read(&resolve(folder, &label.file)).and_then(|bytes| picture::decode(&bytes));
    decoded.map(|decoded| (decoded, source)).map_err(|error| miss(&error.into()))
}

/// What a prepared picture is taken for.
///
/// # Errors
/// [`Miss`]: where it could not be prepared, or its hand cannot be recognised.
pub fn guess_of(
    recogniser: &Recogniser<'_>,
    prepared: Result<Prepared, RecogniseError>,
) -> Result<Guess, Miss> {
    let found = prepared.and_then(|prepared| recogniser.recognise_prepared(prepared, Timings::default()));
    found.map(|found| guess(recogniser, &found)).map_err(|error| miss(&error))
}

fn source_of(kind: Kind, mask: Option<Mask>, labelled_masks: bool) -> MaskSource {
    match (kind, mask) {
        (Kind::Segmented, Some(mask)) => MaskSource::SegmentedAnd(mask),
        (Kind::Segmented, None) => MaskSource::Segmented,
        (Kind::Camera, Some(mask)) if labelled_masks => MaskSource::Given(mask),
        (Kind::Camera, _) => MaskSource::Camera,
    }
}

/// The folder that a table's paths are relative to: the nearest folder above the table in which the
/// first of its pictures that is anywhere is found, as `dev/hands/labels.csv` names
/// `hands/easy/a.jpg`.
pub fn folder_of<'l>(table: &Path, labels: impl IntoIterator<Item = &'l Label>) -> PathBuf {
    // `labels.csv` alone lies in the current folder, whose name is not the empty one that `parent`
    // gives.
    let beside = match table.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    let above = beside.canonicalize().unwrap_or_else(|_| beside.clone());
    let holds = |label: &Label| above.ancestors().take(3).find(|folder| folder.join(&label.file).is_file());
    labels.into_iter().find_map(holds).map_or(beside, Path::to_owned)
}

fn resolve(folder: &Path, file: &str) -> PathBuf {
    folder.join(file)
}

fn labelled_mask(folder: &Path, label: &Label) -> Result<Option<Mask>, Miss> {
    label.mask.as_ref().map(|mask| read_mask(&resolve(folder, mask))).transpose()
}

fn read_mask(path: &Path) -> Result<Mask, Miss> {
    let decoded = picture::read(path).and_then(|bytes| picture::decode_grey(&bytes));
    match decoded {
        Ok((width, height, grey)) => Ok(Mask::from_grey(width, height, &grey)),
        Err(error) => Err(Miss { is_rejection: false, message: format!("mask {}: {error}", path.display()) }),
    }
}

/// No hand found is an overlap of 0; a broken picture has none.
fn overlap(found: &Result<Recognition, RecogniseError>, labelled: &Mask) -> Option<Iou> {
    match found {
        Ok(found) => {
            let truth = labelled.resized(found.prepared.picture.width(), found.prepared.picture.height());
            let skin = found.prepared.skin.as_ref().unwrap_or(&found.prepared.mask);
            Some(Iou { skin: truth.iou(skin)?, hand: truth.iou(&found.prepared.mask)? })
        }
        Err(error) if error.is_rejection() => Some(Iou { skin: 0.0, hand: 0.0 }),
        Err(_) => None,
    }
}

fn guess(recogniser: &Recogniser<'_>, found: &Recognition) -> Guess {
    let best = &found.best;
    let first = best.vote.classes.first();
    let name = |class: u16| recogniser.index().catalogue().classes.get(usize::from(class));
    Guess {
        grasp: match first.and_then(|class| name(class.class)) {
            Some(class) if found.doubt.is_none() => class.name.clone(),
            _ => UNKNOWN.to_owned(),
        },
        probability: first.map_or(0.0, |class| class.probability),
        classes: best.vote.classes.iter().map(|class| (class.name.clone(), class.probability)).collect(),
        stages: best.vote.stages,
        hand: best.side,
        orientation: best.vote.orientation.rotation,
        spread_deg: best.vote.orientation.spread_deg,
        nearest: best.neighbours.first().map_or(f64::INFINITY, |nearest| f64::from(nearest.distance)),
        evidence: found.evidence.clone(),
        trust: found.trust,
    }
}

fn miss(error: &RecogniseError) -> Miss {
    Miss { is_rejection: error.is_rejection(), message: error.to_string() }
}
