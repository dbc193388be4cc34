//! Entries as codes of their difference from the bucket's centre, in blocks.

use super::cells::{CHUNK, Cells};
use crate::search::blocks::{self, BlockMut, CodeBits, LANES};
use crate::search::counting_sort::counting_sort;
use crate::search::learned::axes::{self, FittedAxes};
use crate::search::rows::Rows;
use crate::search::simd::Simd;
use rayon::prelude::*;
use rkyv::util::AlignedVec;

/// Rows that the unit of the codes is measured on.
const SAMPLE: usize = 20_000;
/// The share of coordinates that fit their code. The few that do not are cut off: a finer unit for
/// all others is worth more.
const CODED: f64 = 0.9995;
/// The unit of codes of four bits in standard deviations of the coordinates: of normally
/// distributed ones, fifteen such steps lose the least (J. Max, Quantizing for minimum distortion,
/// 1960, table II, has 0.335 for sixteen).
const STEP: f32 = 0.353;

/// What a distance needs besides the codes.
pub(super) struct Residuals {
    /// The unit of the codes.
    pub(super) scale: f32,
    /// For each row, `|r|^2 + 2 <c, r>`.
    scalars: Vec<f32>,
}

/// Replaces the codes of every row by those of its difference from its centre, of `bits` bits.
pub(super) fn residuals(
    rows: Rows<'_>,
    axes: &FittedAxes,
    bits: CodeBits,
    cells: &Cells,
    homes: &[u32],
    codes: &mut [i8],
    simd: Simd,
) -> Residuals {
    let residual = |row: &[f32], home: u32, coordinates: &mut [f32]| {
        axes.as_axes().project(simd, row, coordinates);
        for (coordinate, &code) in coordinates.iter_mut().zip(cells.centre(home)) {
            *coordinate -= f32::from(code) * cells.scale();
        }
    };
    let mut coordinates = vec![0.0; axes.count];
    let mut sizes = Vec::new();
    for (id, row) in axes::sample(rows, SAMPLE) {
        residual(row, homes[id as usize], &mut coordinates);
        sizes.extend(coordinates.iter().map(|value| value.abs()));
    }
    let scale = unit(sizes, bits);
    let mut scalars = vec![0.0; rows.len()];
    let chunks = (
        codes.par_chunks_mut(CHUNK * axes.count),
        rows.values.par_chunks(CHUNK * rows.dim),
        homes.par_chunks(CHUNK),
        scalars.par_chunks_mut(CHUNK),
    );
    chunks.into_par_iter().for_each(|(codes, values, homes, scalars)| {
        let mut coordinates = vec![0.0; axes.count];
        let each =
            codes.chunks_exact_mut(axes.count).zip(values.chunks_exact(rows.dim)).zip(homes).zip(scalars);
        for (((codes, row), &home), scalar) in each {
            residual(row, home, &mut coordinates);
            let (mut squares, mut with_centre) = (0i32, 0i32);
            for ((code, &coordinate), &centre) in codes.iter_mut().zip(&coordinates).zip(cells.centre(home)) {
                *code = blocks::code(coordinate, 1.0 / scale, bits);
                squares += i32::from(*code) * i32::from(*code);
                with_centre += i32::from(*code) * i32::from(centre);
            }
            *scalar = scale * scale * squares as f32 + 2.0 * scale * cells.scale() * with_centre as f32;
        }
    });
    Residuals { scale, scalars }
}

/// The unit of the codes, by the sizes of some coordinates.
fn unit(mut sizes: Vec<f32>, bits: CodeBits) -> f32 {
    let least = f32::MIN_POSITIVE * 1e6;
    match bits {
        CodeBits::Four => {
            let square: f64 = sizes.iter().map(|&size| f64::from(size) * f64::from(size)).sum();
            ((square / sizes.len() as f64).sqrt() as f32).max(least) * STEP
        }
        CodeBits::Eight => {
            let largest = ((sizes.len() - 1) as f64 * CODED) as usize;
            let (_, &mut largest, _) = sizes.select_nth_unstable_by(largest, f32::total_cmp);
            largest.max(least) / bits.largest() as f32
        }
    }
}

/// Lays the entries out in blocks, bucket by bucket, and returns where each bucket's blocks start
/// and end. Within a bucket ids ascend.
pub(super) fn blocks(
    codes: &[i8],
    axes: usize,
    bits: CodeBits,
    residuals: &Residuals,
    homes: &[u32],
    buckets: usize,
) -> (Vec<u32>, AlignedVec<64>) {
    let (ends, ids) = counting_sort(homes, buckets as u32);
    let mut members = Vec::with_capacity(buckets);
    let mut directory = vec![0u32];
    let (mut start, mut blocks) = (0, 0);
    for &end in &ends {
        let ids = &ids[start as usize..end as usize];
        blocks += ids.len().div_ceil(LANES) as u32;
        directory.push(blocks);
        members.push(ids);
        start = end;
    }
    let stride = blocks::entry_stride(axes, bits);
    let mut bytes = AlignedVec::<64>::new();
    bytes.resize(blocks as usize * stride, 0);
    let sixteens: Vec<&[u32]> = members.iter().flat_map(|ids| ids.chunks(LANES)).collect();
    bytes.par_chunks_exact_mut(stride).zip(sixteens).for_each(|(block, ids)| {
        let mut block = BlockMut::new(block, axes, bits);
        for lane in 0..LANES {
            match ids.get(lane) {
                Some(&id) => {
                    let codes = &codes[id as usize * axes..][..axes];
                    block.put(lane, codes, residuals.scalars[id as usize], Some(id));
                }
                None => block.put_nothing(lane),
            }
        }
    });
    (directory, bytes)
}
