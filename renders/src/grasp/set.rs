//! Reading grasps from TOML.

use serde::Deserialize;

use super::definition::{Grasp, ObjectRange, Placement, StagePose};
use super::example::RawExample;
use super::fault::GraspFault;
use super::object::ObjectKind;
use super::posture::{RawPose, unit};
use crate::hand::Digit;

const BUILTIN: &str = include_str!("../../data/grasps.toml");

/// What is wrong with a set of grasps.
#[derive(Debug, thiserror::Error)]
pub enum GraspSetError {
    /// Not TOML, or a key that is missing, unknown or of the wrong kind.
    #[error("the grasps cannot be parsed")]
    Syntax(#[from] toml::de::Error),
    /// A value that cannot be.
    #[error("grasp `{grasp}`: {fault}")]
    Value {
        /// The grasp's name.
        grasp: String,
        /// What is wrong and what would be right.
        fault: GraspFault,
    },
    /// A set without a grasp.
    #[error("there is no [[grasp]] in the file")]
    Empty,
}

/// A set of grasps.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspSet {
    grasps: Vec<Grasp>,
}

impl GraspSet {
    /// The six grasps of the method, in the order of Cutkosky's numbers.
    pub fn builtin() -> GraspSet {
        GraspSet::parse(BUILTIN).expect("data/grasps.toml is checked by a test")
    }

    /// Reads a set from TOML text; `data/grasps.toml` documents the keys.
    ///
    /// # Errors
    ///
    /// When the text is not TOML, has an unknown or missing key, or a value that cannot be: an
    /// angle out of the joint's limits, an empty range, a name given twice.
    pub fn parse(text: &str) -> Result<GraspSet, GraspSetError> {
        let grasps = grasps(text)?;
        for (at, grasp) in grasps.iter().enumerate() {
            if grasps[..at].iter().any(|g| g.name == grasp.name || g.cutkosky == grasp.cutkosky) {
                let grasp = grasp.name.clone();
                return Err(GraspSetError::Value { grasp, fault: GraspFault::Taken });
            }
        }
        if grasps.is_empty() {
            return Err(GraspSetError::Empty);
        }
        Ok(GraspSet { grasps })
    }

    /// The grasp of this name.
    pub fn get(&self, name: &str) -> Option<&Grasp> {
        self.grasps.iter().find(|grasp| grasp.name == name)
    }

    /// All grasps.
    pub fn iter(&self) -> std::slice::Iter<'_, Grasp> {
        self.grasps.iter()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.grasps.len()
    }

    /// Whether there is none; never true for a set that was read.
    pub fn is_empty(&self) -> bool {
        self.grasps.is_empty()
    }
}

impl<'a> IntoIterator for &'a GraspSet {
    type Item = &'a Grasp;
    type IntoIter = std::slice::Iter<'a, Grasp>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// The grasps of a file, in their order, two of one name among them perhaps.
pub(super) fn grasps(text: &str) -> Result<Vec<Grasp>, GraspSetError> {
    let file: File = toml::from_str(text)?;
    let check = |raw: RawGrasp| {
        raw.check(file.stages, &file.relaxed)
            .map_err(|fault| GraspSetError::Value { grasp: raw.name.clone(), fault })
    };
    file.grasp.into_iter().map(check).collect()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    stages: Stages,
    relaxed: RawPose,
    grasp: Vec<RawGrasp>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct Stages {
    reach: StagePose,
    close: StagePose,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGrasp {
    name: String,
    cutkosky: u8,
    about: String,
    up: [f64; 3],
    touch: Vec<Digit>,
    #[serde(default)]
    follow: Vec<Digit>,
    object: RawObject,
    open: RawPose,
    closed: RawPose,
    #[serde(default)]
    example: Vec<RawExample>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawObject {
    kind: ObjectKind,
    radius: [f64; 2],
    length: Option<[f64; 2]>,
    axis: [f64; 3],
    place: RawPlace,
    anchor: Option<[f64; 2]>,
    push: Option<[f64; 3]>,
    between: Option<Vec<Digit>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum RawPlace {
    Palm,
    Tips,
}

impl RawGrasp {
    fn check(&self, stages: Stages, relaxed: &RawPose) -> Result<Grasp, GraspFault> {
        let fit = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if self.name.is_empty() || !self.name.chars().all(fit) {
            return Err(GraspFault::Name);
        }
        for (name, stage) in [("reach", stages.reach), ("close", stages.close)] {
            if !(0.0..=1.0).contains(&stage.closure) || !(0.0..=0.5).contains(&stage.away) {
                return Err(GraspFault::Stage(name));
            }
        }
        if self.touch.is_empty() {
            return Err(GraspFault::NothingTouches);
        }
        if self.follow.iter().any(|d| self.touch.contains(d) || *d <= Digit::Index) {
            return Err(GraspFault::Follow);
        }
        Ok(Grasp {
            name: self.name.clone(),
            cutkosky: self.cutkosky,
            about: self.about.clone(),
            up: unit("up", self.up)?,
            touch: self.touch.clone(),
            follow: self.follow.clone(),
            relaxed: relaxed.check("relaxed")?,
            object: self.object.check()?,
            open: self.open.check("open")?,
            closed: self.closed.check("closed")?,
            stages: [stages.reach, stages.close],
            examples: self.example.iter().map(|e| e.check(self.object.kind)).collect::<Result<_, _>>()?,
        })
    }
}

impl RawObject {
    fn check(&self) -> Result<ObjectRange, GraspFault> {
        let length = match (self.kind, self.length) {
            (ObjectKind::Sphere, None) => [0.0, 0.0],
            (ObjectKind::Sphere, Some(_)) => return Err(GraspFault::SphereWithLength),
            (_, Some(length)) => range("length", length)?,
            (_, None) => return Err(GraspFault::NoLength),
        };
        let placement = match (self.place, self.anchor, self.push, &self.between) {
            (RawPlace::Palm, Some(anchor), Some(push), None) => {
                if !anchor.iter().all(|a| (-2.0..=2.0).contains(a)) {
                    return Err(GraspFault::Anchor);
                }
                Placement::Palm { anchor, push: unit("push", push)? }
            }
            (RawPlace::Palm, ..) => {
                return Err(GraspFault::Palm);
            }
            (RawPlace::Tips, None, None, Some(between)) => {
                if between.is_empty() || between.contains(&Digit::Thumb) {
                    return Err(GraspFault::Between);
                }
                Placement::Tips { between: between.clone() }
            }
            (RawPlace::Tips, ..) => {
                return Err(GraspFault::Tips);
            }
        };
        Ok(ObjectRange {
            kind: self.kind,
            radius: range("radius", self.radius)?,
            length,
            axis: unit("axis", self.axis)?,
            placement,
        })
    }
}

fn range(key: &'static str, [low, high]: [f64; 2]) -> Result<[f64; 2], GraspFault> {
    if low >= 0.001 && low <= high && high <= 0.5 {
        Ok([low, high])
    } else {
        Err(GraspFault::Range { key, low, high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(from: &str, to: &str) -> String {
        assert!(BUILTIN.contains(from));
        let error = GraspSet::parse(&BUILTIN.replacen(from, to, 1)).expect_err("broken");
        let cause = std::error::Error::source(&error).map(|cause| format!(": {cause}"));
        format!("{error}{}", cause.unwrap_or_default())
    }

    #[test]
    fn the_six_grasps_are_there() {
        let numbers: Vec<u8> = GraspSet::builtin().iter().map(|g| g.cutkosky).collect();
        assert_eq!(numbers, [1, 2, 4, 9, 10, 12]);
    }

    #[test]
    fn mistakes_are_told_plainly() {
        let typo = broken("\ntouch = [", "\ntuoch = [");
        assert!(typo.contains("unknown field `tuoch`, expected one of `name`"), "{typo}");
        insta::assert_snapshot!(broken("index = [7, 12, 18, 10]", "index = [7, 12, 180, 10]"), @"grasp `large-diameter`: open.index: middle is 180 degrees, but that joint goes from -5 to 112");
        insta::assert_snapshot!(broken("radius = [0.028, 0.046]", "radius = [0.046, 0.028]"), @"grasp `large-diameter`: radius must be [smallest, largest] in metres, from 0.001 to 0.5; it is [0.046, 0.028]");
        insta::assert_snapshot!(broken("cutkosky = 2", "cutkosky = 1"), @"grasp `small-diameter`: its name or its number is taken by another grasp");
        insta::assert_snapshot!(broken("\nplace = \"palm\"", "\nplace = \"tips\""), @r#"grasp `large-diameter`: place = "tips" needs between and nothing else"#);
        insta::assert_snapshot!(broken("up = [0.0, 1.0, 0.0]", "up = [0.0, 0.0, 0.0]"), @"grasp `large-diameter`: up has no direction: it needs three numbers that are not all 0");
        insta::assert_snapshot!(broken("name = \"large-diameter\"", "name = \"\""), @"grasp ``: its name becomes a folder's: use a-z, 0-9 and -");
        insta::assert_snapshot!(broken("closure = 0.25", "closure = 1.01"), @"grasp `large-diameter`: stage reach: closure must lie in 0..1 and away in 0..0.5 m");
        insta::assert_snapshot!(broken("away = 0.020", "away = -0.01"), @"grasp `large-diameter`: stage close: closure must lie in 0..1 and away in 0..0.5 m");
        insta::assert_snapshot!(broken("\ntouch = [\"thumb\", \"index\", \"middle\", \"ring\", \"little\"]", "\ntouch = []"), @"grasp `large-diameter`: touch names no digit");
        insta::assert_snapshot!(broken("\n[grasp.object]", "\nfollow = [\"ring\"]\n[grasp.object]"), @"grasp `large-diameter`: follow names fingers after the index that are not in touch");
        insta::assert_snapshot!(broken("anchor = [0.80, 0.00]", "anchor = [0.80, 2.01]"), @"grasp `large-diameter`: anchor is given in shares of the palm: -2 to 2");
        insta::assert_snapshot!(broken("radius = [0.028, 0.046]", "radius = [0.0009, 0.046]"), @"grasp `large-diameter`: radius must be [smallest, largest] in metres, from 0.001 to 0.5; it is [0.0009, 0.046]");
        insta::assert_snapshot!(broken("length = [0.12, 0.18]", "length = [0.12, 0.51]"), @"grasp `large-diameter`: length must be [smallest, largest] in metres, from 0.001 to 0.5; it is [0.12, 0.51]");
        insta::assert_snapshot!(broken("\nbetween = [\"index\"]", "\nbetween = [\"thumb\"]"), @"grasp `pinch`: between names the fingers opposite to the thumb");
        insta::assert_snapshot!(broken("\nbetween = [\"index\"]", "\nbetween = []"), @"grasp `pinch`: between names the fingers opposite to the thumb");
        insta::assert_snapshot!(broken("centre = [0.119, -0.004, -0.158]", "centre = [0.119, -0.004, -0.51]"), @"grasp `large-diameter`: example: the object's centre lies within half a metre of the wrist");
        insta::assert_snapshot!(broken("object = { radius = 0.037", "object = { radius = 0.51"), @"grasp `large-diameter`: example: the object's radius is 0.51; 0.001 to 0.5 m is supported");
        let none = BUILTIN.split("\n[[grasp]]").next().expect("what comes first");
        insta::assert_snapshot!(GraspSet::parse(&format!("grasp = []\n{none}")).expect_err("no grasp"), @"there is no [[grasp]] in the file");
        insta::assert_snapshot!(broken("name = \"large-diameter\"", "name = \"../up\""), @"grasp `../up`: its name becomes a folder's: use a-z, 0-9 and -");
    }
}
