//! The network that looks at scenes.

use grasp_index::NETWORK_STAGES;
use grasp_network::{Path, QuantisedNetwork, ReadError, Scratch};
use thiserror::Error;

/// Pixels a side of the pictures that it takes.
pub(crate) const SIDE: usize = 64;
/// Masks that it answers with: hand, forearm, object.
pub(crate) const MASKS: usize = 3;
/// Values of the heads behind the classes: three stages, and a rotation as two columns.
pub(crate) const STAGES: usize = NETWORK_STAGES.len();
/// Which of the stages is the one in which something is held.
pub(crate) const GRASP: usize = STAGES - 1;
const ROTATION: usize = 6;

/// A scene network, and what its heads mean.
#[derive(Clone, Debug)]
pub struct SceneNetwork {
    pub(crate) network: QuantisedNetwork,
    /// The grasps' names in the heads' order. Behind them comes a hand that is mirrored, then one
    /// in none of the grasps.
    pub(crate) grasps: Vec<String>,
}

/// A network that does not look at scenes.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SceneNetworkError {
    /// The bytes are no network's.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It takes or returns something else.
    #[error("not a network of scenes: {what} is {found}, {expected} expected")]
    Shape {
        /// What differs.
        what: &'static str,
        /// The network's.
        found: usize,
        /// A scene network's.
        expected: usize,
    },
}

impl SceneNetwork {
    /// Reads a network that `grasp-builder train --kind scene`, `naming`, `thing` or `mask` has
    /// written, whose classes are these.
    ///
    /// # Errors
    /// Where the bytes are no network's, or it is one of another kind.
    pub fn from_bytes(bytes: &[u8], grasps: &[&str]) -> Result<Self, SceneNetworkError> {
        Self::new(QuantisedNetwork::from_bytes(bytes)?, grasps)
    }

    /// One that the build script has prepared.
    pub(super) fn built_in(prepared: &'static [u8], grasps: &[&str]) -> Self {
        let network = QuantisedNetwork::from_prepared(prepared, Path::best());
        let network = network.map_err(SceneNetworkError::from).and_then(|network| Self::new(network, grasps));
        network.expect("a test reads the same bytes")
    }

    fn new(network: QuantisedNetwork, grasps: &[&str]) -> Result<Self, SceneNetworkError> {
        let architecture = network.architecture();
        let masks = architecture.masks.map_or(0, |masks| masks.count as usize);
        let shape = [
            ("the number of planes", architecture.planes as usize, 3),
            ("the side of the picture", architecture.side as usize, SIDE),
            ("the number of masks", masks, MASKS),
            ("the size of the heads", architecture.heads as usize, grasps.len() + 2 + STAGES + ROTATION),
        ];
        for (what, found, expected) in shape {
            if found != expected {
                return Err(SceneNetworkError::Shape { what, found, expected });
            }
        }
        Ok(Self { network, grasps: grasps.iter().map(|name| (*name).to_owned()).collect() })
    }

    /// What it answers to one picture.
    pub(crate) fn run(&self, scratch: &mut Scratch, planes: &[f32]) -> Heads {
        let output = self.network.run(scratch, planes);
        let (classes, rest) = output.heads.split_at(self.grasps.len() + 2);
        let mut rotation = [0.0; ROTATION];
        rotation.iter_mut().zip(rest.iter().skip(STAGES)).for_each(|(to, from)| *to = f64::from(*from));
        let mut stages = [0.0; STAGES];
        stages.iter_mut().zip(rest).for_each(|(to, from)| *to = f64::from(*from));
        let classes: Vec<f64> = classes.iter().copied().map(f64::from).collect();
        let mut classes = normalised(&classes);
        let mirrored = classes.remove(self.grasps.len());
        let mask_side = self.network.architecture().mask_side().unwrap_or_default();
        Heads { classes, mirrored, stages, rotation, masks: output.masks.to_vec(), mask_side }
    }
}

/// The answer to one picture.
#[derive(Clone, Debug)]
pub(crate) struct Heads {
    /// The logarithm of each class's probability: the grasps, then none of them.
    pub(crate) classes: Vec<f64>,
    /// The logarithm of the probability that the hand is mirrored.
    pub(crate) mirrored: f64,
    /// The logarithm of the probability of each stage, reach, close and grasp, up to a constant.
    pub(crate) stages: [f64; STAGES],
    /// The first and the second column of the rotation, of any length.
    pub(crate) rotation: [f64; ROTATION],
    /// Logits of hand, forearm and object, row by row.
    pub(crate) masks: Vec<f32>,
    /// Values a side of a mask.
    pub(crate) mask_side: usize,
}

impl Heads {
    /// The direction of the arm in the picture, as an angle clockwise from the right.
    pub(crate) fn arm(&self) -> f64 {
        libm::atan2(-self.rotation[1], -self.rotation[0])
    }
}

/// The logarithms of probabilities that sum to 1, from logarithms up to the same constant.
pub(crate) fn normalised(logs: &[f64]) -> Vec<f64> {
    let highest = logs.iter().copied().fold(f64::MIN, f64::max);
    let sum = libm::log(logs.iter().map(|log| libm::exp(log - highest)).sum::<f64>());
    logs.iter().map(|log| log - highest - sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_networks_and_damaged_ones_are_rejected() {
        let bytes = include_bytes!("../../data/scene.network");
        let grasps = ["a", "b", "c", "d", "e", "f"];
        assert!(SceneNetwork::from_bytes(bytes, &grasps).is_ok());
        assert!(matches!(
            SceneNetwork::from_bytes(bytes, &grasps[1..]),
            Err(SceneNetworkError::Shape { what: "the size of the heads", .. })
        ));
        let architecture = grasp_network::Architecture {
            side: 8,
            planes: 2,
            convolutions: Vec::new(),
            embedding: 4,
            heads: 17,
            masks: None,
        };
        let weights = vec![0.0; architecture.parameters().unwrap()];
        let other = grasp_network::Network::from_weights(architecture, weights).unwrap();
        let error = SceneNetwork::from_bytes(&other.to_bytes(), &grasps).unwrap_err();
        assert_eq!(error.to_string(), "not a network of scenes: the number of planes is 2, 3 expected");
        assert!(SceneNetwork::from_bytes(&bytes[..1000], &grasps).is_err());
    }

    #[test]
    fn something_is_held_at_the_last_stage() {
        assert_eq!(NETWORK_STAGES[GRASP], "grasp");
    }

    #[test]
    fn probabilities_of_the_classes_sum_to_one() {
        let sum: f64 = normalised(&[3.0, -2.0, 900.0, 899.0]).iter().map(|log| log.exp()).sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }
}
