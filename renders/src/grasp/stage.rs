//! How far a grasp is closed.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// How far a grasp is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// The hand is on its way.
    Reach,
    /// About to grasp.
    Close,
    /// The fingers lie on the object.
    Grasp,
}

impl Stage {
    /// All stages in the order of time.
    pub const ALL: [Stage; 3] = [Stage::Reach, Stage::Close, Stage::Grasp];

    /// The stage's name: `reach`, `close` or `grasp`.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Reach => "reach",
            Stage::Close => "close",
            Stage::Grasp => "grasp",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that names no stage.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no stage `{0}`: the stages are reach, close and grasp")]
pub struct UnknownStage(pub String);

impl FromStr for Stage {
    type Err = UnknownStage;

    fn from_str(word: &str) -> Result<Stage, UnknownStage> {
        Stage::ALL.into_iter().find(|stage| stage.name() == word).ok_or_else(|| UnknownStage(word.to_owned()))
    }
}
