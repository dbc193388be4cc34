//! How far answers are to be trusted whose mask was found by colour: the model of [`crate::recognise::Trust`], fitted to labelled
//! camera pictures, to segmented ones put before backgrounds that are hard to tell from skin, and to such backgrounds alone.

mod compose;
mod draws;
mod fit;

use std::fmt::Write as _;
use std::path::Path;

use grasp_index::{Index, Reliability};
use image::RgbaImage;
use serde::Serialize;

use super::write_file;
use crate::evaluate::labels::{Kind, Label, OTHER, Part};
use crate::evaluate::{Miss, labelled_hand};
use crate::picture::{self, Picture};
use crate::recognise::{Evidence, MaskSource, RecogniseError, Recogniser, Recognition, Trust, temper};
use draws::Draws;
use fit::{Example, fit};

/// Backgrounds that each segmented picture is put before.
const BACKGROUNDS: usize = 3;
/// One picture without a hand for so many segmented ones.
const HANDS_PER_NONE: usize = 2;

/// What a picture of the experiment is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scene {
    /// A labelled camera picture as it is.
    Camera,
    /// A segmented hand before a background.
    Composed,
    /// A background.
    Empty,
}

/// One picture that a hand was found in.
#[derive(Clone, Debug)]
pub struct Sample {
    scene: Scene,
    part: Part,
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
    pub worth: Vec<Worth>,
}

/// What stated probabilities are worth on some of the pictures.
#[derive(Clone, Debug, Serialize)]
pub struct Worth {
    /// What they show.
    pub scene: Scene,
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

/// What one label gives. The recogniser must not temper what it says.
pub fn samples(recogniser: &Recogniser<'_>, folder: &Path, label: &Label) -> Result<Vec<Sample>, Miss> {
    let part = label.part();
    let sample = |scene, weight, found: Result<Recognition, RecogniseError>| {
        // Where no hand was found, there is no answer to trust.
        found.ok().map(|found| Sample::new(recogniser, scene, part, weight, &label.grasp, &found))
    };
    if label.kind == Kind::Camera {
        let bytes = picture::read(&folder.join(&label.file)).map_err(RecogniseError::from);
        let found = bytes.and_then(|bytes| recogniser.recognise(&bytes, &MaskSource::Skin));
        return Ok(sample(Scene::Camera, 1.0, found).into_iter().collect());
    }
    let (whole, mask) = labelled_hand(folder, label)?;
    let Some(hand) = compose::cut_out(&whole, &mask) else { return Ok(Vec::new()) };
    let composed = (0..BACKGROUNDS).filter_map(|number| {
        let picture = composed(&hand, &label.file, number)?;
        let found = recogniser.recognise_picture(picture, &MaskSource::Skin);
        sample(Scene::Composed, 1.0 / BACKGROUNDS as f64, found)
    });
    Ok(composed.collect())
}

fn composed(hand: &RgbaImage, file: &str, number: usize) -> Option<Picture> {
    compose::hand(hand, &mut Draws::of(file, number))
}

/// What backgrounds alone give, so many as belong to `segmented` segmented pictures.
pub fn empty(recogniser: &Recogniser<'_>, segmented: usize) -> Vec<Sample> {
    let numbers = 0..segmented / HANDS_PER_NONE;
    let found = numbers.filter_map(|number| {
        let picture = compose::no_hand(&mut Draws::of("no hand", number))?;
        let found = recogniser.recognise_picture(picture, &MaskSource::Skin).ok()?;
        let part = if number % 10 < 7 { Part::Choose } else { Part::Final };
        Some(Sample::new(recogniser, Scene::Empty, part, 1.0, OTHER, &found))
    });
    found.collect()
}

impl Sample {
    fn new(
        recogniser: &Recogniser<'_>,
        scene: Scene,
        part: Part,
        weight: f64,
        grasp: &str,
        found: &Recognition,
    ) -> Self {
        let classes = &found.best.vote.classes;
        let count = recogniser.index().catalogue().classes.len();
        let labelled = classes.iter().find(|class| class.name == grasp).map(|class| class.probability);
        let unknowing = if grasp == OTHER { 1.0 } else { 1.0 / count.max(1) as f64 };
        let first = classes.first();
        Self {
            scene,
            part,
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
        model.of(&self.evidence).unwrap_or(1.0)
    }
}

impl Fitted {
    /// Fits a model to the part of the samples to choose by and measures it on both.
    pub fn new(samples: &[Sample], least: f64) -> Self {
        let fitted: Vec<Example> = samples
            .iter()
            .filter(|sample| sample.part == Part::Choose)
            .map(|sample| sample.example)
            .collect();
        let model = fit(&fitted, least);
        let of = |scene, part: Part| {
            let chosen: Vec<&Sample> =
                samples.iter().filter(|sample| sample.scene == scene && sample.part == part).collect();
            Worth::new(scene, part == Part::Choose, &chosen, &model)
        };
        let scenes = [Scene::Camera, Scene::Composed, Scene::Empty];
        let worth =
            scenes.into_iter().flat_map(|scene| [Part::Choose, Part::Final].map(|part| of(scene, part)));
        let worth = worth.filter(|worth| worth.n > 0).collect();
        Self { model, worth }
    }

    /// The figures for a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for worth in &self.worth {
            let Worth { scene, n, right, unknown, above_before, above, .. } = worth;
            let name = match (scene, worth.is_fitted) {
                (Scene::Camera, true) => "camera pictures, fitted to",
                (Scene::Camera, false) => "camera pictures, held out",
                (Scene::Composed, true) => "composed, fitted to",
                (Scene::Composed, false) => "composed, held out",
                (Scene::Empty, true) => "without a hand, fitted to",
                (Scene::Empty, false) => "without a hand, held out",
            };
            let [before, after] = [worth.ece_before, worth.ece].map(|ece| ece.unwrap_or(0.0));
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{name:<28} {n:5}, {right} right, {unknown} unknown; calibration error {before:.3} -> {after:.3}; \
                 stated above 0.9: {} of {} right -> {} of {}",
                above_before[1], above_before[0], above[1], above[0]
            );
        }
        let _ = writeln!(text, "\nlogit of the trust: {:+.3}", self.model.bias);
        for (name, term) in &self.model.measures {
            let _ = writeln!(
                text,
                "  {name:<12} {:+.3} for each {:.3} above {:.3}",
                term.weight, term.deviation, term.mean
            );
        }
        text
    }

    /// Writes the model as `data/trust.toml` is written, with the command and the index that it was made by.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path, command: &str, index: &Index) -> anyhow::Result<()> {
        let (entries, hands) = (index.len(), index.catalogue().hand_shapes.len());
        let head = format!(
            "# How far an answer is trusted whose mask was found by colour: see query/src/recognise/trust.rs.\n\
             # Made by: {command}\n\
             # with an index of {entries} entries, {hands} hand shapes.\n\n"
        );
        write_file(path, (head + &toml::to_string(&self.model)?).as_bytes())
    }
}

impl Worth {
    fn new(scene: Scene, is_fitted: bool, samples: &[&Sample], model: &Trust) -> Self {
        let before = || samples.iter().map(|sample| (sample.stated, sample.is_right));
        let after = || {
            let tempered = |s: &Sample| temper(s.stated, s.trust(model), s.classes);
            samples.iter().map(move |sample| (tempered(sample), sample.is_right))
        };
        let above = |stated: &mut dyn Iterator<Item = (f64, bool)>| {
            stated
                .filter(|(probability, _)| *probability > 0.9)
                .fold([0, 0], |[n, right], (_, is_right)| [n + 1, right + usize::from(is_right)])
        };
        Self {
            scene,
            is_fitted,
            n: samples.len(),
            right: samples.iter().filter(|sample| sample.is_right).count(),
            unknown: samples.iter().filter(|sample| sample.trust(model) < model.least).count(),
            ece_before: Reliability::of(before()).expected_error(),
            ece: Reliability::of(after()).expected_error(),
            above_before: above(&mut before()),
            above: above(&mut after()),
        }
    }
}
