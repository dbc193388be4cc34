//! A robot hand as data: which of its grasps does for each human grasp, and how each is made.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::Deserialize;

use super::RobotError;
use super::finger::Finger;
use super::human::HumanGrasp;
use super::read::{Source, built_in, described, text};
use super::window::Window;

/// The hands that come with the program.
const BUILT_IN: [(&str, &str); 2] = [
    ("barrett", include_str!("../../data/robots/barrett.toml")),
    ("parallel-gripper", include_str!("../../data/robots/parallel-gripper.toml")),
];

/// The reach of a hand whose description names no fingers, in metres.
const ORDINARY_REACH: f64 = 0.20;

/// The palm's radius where a description has none, in metres.
fn ordinary_palm() -> f64 {
    0.045
}

/// A robot hand.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotHand {
    /// What `--robot` calls it.
    pub name: String,
    /// What it is.
    pub about: String,
    /// The model that simulates it, where there is one.
    pub model: Option<String>,
    /// The link that an arm carries: the parent of the hand.
    pub wrist_link: String,
    /// The middle of the palm's surface in the wrist's frame, in metres; both frames are turned
    /// alike.
    pub wrist_from_palm: [f64; 3],
    /// The palm's radius, in metres: it is taken for a cylinder from the wrist to its surface.
    #[serde(default = "ordinary_palm")]
    pub palm_radius: f64,
    /// The fingers; without them drawings show none, and none is looked for in the table.
    #[serde(default)]
    pub finger: Vec<Finger>,
    /// Links that may touch the object.
    pub touch_links: Vec<String>,
    /// In newtons.
    pub max_contact_force: f64,
    /// The way to the object, along the palm's z.
    pub approach: Way,
    /// The way from where it lay, up.
    pub retreat: Way,
    /// Every joint's least and greatest value, in radians (metres for a sliding one).
    pub limits: BTreeMap<String, [f64; 2]>,
    /// Human grasp to robot grasp.
    pub map: BTreeMap<String, String>,
    /// The robot's grasps.
    pub grasp: BTreeMap<String, RobotGrasp>,
}

/// A straight way.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Way {
    /// How long it should be, in metres.
    pub distance: f64,
    /// How long it must be, in metres.
    pub least: f64,
}

/// One of a robot hand's grasps.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotGrasp {
    /// What it is for.
    pub about: String,
    /// From the palm to the object's near side, in metres.
    pub standoff: Value,
    /// How far beside the palm's middle the object's should lie, toward the thumb, in metres.
    #[serde(default)]
    pub middle: Value,
    /// The least height of the palm above the table, in metres.
    pub table_clearance: f64,
    /// How far beside the palm's middle the closing tips go on lower where the palm is tilted, in
    /// metres.
    #[serde(default)]
    pub table_reach: f64,
    /// The widest object, in metres; without it any.
    pub widest: Option<f64>,
    /// Whether a finger's distal link closes on where its inner link is stopped.
    #[serde(default)]
    pub breakaway: bool,
    /// The posture on the way to the object.
    pub open: BTreeMap<String, Value>,
    /// The posture that closing aims at.
    pub closed: BTreeMap<String, Value>,
    /// What error the grasp tolerates, as it was simulated with objects of several widths.
    #[serde(default)]
    pub window: Vec<Window>,
}

/// A number, or one that depends on the object's width.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Whatever the width.
    Fixed(f64),
    /// Points of width (metres, ascending) and value, between which it is interpolated; constant
    /// beyond the ends.
    ByWidth(Vec<[f64; 2]>),
}

impl Default for Value {
    fn default() -> Self {
        Self::Fixed(0.0)
    }
}

impl Value {
    /// The value for an object of this width, in metres.
    pub fn at(&self, width: f64) -> f64 {
        match self {
            Self::Fixed(value) => *value,
            Self::ByWidth(points) => {
                let after = points.partition_point(|[at, _]| *at <= width);
                match (after.checked_sub(1).and_then(|before| points.get(before)), points.get(after)) {
                    (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (width - x0) / (x1 - x0),
                    (Some([_, only]), None) | (None, Some([_, only])) => *only,
                    (None, None) => 0.0,
                }
            }
        }
    }

    fn is_sound(&self) -> bool {
        match self {
            Self::Fixed(value) => value.is_finite(),
            Self::ByWidth(points) => {
                let ascends = points.windows(2).all(|pair| matches!(pair, [[a, _], [b, _]] if a < b));
                !points.is_empty() && ascends && points.iter().flatten().all(|value| value.is_finite())
            }
        }
    }

    fn values(&self) -> Vec<f64> {
        match self {
            Self::Fixed(value) => vec![*value],
            Self::ByWidth(points) => points.iter().map(|[_, value]| *value).collect(),
        }
    }
}

impl RobotHand {
    /// The hand of this name, or, where the name ends in `.toml`, the one that this file describes.
    ///
    /// # Errors
    /// [`RobotError::UnknownHand`], [`RobotError::Read`], [`RobotError::Format`].
    pub fn find(name: &str) -> Result<Self, RobotError> {
        match described(name) {
            Some(path) => Self::parse(name, &text(path)?),
            None => Self::built_in(name),
        }
    }

    /// The names of the hands that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// A hand that this program knows.
    ///
    /// # Errors
    /// Where it knows none of that name.
    pub fn built_in(name: &str) -> Result<Self, RobotError> {
        let text = built_in(&BUILT_IN, name)
            .map_err(|known| RobotError::UnknownHand { name: name.to_owned(), known })?;
        Self::parse(name, text)
    }

    /// Reads a description from memory; `name` stands for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Format`]: a joint beyond its limits or unknown, a mapping to a grasp that is
    /// not there.
    pub fn parse(name: &str, text: &str) -> Result<Self, RobotError> {
        let source = Source { name, what: "a robot hand" };
        let hand: Self = source.parse(text)?;
        hand.check(source)?;
        Ok(hand)
    }

    fn check(&self, source: Source<'_>) -> Result<(), RobotError> {
        source.position("wrist_from_palm", self.wrist_from_palm)?;
        source.length("max_contact_force", self.max_contact_force, 1e4)?;
        source.length("palm_radius", self.palm_radius, 1.0)?;
        if let Some(fault) = self.finger.iter().find_map(|finger| finger.fault(&self.limits)) {
            return Err(source.error(fault));
        }
        for (key, way) in [("approach", self.approach), ("retreat", self.retreat)] {
            source.length(&format!("{key}.least"), way.least, way.distance)?;
            source.length(&format!("{key}.distance"), way.distance, 1.0)?;
        }
        for (human, robot) in &self.map {
            if HumanGrasp::named(human).is_none() {
                let known = HumanGrasp::names().collect::<Vec<_>>().join(", ");
                return Err(source.error(format!("map.{human}: the human grasps are {known}")));
            }
            if !self.grasp.contains_key(robot) {
                return Err(source.error(format!(
                    "map.{human} = `{robot}`, which is not one of its grasps: they are {}",
                    self.grasp_names()
                )));
            }
        }
        self.grasp.iter().try_for_each(|(name, grasp)| self.check_grasp(source, name, grasp))
    }

    fn check_grasp(&self, source: Source<'_>, name: &str, grasp: &RobotGrasp) -> Result<(), RobotError> {
        let is_sound = grasp.standoff.is_sound()
            && grasp.middle.is_sound()
            && [grasp.table_clearance, grasp.table_reach].iter().all(|metres| (0.0..1.0).contains(metres));
        if !is_sound {
            return Err(source.error(format!(
                "grasp.{name}: standoff, middle, table_clearance and table_reach need metres, points with ascending widths"
            )));
        }
        for window in &grasp.window {
            let yaw = window.yaw_rad.map(|yaw| ("yaw_rad", yaw, PI));
            let tilt = window.tilt_rad.map(|tilt| ("tilt_rad", tilt, PI));
            let force = window.force_n.map(|force| ("force_n", force, 1e4));
            let lengths = [("position_m", window.position_m, 1.0), ("width_m", window.width_m, 1.0)];
            for (key, value, most) in lengths.into_iter().chain(yaw).chain(tilt).chain(force) {
                source.length(&format!("grasp.{name}.window.{key}"), value, most)?;
            }
        }
        for (posture, joints) in [("open", &grasp.open), ("closed", &grasp.closed)] {
            if joints.keys().ne(self.limits.keys()) {
                return Err(source.error(format!(
                    "grasp.{name}.{posture} must name every joint of [limits], and no other"
                )));
            }
            for (joint, value) in joints {
                let [least, most] = self.limits.get(joint).copied().unwrap_or_default();
                if !value.is_sound() || value.values().iter().any(|value| !(least..=most).contains(value)) {
                    return Err(source.error(format!(
                        "grasp.{name}.{posture}.{joint}: values must lie from {least} to {most}, and the widths of points must ascend"
                    )));
                }
            }
        }
        Ok(())
    }

    /// How far from the middle of the palm's surface a finger's tip may be, in metres.
    pub(super) fn reach(&self) -> f64 {
        let fingers = self.finger.iter().map(|finger| finger.reach(&self.limits));
        fingers.reduce(f64::max).unwrap_or(ORDINARY_REACH)
    }

    fn grasp_names(&self) -> String {
        self.grasp.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
    }

    /// The robot grasp that does for a human one, with its name.
    ///
    /// # Errors
    /// [`RobotError::Unmapped`].
    pub fn for_human(&self, grasp: &str) -> Result<(&str, &RobotGrasp), RobotError> {
        let name = self.map.get(grasp);
        let found = name.and_then(|name| Some((name.as_str(), self.grasp.get(name)?)));
        found.ok_or_else(|| RobotError::Unmapped { hand: self.name.clone(), grasp: grasp.to_owned() })
    }

    /// The grasp of this name.
    ///
    /// # Errors
    /// [`RobotError::UnknownGrasp`].
    pub fn grasp_named(&self, name: &str) -> Result<&RobotGrasp, RobotError> {
        self.grasp.get(name).ok_or_else(|| RobotError::UnknownGrasp {
            hand: self.name.clone(),
            grasp: name.to_owned(),
            known: self.grasp_names(),
        })
    }
}
