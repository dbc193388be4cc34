//! What a person may answer.

use serde::Serialize;

/// A grasp as the page offers it: its key is its place, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// The class.
    pub grasp: &'static str,
    /// Its number in Cutkosky's taxonomy.
    pub cutkosky: u8,
    /// What to look for.
    pub words: &'static str,
}

/// The paper's six grasps.
pub const CHOICES: [Choice; 6] = [
    Choice {
        grasp: "large-diameter",
        cutkosky: 1,
        words: "fingers and thumb round something thick, such as a bottle",
    },
    Choice {
        grasp: "small-diameter",
        cutkosky: 2,
        words: "fingers and thumb closed round something thin, such as a stick",
    },
    Choice { grasp: "abducted-thumb", cutkosky: 4, words: "round a handle, the thumb stretched along it" },
    Choice { grasp: "pinch", cutkosky: 9, words: "a small thing between the tips of thumb and index" },
    Choice { grasp: "power-sphere", cutkosky: 10, words: "fingers spread round a ball, the palm against it" },
    Choice {
        grasp: "precision-disc",
        cutkosky: 12,
        words: "a lid by its rim, the fingertips spread, the palm away",
    },
];
