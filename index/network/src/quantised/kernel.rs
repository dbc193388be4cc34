//! The inner loops in integers. Sums of integers are exact in any order, and what follows them is
//! done value by value: all paths return the same bits.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;
#[cfg(target_arch = "x86_64")]
use std::mem::transmute;

use bytemuck::NoUninit;
use wide::{i16x16, i32x8};

use super::packed::{PackedIntegers, Quads, TOGETHER};
use super::rounding::{nearest_byte, nearest_word};
use crate::kernel::{rectify, write};
use crate::layer::{LANES, Rectifier};

/// The largest integer that stands for a value.
const LARGEST_VALUE: f32 = 255.0;
/// Outputs whose weights, as words, fill a vector of 32 bytes.
const OF_VECTOR: usize = 4;
/// Vectors of sums a pixel that are kept at once where products of words are summed: two pixels
/// have their sums, values, weights and products in 16 registers.
const AT_ONCE: usize = 4;
/// The outputs of so many vectors.
const PART: usize = AT_ONCE * OF_VECTOR;

/// Computes a layer, `PIXELS` of its pixels at a time; `sums` takes the weights of a block of
/// outputs, how many of them there are and the places where windows start, and returns the sums of
/// products, of which so many are used.
///
/// `output` has the border that the layer was packed for; only the pixels inside it are written.
/// `unit` is what the input's integers count.
#[inline(always)]
pub(super) fn compute<const PIXELS: usize>(
    layer: &PackedIntegers,
    unit: f32,
    output: &mut [f32],
    sums: impl Fn(&[Quads], usize, [usize; PIXELS]) -> [[i32; LANES]; PIXELS],
) {
    // A layer has an output at least, and an output an input.
    let blocks = layer.weights.chunks_exact(layer.weights.len() / layer.scales.len());
    for ((weights, scales), first) in blocks.zip(&layer.scales).zip((0..).step_by(LANES)) {
        let width = LANES.min(layer.outputs - first);
        let units = scales.units.map(|of_weights| unit * of_weights);
        for group in layer.pixels.chunks(PIXELS) {
            // A last group that is smaller computes its last pixel several times.
            let starts = std::array::from_fn(|at| group[at.min(group.len() - 1)].input);
            for (pixel, sums) in group.iter().zip(sums(weights, width, starts)) {
                let values = finished(sums, &units, &scales.biases, layer.rectifier);
                write(&values, &mut output[pixel.output + first..][..width]);
            }
        }
    }
}

/// The outputs: what sums of integers stand for, with the biases, and what follows those.
#[inline(always)]
pub(super) fn finished<const N: usize>(
    sums: [i32; N],
    units: &[f32; N],
    biases: &[f32; N],
    rectifier: Rectifier,
) -> [f32; N] {
    let mut values = [0.0; N];
    for lane in 0..N {
        values[lane] = sums[lane] as f32 * units[lane] + biases[lane];
    }
    rectify(values, rectifier)
}

/// The rows of the windows that start at `starts`, in fours of values, with the weights of each.
#[inline(always)]
fn fours<'a, T, const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &'a [Quads],
    input: &'a [T],
    starts: [usize; PIXELS],
) -> impl Iterator<Item = (&'a [Quads], [&'a [[T; TOGETHER]]; PIXELS])> {
    let (length, step) = (layer.row_length, layer.row_step);
    quads.chunks_exact(length / TOGETHER).enumerate().map(move |(y, weights)| {
        let window = |pixel| input[starts[pixel] + y * step..][..length].as_chunks().0;
        (weights, std::array::from_fn(window))
    })
}

/// The weights of [`OF_VECTOR`] outputs, from this one on.
#[inline(always)]
fn vector_of(quads: &Quads, first: usize) -> [[i8; TOGETHER]; OF_VECTOR] {
    std::array::from_fn(|lane| quads.0[first + lane])
}

/// The sums of the first `width` outputs by products of words, in pairs, on any processor. An
/// output has two sums: of its first two and of its last two inputs of each four.
#[inline(always)]
pub(super) fn words<const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &[Quads],
    width: usize,
    input: &[i16],
    starts: [usize; PIXELS],
) -> [[i32; LANES]; PIXELS] {
    let mut all = [[0; LANES]; PIXELS];
    for first in (0..width).step_by(PART) {
        let mut sums = [[i32x8::ZERO; PIXELS]; AT_ONCE];
        for (quads, windows) in fours(layer, quads, input, starts) {
            for (at, quads) in quads.iter().enumerate() {
                let values = windows.map(|window| i16x16::from(repeated(window[at])));
                for (sums, outputs) in sums.iter_mut().zip((first..).step_by(OF_VECTOR)) {
                    let weights = i16x16::from_i8x16(bytemuck::cast(vector_of(quads, outputs)));
                    for (sum, values) in sums.iter_mut().zip(values) {
                        *sum += values.dot(weights);
                    }
                }
            }
        }
        add_pairs(sums, &mut all, first);
    }
    all
}

/// The same by vectors of 32 bytes.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn words_256<const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &[Quads],
    width: usize,
    input: &[i16],
    starts: [usize; PIXELS],
) -> [[i32; LANES]; PIXELS] {
    let mut all = [[0; LANES]; PIXELS];
    for first in (0..width).step_by(PART) {
        let mut sums = [[_mm256_setzero_si256(); PIXELS]; AT_ONCE];
        for (quads, windows) in fours(layer, quads, input, starts) {
            for (at, quads) in quads.iter().enumerate() {
                let mut values = [_mm256_setzero_si256(); PIXELS];
                for (values, window) in values.iter_mut().zip(windows) {
                    *values = _mm256_set1_epi64x(bytemuck::cast(window[at]));
                }
                for (sums, outputs) in sums.iter_mut().zip((first..).step_by(OF_VECTOR)) {
                    let weights = _mm256_cvtepi8_epi16(bytemuck::cast(vector_of(quads, outputs)));
                    for (sum, values) in sums.iter_mut().zip(values) {
                        *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(values, weights));
                    }
                }
            }
        }
        add_pairs(sums, &mut all, first);
    }
    all
}

/// Four values, again and again.
#[inline(always)]
fn repeated(values: [i16; TOGETHER]) -> [i16; 16] {
    std::array::from_fn(|at| values[at % TOGETHER])
}

/// Adds the two sums of each output, from output `first` of the block on. `V` are vectors of 32
/// bytes.
#[inline(always)]
fn add_pairs<V: NoUninit, const PIXELS: usize>(
    sums: [[V; PIXELS]; AT_ONCE],
    all: &mut [[i32; LANES]; PIXELS],
    first: usize,
) {
    for (pixel, all) in all.iter_mut().enumerate() {
        let pairs: [[[i32; 2]; OF_VECTOR]; AT_ONCE] = sums.map(|sums| bytemuck::cast(sums[pixel]));
        let pairs = pairs.as_flattened();
        all[first..].iter_mut().zip(pairs).for_each(|(sum, [one, other])| *sum = one + other);
    }
}

/// The sums by instructions that multiply four bytes by four others and add all to a sum.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vnni")]
#[inline]
pub(super) fn vnni<const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &[Quads],
    input: &[u8],
    starts: [usize; PIXELS],
) -> [[i32; LANES]; PIXELS] {
    const VECTORS: usize = LANES / 16;
    let mut sums = [[_mm512_setzero_si512(); VECTORS]; PIXELS];
    for (quads, windows) in fours(layer, quads, input, starts) {
        for (at, quads) in quads.iter().enumerate() {
            // SAFETY: both are 128 bytes, and any bytes are values of either.
            let weights = unsafe { transmute::<[[i8; TOGETHER]; LANES], [__m512i; VECTORS]>(quads.0) };
            for pixel in 0..PIXELS {
                let values = _mm512_set1_epi32(i32::from_le_bytes(windows[pixel][at]));
                for vector in 0..VECTORS {
                    let sum = &mut sums[pixel][vector];
                    *sum = _mm512_dpbusd_epi32(*sum, values, weights[vector]);
                }
            }
        }
    }
    // SAFETY: as above.
    sums.map(|sums| unsafe { transmute::<[__m512i; VECTORS], [i32; LANES]>(sums) })
}

/// The same by vectors of half the size.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avxvnni")]
#[inline]
pub(super) fn vnni_256<const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &[Quads],
    input: &[u8],
    starts: [usize; PIXELS],
) -> [[i32; LANES]; PIXELS] {
    const VECTORS: usize = LANES / 8;
    let mut sums = [[_mm256_setzero_si256(); VECTORS]; PIXELS];
    for (quads, windows) in fours(layer, quads, input, starts) {
        for (at, quads) in quads.iter().enumerate() {
            let weights: [__m256i; VECTORS] = bytemuck::cast(quads.0);
            for pixel in 0..PIXELS {
                let values = _mm256_set1_epi32(i32::from_le_bytes(windows[pixel][at]));
                for vector in 0..VECTORS {
                    let sum = &mut sums[pixel][vector];
                    *sum = _mm256_dpbusd_avx_epi32(*sum, values, weights[vector]);
                }
            }
        }
    }
    sums.map(bytemuck::cast)
}

/// How integers stand for some values that are not below 0.
#[derive(Clone, Copy, Debug)]
struct Scale {
    /// Integers a unit of a value.
    of_values: f32,
    /// What each integer counts.
    unit: f32,
}

impl Scale {
    /// The largest integer stands for the largest of these.
    #[inline(always)]
    fn of(values: &[f32]) -> Self {
        // As integers, the bits of floats that are not below 0 have the floats' order, and their
        // largest is found in vectors.
        let largest = f32::from_bits(values.iter().map(|value| value.to_bits()).max().unwrap_or(0));
        // Values that are as good as 0 become 0.
        let of_values = Some(LARGEST_VALUE / largest).filter(|scale| scale.is_finite()).unwrap_or(0.0);
        Self { of_values, unit: largest / LARGEST_VALUE }
    }
}

/// Rounds values that are not below 0 to integers, as bytes. Returns what each integer counts.
#[inline(always)]
pub(super) fn to_bytes(values: &[f32], bytes: &mut [u8]) -> f32 {
    let scale = Scale::of(values);
    for (byte, value) in bytes.iter_mut().zip(values) {
        *byte = nearest_byte(*value * scale.of_values);
    }
    scale.unit
}

/// The same, as words.
#[inline(always)]
pub(super) fn to_words(values: &[f32], words: &mut [i16]) -> f32 {
    let scale = Scale::of(values);
    for (word, value) in words.iter_mut().zip(values) {
        *word = nearest_word(*value * scale.of_values);
    }
    scale.unit
}
