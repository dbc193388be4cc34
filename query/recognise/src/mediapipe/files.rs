//! The networks as the files that a user has.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rten::ThreadPool;
use thiserror::Error;

use super::hand::{self, HAND_SIDE, Hand};
use super::network::{Network, NetworkFault};
use super::palm::{self, PALM_SIDE, Palm};

/// No file of either network has more bytes: they have 4 and 11 millions.
const MOST_BYTES: u64 = 64 << 20;

/// The networks that find palms and the joints of hands. Copies share them.
#[derive(Clone)]
pub struct HandNetworks(Arc<Networks>);

struct Networks {
    palm: Network,
    hand: Network,
}

/// Why the networks cannot be used.
#[derive(Debug, Error)]
pub enum HandNetworksError {
    /// A file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file is another network's, or none's.
    #[error("cannot use {name}: {fault}")]
    Unusable {
        /// The file, or which of the networks.
        name: String,
        /// What is wrong with it.
        fault: NetworkFault,
    },
}

impl HandNetworks {
    /// The names of the files: what finds palms, and what finds a hand's joints.
    pub const FILES: [&str; 2] = ["palm_detection.onnx", "hand_landmark.onnx"];

    /// Reads [`Self::FILES`] in a folder.
    ///
    /// # Errors
    /// Where a file cannot be read, or is not that network.
    pub fn read(folder: &Path) -> Result<Self, HandNetworksError> {
        let [palm, hand] = Self::FILES.map(|name| {
            let path = folder.join(name);
            read(&path).map(|bytes| (bytes, path.display().to_string()))
        });
        Self::new(palm?, hand?)
    }

    /// The same from the files' bytes.
    ///
    /// # Errors
    /// Where one is not that network.
    pub fn from_onnx(palm: Vec<u8>, hand: Vec<u8>) -> Result<Self, HandNetworksError> {
        Self::new((palm, "the palm network".into()), (hand, "the hand network".into()))
    }

    fn new(palm: (Vec<u8>, String), hand: (Vec<u8>, String)) -> Result<Self, HandNetworksError> {
        // As many as the rest of the program has: `rten` would take one a core.
        let threads = Arc::new(ThreadPool::with_num_threads(rayon::current_num_threads()));
        let network = |(bytes, name): (Vec<u8>, String), side: usize, sizes: &[usize]| {
            let unusable = |fault| HandNetworksError::Unusable { name, fault };
            Network::from_onnx(bytes, side, sizes, &threads).map_err(unusable)
        };
        let palm = network(palm, PALM_SIDE, &palm::SIZES)?;
        Ok(Self(Arc::new(Networks { palm, hand: network(hand, HAND_SIDE, &hand::SIZES)? })))
    }

    /// The palms in a square of [`PALM_SIDE`] pixels a side, red, green and blue from 0 to 1, the
    /// likeliest first.
    pub(crate) fn palms(&self, pixels: &[f32]) -> Result<Vec<Palm>, HandNetworksError> {
        let answer = run(&self.0.palm, pixels, 0)?;
        let [boxes, logits] = answer.as_slice() else { return Ok(Vec::new()) };
        Ok(palm::palms(boxes, logits))
    }

    /// The hand in a square of [`HAND_SIDE`] pixels a side; `None` where the answer makes no sense.
    pub(crate) fn hand(&self, pixels: &[f32]) -> Result<Option<Hand>, HandNetworksError> {
        let answer = run(&self.0.hand, pixels, 1)?;
        let [places, presence, right, _] = answer.as_slice() else { return Ok(None) };
        let (Some(presence), Some(right)) = (presence.first(), right.first()) else { return Ok(None) };
        Ok(hand::hand(places, *presence, *right))
    }
}

fn run(network: &Network, pixels: &[f32], file: usize) -> Result<Vec<Vec<f32>>, HandNetworksError> {
    let name = || HandNetworks::FILES[file].to_owned();
    network.run(pixels).map_err(|fault| HandNetworksError::Unusable { name: name(), fault })
}

fn read(path: &Path) -> Result<Vec<u8>, HandNetworksError> {
    let failed = |source| HandNetworksError::Read { path: path.to_owned(), source };
    grasp_bounded::read(path, MOST_BYTES).map_err(failed)
}

impl fmt::Debug for HandNetworks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("HandNetworks")
    }
}

/// The same networks in memory are the same.
impl PartialEq for HandNetworks {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for HandNetworks {}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{Answer, onnx};
    use super::*;

    fn zeros(sizes: &[usize]) -> Vec<Answer> {
        sizes.iter().map(|size| Answer::Values(vec![0.0; *size])).collect()
    }

    fn palm() -> Vec<u8> {
        onnx(PALM_SIDE, &zeros(&palm::SIZES))
    }

    fn hand() -> Vec<u8> {
        onnx(HAND_SIDE, &zeros(&hand::SIZES))
    }

    #[test]
    fn networks_are_read_from_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let [palm_file, hand_file] = HandNetworks::FILES.map(|name| folder.path().join(name));
        let error = HandNetworks::read(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with("cannot read ") && error.contains("palm_detection.onnx: "), "{error}");
        std::fs::write(palm_file, palm()).unwrap();
        std::fs::write(&hand_file, b"no network").unwrap();
        let error = HandNetworks::read(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with("cannot use ") && error.contains("hand_landmark.onnx: "), "{error}");
        std::fs::write(&hand_file, hand()).unwrap();
        let networks = HandNetworks::read(folder.path()).unwrap();
        assert_eq!(networks, networks.clone());
        // Logits of 0 are palms of one half, but boxes of no size are none.
        assert_eq!(networks.palms(&vec![0.0; 3 * PALM_SIDE * PALM_SIDE]).unwrap(), []);
        let found = networks.hand(&vec![0.0; 3 * HAND_SIDE * HAND_SIDE]).unwrap().unwrap();
        assert_eq!(found.presence, 0.0);
    }

    #[test]
    fn other_networks_are_rejected_with_what_they_take_or_answer() {
        let error = |palm, hand| HandNetworks::from_onnx(palm, hand).unwrap_err().to_string();
        insta::assert_snapshot!(error(hand(), hand()), @"cannot use the palm network: it takes [1, 224, 224, 3], [1, 192, 192, 3] are expected");
        let other = onnx(HAND_SIDE, &zeros(&[63, 1, 1]));
        insta::assert_snapshot!(error(palm(), other), @"cannot use the hand network: it answers with [63, 1, 1] values, [63, 1, 1, 63] are expected");
        let cut = palm()[..40].to_vec();
        assert!(error(cut, hand()).starts_with("cannot use the palm network: "));
    }
}
