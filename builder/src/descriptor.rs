//! Descriptors by name, the network that comes with the program, and what in a picture is
//! described.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use anyhow::Context as _;
use grasp_index::{BACKGROUND, DescriptorModel, DescriptorParams, HandImage, HandImageError, Network};

/// The weights that `data/README.md` describes.
const SHIPPED: &[u8] = include_bytes!("../data/hand.network");

/// The most bytes of a network's file.
const MOST_BYTES: u64 = 64 << 20;

/// Names of the descriptors of pictures, as options take them.
pub const NAMES: [&str; 4] = [LEARNED, "upright", "default", "paper"];

/// The name of the descriptor that a network computes.
pub const LEARNED: &str = "learned";

/// The descriptor that goes by a name: a learned one is that of the network in a file, or of the
/// one that comes with the program.
///
/// # Errors
/// Where there is no such name, or the file holds no network.
pub fn by_name(name: &str, network: Option<&Path>) -> anyhow::Result<DescriptorModel> {
    if name == LEARNED {
        let network = network.map_or_else(shipped_network, |path| read_network(path).map(Arc::new))?;
        return Ok(DescriptorModel::learned(network)?);
    }
    let params =
        DescriptorParams::by_name(name).with_context(|| format!("there is no descriptor named {name}"))?;
    Ok(DescriptorModel::new(params)?)
}

/// The network that comes with the program.
///
/// # Errors
/// Never, as a test makes sure: its bytes are part of the program.
pub fn shipped_network() -> anyhow::Result<Arc<Network>> {
    static NETWORK: OnceLock<Arc<Network>> = OnceLock::new();
    if let Some(network) = NETWORK.get() {
        return Ok(Arc::clone(network));
    }
    let network = Network::from_bytes(SHIPPED).context("cannot use the network of this program")?;
    Ok(Arc::clone(NETWORK.get_or_init(|| Arc::new(network))))
}

/// Reads a network's file.
pub(crate) fn read_network(path: &Path) -> anyhow::Result<Network> {
    let cannot = || format!("cannot use the network {}", path.display());
    let bytes = grasp_bounded::read(path, MOST_BYTES).with_context(cannot)?;
    Network::from_bytes(&bytes).with_context(cannot)
}

/// The hand of a segmented picture; `None` where there is none, or too little of one to describe.
///
/// # Errors
/// Where the pixels are not those of a picture of that size.
pub(crate) fn hand_in(width: usize, height: usize, grey: &[u8]) -> Result<Option<HandImage>, HandImageError> {
    match HandImage::from_segmented(width, height, grey, BACKGROUND) {
        Ok(hand) => Ok(Some(hand)),
        Err(HandImageError::NoHand { .. } | HandImageError::TooSmall { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_descriptor() {
        for name in NAMES {
            assert_eq!(by_name(name, None).expect("a descriptor").params().name(), name);
        }
    }

    #[test]
    fn the_shipped_network_is_the_one_that_its_page_names() {
        let fingerprint = shipped_network().expect("a network").fingerprint();
        let page = include_str!("../data/README.md");
        assert!(page.contains(&format!("`{fingerprint:016x}`")), "{fingerprint:016x}");
    }
}
