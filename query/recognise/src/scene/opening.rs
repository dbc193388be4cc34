//! What hands look like before they hold something.
//!
//! A hand on its way is open wider than what it will hold, and people open theirs more alike than
//! the hands of our scenes do. So the grasps of thin things are likelier while nothing is held than
//! neighbours and networks say, and those of large and flat ones less likely.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// For each grasp by its name, the logarithm of how much likelier it is where nothing is held yet.
static LOG_ODDS: LazyLock<BTreeMap<String, f64>> = LazyLock::new(|| {
    toml::from_str(include_str!("../../data/opening.toml")).expect("a test reads the same file")
});

/// How much likelier a grasp is, as a factor, where the hand holds nothing yet with probability
/// `open`; 1 for grasps that are not known.
pub(super) fn factor(grasp: Option<&str>, open: f64) -> f64 {
    let log_odds = grasp.and_then(|grasp| LOG_ODDS.get(grasp)).copied().unwrap_or_default();
    libm::exp(open * log_odds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneNetwork;

    #[test]
    fn every_grasp_of_the_networks_is_known_and_no_other() {
        let mut grasps = SceneNetwork::naming().grasps.clone();
        grasps.sort();
        assert!(grasps.iter().eq(LOG_ODDS.keys()));
        assert_eq!([factor(Some("wave"), 1.0), factor(None, 1.0)], [1.0; 2]);
    }

    #[test]
    fn a_hand_that_holds_its_thing_is_what_it_looks_like() {
        for grasp in LOG_ODDS.keys() {
            assert_eq!(factor(Some(grasp), 0.0), 1.0);
        }
        assert!(factor(Some("small-diameter"), 0.5) > 1.0 && factor(Some("precision-disc"), 0.5) < 1.0);
    }
}
