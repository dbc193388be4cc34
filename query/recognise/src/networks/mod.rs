//! The networks of scenes: the program's, and those that a user has trained.

mod network;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use thiserror::Error;

pub(crate) use network::{GRASP, Heads, MASKS, SIDE, STAGES, normalised};
pub use network::{SceneNetwork, SceneNetworkError};

/// No network of this program has more bytes: the largest has 2.5 millions.
const MOST_BYTES: u64 = 64 << 20;

/// The grasps that the networks know, as `grasp-builder train` orders them.
const GRASPS: [&str; 6] =
    ["large-diameter", "small-diameter", "abducted-thumb", "pinch", "power-sphere", "precision-disc"];

/// Bytes that begin where integers may be read as they lie.
#[repr(C, align(64))]
struct Aligned<B: ?Sized>(B);

/// A network of the program's own, as the build script has prepared it; read when it is first asked.
macro_rules! built_in {
    ($file:literal) => {{
        static PREPARED: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/", $file)));
        LazyLock::new(|| SceneNetwork::built_in(&PREPARED.0, &GRASPS))
    }};
}

static FINDING: LazyLock<SceneNetwork> = built_in!("scene.network");
static NAMING: LazyLock<SceneNetwork> = built_in!("naming.network");
static THINGS: LazyLock<SceneNetwork> = built_in!("thing.network");
static CUTTING: LazyLock<SceneNetwork> = built_in!("mask.network");

/// The four networks that look at scenes; by default the program's own. Copies share them.
#[derive(Clone, Debug, Default)]
pub struct Networks {
    /// A user's, in the order of [`Networks::FILES`].
    own: [Option<Arc<SceneNetwork>>; 4],
}

/// Why a user's networks cannot be used.
#[derive(Debug, Error)]
pub enum NetworksError {
    /// A file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file is no network of scenes.
    #[error("cannot use {}: {fault}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: SceneNetworkError,
    },
    /// There is no such folder.
    #[error("there is no folder {}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// There is none of the files.
    #[error(
        "{} holds none of {}: name one so in `grasp-builder train --out`",
        folder.display(),
        Networks::FILES.join(", ")
    )]
    Missing {
        /// The folder.
        folder: PathBuf,
    },
}

impl Networks {
    /// The names of the files: what finds hands, what names them, what names a grasp by the thing
    /// that is held, and what cuts hand and thing out.
    pub const FILES: [&str; 4] = ["scene.network", "naming.network", "thing.network", "mask.network"];

    /// Reads those of [`Self::FILES`] that a folder holds, as `grasp-builder train` has written
    /// them; the others stay the program's own.
    ///
    /// # Errors
    /// Where a file cannot be read or is no network of scenes, or there is none.
    pub fn read(folder: &Path) -> Result<Self, NetworksError> {
        let [finding, naming, things, cutting] = Self::FILES.map(|name| read(folder.join(name)));
        let own = [finding?, naming?, things?, cutting?];
        if own.iter().all(Option::is_none) {
            if !folder.is_dir() {
                return Err(NetworksError::NoFolder { folder: folder.to_owned() });
            }
            return Err(NetworksError::Missing { folder: folder.to_owned() });
        }
        Ok(Self { own })
    }

    /// Loads the built-in networks in the order of their first use. Where a processor sums products
    /// of bytes, there is little to do; elsewhere weights are converted first, which the first look
    /// would otherwise wait for. Hands that are cut out are only looked at by two of them.
    pub fn read_ahead(&self, are_cut_out: bool) {
        let of_scenes = [Self::finding, Self::cutting, Self::naming, Self::things];
        let of_hands = [Self::finding, Self::naming];
        for read in if are_cut_out { &of_hands[..] } else { &of_scenes } {
            read(self);
        }
    }

    /// What finds hands.
    pub fn finding(&self) -> &SceneNetwork {
        self.own[0].as_deref().unwrap_or(&FINDING)
    }

    /// What names hands that have been found.
    pub fn naming(&self) -> &SceneNetwork {
        self.own[1].as_deref().unwrap_or(&NAMING)
    }

    /// What names grasps by the thing that is held.
    pub fn things(&self) -> &SceneNetwork {
        self.own[2].as_deref().unwrap_or(&THINGS)
    }

    /// What cuts hand, arm and thing out.
    pub fn cutting(&self) -> &SceneNetwork {
        self.own[3].as_deref().unwrap_or(&CUTTING)
    }
}

/// Whether they are the same networks, not whether they answer alike.
impl PartialEq for Networks {
    fn eq(&self, other: &Self) -> bool {
        self.own.iter().zip(&other.own).all(|pair| match pair {
            (Some(this), Some(that)) => Arc::ptr_eq(this, that),
            (None, None) => true,
            _ => false,
        })
    }
}

/// `None` where there is no such file.
fn read(path: PathBuf) -> Result<Option<Arc<SceneNetwork>>, NetworksError> {
    let bytes = match grasp_bounded::read(&path, MOST_BYTES) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(NetworksError::Read { path, source }),
    };
    match SceneNetwork::from_bytes(&bytes, &GRASPS) {
        Ok(network) => Ok(Some(Arc::new(network))),
        Err(fault) => Err(NetworksError::Unusable { path, fault }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_programs_own_can_be_read() {
        for network in [&FINDING, &NAMING, &THINGS, &CUTTING] {
            assert_eq!(network.grasps, GRASPS);
        }
    }

    #[test]
    fn a_folder_may_hold_some_and_the_others_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let missing = Networks::read(folder.path()).unwrap_err().to_string();
        assert!(
            missing.contains("holds none of scene.network, naming.network, thing.network, mask.network: "),
            "{missing}"
        );
        fs::write(folder.path().join("naming.network"), include_bytes!("../../data/thing.network")).unwrap();
        let networks = Networks::read(folder.path()).unwrap();
        assert!(std::ptr::eq(networks.finding(), &raw const *FINDING));
        assert!(!std::ptr::eq(networks.naming(), &raw const *NAMING));
        assert!(networks == networks.clone() && networks != Networks::default());
        fs::write(folder.path().join("thing.network"), "a poem").unwrap();
        let unusable = Networks::read(folder.path()).unwrap_err().to_string();
        assert!(unusable.starts_with("cannot use ") && unusable.contains("thing.network: "), "{unusable}");
    }
}
