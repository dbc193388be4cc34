//! The inner loops, tile by tile.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

use wide::{i16x16, i32x8};

use super::layout::{PAIR, Pairs, Tile, WIDTH, Winograd};
use super::transform::{self, PLACES, PLANES, WINDOW};
use crate::kernel::write;
use crate::layer::LANES;
use crate::quantised::kernel::finished;
use crate::scratch::TileBuffers;

/// Outputs whose sums are transformed together.
const SUMS: usize = 8;

/// Values between one place's inputs and the next: else a tile's would share one set of a cache.
const APART: usize = 32;

/// Computes a layer, `TILES` of its tiles at a time; `products` takes the transformed weights of a
/// block of outputs and the transformed inputs of tiles, all of one place, and returns the sums of
/// their products.
///
/// `input`, `output` and `unit` are as window by window.
#[inline(always)]
pub(crate) fn compute<const TILES: usize>(
    layer: &Winograd,
    unit: f32,
    input: &[i16],
    output: &mut [f32],
    buffers: &mut TileBuffers,
    products: impl Fn(&[Pairs], [&[[i16; PAIR]]; TILES]) -> [[i32; WIDTH]; TILES],
) {
    let (planes, tiles) = (layer.planes, &layer.tiles);
    let of_place = tiles.len() * planes + APART;
    let inputs = at_least(&mut buffers.inputs, PLACES * of_place);
    let sums = at_least(&mut buffers.sums, tiles.len() * PLACES * WIDTH);
    let (sums, _) = sums.as_chunks_mut::<WIDTH>();

    for (tile, first) in tiles.iter().zip((0..).step_by(planes)) {
        transform_inputs(&input[tile.input..], layer.row_step, planes, &mut inputs[first..], of_place);
    }
    let blocks = layer.weights.chunks_exact(PLACES * planes / PAIR);
    for (weights, first_output) in blocks.zip((0..).step_by(WIDTH)) {
        let places = weights.chunks_exact(planes / PAIR).zip(inputs.chunks_exact(of_place));
        for (place, (weights, inputs)) in places.enumerate() {
            for first in (0..tiles.len()).step_by(TILES) {
                let group = TILES.min(tiles.len() - first);
                let mut values: [&[[i16; PAIR]]; TILES] = [&[]; TILES];
                for (at, values) in values.iter_mut().enumerate() {
                    // A last group that is smaller computes its last tile several times.
                    *values = inputs[(first + at.min(group - 1)) * planes..][..planes].as_chunks().0;
                }
                let products = products(weights, values);
                for (at, products) in products.iter().enumerate().take(group) {
                    sums[(first + at) * PLACES + place] = *products;
                }
            }
        }
        for (tile, sums) in tiles.iter().zip(sums.as_chunks().0) {
            for part in (0..WIDTH.min(layer.outputs - first_output)).step_by(SUMS) {
                write_outputs(layer, unit, output, tile, first_output + part, sums, part);
            }
        }
    }
}

/// Writes [`SUMS`] outputs of a tile from `first` on, whose sums of products lie from `part` on.
#[inline(always)]
fn write_outputs(
    layer: &Winograd,
    unit: f32,
    output: &mut [f32],
    tile: &Tile,
    first: usize,
    sums: &[[i32; WIDTH]; PLACES],
    part: usize,
) {
    let mut of_part = [&[0; SUMS]; PLACES];
    for (of_part, sums) in of_part.iter_mut().zip(sums) {
        *of_part = chunk(&sums[part..]);
    }
    let scales = &layer.scales[first / LANES];
    let (biases, mut units) = (chunk(&scales.biases[first % LANES..]), [0.0; SUMS]);
    for (unit_of_sums, of_weights) in units.iter_mut().zip(&scales.units[first % LANES..]) {
        *unit_of_sums = unit * of_weights;
    }
    let count = SUMS.min(layer.outputs - first);
    let windows = transform::of_sums(of_part);
    for (sums, to) in windows.iter().zip(tile.outputs) {
        let values = finished(*sums, &units, biases, layer.rectifier);
        write(&values, &mut output[to + first..][..count]);
    }
}

/// The first `count` values of a buffer, which grows where it is shorter.
#[inline(always)]
fn at_least<T: Clone + Default>(memory: &mut Vec<T>, count: usize) -> &mut [T] {
    if memory.len() < count {
        memory.resize(count, T::default());
    }
    &mut memory[..count]
}

/// Transforms all planes of a tile's window: those of place 0 go to the start of `transformed`,
/// those of each further place `step` values on.
#[inline(always)]
fn transform_inputs(window: &[i16], row_step: usize, planes: usize, transformed: &mut [i16], step: usize) {
    for first in (0..planes).step_by(PLANES) {
        // The last planes are computed with some before them, once more.
        let first = first.min(planes - PLANES);
        let mut values = [&[0; PLANES]; PLACES];
        for (place, values) in values.iter_mut().enumerate() {
            *values = chunk(&window[place / WINDOW * row_step + place % WINDOW * planes + first..]);
        }
        for (place, of_place) in transform::of_inputs(values).iter().enumerate() {
            transformed[place * step + first..][..PLANES].copy_from_slice(of_place);
        }
    }
}

/// The first values of so many or more.
#[inline(always)]
fn chunk<T, const N: usize>(values: &[T]) -> &[T; N] {
    values.first_chunk().expect("windows and blocks are whole")
}

/// The sums of products of words, in pairs, on any processor.
#[inline(always)]
pub(crate) fn pairs<const TILES: usize>(
    weights: &[Pairs],
    values: [&[[i16; PAIR]]; TILES],
) -> [[i32; WIDTH]; TILES] {
    let mut sums = [[i32x8::ZERO; WIDTH / 8]; TILES];
    let values = values.map(|values| &values[..weights.len()]);
    for (at, weights) in weights.iter().enumerate() {
        let weights: [i16x16; WIDTH / 8] = bytemuck::cast(weights.0);
        for (sums, values) in sums.iter_mut().zip(values) {
            let values = i16x16::from(std::array::from_fn::<_, 16, _>(|lane| values[at][lane % PAIR]));
            for (sum, weights) in sums.iter_mut().zip(weights) {
                *sum += values.dot(weights);
            }
        }
    }
    sums.map(bytemuck::cast)
}

/// The same by vectors of 32 bytes.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
pub(crate) fn pairs_256<const TILES: usize>(
    weights: &[Pairs],
    mut values: [&[[i16; PAIR]]; TILES],
) -> [[i32; WIDTH]; TILES] {
    let mut sums = [[_mm256_setzero_si256(); WIDTH / 8]; TILES];
    for values in &mut values {
        *values = &values[..weights.len()];
    }
    for (at, weights) in weights.iter().enumerate() {
        let weights: [__m256i; WIDTH / 8] = bytemuck::cast(weights.0);
        for (sums, values) in sums.iter_mut().zip(values) {
            let values = _mm256_set1_epi32(bytemuck::cast(values[at]));
            for (sum, weights) in sums.iter_mut().zip(weights) {
                *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(values, weights));
            }
        }
    }
    let mut all = [[0; WIDTH]; TILES];
    for (all, sums) in all.iter_mut().zip(sums) {
        *all = bytemuck::cast(sums);
    }
    all
}
