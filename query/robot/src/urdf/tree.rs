//! The links and joints of a URDF.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;
use toml::{Table, Value};
use urdf_rs::{Joint, JointType, Robot};

use super::markup;
use super::values::numbers;
use crate::chain::{Segment, frames};
use crate::object::LARGEST;
use crate::read::Source;
use crate::{RobotError, UrdfFault};

/// A hand has fewer joints and links.
const MOST: usize = 1000;
/// How far from 0 a finger's joint may be, in radians: two turns.
const MOST_TURN: f64 = 4.0 * std::f64::consts::PI;
/// How far from 0 a finger may slide, in metres: half of the largest object.
const MOST_SLIDE: f64 = 0.5 * LARGEST;

/// A robot whose every link but one has a parent.
pub(super) struct Tree {
    robot: Robot,
    /// The joint above each link.
    above: BTreeMap<String, usize>,
    root: String,
}

/// The joints from the wrist to a tip, by their places in the URDF.
pub(super) type Way = Vec<usize>;

impl Tree {
    pub(super) fn parse(source: Source<'_>, text: &str) -> Result<Self, RobotError> {
        // What xacro is still to expand is no URDF, and would be read as one without joints.
        let elements = text.split("-->").filter_map(|part| part.split("<!--").next());
        if elements.into_iter().any(|part| part.contains("<xacro:")) {
            return Err(source.error(UrdfFault::Xacro.into()));
        }
        if let Some(fault) = markup::fault(text) {
            return Err(source.error(fault.into()));
        }
        let robot = urdf_rs::read_from_string(text)
            .map_err(|error| source.error(UrdfFault::Parser(error.to_string()).into()))?;
        if robot.joints.len() > MOST || robot.links.len() > MOST {
            return Err(source.error(UrdfFault::TooMany { most: MOST }.into()));
        }
        let mut above = BTreeMap::new();
        for (at, joint) in robot.joints.iter().enumerate() {
            if above.insert(joint.child.link.clone(), at).is_some() {
                return Err(source.error(UrdfFault::CarriedTwice(joint.child.link.clone()).into()));
            }
        }
        let mut roots = robot.links.iter().filter(|link| !above.contains_key(&link.name));
        let root = match (roots.next(), roots.next()) {
            (Some(root), None) => root.name.clone(),
            (None, _) => return Err(source.error(UrdfFault::NoRoot.into())),
            (Some(one), Some(other)) => {
                let (one, other) = (one.name.clone(), other.name.clone());
                return Err(source.error(UrdfFault::TwoRoots { one, other }.into()));
            }
        };
        let tree = Self { robot, above, root };
        tree.check(source)?;
        Ok(tree)
    }

    /// Followed joints must exist, and follow none themselves.
    fn check(&self, source: Source<'_>) -> Result<(), RobotError> {
        for joint in &self.robot.joints {
            let Some(mimic) = &joint.mimic else { continue };
            let (name, leader) = (joint.name.clone(), mimic.joint.clone());
            let fault = match self.robot.joints.iter().find(|other| other.name == mimic.joint) {
                None => UrdfFault::NoLeader { joint: name, leader },
                Some(found) if found.mimic.is_some() => UrdfFault::LeaderFollows { joint: name, leader },
                Some(_) => continue,
            };
            return Err(source.error(fault.into()));
        }
        Ok(())
    }

    pub(super) fn name(&self) -> &str {
        &self.robot.name
    }

    pub(super) fn root(&self) -> &str {
        &self.root
    }

    /// The links that carry no others.
    pub(super) fn leaves(&self) -> Vec<&str> {
        let parents: BTreeSet<&str> =
            self.robot.joints.iter().map(|joint| joint.parent.link.as_str()).collect();
        let links = self.robot.links.iter().map(|link| link.name.as_str());
        links.filter(|link| !parents.contains(link)).collect()
    }

    /// The joints between two links.
    pub(super) fn chain(&self, source: Source<'_>, from: &str, to: &str) -> Result<Way, RobotError> {
        let mut way = Vec::new();
        let mut link = to;
        while link != from {
            let Some(&at) = self.above.get(link) else {
                let is_there = self.robot.links.iter().any(|other| other.name == to);
                let links: Vec<&str> = self.robot.links.iter().map(|link| link.name.as_str()).collect();
                let fault = if is_there && links.contains(&from) {
                    UrdfFault::Apart { from: from.to_owned(), to: to.to_owned() }
                } else {
                    let link = if is_there { from } else { to }.to_owned();
                    UrdfFault::NoLink { link, known: links.join(", ") }
                };
                return Err(source.error(fault.into()));
            };
            way.push(at);
            // As many joints as there are, or it runs in a circle.
            if way.len() > self.robot.joints.len() {
                return Err(source.error(UrdfFault::Circle(to.to_owned()).into()));
            }
            link = self.robot.joints.get(at).map_or(from, |joint| joint.parent.link.as_str());
        }
        way.reverse();
        Ok(way)
    }

    /// The place of one link in another's frame, all joints being at 0.
    pub(super) fn pose(
        &self,
        source: Source<'_>,
        from: &str,
        to: &str,
    ) -> Result<Isometry3<f64>, RobotError> {
        let segments = self.segments(&self.chain(source, from, to)?);
        Ok(frames(&segments, |_| 0.0).last().copied().unwrap_or_else(Isometry3::identity))
    }

    fn joints<'a>(&'a self, way: &'a Way) -> impl Iterator<Item = &'a Joint> {
        way.iter().filter_map(|at| self.robot.joints.get(*at))
    }

    /// The segments of a way.
    pub(super) fn segments(&self, way: &Way) -> Vec<Segment> {
        self.joints(way).map(segment).collect()
    }

    /// The joints of some ways that move by themselves, with their least and greatest values: as
    /// far as those that follow them can.
    pub(super) fn limits(
        &self,
        source: Source<'_>,
        ways: &[Way],
    ) -> Result<BTreeMap<String, [f64; 2]>, RobotError> {
        let mut limits = BTreeMap::new();
        for joint in ways.iter().flat_map(|way| self.joints(way)) {
            let leader = match &joint.mimic {
                Some(mimic) => self.robot.joints.iter().find(|other| other.name == mimic.joint),
                None => Some(joint),
            };
            let Some(leader) = leader.filter(|_| moves(joint)) else { continue };
            if !limits.contains_key(&leader.name) {
                limits.insert(leader.name.clone(), self.common_limits(source, leader)?);
            }
        }
        Ok(limits)
    }

    /// A joint's least and greatest value, cut to what those allow that follow it.
    fn common_limits(&self, source: Source<'_>, leader: &Joint) -> Result<[f64; 2], RobotError> {
        let [mut low, mut high] = own_limits(source, leader)?;
        for follower in self.robot.joints.iter().filter(|joint| moves(joint)) {
            let Some(mimic) = follower.mimic.as_ref().filter(|mimic| mimic.joint == leader.name) else {
                continue;
            };
            // Without a <limit>, which a parser reads as two zeros, a follower says nothing.
            let says = follower.limit.lower != 0.0 || follower.limit.upper != 0.0;
            let factor = mimic.multiplier.unwrap_or(1.0);
            if !says || factor == 0.0 || follower.joint_type == JointType::Continuous {
                continue;
            }
            let plus = mimic.offset.unwrap_or(0.0);
            let ends = own_limits(source, follower)?.map(|end| (end - plus) / factor);
            let cut = [low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1]))];
            // Descriptions of real grippers copy a leader's limits to followers that turn the other
            // way. Limits that leave nothing contradict the <mimic>, and say nothing.
            if cut[0] < cut[1] {
                [low, high] = cut;
            }
        }
        Ok([low, high])
    }

    /// The links of some ways that joints carry which move.
    pub(super) fn links_of(&self, ways: &[Way]) -> Vec<String> {
        let mut links = BTreeSet::new();
        for way in ways {
            let moved = self.joints(way).skip_while(|joint| !moves(joint));
            links.extend(moved.map(|joint| joint.child.link.clone()));
        }
        links.into_iter().collect()
    }

    /// A way as a HAND.toml has it.
    pub(super) fn table(&self, way: &Way) -> Value {
        let segment = |joint: &Joint| {
            let Segment { at, rpy, joint, axis, slides, factor, plus } = segment(joint);
            let mut table = Table::new();
            let mut set = |key: &str, value: Value| {
                table.insert(key.to_owned(), value);
            };
            set("at", numbers(at));
            set("rpy", numbers(rpy));
            if let Some(joint) = joint {
                set("joint", joint.into());
                set("axis", numbers(axis));
                set("slides", slides.into());
                set("factor", factor.into());
                set("plus", plus.into());
            }
            Value::Table(table)
        };
        let segments = self.joints(way).map(segment).collect();
        Value::Table([("segments".to_owned(), Value::Array(segments))].into_iter().collect())
    }
}

/// What a joint's own <limit> says.
fn own_limits(source: Source<'_>, joint: &Joint) -> Result<[f64; 2], RobotError> {
    let ([low, high], most) = match joint.joint_type {
        JointType::Continuous => return Ok([-std::f64::consts::PI, std::f64::consts::PI]),
        JointType::Revolute => ([joint.limit.lower, joint.limit.upper], MOST_TURN),
        JointType::Prismatic => ([joint.limit.lower, joint.limit.upper], MOST_SLIDE),
        _ => return Err(source.error(UrdfFault::Kind(joint.name.clone()).into())),
    };
    // What is not a number is in no range.
    if low < high && low >= -most && high <= most {
        return Ok([low, high]);
    }
    let (joint, most_turn, most_slide) = (joint.name.clone(), MOST_TURN, MOST_SLIDE);
    Err(source.error(UrdfFault::Limits { joint, low, high, most_turn, most_slide }.into()))
}

fn moves(joint: &Joint) -> bool {
    joint.joint_type != JointType::Fixed
}

fn segment(joint: &Joint) -> Segment {
    let mimic = joint.mimic.as_ref();
    let leader = mimic.map_or(&joint.name, |mimic| &mimic.joint);
    Segment {
        at: *joint.origin.xyz,
        rpy: *joint.origin.rpy,
        joint: moves(joint).then(|| leader.clone()),
        axis: *joint.axis.xyz,
        slides: joint.joint_type == JointType::Prismatic,
        factor: mimic.and_then(|mimic| mimic.multiplier).unwrap_or(1.0),
        plus: mimic.and_then(|mimic| mimic.offset).unwrap_or(0.0),
    }
}
