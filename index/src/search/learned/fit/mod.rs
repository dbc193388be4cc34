//! Learning the hash: the axes, the tree of hyperplanes, the centres, and the blocks.
//!
//! The memory taken is P + 12 bytes an entry besides the blocks that are made; the rows are read
//! twice, from front to back.

mod cells;
mod encode;
mod tree;

use super::axes::{self, FittedAxes};
use super::centres::Centres;
use super::{Entries, Learned, LearnedHash};
use crate::search::blocks::{self, Blocks, CodeBits};
use crate::search::rows::Rows;
use crate::search::simd::Simd;
use cells::{CHUNK, Cells};
use rayon::prelude::*;
use rkyv::util::AlignedVec;

/// Entries of a bucket, on average, that are aimed at: with fewer, more centres have to be ranked;
/// with more, more entries scanned.
const BUCKET: usize = 70;
/// The most planes: buckets are numbered in 32 bits, and this many hold four thousand million
/// entries.
pub(crate) const MAX_PLANES: u32 = 26;
/// How often entries move to the nearest centre and centres to the middle of their entries.
const ROUNDS: usize = 4;

/// A learned hash on its way into a file.
#[derive(Debug)]
pub(crate) struct Fitted {
    pub(crate) size: LearnedHash,
    pub(crate) axes: FittedAxes,
    pub(crate) groups: AlignedVec<64>,
    pub(crate) group_directory: Vec<u32>,
    pub(crate) centres: AlignedVec<64>,
    pub(crate) bucket_directory: Vec<u32>,
    pub(crate) entries: AlignedVec<64>,
}

impl Fitted {
    pub(crate) fn as_learned(&self) -> Learned<'_> {
        let axes = self.axes.count;
        Learned {
            axes: self.axes.as_axes(),
            centres: Centres {
                scale: self.size.centre_scale,
                groups: Blocks::of_centres(&self.groups, axes),
                group_directory: &self.group_directory,
                buckets: Blocks::of_centres(&self.centres, axes),
            },
            residual_scale: self.size.residual_scale,
            files: vec![Entries {
                directory: &self.bucket_directory,
                blocks: Blocks::of_entries(&self.entries, axes, self.size.code_bits),
            }],
        }
    }
}

/// How many planes `rows` entries get.
fn planes(rows: usize) -> u32 {
    let mut planes = 0;
    // The power of two nearest to the wanted number, by ratio.
    while planes < MAX_PLANES
        && (rows as f64) > BUCKET as f64 * f64::from(1 << planes) * std::f64::consts::SQRT_2
    {
        planes += 1;
    }
    planes
}

/// Learns a hash for the rows: the same one at any number of threads and on any machine's
/// instructions. `keeps_descriptors`: whether the index keeps them, to measure the best exactly.
/// `progress` hears the share that is done, and stops the work by returning an error.
pub(crate) fn fit<E: Send>(
    rows: Rows<'_>,
    keeps_descriptors: bool,
    simd: Simd,
    progress: &dyn Fn(f64) -> Result<(), E>,
) -> Result<Fitted, E> {
    let planes = planes(rows.len());
    let axes = axes::fit(rows, keeps_descriptors);
    let (axes, code_bits) =
        if keeps_descriptors { (axes.mix(), CodeBits::Four) } else { (axes, CodeBits::Eight) };
    progress(0.05)?;
    let (mut codes, centre_scale) = quantise(rows, &axes, simd);
    progress(0.15)?;
    let leaves = tree::grow(&codes, axes.count, planes);
    progress(0.35)?;
    let mut cells = Cells::new(&codes, axes.count, &leaves, planes, centre_scale);
    drop(leaves);
    let mut homes = Vec::new();
    for round in 0..ROUNDS {
        homes = cells.assign(&codes, simd);
        // The last time, entries stay with the centres that they were given to.
        if round + 1 < ROUNDS {
            cells.move_centres(&codes, &homes, simd);
        }
        progress(0.35 + 0.4 * (round + 1) as f64 / ROUNDS as f64)?;
    }
    let residuals = encode::residuals(rows, &axes, code_bits, &cells, &homes, &mut codes, simd);
    progress(0.9)?;
    let (bucket_directory, entries) =
        encode::blocks(&codes, axes.count, code_bits, &residuals, &homes, cells.places());
    progress(1.0)?;
    let size = LearnedHash {
        planes,
        axes: axes.count as u32,
        groups: cells.groups() as u32,
        centre_blocks: (cells.places() / blocks::LANES) as u32,
        entry_blocks: (entries.len() / blocks::entry_stride(axes.count, code_bits)) as u32,
        centre_scale,
        residual_scale: residuals.scale,
        code_bits,
    };
    let (groups, group_directory, centres) = cells.into_parts();
    Ok(Fitted { size, axes, groups, group_directory, centres, bucket_directory, entries })
}

/// The rows as codes in one scale: what the tree and the cells are made from.
fn quantise(rows: Rows<'_>, axes: &FittedAxes, simd: Simd) -> (Vec<i8>, f32) {
    const SAMPLE: usize = 20_000;
    let mut coordinates = vec![0.0; axes.count];
    let mut largest = f32::MIN_POSITIVE * 1e6;
    for (_, row) in axes::sample(rows, SAMPLE) {
        axes.as_axes().project(simd, row, &mut coordinates);
        largest = coordinates.iter().fold(largest, |largest, value| largest.max(value.abs()));
    }
    let scale = largest / blocks::MAX_CODE as f32;
    let mut codes = vec![0i8; rows.len() * axes.count];
    codes.par_chunks_mut(CHUNK * axes.count).zip(rows.values.par_chunks(CHUNK * rows.dim)).for_each(
        |(codes, rows_of)| {
            let mut coordinates = vec![0.0; axes.count];
            for (codes, row) in codes.chunks_exact_mut(axes.count).zip(rows_of.chunks_exact(rows.dim)) {
                axes.as_axes().project(simd, row, &mut coordinates);
                for (code, &coordinate) in codes.iter_mut().zip(&coordinates) {
                    *code = blocks::code(coordinate, 1.0 / scale, CodeBits::Eight);
                }
            }
        },
    );
    (codes, scale)
}
