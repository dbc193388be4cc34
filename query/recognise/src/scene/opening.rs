//! What hands look like before they hold something.
//!
//! A hand on its way is open wider than what it will hold, and people open theirs more alike than
//! the hands of our scenes do. So the grasps of thin things are likelier while nothing is held than
//! neighbours and networks say, and those of large and flat ones less likely.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// For each grasp by its name, the logarithm of how much likelier it is where nothing is held yet
/// than it looks. `grasp-query experiment opening` fits it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Opening {
    /// The logarithms; a grasp that is not here is as likely as it looks.
    pub log_odds: BTreeMap<String, f64>,
}

static BUILT_IN: LazyLock<Opening> = LazyLock::new(|| {
    toml::from_str(include_str!("../../data/opening.toml")).expect("a test reads the same file")
});

impl Opening {
    /// What the program weighs the grasps of camera pictures by.
    pub fn built_in() -> &'static Self {
        &BUILT_IN
    }

    /// The logarithm of how much likelier a grasp is than it looks, where the hand holds nothing
    /// yet with probability `open`; 0 for grasps that are not known.
    pub fn log_odds(&self, grasp: &str, open: f64) -> f64 {
        open * self.log_odds.get(grasp).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::Networks;

    #[test]
    fn every_grasp_of_the_networks_is_known_and_no_other() {
        let mut grasps = Networks::default().naming().grasps.clone();
        grasps.sort();
        assert!(grasps.iter().eq(Opening::built_in().log_odds.keys()));
        assert_eq!(Opening::built_in().log_odds("wave", 1.0), 0.0);
    }

    #[test]
    fn a_hand_that_holds_its_thing_is_what_it_looks_like() {
        let opening = Opening::built_in();
        for grasp in opening.log_odds.keys() {
            assert_eq!(opening.log_odds(grasp, 0.0), 0.0);
        }
        assert!(opening.log_odds("small-diameter", 0.5) > 0.0);
        assert!(opening.log_odds("precision-disc", 0.5) < 0.0);
    }
}
