//! A robot hand's fingers as chains of links: where they are, for drawings and for what stands in
//! their way.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde::Deserialize;

use super::DescriptionFault;

/// The longest part of a finger, in metres.
const LONGEST: f64 = 1.0;

/// A finger: links one after the other, bent in one plane that holds the palm's z.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finger {
    /// Where it is fastened, in the palm's frame, in metres.
    at: [f64; 3],
    /// The direction in which it leaves the palm, as an angle about the palm's z from its x, in
    /// radians.
    outward: f64,
    /// The joint that turns that direction.
    spread: Option<Spread>,
    /// The joint that slides the finger along that direction.
    slide: Option<String>,
    /// How far along that direction the first link begins, in metres.
    #[serde(default)]
    offset: f64,
    /// From the palm to the tip.
    links: Vec<Link>,
}

/// The joint that spreads a finger.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Spread {
    joint: String,
    /// 1 or -1: which way a positive angle turns about the palm's z.
    sign: i8,
}

/// A part of a finger.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Link {
    /// The joint that bends it, from the direction of the part before.
    joint: Option<String>,
    /// By how much it is bent where the joint says 0, in radians.
    #[serde(default)]
    rest: f64,
    /// In metres.
    length: f64,
}

impl Finger {
    /// The finger's middle line in the palm's frame, from where it is fastened to its tip, its
    /// joints being as `posture` says.
    pub(super) fn points(&self, posture: &BTreeMap<String, f64>) -> Vec<Point3<f64>> {
        let value = |joint: &String| posture.get(joint).copied().unwrap_or_default();
        let spread = self.spread.as_ref().map_or(0.0, |turn| f64::from(turn.sign) * value(&turn.joint));
        let (sin, cos) = (self.outward + spread).sin_cos();
        let outward = Vector3::new(cos, sin, 0.0);
        let slid = self.slide.as_ref().map_or(0.0, value);
        let mut end = Point3::from(self.at) + outward * (self.offset + slid);
        let mut points = vec![end];
        let mut bend = 0.0;
        for link in &self.links {
            bend += link.rest + link.joint.as_ref().map_or(0.0, value);
            end += (outward * bend.cos() + Vector3::z() * bend.sin()) * link.length;
            points.push(end);
        }
        points
    }

    /// What is wrong with its description, for a hand whose joints are those of `limits`.
    pub(super) fn fault(&self, limits: &BTreeMap<String, [f64; 2]>) -> Option<DescriptionFault> {
        let spread = self.spread.as_ref();
        let mut joints = spread.map(|turn| &turn.joint).into_iter().chain(&self.slide);
        let unknown = joints.find(|joint| !limits.contains_key(*joint));
        let unknown = unknown.or_else(|| {
            self.links
                .iter()
                .filter_map(|link| link.joint.as_ref())
                .find(|joint| !limits.contains_key(*joint))
        });
        if let Some(joint) = unknown {
            return Some(DescriptionFault::FingerJoint(joint.clone()));
        }
        if spread.is_some_and(|turn| turn.sign.abs() != 1) {
            return Some(DescriptionFault::FingerSign);
        }
        let lengths = self.links.iter().map(|link| link.length);
        let lengths = lengths.chain(self.at).chain([self.offset]);
        let angles = self.links.iter().map(|link| link.rest).chain([self.outward]);
        // Written so that what is not a number is rejected as well.
        let is_sound = lengths.into_iter().all(|metres| metres.abs() <= LONGEST)
            && angles.into_iter().all(|radians| radians.abs() <= std::f64::consts::TAU);
        (!is_sound).then_some(DescriptionFault::Finger { longest: LONGEST })
    }
}
