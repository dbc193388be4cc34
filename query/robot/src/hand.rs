//! A robot hand as data: which of its grasps does for each human grasp, and how each is made.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use serde::Deserialize;

use super::chain::Chain;
use super::finger::Finger;
use super::human::HumanGrasp;
use super::object::LARGEST;
use super::read::{Source, built_in, text};
use super::urdf;
use super::window::Window;
use super::{DescriptionFault, RobotError};

/// The hands that come with the program.
const BUILT_IN: [(&str, &str); 5] = [
    ("allegro", include_str!("../../data/robots/allegro.toml")),
    ("barrett", include_str!("../../data/robots/barrett.toml")),
    ("franka-hand", include_str!("../../data/robots/franka-hand.toml")),
    ("parallel-gripper", include_str!("../../data/robots/parallel-gripper.toml")),
    ("robotiq-2f-85", include_str!("../../data/robots/robotiq-2f-85.toml")),
];

/// How far from 0 a hand's joint may be, in radians (metres where it slides): two turns, as of an
/// arm's.
const FARTHEST_JOINT: f64 = 4.0 * PI;

/// The least height of the palm's cylinder, in metres, for hands whose wrist lies in the palm's
/// surface.
const THINNEST_PALM: f64 = 0.01;

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
    /// The middle of the palm's surface in the wrist's frame, in metres.
    pub wrist_from_palm: [f64; 3],
    /// How the palm is turned there, as a unit quaternion x, y, z, w; without it both frames are
    /// turned alike.
    pub wrist_from_palm_xyzw: Option<[f64; 4]>,
    /// The palm's radius, in metres: it is taken for a cylinder that ends in its surface.
    #[serde(default = "ordinary_palm")]
    pub palm_radius: f64,
    /// How high that cylinder is, in metres; without it, it begins at the height of the wrist.
    pub palm_height: Option<f64>,
    /// Fingers that bend in a plane; without any finger drawings show none, and none is looked for
    /// in the table.
    #[serde(default)]
    pub finger: Vec<Finger>,
    /// Fingers whose joints may lie in any arrangement.
    #[serde(default)]
    pub chain: Vec<Chain>,
    /// Links that may touch the object.
    pub touch_links: Vec<String>,
    /// In newtons.
    pub max_contact_force: f64,
    /// The way to the object, along the palm's z.
    pub approach: Travel,
    /// The way from where it lay, up.
    pub retreat: Travel,
    /// Every joint's least and greatest value, in radians (metres for a sliding one).
    pub limits: BTreeMap<String, [f64; 2]>,
    /// Human grasp to robot grasp.
    pub map: BTreeMap<String, String>,
    /// Human grasps that the hand cannot imitate: what it does instead, for a person.
    #[serde(default)]
    pub instead: BTreeMap<String, String>,
    /// The robot's grasps.
    pub grasp: BTreeMap<String, RobotGrasp>,
}

/// A straight way.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Travel {
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
    /// From the palm to the object's near side, in metres: to where a line along the approach
    /// through its middle meets it.
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
    /// The widest object, in metres; without it any that goes between the open fingers.
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
    /// The hand of this name, or, where the name ends in `.toml` or `.urdf`, the one that this file
    /// describes; see [`RobotHand::description`].
    ///
    /// # Errors
    /// [`RobotError::UnknownHand`], [`RobotError::Read`], [`RobotError::Format`],
    /// [`RobotError::NoCompanion`].
    pub fn find(name: &str) -> Result<Self, RobotError> {
        match Self::description(name)? {
            Some(text) => Self::parse(name, &text),
            None => Self::built_in(name),
        }
    }

    /// The description of a hand that is a file, as [`RobotHand::parse`] reads it: that file where
    /// its name ends in `.toml`. Where it ends in `.urdf`, what the URDF says, with what the file
    /// beside it that ends in `.toml` adds to it. `None` for any other name.
    ///
    /// # Errors
    /// [`RobotError::Read`], [`RobotError::Format`], [`RobotError::NoCompanion`].
    pub fn description(name: &str) -> Result<Option<String>, RobotError> {
        let path = Path::new(name);
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("toml") => text(path).map(Some),
            Some("urdf") => urdf::description(path).map(Some),
            _ => Ok(None),
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
        let known = || Self::names().collect::<Vec<_>>().join(", ");
        let text = built_in(&BUILT_IN, name)
            .ok_or_else(|| RobotError::UnknownHand { name: name.to_owned(), known: known() })?;
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
        if let Some(xyzw) = self.wrist_from_palm_xyzw {
            source.rotation("wrist_from_palm_xyzw", xyzw)?;
        }
        if let Some(height) = self.palm_height {
            source.length("palm_height", height, 1.0)?;
        }
        source.length("max_contact_force", self.max_contact_force, 1e4)?;
        source.length("palm_radius", self.palm_radius, 1.0)?;
        if let Some(fault) = self.finger.iter().find_map(|finger| finger.fault(&self.limits)) {
            return Err(source.error(fault));
        }
        if let Some(fault) = self.chain.iter().find_map(|chain| chain.fault(&self.limits)) {
            return Err(source.error(fault));
        }
        let is_range =
            |[low, high]: [f64; 2]| low <= high && low >= -FARTHEST_JOINT && high <= FARTHEST_JOINT;
        if let Some((joint, ends)) = self.limits.iter().find(|(_, ends)| !is_range(**ends)) {
            let (joint, ends, most) = (joint.clone(), *ends, FARTHEST_JOINT);
            return Err(source.error(DescriptionFault::Range { joint, ends, most }));
        }
        // The distance first: it is what the least way is measured by.
        for (key, way) in [("approach", self.approach), ("retreat", self.retreat)] {
            source.length(&format!("{key}.distance"), way.distance, 1.0)?;
            source.length(&format!("{key}.least"), way.least, way.distance)?;
        }
        let humans = self.map.keys().map(|human| ("map", human));
        for (table, human) in humans.chain(self.instead.keys().map(|human| ("instead", human))) {
            if HumanGrasp::named(human).is_none() {
                let known = HumanGrasp::names().collect::<Vec<_>>().join(", ");
                let human = human.clone();
                return Err(source.error(DescriptionFault::HumanGrasp { table, human, known }));
            }
        }
        for (human, robot) in &self.map {
            if !self.grasp.contains_key(robot) {
                let (human, robot) = (human.clone(), robot.clone());
                let known = self.grasp_names();
                return Err(source.error(DescriptionFault::NoSuchGrasp { human, robot, known }));
            }
        }
        self.grasp.iter().try_for_each(|(name, grasp)| self.check_grasp(source, name, grasp))
    }

    fn check_grasp(&self, source: Source<'_>, name: &str, grasp: &RobotGrasp) -> Result<(), RobotError> {
        let is_sound = grasp.standoff.is_sound()
            && grasp.middle.is_sound()
            && [grasp.table_clearance, grasp.table_reach].iter().all(|metres| (0.0..1.0).contains(metres));
        if !is_sound {
            return Err(source.error(DescriptionFault::Distances(name.to_owned())));
        }
        if let Some(widest) = grasp.widest {
            source.length(&format!("grasp.{name}.widest"), widest, LARGEST)?;
        }
        for window in &grasp.window {
            let yaw = window.yaw_rad.map(|yaw| ("yaw_rad", yaw, PI));
            let tilt = window.tilt_rad.map(|tilt| ("tilt_rad", tilt, PI));
            let roll = window.roll_rad.map(|roll| ("roll_rad", roll, PI));
            let force = window.force_n.map(|force| ("force_n", force, 1e4));
            let lengths = [("position_m", window.position_m, 1.0), ("width_m", window.width_m, 1.0)];
            for (key, value, most) in lengths.into_iter().chain(yaw).chain(tilt).chain(roll).chain(force) {
                source.length(&format!("grasp.{name}.window.{key}"), value, most)?;
            }
        }
        for (posture, joints) in [("open", &grasp.open), ("closed", &grasp.closed)] {
            if joints.keys().ne(self.limits.keys()) {
                return Err(source.error(DescriptionFault::Posture { grasp: name.to_owned(), posture }));
            }
            for (joint, value) in joints {
                let [least, most] = self.limits.get(joint).copied().unwrap_or_default();
                if !value.is_sound() || value.values().iter().any(|value| !(least..=most).contains(value)) {
                    let (grasp, joint) = (name.to_owned(), joint.clone());
                    let fault = DescriptionFault::Joint { grasp, posture, joint, least, most };
                    return Err(source.error(fault));
                }
            }
        }
        Ok(())
    }

    /// The palm in the wrist's frame.
    pub(super) fn wrist_from_palm(&self) -> Isometry3<f64> {
        let [x, y, z, w] = self.wrist_from_palm_xyzw.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let turned = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(self.wrist_from_palm), turned)
    }

    /// How high the palm's cylinder is, in metres.
    pub(super) fn palm_height(&self) -> f64 {
        self.palm_height.unwrap_or(self.wrist_from_palm[2]).max(THINNEST_PALM)
    }

    /// Each finger's middle line in the palm's frame, from the palm to its tip, its joints being as
    /// `posture` says.
    pub fn fingers(&self, posture: &BTreeMap<String, f64>) -> Vec<Vec<Point3<f64>>> {
        let palm_from_wrist = self.wrist_from_palm().inverse();
        let in_palm = |chain: &Chain| {
            chain.points(posture).iter().map(|point| palm_from_wrist * point).collect::<Vec<_>>()
        };
        let planar = self.finger.iter().map(|finger| finger.points(posture));
        planar.chain(self.chain.iter().map(in_palm)).collect()
    }

    /// Other hands that come with the program and take an object as wide as `width`, in metres,
    /// where a human grasps it so. All of their grasps say how wide: a test sees to it.
    pub(super) fn that_open_wider(&self, human: &str, width: f64) -> Vec<&'static str> {
        let takes = |name: &&str| {
            let Ok(hand) = Self::built_in(name) else { return false };
            let is_taken =
                |(_, grasp): (&str, &RobotGrasp)| grasp.widest.is_some_and(|widest| width <= widest);
            hand.name != self.name && hand.for_human(human).is_ok_and(is_taken)
        };
        Self::names().filter(takes).collect()
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
