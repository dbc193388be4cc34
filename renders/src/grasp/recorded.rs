//! Poses of hands that hold things, as people recorded or set them (`data/poses.csv`).
//!
//! They say what people's fingers do in a grasp: how they splay, how unevenly they curl, where the
//! thumb lies. What they held is not known, so that an object is fitted into the hand when a scene
//! is built.

use std::sync::OnceLock;

use serde::Deserialize;

use crate::hand::{HandPose, JOINTS};
use grasp_canonical::Encoder;

const FILE: &str = include_str!("../../data/poses.csv");
/// Joint angles a row: five of the thumb, four of each finger.
const ANGLES: usize = 21;
/// One pose in this many is held out.
const HELD_OUT: u64 = 5;
/// Hashed with the poses; chosen so that each grasp has some in either group.
const HELD_OUT_SALT: u32 = 9;

/// One recorded pose.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedPose {
    /// The name of the grasp.
    pub grasp: String,
    /// How sure the label is: 3 clear, 2 likely, 1 a guess between two.
    pub confidence: u8,
    /// The joint angles.
    pub pose: HandPose,
}

/// Which of the recorded poses may be drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseGroup {
    /// All of them.
    All,
    /// A fifth of them, chosen by a hash of grasp and joint angles: to measure on poses that
    /// nothing was learned from.
    HeldOut,
    /// A share of the others; a larger one includes all poses of a smaller one.
    Kept {
        /// 0 to 100.
        percent: u8,
    },
}

impl PoseGroup {
    /// Whether a pose is one of the group's.
    pub fn contains(self, recorded: &RecordedPose) -> bool {
        match self {
            PoseGroup::All => true,
            PoseGroup::HeldOut => recorded.is_held_out(),
            PoseGroup::Kept { percent } => recorded.is_kept(percent),
        }
    }
}

/// A row of the file; what names source and licence is for readers of the file.
#[derive(Deserialize)]
struct Row {
    grasp: String,
    confidence: u8,
}

impl RecordedPose {
    /// All of them, in the order of the file.
    pub fn all() -> &'static [RecordedPose] {
        static ALL: OnceLock<Vec<RecordedPose>> = OnceLock::new();
        ALL.get_or_init(|| parse(FILE).expect("data/poses.csv is checked by a test"))
    }

    fn is_held_out(&self) -> bool {
        self.hash().is_multiple_of(HELD_OUT)
    }

    fn is_kept(&self, percent: u8) -> bool {
        !self.is_held_out() && self.hash() / HELD_OUT % 100 < u64::from(percent)
    }

    fn hash(&self) -> u64 {
        Encoder::new().u32(HELD_OUT_SALT).text(&self.grasp).value(&self.pose).hash()
    }
}

fn parse(text: &str) -> Result<Vec<RecordedPose>, csv::Error> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let headers = reader.headers()?.clone();
    let first = headers.len().saturating_sub(ANGLES);
    let mut poses = Vec::new();
    for record in reader.records() {
        let record = record?;
        let Row { grasp, confidence } = record.deserialize(Some(&headers))?;
        let degrees = record.iter().skip(first).map(|angle| angle.parse().unwrap_or(f64::NAN));
        let angles: Vec<f64> = degrees.map(f64::to_radians).collect();
        let mut pose = HandPose { digits: [[0.0; JOINTS]; 5] };
        let joints = pose.digits.iter_mut().enumerate();
        let joints =
            joints.flat_map(|(digit, joints)| joints.iter_mut().take(if digit == 0 { 5 } else { 4 }));
        joints.zip(angles).for_each(|(joint, angle)| *joint = angle);
        poses.push(RecordedPose { grasp, confidence, pose });
    }
    Ok(poses)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::GraspSet;
    use crate::hand::{Digit, joint_limits};

    #[test]
    fn about_a_fifth_of_each_grasps_poses_is_held_out() {
        for grasp in GraspSet::builtin().iter() {
            let count = |group: PoseGroup| {
                let of_grasp = RecordedPose::all().iter().filter(|recorded| recorded.grasp == grasp.name);
                of_grasp.filter(|recorded| group.contains(recorded)).count()
            };
            let [all, held_out, kept] =
                [PoseGroup::All, PoseGroup::HeldOut, PoseGroup::Kept { percent: 100 }].map(count);
            assert_eq!(held_out + kept, all);
            assert!(held_out > 0 && held_out <= kept, "{}: {held_out} of {all}", grasp.name);
        }
    }

    #[test]
    fn a_larger_share_of_what_is_kept_has_all_of_a_smaller_one() {
        let count = |percent| {
            let is_kept = |recorded: &&RecordedPose| PoseGroup::Kept { percent }.contains(recorded);
            RecordedPose::all().iter().filter(is_kept).count()
        };
        let counts = [0, 10, 40, 100].map(count);
        assert_eq!(counts[0], 0);
        assert!(counts.is_sorted_by(|few, more| few < more), "{counts:?}");
        for recorded in RecordedPose::all() {
            let is_kept = |percent| PoseGroup::Kept { percent }.contains(recorded);
            assert!((0..100).all(|percent| !is_kept(percent) || is_kept(percent + 1)));
            assert!(!is_kept(100) || !PoseGroup::HeldOut.contains(recorded));
        }
    }

    #[test]
    fn every_pose_is_one_of_a_hand_in_a_known_grasp() {
        let grasps = GraspSet::builtin();
        assert_eq!(RecordedPose::all().len(), 105);
        for recorded in RecordedPose::all() {
            assert!(grasps.get(&recorded.grasp).is_some(), "{}", recorded.grasp);
            assert!((1..=3).contains(&recorded.confidence));
            for digit in Digit::ALL {
                for (angle, [low, high]) in
                    recorded.pose.digits[digit as usize].iter().zip(joint_limits(digit))
                {
                    let rounding = 0.1f64.to_radians();
                    assert!((low - rounding..=high + rounding).contains(angle), "{recorded:?}");
                }
            }
        }
    }
}
