//! The file of a network, little-endian.
//!
//! | bytes | |
//! |---|---|
//! | 0..8 | magic |
//! | 8..12 | version |
//! | 12..16 | convolutions, n |
//! | 16..24 | the file's length in bytes |
//! | 24..40 | side, planes, embedding, heads: 4 bytes each |
//! | 40..40 + 12 n | kernel, stride, outputs of each convolution: 4 bytes each |
//! | 12 more, but in version 1 | the masks' convolution, count and cells: 4 bytes each |
//! | to 8 before the end | the weights in [`Architecture`]'s order, `f16` |
//! | the last 8 | xxh3 of all before |
//!
//! Networks that are computed in floats are written in version 1 without masks, and in version 2
//! with masks; those that are computed in integers in version 3, where masks of 0 are none.
//!
//! The magic, the version, the length and the hash stay where they are in every version.

use crate::architecture::{Architecture, Convolution};
use crate::arithmetic::Arithmetic;
use crate::layer::{Layer, Stored};
use crate::masks::Masks;
use crate::weights::WeightsError;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// No text, and broken by transfers that rewrite line ends.
const MAGIC: [u8; 8] = *b"\x89GRNN\r\n\x1a";
/// The version of networks without masks.
const PLAIN: u32 = 1;
/// The version of networks with masks.
const WITH_MASKS: u32 = 2;
/// The version of networks that are computed in integers.
const IN_INTEGERS: u32 = 3;
/// The bytes before the convolutions.
const HEADER: usize = 40;
/// The bytes of one convolution.
const CONVOLUTION: usize = 12;
/// The bytes of the masks' numbers.
const MASKS: usize = 12;
/// The bytes of the hash.
const HASH: usize = 8;

/// Bytes that are not the file of a network.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ReadError {
    /// They start otherwise.
    #[error("not the weights of a network: the first bytes are others")]
    NotANetwork,
    /// The end is missing.
    #[error("truncated: {expected} bytes expected, {found} found")]
    Truncated {
        /// The length of the whole file, or of the part that says it.
        expected: u64,
        /// The bytes that are there.
        found: u64,
    },
    /// Something follows.
    #[error("too long: {expected} bytes expected, {found} found")]
    TooLong {
        /// The length of the file.
        expected: u64,
        /// The bytes that are there.
        found: u64,
    },
    /// Some bytes have changed.
    #[error("damaged: the bytes do not match their hash")]
    Damaged,
    /// Another version of this crate wrote it.
    #[error("written in version {found} of the format, where this program reads {PLAIN} to {IN_INTEGERS}")]
    Version {
        /// The file's version.
        found: u32,
    },
    /// The parts have other lengths than the header says.
    #[error("malformed: the architecture takes {expected} bytes, and the file has {found}")]
    Malformed {
        /// What the architecture takes.
        expected: u64,
        /// What the file has.
        found: u64,
    },
    /// The network cannot be.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

/// What a file holds.
pub(crate) struct Contents<'a> {
    pub(crate) architecture: Architecture,
    pub(crate) layers: Vec<Layer>,
    pub(crate) arithmetic: Arithmetic,
    /// Of which the number is right; their values have not been checked.
    pub(crate) weights: &'a [Stored],
}

/// What stands before the weights.
pub(crate) struct Shape {
    pub(crate) architecture: Architecture,
    pub(crate) layers: Vec<Layer>,
    arithmetic: Arithmetic,
    /// Where the weights begin.
    start: usize,
}

/// The version of the file of a network.
fn version(architecture: &Architecture, arithmetic: Arithmetic) -> u32 {
    match (arithmetic, architecture.masks) {
        (Arithmetic::Integers, _) => IN_INTEGERS,
        (Arithmetic::Floats, Some(_)) => WITH_MASKS,
        (Arithmetic::Floats, None) => PLAIN,
    }
}

/// The bytes of a file, for an architecture that has been validated.
pub(crate) fn encode(architecture: &Architecture, arithmetic: Arithmetic, weights: &[Stored]) -> Vec<u8> {
    let Architecture { side, planes, convolutions, embedding, heads, masks } = architecture;
    let version = version(architecture, arithmetic);
    let length = start(convolutions.len(), version) + size_of_val(weights) + HASH;
    let mut bytes = Vec::with_capacity(length);
    bytes.extend(MAGIC);
    bytes.extend(version.to_le_bytes());
    bytes.extend((convolutions.len() as u32).to_le_bytes());
    bytes.extend((length as u64).to_le_bytes());
    let sizes = [side, planes, embedding, heads].into_iter();
    let convolutions =
        convolutions.iter().flat_map(|Convolution { kernel, stride, outputs }| [kernel, stride, outputs]);
    let masks = match (masks, version) {
        (_, PLAIN) => Vec::new(),
        (Some(Masks { convolution, count, cells }), _) => vec![convolution, count, cells],
        (None, _) => vec![&0; 3],
    };
    bytes.extend(sizes.chain(convolutions).chain(masks).flat_map(|value| value.to_le_bytes()));
    bytes.extend(weights.as_flattened());
    let hash = xxh3_64(&bytes);
    bytes.extend(hash.to_le_bytes());
    bytes
}

/// What the bytes hold.
pub(crate) fn decode(bytes: &[u8]) -> Result<Contents<'_>, ReadError> {
    let Shape { architecture, layers, arithmetic, start } = shape(bytes)?;
    let parameters: usize = layers.iter().map(Layer::parameters).sum();
    let expected = start + parameters * size_of::<Stored>() + HASH;
    let weights = bytes
        .get(start..bytes.len() - HASH)
        .filter(|_| bytes.len() == expected)
        .ok_or(ReadError::Malformed { expected: expected as u64, found: bytes.len() as u64 })?;
    Ok(Contents { architecture, layers, arithmetic, weights: weights.as_chunks().0 })
}

/// What stands before the weights.
pub(crate) fn shape(bytes: &[u8]) -> Result<Shape, ReadError> {
    check_whole(bytes)?;
    let malformed =
        |expected: usize| ReadError::Malformed { expected: expected as u64, found: bytes.len() as u64 };
    let mut numbers = bytes.as_chunks::<4>().0.iter().map(|number| u32::from_le_bytes(*number));
    let mut next = || numbers.next().ok_or_else(|| malformed(HEADER + HASH));
    let (_magic, version) = ([next()?, next()?], next()?);
    let arithmetic = match version {
        PLAIN | WITH_MASKS => Arithmetic::Floats,
        IN_INTEGERS => Arithmetic::Integers,
        found => return Err(ReadError::Version { found }),
    };
    let (count, _length) = (next()? as usize, [next()?, next()?]);
    let (side, planes, embedding, heads) = (next()?, next()?, next()?, next()?);
    Architecture::check_convolutions(count).map_err(WeightsError::from)?;
    let mut convolutions = Vec::with_capacity(count);
    for _ in 0..count {
        convolutions.push(Convolution { kernel: next()?, stride: next()?, outputs: next()? });
    }
    let masks = match version {
        PLAIN => None,
        _ => Some(Masks { convolution: next()?, count: next()?, cells: next()? }),
    };
    let none = Masks { convolution: 0, count: 0, cells: 0 };
    let masks = masks.filter(|masks| version == WITH_MASKS || *masks != none);
    let architecture = Architecture { side, planes, convolutions, embedding, heads, masks };
    let layers = architecture.layers().map_err(WeightsError::from)?;
    Ok(Shape { architecture, layers, arithmetic, start: start(count, version) })
}

/// The length of the file that begins so, as it says itself.
pub(crate) fn length(bytes: &[u8]) -> Result<u64, ReadError> {
    let (expected, found) = (HEADER as u64, bytes.len() as u64);
    if !bytes.starts_with(&MAGIC) {
        let is_start = !bytes.is_empty() && MAGIC.starts_with(bytes);
        return Err(if is_start { ReadError::Truncated { expected, found } } else { ReadError::NotANetwork });
    }
    let length = bytes.get(16..).and_then(<[u8]>::first_chunk);
    length.map(|length| u64::from_le_bytes(*length)).ok_or(ReadError::Truncated { expected, found })
}

/// Checks what holds in every version: the magic, the length and the hash.
fn check_whole(bytes: &[u8]) -> Result<(), ReadError> {
    let (expected, found) = (length(bytes)?, bytes.len() as u64);
    if found < expected {
        return Err(ReadError::Truncated { expected, found });
    }
    if found > expected {
        return Err(ReadError::TooLong { expected, found });
    }
    match bytes.split_last_chunk::<HASH>() {
        Some((before, hash)) if xxh3_64(before) == u64::from_le_bytes(*hash) => Ok(()),
        _ => Err(ReadError::Damaged),
    }
}

/// Where the weights begin, behind the architecture of a network of `convolutions` convolutions.
fn start(convolutions: usize, version: u32) -> usize {
    let masks = if version == PLAIN { 0 } else { MASKS };
    HEADER + convolutions * CONVOLUTION + masks
}
