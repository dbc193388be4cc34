//! How a gripper with one joint grasps, by where its tips go: nobody has to write that down.

use nalgebra::{Isometry3, Point3};
use toml::{Table, Value};

use super::tree::{Tree, Way};
use super::values::numbers;
use crate::chain::{Segment, frames};
use crate::human::HumanGrasp;
use crate::object::LARGEST;
use crate::read::Source;
use crate::{RobotError, UrdfFault};

/// The joint's range is divided into this many parts to see how the tips move.
const PARTS: u32 = 200;
/// How much more than the object the tips open, in metres, where they can.
const ROOM: f64 = 0.02;
/// By how much less than the tips open an object must be, in metres.
const CLEAR: f64 = 0.005;
/// A gripper whose tips open by less, in metres, grasps nothing.
const LEAST: f64 = 0.01;
/// Between two points of the posture by the object's width, in metres.
const STEP: f64 = 0.01;
/// What lies less beside the palm's middle, in metres, is a rounding.
const ASIDE: f64 = 1e-5;
/// How far beyond the tips' frames the table must stay, in metres.
const ABOVE_TABLE: f64 = 0.02;

/// The fingers of a gripper.
pub(super) struct Gripper {
    chains: Vec<Vec<Segment>>,
    palm_from_wrist: Isometry3<f64>,
    pad: f64,
}

/// Where the tips are at a value of the joint.
#[derive(Clone, Copy)]
struct Opening {
    joint: f64,
    /// Between the pads, across what is grasped, in metres.
    wide: f64,
    /// Its middle beside the palm's, toward the thumb's side, in metres.
    middle: f64,
    /// How far the tips are from the palm along the approach, in metres.
    deep: f64,
}

impl Gripper {
    pub(super) fn new(tree: &Tree, ways: &[Way], palm: &Isometry3<f64>, pad: f64) -> Self {
        let chains = ways.iter().map(|way| tree.segments(way)).collect();
        Self { chains, palm_from_wrist: palm.inverse(), pad }
    }

    fn opening(&self, joint: f64) -> Opening {
        let tips: Vec<Point3<f64>> = self
            .chains
            .iter()
            .filter_map(|chain| frames(chain, |_| joint).last().map(|tip| tip.translation.vector.into()))
            .map(|tip: Point3<f64>| self.palm_from_wrist * tip)
            .collect();
        // The thumb's side against the other one.
        let least = |side: f64| tips.iter().map(|tip| side * tip.y).fold(f64::NEG_INFINITY, f64::max);
        let [thumb, other] = [least(1.0), least(-1.0)];
        let (wide, middle) = (thumb + other - 2.0 * self.pad, 0.5 * (thumb - other));
        let deep = tips.iter().map(|tip| tip.z).sum::<f64>() / tips.len().max(1) as f64;
        Opening { joint, wide, middle, deep }
    }

    /// `[map]` and `[grasp]` of a gripper whose only joint moves between `ends`.
    pub(super) fn grasp(
        &self,
        source: Source<'_>,
        joint: &str,
        [low, high]: [f64; 2],
    ) -> Result<(Value, Value), RobotError> {
        let along = |part: u32| low + (high - low) * f64::from(part) / f64::from(PARTS);
        let openings: Vec<Opening> = (0..=PARTS).map(|part| self.opening(along(part))).collect();
        let openings = ever_wider(&openings);
        let (Some(shut), Some(widest)) = (openings.first().copied(), openings.last().copied()) else {
            return Err(
                source.error(UrdfFault::Opening { joint: joint.to_owned(), shut: 0.0, widest: 0.0 }.into())
            );
        };
        if widest.wide - shut.wide.max(0.0) < LEAST || widest.wide < LEAST + CLEAR {
            let (shut, widest) = (shut.wide, widest.wide);
            return Err(source.error(UrdfFault::Opening { joint: joint.to_owned(), shut, widest }.into()));
        }
        // The first opening of at least a width, or the widest.
        let wide = |width: f64| {
            let at = openings.partition_point(|opening| opening.wide < width);
            openings.get(at).copied().unwrap_or(widest)
        };
        // A joint may have limits far beyond any object.
        let largest = (widest.wide - CLEAR).min(LARGEST);
        let steps = (largest / STEP).floor().max(1.0) as u32;
        let widths: Vec<f64> = (0..=steps).map(|step| f64::from(step) * STEP).collect();
        let by_width = |value: &dyn Fn(f64) -> f64| {
            Value::Array(widths.iter().map(|width| numbers([*width, value(*width)])).collect())
        };
        let deepest = openings.iter().map(|opening| opening.deep).fold(0.0, f64::max);
        let posture = |value: Value| Value::Table([(joint.to_owned(), value)].into_iter().collect());
        let mut grasp = Table::new();
        let mut set = |key: &str, value: Value| {
            grasp.insert(key.to_owned(), value);
        };
        set("about", "the object's middle between the tips".into());
        // A round object's middle between the tips, where that is before the palm.
        set("standoff", by_width(&|width| (wide(width).deep - 0.5 * width).max(CLEAR)));
        // Between the open tips, so that neither meets the object on the way to it: those that do
        // not move alike push it to where they meet.
        if openings.iter().any(|opening| opening.middle.abs() > ASIDE) {
            set("middle", by_width(&|width| wide(width + ROOM).middle));
        }
        set("table_clearance", (deepest + ABOVE_TABLE).clamp(0.0, 0.999).into());
        set("widest", largest.into());
        set("open", posture(by_width(&|width| wide(width + ROOM).joint)));
        set("closed", posture(shut.joint.into()));
        let map = HumanGrasp::names().map(|human| (human.to_owned(), "parallel".into())).collect();
        let grasps = [("parallel".to_owned(), Value::Table(grasp))].into_iter().collect();
        Ok((Value::Table(map), Value::Table(grasps)))
    }
}

/// The openings on the way from where a gripper is shut to where it is widest, each wider than all
/// before it. A joint may open both ways, or on and on: what lies between two of these is another
/// opening as well.
fn ever_wider(openings: &[Opening]) -> Vec<Opening> {
    let by_width = |one: &(usize, &Opening), other: &(usize, &Opening)| one.1.wide.total_cmp(&other.1.wide);
    let shut = openings.iter().enumerate().min_by(by_width);
    let widest = openings.iter().enumerate().max_by(by_width);
    let (Some((shut, _)), Some((widest, _))) = (shut, widest) else { return Vec::new() };
    let mut way = openings[shut.min(widest)..=shut.max(widest)].to_vec();
    if widest < shut {
        way.reverse();
    }
    // Where it is shut all along, from the last such place on.
    let last_shut = way.iter().rposition(|opening| opening.wide <= way[0].wide);
    way.drain(..last_shut.unwrap_or(0));
    let mut wide = f64::NEG_INFINITY;
    way.retain(|opening| {
        let is_wider = opening.wide > wide;
        wide = wide.max(opening.wide);
        is_wider
    });
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ever(wide: impl Fn(f64) -> f64) -> Vec<f64> {
        let joints = (-10..=10).map(|part| f64::from(part) / 10.0);
        let openings: Vec<Opening> =
            joints.map(|joint| Opening { joint, wide: wide(joint), middle: 0.0, deep: 0.0 }).collect();
        ever_wider(&openings).iter().map(|opening| opening.joint).collect()
    }

    #[test]
    fn a_joint_opens_one_way() {
        // Both ways: one of them, without a jump to the other.
        let both = ever(f64::abs);
        assert!(both.len() == 11 && both.windows(2).all(|pair| pair[0] < pair[1]), "{both:?}");
        // Up or down, all of it; shut for a while, what follows that.
        assert_eq!(ever(|joint| joint).len(), 21);
        assert_eq!(ever(|joint| -joint).first(), Some(&1.0));
        assert_eq!(ever(|joint| joint.max(0.0)), both);
        // What closes again on the way is left out.
        let dented = ever(|joint| if joint == 0.5 { 0.0 } else { joint });
        assert!(dented.len() == 20 && !dented.contains(&0.5), "{dented:?}");
    }
}
