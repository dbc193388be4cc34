//! How the hands of an index are posed and seen, as the index keeps it for hands that are added
//! later.
//!
//! It is data, a JSON object with a version in the index's provenance, and not a command line: an
//! option can be renamed without a change of what indexes hold.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use grasp_renders::{Preset, Stage};
use serde::{Deserialize, Serialize};

/// The version of the JSON form. It rises where keys change or mean something else; one that is
/// added and may be absent is rejected by programs that do not know it.
const VERSION: u32 = 1;

/// How many stages may be named; one that is named twice is rendered twice.
const MOST_STAGES: usize = 100;
/// How many rolls a grid may have.
pub const ROLLS: RangeInclusive<u32> = 1..=360;
/// How many views may be drawn for a scene.
pub const VIEWS: RangeInclusive<u32> = 1..=1_000_000;
/// Which share of the scenes may be posed like examples.
pub const EXAMPLES: RangeInclusive<f64> = 0.0..=1.0;
/// Degrees between views. Only to list a grid that is finer would take minutes.
pub const STEPS_DEG: RangeInclusive<f64> = 0.5..=180.0;

/// A preset and what differs from it. `None` leaves a value as the preset has it.
///
/// ```
/// use grasp_builder::plan_spec::PlanSpec;
///
/// let spec: PlanSpec = r#"{"version":1,"preset":"paper","rolls":4}"#.parse()?;
/// assert_eq!(spec.rolls, Some(4));
/// assert_eq!(spec.to_string(), r#"{"version":1,"preset":"paper","rolls":4}"#);
/// # Ok::<(), grasp_builder::plan_spec::PlanSpecError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSpec {
    /// Which form it is.
    pub version: Version,
    /// The named plan that the other values change.
    pub preset: Preset,
    /// The stages; none leaves those of the preset.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<Stage>,
    /// Step between views in degrees, in azimuth and elevation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_deg: Option<f64>,
    /// Lowest and highest elevation in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elevations_deg: Option<[f64; 2]>,
    /// Rolls about the optical axis, evenly spaced over the full turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolls: Option<u32>,
    /// Views drawn for each scene instead of a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views: Option<u32>,
    /// The share of scenes that are posed like examples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub examples: Option<f64>,
    /// Distance of the camera in hand lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// Length of the bare forearm in millimetres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forearm_mm: Option<f64>,
    /// How far the light may move from view to view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light_variation: Option<f64>,
    /// How far the distance may vary from view to view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_variation: Option<f64>,
    /// The grasps, in the form of `renders/data/grasps.toml`, where they are not the built-in ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grasps: Option<String>,
}

/// A text that describes no plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanSpecError {
    /// It is not the JSON form, or that of another version.
    #[error("the description of the views cannot be parsed")]
    Json(#[from] serde_json::Error),
    /// It is not what earlier builds wrote either.
    #[error("the description of the views cannot be parsed at `{0}`")]
    Options(String),
    /// A value that cannot be.
    #[error("{0} is out of its range")]
    Range(&'static str),
}

/// The version of the form, which every description states; no other one is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub struct Version;

impl From<Version> for u32 {
    fn from(_: Version) -> u32 {
        VERSION
    }
}

/// A form of another version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("version {0}: this program reads {VERSION}")]
pub struct UnknownVersion(u32);

impl TryFrom<u32> for Version {
    type Error = UnknownVersion;

    fn try_from(version: u32) -> Result<Self, UnknownVersion> {
        if version == VERSION { Ok(Self) } else { Err(UnknownVersion(version)) }
    }
}

impl fmt::Display for PlanSpec {
    /// One line of JSON. Numbers are written so that they read back exactly.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let json = serde_json::to_string(self).map_err(|_| fmt::Error)?;
        f.write_str(&json)
    }
}

impl FromStr for PlanSpec {
    type Err = PlanSpecError;

    /// Reads the JSON form, or the options of indexes that earlier builds wrote.
    fn from_str(text: &str) -> Result<PlanSpec, PlanSpecError> {
        let spec = if text.starts_with('{') { serde_json::from_str(text)? } else { from_options(text)? };
        spec.check()?;
        Ok(spec)
    }
}

impl PlanSpec {
    /// A preset as it is.
    #[must_use]
    pub fn of_preset(preset: Preset) -> Self {
        Self {
            version: Version,
            preset,
            stages: Vec::new(),
            step_deg: None,
            elevations_deg: None,
            rolls: None,
            views: None,
            examples: None,
            distance: None,
            forearm_mm: None,
            light_variation: None,
            distance_variation: None,
            grasps: None,
        }
    }

    /// An index may come from anywhere: what would take unbounded memory is not read. The renderer
    /// itself checks the rest.
    fn check(&self) -> Result<(), PlanSpecError> {
        let fits = [
            ("the number of rolls", self.rolls.is_none_or(|rolls| ROLLS.contains(&rolls))),
            ("the number of views", self.views.is_none_or(|views| VIEWS.contains(&views))),
            ("the step between views", self.step_deg.is_none_or(|step| STEPS_DEG.contains(&step))),
            ("the share of examples", self.examples.is_none_or(|share| EXAMPLES.contains(&share))),
            ("the elevation", self.elevations_deg.is_none_or(are_elevations)),
            ("the number of stages", self.stages.len() <= MOST_STAGES),
        ];
        fits.iter().find(|(_, fits)| !fits).map_or(Ok(()), |(what, _)| Err(PlanSpecError::Range(what)))
    }
}

/// Whether these are a lowest and a highest elevation in degrees.
#[must_use]
pub fn are_elevations([low, high]: [f64; 2]) -> bool {
    -90.0 <= low && low <= high && high <= 90.0
}

/// The options that indexes of earlier builds hold: `--preset=wide --stage=reach --views=9`. Their
/// names are frozen, whatever the program's options are called today.
fn from_options(text: &str) -> Result<PlanSpec, PlanSpecError> {
    fn set<T: FromStr>(to: &mut Option<T>, value: &str) -> Option<()> {
        *to = Some(value.parse().ok()?);
        Some(())
    }
    let mut preset = None;
    let mut spec = PlanSpec::of_preset(Preset::Paper);
    for option in text.split(' ') {
        let parsed = option.split_once('=').and_then(|(name, value)| match name {
            "--preset" => set(&mut preset, value),
            "--stage" => value.parse().ok().map(|stage| spec.stages.push(stage)),
            "--elevations" => {
                let (low, high) = value.split_once("..")?;
                spec.elevations_deg = Some([low.parse().ok()?, high.parse().ok()?]);
                Some(())
            }
            "--rolls" => set(&mut spec.rolls, value),
            "--views" => set(&mut spec.views, value),
            "--step" => set(&mut spec.step_deg, value),
            "--examples" => set(&mut spec.examples, value),
            "--distance" => set(&mut spec.distance, value),
            "--forearm" => set(&mut spec.forearm_mm, value),
            "--light-variation" => set(&mut spec.light_variation, value),
            "--distance-variation" => set(&mut spec.distance_variation, value),
            _ => None,
        });
        parsed.ok_or_else(|| PlanSpecError::Options(option.to_owned()))?;
    }
    let preset = preset.ok_or_else(|| PlanSpecError::Options(text.to_owned()))?;
    Ok(PlanSpec { preset, ..spec })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an index of an earlier build holds, with every option.
    const OPTIONS: &str = "--preset=wide --stage=reach --stage=grasp --elevations=-84..84 --rolls=7 --views=3 \
                           --step=51.42857142857143 --examples=0.1 --distance=3.7 --forearm=33.3 \
                           --light-variation=0.3 --distance-variation=0.07";
    const JSON: &str = r#"{"version":1,"preset":"wide","stages":["reach","grasp"],"step_deg":51.42857142857143,"elevations_deg":[-84.0,84.0],"rolls":7,"views":3,"examples":0.1,"distance":3.7,"forearm_mm":33.3,"light_variation":0.3,"distance_variation":0.07}"#;

    #[test]
    fn both_forms_are_read_and_the_data_is_written() {
        let [old, new] = [OPTIONS, JSON].map(|text| text.parse::<PlanSpec>().unwrap());
        assert_eq!(old, new);
        assert_eq!(old.to_string(), JSON);
        assert_eq!(PlanSpec::of_preset(Preset::Standard).to_string(), r#"{"version":1,"preset":"standard"}"#);
    }

    #[test]
    fn numbers_read_back_exactly() {
        for bits in (0..2000).map(|i: u64| 0x3ff0_0000_0000_0000 + i * 0x0000_1234_5678_9abc) {
            let spec =
                PlanSpec { distance: Some(f64::from_bits(bits)), ..PlanSpec::of_preset(Preset::Paper) };
            assert_eq!(spec.to_string().parse::<PlanSpec>().unwrap(), spec);
        }
    }

    #[test]
    fn other_texts_describe_nothing() {
        for odd in [
            "",
            "wide",
            "--stage=reach",
            "--preset=huge",
            "--preset=paper --step",
            "--preset=paper --grasps=grasps.toml",
            "--preset=paper --rolls=361",
            r#"{"version":2,"preset":"paper"}"#,
            r#"{"preset":"paper"}"#,
            r#"{"version":1,"preset":"paper","seed":3}"#,
            r#"{"version":1,"preset":"paper","views":4000000000}"#,
            r#"{"version":1,"preset":"paper","elevations_deg":[9,-9]}"#,
        ] {
            assert!(odd.parse::<PlanSpec>().is_err(), "{odd}");
        }
    }
}
