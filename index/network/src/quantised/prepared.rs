//! Networks whose weights are integers before a program starts.
//!
//! Whoever carries a network in a program prepares it while the program is compiled. The weights
//! then stay where they lie: a process that answers one question rounds none and asks for no memory
//! for them. Only layers that are computed in tiles are transformed into memory of their own.
//!
//! | part, each from the next multiple of 64 bytes on | |
//! |---|---|
//! | the file of a network in integers | without weights |
//! | of each layer that is computed in floats | its blocks, `f32` |
//! | of each other layer | its integers in fours, then the scales of its blocks, `f32` |

use std::borrow::Cow;

use super::packed::{PackedIntegers, Quads, Scales, TOGETHER};
use super::{QuantisedNetwork, Step, Weights, is_rounded, reads_integers, rounded};
use crate::file::{self, Contents, Shape};
use crate::lanes::Lanes;
use crate::layer::{LANES, Layer};
use crate::packed::Packed;
use crate::path::Path;
use crate::pixels::Borders;
use crate::unpacked::pack_layers;
use crate::{Arithmetic, ReadError};

/// What parts begin at multiples of: cache lines.
const ALIGNMENT: usize = align_of::<Quads>();

impl QuantisedNetwork {
    /// Makes of the file of a network what [`Self::from_prepared`] reads.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn prepare(bytes: &[u8]) -> Result<Vec<u8>, ReadError> {
        let Contents { architecture, layers, weights, .. } = file::decode(bytes)?;
        let is_rounded = is_rounded(&architecture, &layers);
        let all = pack_layers(&architecture, &layers, weights, |layer| rounded(layer, &is_rounded))?;
        let mut prepared = file::encode(&architecture, Arithmetic::Integers, &[]);
        for weights in &all {
            match weights {
                Weights::Floats(layer) => {
                    append(&mut prepared, bytes_of(layer.weights().iter().map(|row| row.0)))
                }
                Weights::Integers(layer) => {
                    append(&mut prepared, bytemuck::cast_slice(&layer.weights).iter().copied());
                    let scales = layer.scales.iter().flat_map(|scales| [scales.units, scales.biases]);
                    append(&mut prepared, bytes_of(scales));
                }
            }
        }
        Ok(prepared)
    }

    /// Takes what [`Self::prepare`] has made, to be computed by these instructions. Weights are taken
    /// as they are: these bytes are to be a program's own. Where they do not begin at a multiple of
    /// 64 bytes, integers are copied.
    ///
    /// # Errors
    /// Bytes of another form or length.
    pub fn from_prepared(bytes: &'static [u8], path: Path) -> Result<Self, ReadError> {
        let mut parts = Parts { bytes, at: 0 };
        let head = parts.take(usize::try_from(file::length(bytes)?).unwrap_or(usize::MAX))?;
        let Shape { architecture, layers, .. } = file::shape(head)?;
        let is_rounded = is_rounded(&architecture, &layers);
        let mut steps = Vec::with_capacity(layers.len());
        for (at, layer) in layers.iter().enumerate() {
            let source = architecture.source(at);
            let borders = Borders::of_layer(&layers, at, source);
            let weights = match reads_integers(source, &is_rounded) {
                true => Weights::Integers(parts.integers(layer, borders)?),
                false => Weights::Floats(parts.floats(layer, borders)?),
            };
            steps.push(Step::new(layer, weights, path));
        }
        let (expected, found) = (parts.at as u64, bytes.len() as u64);
        if expected < found {
            return Err(ReadError::TooLong { expected, found });
        }
        Ok(Self { architecture, layers, steps, is_rounded, path })
    }
}

/// Adds a part at the next place where one may begin.
fn append(prepared: &mut Vec<u8>, part: impl Iterator<Item = u8>) {
    prepared.resize(prepared.len().next_multiple_of(ALIGNMENT), 0);
    prepared.extend(part);
}

/// Rows of numbers, little-endian.
fn bytes_of(rows: impl Iterator<Item = [f32; LANES]>) -> impl Iterator<Item = u8> {
    rows.flatten().flat_map(f32::to_le_bytes)
}

/// Reads one part after the other.
struct Parts {
    bytes: &'static [u8],
    /// Where the last one ends.
    at: usize,
}

impl Parts {
    /// The next `length` bytes.
    fn take(&mut self, length: usize) -> Result<&'static [u8], ReadError> {
        let start = self.at.next_multiple_of(ALIGNMENT);
        let end = start.saturating_add(length);
        let (expected, found) = (end as u64, self.bytes.len() as u64);
        self.at = end;
        self.bytes.get(start..end).ok_or(ReadError::Truncated { expected, found })
    }

    /// The next `count` rows of numbers.
    fn rows(&mut self, count: usize) -> Result<impl Iterator<Item = [f32; LANES]>, ReadError> {
        let bytes = self.take(count * size_of::<[f32; LANES]>())?;
        let mut numbers = bytes.as_chunks().0.iter().map(|number| f32::from_le_bytes(*number));
        Ok((0..count).map(move |_| std::array::from_fn(|_| numbers.next().unwrap_or_default())))
    }

    /// A layer that is computed in floats.
    fn floats(&mut self, layer: &Layer, borders: Borders) -> Result<Packed, ReadError> {
        let weights = self.rows(layer.padded_parameters() / LANES)?.map(Lanes).collect();
        Ok(Packed::of_blocks(weights, layer, borders))
    }

    /// A layer that is computed in integers.
    fn integers(&mut self, layer: &Layer, borders: Borders) -> Result<PackedIntegers, ReadError> {
        let blocks = layer.output_planes.div_ceil(LANES);
        let bytes = self.take(blocks * layer.inputs() / TOGETHER * size_of::<Quads>())?;
        let quads = match bytemuck::try_cast_slice(bytes) {
            Ok(quads) => Cow::Borrowed(quads),
            Err(_) => Cow::Owned(bytemuck::pod_collect_to_vec(bytes)),
        };
        let mut rows = self.rows(2 * blocks)?;
        let mut next = || rows.next().unwrap_or_default();
        let scales = (0..blocks).map(|_| Scales { units: next(), biases: next() }).collect();
        Ok(PackedIntegers::of_blocks(quads, scales, layer, borders))
    }
}
