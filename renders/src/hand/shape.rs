//! The measures of one person's hand.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use crate::random::normal;

/// Mean and spread of every measure, and the presets; see the file for its sources.
const TABLE: &str = include_str!("../../data/hand.toml");

/// How far a sampled measure may lie from the mean, in standard deviations: about the range from
/// the 2nd to the 98th percentile.
const SAMPLE_LIMIT: f64 = 2.0;

/// What went wrong when a hand shape was asked for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HandShapeError {
    /// No preset has this name.
    #[error("there is no hand shape `{name}`: the named ones are {}, and `hand-N` is a sampled hand with seed N", .known.join(", "))]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        known: Vec<String>,
    },
}

/// One finger's (or the thumb's) measures in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FingerMeasures {
    /// Lengths of the three bones from the palm to the tip: proximal, middle, distal for a finger;
    /// metacarpal, proximal, distal for the thumb.
    pub bones: [f64; 3],
    /// Breadth at the joint nearer to the palm.
    pub breadth: f64,
    /// Breadth at the joint nearer to the tip.
    pub tip_breadth: f64,
}

/// The measures of one person's hand, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct HandShape {
    /// A name fit for a file name: `mean`, a preset's name, or `hand-SEED`.
    pub name: String,
    /// From the wrist's centre to the middle knuckle.
    pub palm_length: f64,
    /// Across the knuckles.
    pub palm_breadth: f64,
    /// From the back of the hand to the palm, at the knuckles.
    pub palm_thickness: f64,
    /// Across the wrist.
    pub wrist_breadth: f64,
    /// From the back of the wrist to its palm side.
    pub wrist_thickness: f64,
    /// Thumb, index, middle, ring, little.
    pub digits: [FingerMeasures; 5],
}

#[derive(Deserialize)]
struct Table {
    measures: BTreeMap<String, Measure>,
    presets: BTreeMap<String, BTreeMap<Group, f64>>,
}

#[derive(Deserialize)]
struct Measure {
    mean: f64,
    sd: f64,
    group: Group,
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
enum Group {
    Palm,
    Fingers,
    Breadth,
    Girth,
}

/// The table is part of the program; a test reads it, so it cannot be broken in a release.
static PARSED: LazyLock<Table> =
    LazyLock::new(|| toml::from_str(TABLE).expect("data/hand.toml is checked by a test"));

impl HandShape {
    /// The mean adult hand.
    pub fn mean() -> HandShape {
        HandShape::from_scores("mean", |_, _| 0.0)
    }

    /// A named hand: `mean`, `small`, `large`, `slender`, `broad`, `long-fingered`,
    /// `short-fingered`, or `hand-N` for the hand that [`HandShape::sample`] makes of seed N.
    ///
    /// # Errors
    ///
    /// [`HandShapeError::Unknown`] when no hand has this name.
    pub fn preset(name: &str) -> Result<HandShape, HandShapeError> {
        if name == "mean" {
            return Ok(HandShape::mean());
        }
        // Each seed has one name: `hand-007` is rejected.
        let seed = name.strip_prefix("hand-").and_then(|seed| seed.parse().ok());
        if let Some(hand) = seed.map(HandShape::sample).filter(|hand| hand.name == name) {
            return Ok(hand);
        }
        let Some(groups) = PARSED.presets.get(name) else {
            return Err(HandShapeError::Unknown { name: name.to_owned(), known: HandShape::preset_names() });
        };
        Ok(HandShape::from_scores(name, |_, group| groups.get(&group).copied().unwrap_or(0.0)))
    }

    /// The names of all presets, `mean` first.
    pub fn preset_names() -> Vec<String> {
        std::iter::once("mean".to_owned()).chain(PARSED.presets.keys().cloned()).collect()
    }

    /// All presets, the mean hand first.
    pub fn presets() -> Vec<HandShape> {
        HandShape::preset_names().iter().filter_map(|name| HandShape::preset(name).ok()).collect()
    }

    /// A random adult hand; the same seed gives the same hand.
    ///
    /// Half of each measure's variance is the person's size, a quarter is shared within its group
    /// (palm, fingers, breadths, girths), a quarter is its own. No measure leaves the mean by more
    /// than two standard deviations.
    pub fn sample(seed: u64) -> HandShape {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let size = normal(&mut rng);
        let groups: Vec<(Group, f64)> = [Group::Palm, Group::Fingers, Group::Breadth, Group::Girth]
            .into_iter()
            .map(|group| (group, normal(&mut rng)))
            .collect();
        HandShape::from_scores(&format!("hand-{seed}"), |_, group| {
            let shared = groups.iter().find(|(g, _)| *g == group).map_or(0.0, |(_, z)| *z);
            let score = 0.5f64.sqrt() * size + 0.5 * shared + 0.5 * normal(&mut rng);
            score.clamp(-SAMPLE_LIMIT, SAMPLE_LIMIT)
        })
    }

    /// From the wrist's centre to the tip of the stretched middle finger, in metres.
    pub fn length(&self) -> f64 {
        self.palm_length + self.digits[2].bones.iter().sum::<f64>()
    }

    /// Every measure as a list, in a fixed order.
    #[cfg(test)]
    pub(crate) fn measures(&self) -> Vec<f64> {
        let palm = [
            self.palm_length,
            self.palm_breadth,
            self.palm_thickness,
            self.wrist_breadth,
            self.wrist_thickness,
        ];
        let digits =
            self.digits.iter().flat_map(|d| d.bones.iter().copied().chain([d.breadth, d.tip_breadth]));
        palm.into_iter().chain(digits).collect()
    }

    /// A hand whose measures lie `score(name, group)` standard deviations from their means.
    fn from_scores(name: &str, mut score: impl FnMut(&str, Group) -> f64) -> HandShape {
        let mut metres = |measure: &str| {
            let m = &PARSED.measures[measure];
            (m.mean + m.sd * score(measure, m.group)) * 1e-3
        };
        let palm = [
            metres("palm_length"),
            metres("palm_breadth"),
            metres("palm_thickness"),
            metres("wrist_breadth"),
            metres("wrist_thickness"),
        ];
        let digits = [
            ("thumb", ["metacarpal", "proximal", "distal"]),
            ("index", ["proximal", "middle", "distal"]),
            ("middle", ["proximal", "middle", "distal"]),
            ("ring", ["proximal", "middle", "distal"]),
            ("little", ["proximal", "middle", "distal"]),
        ]
        .map(|(digit, bones)| FingerMeasures {
            bones: bones.map(|bone| metres(&format!("{digit}_{bone}"))),
            breadth: metres(&format!("{digit}_breadth")),
            tip_breadth: metres(&format!("{digit}_tip_breadth")),
        });
        HandShape {
            name: name.to_owned(),
            palm_length: palm[0],
            palm_breadth: palm[1],
            palm_thickness: palm[2],
            wrist_breadth: palm[3],
            wrist_thickness: palm[4],
            digits,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_hand_is_of_human_size() {
        let hand = HandShape::mean();
        assert!((0.18..0.195).contains(&hand.length()), "{}", hand.length());
        assert!(hand.digits[2].bones[0] > hand.digits[4].bones[0]);
    }

    #[test]
    fn presets_differ_as_their_names_say() {
        let get = |name: &str| HandShape::preset(name).expect("a preset");
        assert!(get("small").length() < get("mean").length());
        assert!(get("large").length() > get("mean").length());
        assert!(get("slender").palm_breadth < get("broad").palm_breadth);
        let fingers = |name: &str| get(name).digits[2].bones[0] / get(name).palm_length;
        assert!(fingers("long-fingered") > fingers("mean"));
        assert!(fingers("short-fingered") < fingers("mean"));
        assert_eq!(HandShape::presets().len(), 7);
    }

    #[test]
    fn sampling_is_repeatable_and_stays_in_range() {
        assert_eq!(HandShape::sample(7), HandShape::sample(7));
        assert_ne!(HandShape::sample(7).measures(), HandShape::sample(8).measures());
        assert_eq!(HandShape::preset("hand-7"), Ok(HandShape::sample(7)));
        let lengths: Vec<f64> = (0..200).map(|s| HandShape::sample(s).length()).collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        assert!((mean - HandShape::mean().length()).abs() < 0.003, "mean {mean}");
        assert!(lengths.iter().all(|l| (0.15..0.225).contains(l)));
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let error = HandShape::preset("giant").expect_err("no such hand");
        insta::assert_snapshot!(error, @"there is no hand shape `giant`: the named ones are mean, broad, large, long-fingered, short-fingered, slender, small, and `hand-N` is a sampled hand with seed N");
    }
}
