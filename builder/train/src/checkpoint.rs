//! The complete state of a training as bytes.
//!
//! Little-endian: magic, version (u32), the architecture (side, planes, embedding, heads, number of
//! convolutions, kernel, stride and outputs of each, and the masks' convolution, count and cells,
//! zeros where there are none: u32), the number of joints and the optimiser (0 Muon, 1 Adam: u32),
//! seed and steps (u64), the arrays of the state in their order (f32; their lengths follow from the
//! architecture), and the xxh3 of all bytes before it (u64).

use crate::optimiser::{Moments, Optimiser};
use crate::plan::Plan;
use crate::trainer::{State, Trainer};
use grasp_network::{Architecture, ArchitectureError, Convolution, Masks};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

const MAGIC: [u8; 8] = *b"graspTRN";
/// Goes up with every change that makes older checkpoints unusable, a change of what training does
/// included.
const VERSION: u32 = 4;

/// Bytes that are no checkpoint that training can go on from.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The bytes are something else.
    #[error("not a checkpoint of a training")]
    NotACheckpoint,
    /// Another version of the program wrote it.
    #[error("a checkpoint of version {found}, and this program reads {VERSION}: begin the training again")]
    Version {
        /// The checkpoint's version.
        found: u32,
    },
    /// Bytes are missing or left over.
    #[error("{found} bytes where {expected} were expected: the checkpoint is damaged")]
    Length {
        /// The length of the bytes.
        found: usize,
        /// What the header asks for, at least.
        expected: usize,
    },
    /// The bytes have changed since they were written.
    #[error("the checksum does not match: the checkpoint is damaged")]
    Checksum,
    /// The network is not supported.
    #[error(transparent)]
    Architecture(#[from] ArchitectureError),
    /// A value is infinite or not a number, or a variance or second moment is negative.
    #[error("the checkpoint holds {what} that no training arrives at")]
    Value {
        /// Which array holds it.
        what: &'static str,
    },
}

impl Trainer {
    /// The complete state: a trainer that is loaded from it goes on as this one does.
    pub fn save(&self) -> Vec<u8> {
        let State { plan, optimiser, seed, steps, .. } = &self.state;
        let Architecture { side, planes, convolutions, embedding, heads, masks } = &plan.architecture;
        let mut bytes = MAGIC.to_vec();
        let mut header = vec![VERSION, *side, *planes, *embedding, *heads, convolutions.len() as u32];
        for &Convolution { kernel, stride, outputs } in convolutions {
            header.extend([kernel, stride, outputs]);
        }
        let masks = masks.map_or([0; 3], |Masks { convolution, count, cells }| [convolution, count, cells]);
        header.extend(masks);
        let optimiser = match optimiser {
            Optimiser::Muon => 0,
            Optimiser::Adam => 1,
        };
        header.extend([plan.joints() as u32, optimiser]);
        bytes.extend(header.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([*seed, *steps].iter().flat_map(|value| value.to_le_bytes()));
        for (_, array) in arrays(&self.state) {
            bytes.extend(array.iter().flat_map(|value| value.to_le_bytes()));
        }
        let checksum = xxh3_64(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    /// The trainer that [`Self::save`] wrote.
    ///
    /// # Errors
    /// The bytes are not complete, not unchanged, or not of this version.
    pub fn load(bytes: &[u8]) -> Result<Self, CheckpointError> {
        let mut reader = Reader { bytes, rest: bytes };
        if !bytes.starts_with(&MAGIC) {
            return Err(CheckpointError::NotACheckpoint);
        }
        reader.take(MAGIC.len())?;
        let found = reader.u32()?;
        if found != VERSION {
            return Err(CheckpointError::Version { found });
        }
        let [side, planes, embedding, heads, count] = reader.u32s()?;
        let mut convolutions = Vec::new();
        for _ in 0..count {
            let [kernel, stride, outputs] = reader.u32s()?;
            convolutions.push(Convolution { kernel, stride, outputs });
        }
        let masks = match reader.u32s()? {
            [0, 0, 0] => None,
            [convolution, count, cells] => Some(Masks { convolution, count, cells }),
        };
        let architecture = Architecture { side, planes, convolutions, embedding, heads, masks };
        let joints = reader.u32()? as usize;
        let optimiser = match reader.u32()? {
            0 => Optimiser::Muon,
            1 => Optimiser::Adam,
            _ => return Err(CheckpointError::Value { what: "an optimiser" }),
        };
        let (seed, steps) = (reader.u64()?, reader.u64()?);

        // Before anything is allocated by what the header claims.
        let plan = Plan::new(&architecture, joints)?;
        let values = 4 * plan.parameters + plan.statistics;
        let (found, expected) = (reader.rest.len(), values.saturating_mul(4).saturating_add(8));
        if found != expected {
            let header = bytes.len() - found;
            let expected = expected.saturating_add(header);
            return Err(CheckpointError::Length { found: bytes.len(), expected });
        }
        let (hashed, _) = bytes.split_at(bytes.len() - 8);
        let parameters = reader.f32s(plan.parameters)?;
        let first = reader.f32s(plan.parameters)?;
        let second = reader.f32s(plan.parameters)?;
        let averaged = reader.f32s(plan.parameters)?;
        let statistics = reader.f32s(plan.statistics)?;
        if reader.u64()? != xxh3_64(hashed) {
            return Err(CheckpointError::Checksum);
        }
        let moments = Moments { first, second };
        let state = State { plan, optimiser, seed, steps, parameters, moments, averaged, statistics };
        check(&state)?;
        Ok(Self::from_state(state))
    }
}

/// The arrays in the order in which they are written.
fn arrays(state: &State) -> [(&'static str, &[f32]); 5] {
    [
        ("a weight", &state.parameters),
        ("a mean gradient", &state.moments.first),
        ("a mean squared gradient", &state.moments.second),
        ("an averaged weight", &state.averaged),
        ("a statistic", &state.statistics),
    ]
}

/// A training that has diverged may be saved, but not gone on with.
fn check(state: &State) -> Result<(), CheckpointError> {
    for (what, array) in arrays(state) {
        if !array.iter().all(|value| value.is_finite()) {
            return Err(CheckpointError::Value { what });
        }
    }
    let negative = |values: &[f32]| values.iter().any(|value| *value < 0.0);
    let mut variances = state.plan.blocks.iter().map(|block| &state.statistics[block.variance.clone()]);
    if variances.any(negative) {
        return Err(CheckpointError::Value { what: "a negative variance" });
    }
    if negative(&state.moments.second) {
        return Err(CheckpointError::Value { what: "a negative mean square" });
    }
    Ok(())
}

/// Takes numbers off the front.
struct Reader<'a> {
    bytes: &'a [u8],
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], CheckpointError> {
        let (first, rest) = self.rest.split_at_checked(count).ok_or_else(|| {
            let done = self.bytes.len() - self.rest.len();
            CheckpointError::Length { found: self.bytes.len(), expected: done.saturating_add(count) }
        })?;
        self.rest = rest;
        Ok(first)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CheckpointError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u32(&mut self) -> Result<u32, CheckpointError> {
        self.array().map(u32::from_le_bytes)
    }

    fn u32s<const N: usize>(&mut self) -> Result<[u32; N], CheckpointError> {
        let mut values = [0; N];
        for value in &mut values {
            *value = self.u32()?;
        }
        Ok(values)
    }

    fn u64(&mut self) -> Result<u64, CheckpointError> {
        self.array().map(u64::from_le_bytes)
    }

    fn f32s(&mut self, count: usize) -> Result<Vec<f32>, CheckpointError> {
        let (values, _) = self.take(count * 4)?.as_chunks();
        Ok(values.iter().map(|&value| f32::from_le_bytes(value)).collect())
    }
}
