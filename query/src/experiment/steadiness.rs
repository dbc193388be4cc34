//! How steady answers are: each labelled picture as it is, and changed so little that a person
//! answers the same. A few pictures, each in many variants, also say more surely which of two
//! choices recognises better than as many pictures by themselves.

use std::fmt::Write as _;
use std::path::Path;

use grasp_terminal::text::counted;
use serde::Serialize;

use super::{csv_of, json_of, write_files};
use crate::evaluate::confusion::Share;
use crate::evaluate::errors::median;
use crate::evaluate::labels::{Label, OTHER, RowError};
use crate::evaluate::report::{RowReport, errors_text};
use crate::evaluate::{Guess, Miss, guess_of, labelled_picture};
use grasp_answer::record::UNKNOWN;
use grasp_index::Index;
use grasp_recognise::segment::SegmentParams;
use grasp_recognise::{MaskSource, Prepared, RecogniseOptions, Recogniser, Side, Variant};

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Steadiness {
    /// The table of labels.
    pub labels: String,
    /// Every change, the unchanged pictures first.
    pub changes: Vec<ChangeRow>,
    /// All of them together, the unchanged pictures included.
    pub all: Share,
    /// Pictures that are classed rightly in every variant, in some, and in none.
    pub always: usize,
    /// In some.
    pub sometimes: usize,
    /// In none.
    pub never: usize,
    /// Rows and pictures that could not be used.
    pub errors: Vec<RowReport>,
    #[serde(skip)]
    answers: Vec<Answer>,
}

/// What one change does.
#[derive(Clone, Debug, Serialize)]
pub struct ChangeRow {
    /// The change.
    pub change: &'static str,
    /// Those classed rightly.
    pub right: Share,
    /// The share of pictures whose answer is that of the unchanged picture, 0..=1.
    pub same: f64,
    /// The share of pictures whose labelled hand was recognised, where it was left to the program.
    pub hand_right: Option<f64>,
    /// The median angle between labelled and answered rotation, in degrees.
    pub orientation_error_deg: Option<f64>,
}

/// A line of `steadiness.csv`. Columns are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    file: String,
    change: &'static str,
    labelled: String,
    /// The class, or `unknown`, also where no hand is found.
    grasp: String,
    probability: f64,
    hand: Option<Side>,
    labelled_hand: Option<Side>,
    orientation_error_deg: Option<f64>,
}

/// What recognises pictures in all their variants.
#[derive(Debug)]
pub struct Recognisers<'a> {
    recogniser: Recogniser<'a>,
    /// The same where the other hand is given.
    mirrored: Recogniser<'a>,
    segment: SegmentParams,
    labelled_masks: bool,
}

impl<'a> Recognisers<'a> {
    /// By one index and some options.
    pub fn new(index: &'a Index, options: RecogniseOptions, labelled_masks: bool) -> Self {
        let hand = Variant::Mirrored.hand(options.hand);
        let mirrored = Recogniser::new(index, RecogniseOptions { hand, ..options.clone() });
        let segment = options.segment.clone();
        Self { recogniser: Recogniser::new(index, options), mirrored, segment, labelled_masks }
    }

    /// What one label's picture is taken for in every variant, in the order of the changes.
    ///
    /// # Errors
    /// [`Miss`]: where its picture or its mask cannot be used. That no hand is found is an answer.
    pub fn answers(&self, folder: &Path, label: &Label) -> Result<Vec<Answer>, Miss> {
        let (decoded, source) = labelled_picture(folder, label, self.labelled_masks)?;
        let answer = |variant: Variant| {
            let recogniser = if variant == Variant::Mirrored { &self.mirrored } else { &self.recogniser };
            let (picture, source) = (variant.picture(&decoded.picture), source_of(variant, &source));
            let prepared = Prepared::new(picture, decoded.is_jpeg, &source, &self.segment);
            match guess_of(recogniser, prepared) {
                Ok(guess) => Ok(Answer::new(label, variant, Some(&guess))),
                Err(miss) if miss.is_rejection => Ok(Answer::new(label, variant, None)),
                Err(miss) => Err(miss),
            }
        };
        Variant::ALL.into_iter().map(answer).collect()
    }
}

impl Answer {
    fn new(label: &Label, variant: Variant, guess: Option<&Guess>) -> Self {
        let error = |guess: &Guess| {
            let labelled = variant.orientation(label.orientation.as_ref()?);
            Some(labelled.angle_to(&guess.orientation).to_degrees())
        };
        Self {
            file: label.file.clone(),
            change: variant.name(),
            labelled: label.grasp.clone(),
            grasp: guess.map_or_else(|| UNKNOWN.to_owned(), |guess| guess.grasp.clone()),
            probability: guess.map_or(0.0, |guess| guess.probability),
            hand: guess.map(|guess| guess.hand),
            labelled_hand: label.hand.map(|hand| variant.side(hand)),
            orientation_error_deg: guess.and_then(error),
        }
    }

    fn is_right(&self) -> bool {
        self.grasp == self.labelled
    }
}

impl Steadiness {
    /// Sums up what pictures in all their variants were taken for; each item is a label and its
    /// answers. Pictures in none of the classes are left out.
    pub fn new(
        labels: String,
        found: Vec<(&Label, Result<Vec<Answer>, Miss>)>,
        broken: &[RowError],
        hand_is_given: bool,
    ) -> Self {
        let mut errors: Vec<RowReport> = broken.iter().map(RowReport::from).collect();
        let mut pictures = Vec::new();
        for (label, answers) in found {
            match answers {
                Ok(answers) => pictures.push(answers),
                Err(miss) => errors.push(RowReport {
                    line: label.line,
                    file: Some(label.file.clone()),
                    message: miss.message,
                }),
            }
        }
        errors.sort_by_key(|error| error.line);
        let rows = Variant::ALL.iter().enumerate();
        let changes =
            rows.map(|(at, variant)| ChangeRow::new(*variant, at, &pictures, hand_is_given)).collect();
        let rights: Vec<usize> = pictures
            .iter()
            .map(|answers| answers.iter().filter(|answer| answer.is_right()).count())
            .collect();
        let count = |test: &dyn Fn(usize) -> bool| rights.iter().filter(|right| test(**right)).count();
        let variants = Variant::ALL.len();
        Self {
            labels,
            changes,
            all: Share { n: variants * rights.len(), right: rights.iter().sum() },
            always: count(&|right| right == variants),
            sometimes: count(&|right| (1..variants).contains(&right)),
            never: count(&|right| right == 0),
            errors,
            answers: pictures.into_iter().flatten().collect(),
        }
    }

    /// Whether a label's picture shows one of the grasps.
    pub fn is_meant(label: &Label) -> bool {
        label.grasp != OTHER
    }

    /// The figures as text.
    pub fn text(&self) -> String {
        if self.all.n == 0 {
            return errors_text(&self.errors);
        }
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let mut text = format!(
            "{:<14}{:>9}{:>13}{:>12}{:>14}\n",
            "change", "right", "same grasp", "hand right", "median error"
        );
        for row in &self.changes {
            let hand = or_none(row.hand_right.map(percent));
            let error = or_none(row.orientation_error_deg.map(|error| format!("{error:.1}°")));
            let (right, same) = (percent(row.right.top1()), percent(row.same));
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{:<14}{right:>9}{same:>13}{hand:>12}{error:>14}", row.change);
        }
        let _ = writeln!(
            text,
            "{:<14}{:>9}\n{}: {} right in every variant, {} in some, {} in none",
            "all",
            percent(self.all.top1()),
            counted(self.always + self.sometimes + self.never, ["picture", "pictures"]),
            self.always,
            self.sometimes,
            self.never,
        );
        text + &errors_text(&self.errors)
    }

    /// What [`Self::write`] writes.
    pub const FILES: [&str; 2] = ["steadiness.csv", "steadiness.json"];

    /// Writes [`Self::FILES`] into a folder, which is made where there is none.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        write_files(folder, Self::FILES, [csv_of(&self.answers)?, json_of(self)?])
    }
}

impl ChangeRow {
    fn new(variant: Variant, at: usize, pictures: &[Vec<Answer>], hand_is_given: bool) -> Self {
        let answers = || pictures.iter().filter_map(|answers| answers.get(at));
        let share = |n: usize, of: usize| if of == 0 { 0.0 } else { n as f64 / of as f64 };
        let unchanged = pictures.iter().filter_map(|answers| answers.first());
        let same = answers().zip(unchanged).filter(|(answer, before)| answer.grasp == before.grasp).count();
        let hands = || answers().filter(|answer| answer.labelled_hand.is_some() && answer.hand.is_some());
        let hands_right = hands().filter(|answer| answer.hand == answer.labelled_hand).count();
        let hands = hands().count();
        Self {
            change: variant.name(),
            right: Share { n: pictures.len(), right: answers().filter(|answer| answer.is_right()).count() },
            same: share(same, pictures.len()),
            hand_right: (!hand_is_given && hands > 0).then(|| share(hands_right, hands)),
            orientation_error_deg: median(
                answers().filter_map(|answer| answer.orientation_error_deg).collect(),
            ),
        }
    }
}

/// Where the mask of a picture in this variant comes from.
fn source_of(variant: Variant, source: &MaskSource) -> MaskSource {
    match source {
        MaskSource::SegmentedAnd(mask) => MaskSource::SegmentedAnd(variant.mask(mask)),
        MaskSource::Given(mask) => MaskSource::Given(variant.mask(mask)),
        other => other.clone(),
    }
}
