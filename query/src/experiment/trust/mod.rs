//! How far answers about camera pictures are to be trusted: the model of
//! [`grasp_recognise::Trust`], fitted to labelled camera pictures, to segmented ones put before
//! backgrounds that are hard to tell from skin, and to such backgrounds alone.

mod compose;
mod draws;
mod fit;

use std::fmt::Write as _;
use std::path::Path;

use grasp_index::{Index, Reliability};
use serde::Serialize;

use super::write_file;
use crate::evaluate::labels::{Kind, Label, OTHER, Part};
use crate::evaluate::{Miss, labelled_hand};
use draws::Draws;
use fit::{Example, fit};
use grasp_recognise::picture;
use grasp_recognise::segment::SegmentParams;
use grasp_recognise::{
    Accept, Evidence, HandChoice, MaskSource, Prepared, RecogniseError, RecogniseOptions, Recogniser,
    Recognition, Side, Timings, Trust, temper,
};

/// How many backgrounds each segmented picture is put in front of.
const BACKGROUNDS: usize = 3;
/// One background alone for this many segmented pictures: see [`Recognisers::empty`].
pub const HANDS_PER_NONE: usize = 2;

/// What a picture of the experiment is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scene {
    /// A labelled camera picture as it is.
    Camera,
    /// A segmented hand in front of a background.
    Composed,
    /// A background.
    Empty,
}

/// One picture that a hand was found in.
#[derive(Clone, Debug)]
pub struct Sample {
    scene: Scene,
    part: Part,
    hand_is_given: bool,
    example: Example,
    evidence: Evidence,
    /// The probability of the first class by the neighbours.
    stated: f64,
    is_right: bool,
    classes: usize,
}

/// The figures. JSON keys are an interface: they may be added to, never renamed.
#[derive(Clone, Debug, Serialize)]
pub struct Fitted {
    /// The model, fitted to seven tenths of the pictures.
    pub model: Trust,
    /// What it is worth on those and on the rest.
    pub worth: Vec<TrustScore>,
}

/// What stated probabilities are worth on some of the pictures.
#[derive(Clone, Debug, Serialize)]
pub struct TrustScore {
    /// What they show.
    pub scene: Scene,
    /// Whether the labelled hand was given, or both were tried.
    pub hand_is_given: bool,
    /// Whether the model was fitted to them.
    pub is_fitted: bool,
    /// How many there are.
    pub n: usize,
    /// How many of them are classed rightly.
    pub right: usize,
    /// How many have less trust than makes an answer.
    pub unknown: usize,
    /// The calibration error of the neighbours' probabilities.
    pub ece_before: Option<f64>,
    /// The same of the tempered ones.
    pub ece: Option<f64>,
    /// Neighbours' probabilities above 0.9, and how many of these answers are right.
    pub above_before: [usize; 2],
    /// The same of the tempered ones.
    pub above: [usize; 2],
}

/// What recognises the pictures: it must not temper what it says.
#[derive(Debug)]
pub struct Recognisers<'a> {
    tried: Recogniser<'a>,
    /// Left and right.
    given: [Recogniser<'a>; 2],
    segment: SegmentParams,
}

impl<'a> Recognisers<'a> {
    /// By one index, with the hand left open and given; hands are found like this.
    pub fn new(index: &'a Index, segment: SegmentParams) -> Self {
        let of = |hand| {
            let (accept, segment) = (Accept::Always, segment.clone());
            let options = RecogniseOptions { hand, accept, segment, temper: false, ..Default::default() };
            Recogniser::new(index, options)
        };
        let given = [of(HandChoice::Left), of(HandChoice::Right)];
        Self { tried: of(HandChoice::Auto), given, segment }
    }

    /// What one label gives.
    ///
    /// # Errors
    /// [`Miss`]: where its picture or its mask cannot be used.
    pub fn samples(&self, folder: &Path, label: &Label) -> Result<Vec<Sample>, Miss> {
        let shown = |scene, weight| Shown {
            scene,
            part: label.part(),
            weight,
            grasp: &label.grasp,
            hand: label.hand.unwrap_or_default(),
        };
        let params = &self.segment;
        if label.kind == Kind::Camera {
            let bytes = picture::read(&folder.join(&label.file)).map_err(RecogniseError::from);
            let prepared = bytes.and_then(|bytes| Prepared::decode(&bytes, &MaskSource::Camera, params));
            return Ok(self.samples_of(&shown(Scene::Camera, 1.0), prepared));
        }
        let (whole, mask) = labelled_hand(folder, label)?;
        let Some(hand) = compose::cut_out(&whole, &mask) else { return Ok(Vec::new()) };
        let shown = shown(Scene::Composed, 1.0 / BACKGROUNDS as f64);
        let composed = (0..BACKGROUNDS).flat_map(|number| {
            let picture = compose::hand(&hand, &mut Draws::of(&label.file, number));
            picture.map_or_else(Vec::new, |picture| {
                self.samples_of(&shown, Prepared::new(picture, false, &MaskSource::Camera, params))
            })
        });
        Ok(composed.collect())
    }

    /// What the background of this number gives, alone.
    pub fn empty(&self, number: usize) -> Vec<Sample> {
        let part = if number % 10 < 7 { Part::Choose } else { Part::Final };
        let hand = if number.is_multiple_of(2) { Side::Right } else { Side::Left };
        let shown = Shown { scene: Scene::Empty, part, weight: 1.0, grasp: OTHER, hand };
        let picture = compose::no_hand(&mut Draws::of("no hand", number));
        picture.map_or_else(Vec::new, |picture| {
            self.samples_of(&shown, Prepared::new(picture, false, &MaskSource::Camera, &self.segment))
        })
    }

    /// Where no hand was found, there is no answer to trust.
    fn samples_of(&self, shown: &Shown<'_>, prepared: Result<Prepared, RecogniseError>) -> Vec<Sample> {
        let Ok(prepared) = prepared else { return Vec::new() };
        let [left, right] = &self.given;
        let given = if shown.hand == Side::Left { left } else { right };
        let sample = |recogniser: &Recogniser<'_>, hand_is_given| {
            let found = recogniser.recognise_prepared(prepared.clone(), Timings::default()).ok()?;
            Some(Sample::new(shown, hand_is_given, &found))
        };
        [sample(&self.tried, false), sample(given, true)].into_iter().flatten().collect()
    }
}

/// What a picture shows, and how it counts.
struct Shown<'a> {
    scene: Scene,
    part: Part,
    weight: f64,
    grasp: &'a str,
    hand: Side,
}

impl Sample {
    fn new(shown: &Shown<'_>, hand_is_given: bool, found: &Recognition) -> Self {
        let &Shown { scene, part, weight, grasp, .. } = shown;
        let classes = &found.best.vote.classes;
        let count = classes.len();
        let labelled = classes.iter().find(|class| class.name == grasp).map(|class| class.probability);
        let unknowing = if grasp == OTHER { 1.0 } else { 1.0 / count.max(1) as f64 };
        let first = classes.first();
        Self {
            scene,
            part,
            hand_is_given,
            example: Example {
                measures: found.evidence.measures(),
                labelled: labelled.unwrap_or(0.0),
                unknowing,
                weight,
            },
            evidence: found.evidence.clone(),
            stated: first.map_or(0.0, |class| class.probability),
            is_right: first.is_some_and(|class| class.name == grasp),
            classes: count,
        }
    }

    fn trust(&self, model: &Trust) -> f64 {
        model.trust(&self.evidence).unwrap_or(1.0)
    }
}

impl Fitted {
    /// Fits a model to the part of the samples to choose by and measures it on both. Its least
    /// trust and its floor are given.
    pub fn new(samples: &[Sample], [least, floor]: [f64; 2]) -> Self {
        let [hand_tried, hand_given] = [false, true].map(|hand_is_given| {
            let chosen = samples
                .iter()
                .filter(|sample| sample.part == Part::Choose && sample.hand_is_given == hand_is_given);
            fit(&chosen.map(|sample| sample.example).collect::<Vec<_>>())
        });
        let model = Trust { least, floor, hand_tried, hand_given };
        let of = |scene, hand_is_given, part: Part| {
            let is_meant = |sample: &&Sample| {
                sample.scene == scene && sample.hand_is_given == hand_is_given && sample.part == part
            };
            let chosen: Vec<&Sample> = samples.iter().filter(is_meant).collect();
            TrustScore::new((scene, hand_is_given, part == Part::Choose), &chosen, &model)
        };
        let scenes = [Scene::Camera, Scene::Composed, Scene::Empty];
        let hands = scenes.into_iter().flat_map(|scene| [(scene, false), (scene, true)]);
        let worth =
            hands.flat_map(|(scene, given)| [Part::Choose, Part::Final].map(|part| of(scene, given, part)));
        let worth = worth.filter(|worth| worth.n > 0).collect();
        Self { model, worth }
    }

    /// The figures for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for worth in &self.worth {
            let TrustScore { scene, n, right, unknown, above_before, above, .. } = worth;
            let scene = match scene {
                Scene::Camera => "camera pictures",
                Scene::Composed => "composed",
                Scene::Empty => "without a hand",
            };
            let hand = if worth.hand_is_given { "hand given" } else { "both hands tried" };
            let name = format!("{scene}, {hand}, {}", if worth.is_fitted { "fitted to" } else { "held out" });
            let [before, after] = [worth.ece_before, worth.ece].map(|ece| ece.unwrap_or(0.0));
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{name:<44} {n:5}, {right} right, {unknown} unknown; calibration error {before:.3} -> {after:.3}; \
                 stated above 0.9: {} of {} right -> {} of {}",
                above_before[1], above_before[0], above[1], above[0]
            );
        }
        for (hand, model) in
            [("both hands tried", &self.model.hand_tried), ("hand given", &self.model.hand_given)]
        {
            let _ = writeln!(text, "\nlogit of the trust, {hand}: {:+.3}", model.bias);
            for (name, term) in &model.measures {
                let _ = writeln!(
                    text,
                    "  {name:<12} {:+.3} for each {:.3} above {:.3}",
                    term.weight, term.deviation, term.mean
                );
            }
        }
        text
    }

    /// Writes the model as `data/trust.toml` is written, with the command and the index that it was
    /// made by.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path, command: &str, index: &Index) -> anyhow::Result<()> {
        let (entries, hands) = (index.len(), index.catalogue().hand_shapes.len());
        let head = format!(
            "# How far an answer about a camera picture is trusted: see query/recognise/src/trust.rs.\n\
             # Made by: {command}\n\
             # with an index of {entries} entries, {hands} hand shapes.\n\n"
        );
        write_file(path, (head + &toml::to_string(&self.model)?).as_bytes())
    }
}

impl TrustScore {
    fn new(
        (scene, hand_is_given, is_fitted): (Scene, bool, bool),
        samples: &[&Sample],
        model: &Trust,
    ) -> Self {
        let before = || samples.iter().map(|sample| (sample.stated, sample.is_right));
        let after = || {
            let tempered = |s: &Sample| temper(s.stated, model.tempering(s.trust(model)), s.classes);
            samples.iter().map(move |sample| (tempered(sample), sample.is_right))
        };
        let above = |stated: &mut dyn Iterator<Item = (f64, bool)>| {
            stated
                .filter(|(probability, _)| *probability > 0.9)
                .fold([0, 0], |[n, right], (_, is_right)| [n + 1, right + usize::from(is_right)])
        };
        Self {
            scene,
            hand_is_given,
            is_fitted,
            n: samples.len(),
            right: samples.iter().filter(|sample| sample.is_right).count(),
            unknown: samples.iter().filter(|sample| sample.trust(model) < model.least).count(),
            ece_before: Reliability::from_answers(before()).expected_error(),
            ece: Reliability::from_answers(after()).expected_error(),
            above_before: above(&mut before()),
            above: above(&mut after()),
        }
    }
}
