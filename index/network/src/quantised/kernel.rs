//! The inner loops in integers. Sums of integers are exact in any order, and what follows them is
//! done value by value: all paths return the same bits.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;
#[cfg(target_arch = "x86_64")]
use std::mem::transmute;

use super::packed::{PackedIntegers, Quads, TOGETHER};
use super::rounding::{nearest, nearest_byte};
use crate::kernel::rectify;
use crate::lanes::Lanes;
use crate::layer::LANES;

/// The largest integer that stands for a value.
const LARGEST_VALUE: f32 = 255.0;
/// Inputs whose products are summed as floats: sums of so many integers, each below 2^15, stay
/// below 2^24, to which floats are exact.
const EXACT: usize = 512;

/// Computes a layer, `PIXELS` of its pixels at a time. `weights` are [`Quads`] or rows of
/// [`Lanes`], so many for each block of outputs; `sums` takes a block's and the places where
/// windows start, and returns the sums of products.
///
/// `output` has the border that the layer was packed for; only the pixels inside it are written.
/// `unit` is what the input's integers count.
#[inline(always)]
pub(super) fn compute<const PIXELS: usize, W>(
    layer: &PackedIntegers,
    weights: &[W],
    unit: f32,
    output: &mut [f32],
    sums: impl Fn(&[W], [usize; PIXELS]) -> [[i32; LANES]; PIXELS],
) {
    // A layer has an output at least, and an output an input.
    let blocks = weights.chunks_exact(weights.len() / layer.scales.len());
    for ((weights, scales), first) in blocks.zip(&layer.scales).zip((0..).step_by(LANES)) {
        let width = LANES.min(layer.outputs - first);
        let units = scales.units.map(|of_weights| unit * of_weights);
        for group in layer.pixels.chunks(PIXELS) {
            // A last group that is smaller computes its last pixel several times.
            let starts = std::array::from_fn(|at| group[at.min(group.len() - 1)].input);
            for (pixel, sums) in group.iter().zip(sums(weights, starts)) {
                let values = rectify(scaled(sums, &units, &scales.biases), layer.rectifier);
                output[pixel.output + first..][..width].copy_from_slice(&values[..width]);
            }
        }
    }
}

/// What sums of integers stand for, and the biases.
#[inline(always)]
fn scaled(sums: [i32; LANES], units: &[f32; LANES], biases: &[f32; LANES]) -> [f32; LANES] {
    let mut values = [0.0; LANES];
    for lane in 0..LANES {
        values[lane] = sums[lane] as f32 * units[lane] + biases[lane];
    }
    values
}

/// The sums by floats, which are exact: see [`EXACT`].
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "as in the loops over floats")]
pub(super) fn by_floats<const PIXELS: usize>(
    layer: &PackedIntegers,
    rows: &[Lanes],
    input: &[f32],
    starts: [usize; PIXELS],
) -> [[i32; LANES]; PIXELS] {
    let mut sums = [[0; LANES]; PIXELS];
    let (mut exact, mut summed) = ([[0.0f32; LANES]; PIXELS], 0);
    for (y, rows) in rows.chunks_exact(layer.row_length).enumerate() {
        for (part, rows) in rows.chunks(EXACT).enumerate() {
            summed += rows.len();
            if summed > EXACT {
                add(&mut sums, &exact);
                (exact, summed) = ([[0.0; LANES]; PIXELS], rows.len());
            }
            let from = y * layer.row_step + part * EXACT;
            let windows: [&[f32]; PIXELS] =
                std::array::from_fn(|pixel| &input[starts[pixel] + from..][..rows.len()]);
            for (at, weights) in rows.iter().enumerate() {
                for pixel in 0..PIXELS {
                    let value = windows[pixel][at];
                    for lane in 0..LANES {
                        exact[pixel][lane] += value * weights.0[lane];
                    }
                }
            }
        }
    }
    add(&mut sums, &exact);
    sums
}

/// Adds sums that are exact as floats.
#[inline(always)]
fn add<const PIXELS: usize>(sums: &mut [[i32; LANES]; PIXELS], exact: &[[f32; LANES]; PIXELS]) {
    for (sum, exact) in sums.as_flattened_mut().iter_mut().zip(exact.as_flattened()) {
        *sum += *exact as i32;
    }
}

/// The rows of the windows that start at `starts`, in fours of values, with the weights of each.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn fours<'a, const PIXELS: usize>(
    layer: &PackedIntegers,
    quads: &'a [Quads],
    input: &'a [u8],
    starts: [usize; PIXELS],
) -> impl Iterator<Item = (&'a [Quads], [&'a [[u8; TOGETHER]]; PIXELS])> {
    let (length, step) = (layer.row_length, layer.row_step);
    quads.chunks_exact(length / TOGETHER).enumerate().map(move |(y, weights)| {
        let window = |pixel| input[starts[pixel] + y * step..][..length].as_chunks().0;
        (weights, std::array::from_fn(window))
    })
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
            // SAFETY: both are 128 bytes, and any bytes are values of either.
            let weights = unsafe { transmute::<[[i8; TOGETHER]; LANES], [__m256i; VECTORS]>(quads.0) };
            for pixel in 0..PIXELS {
                let values = _mm256_set1_epi32(i32::from_le_bytes(windows[pixel][at]));
                for vector in 0..VECTORS {
                    let sum = &mut sums[pixel][vector];
                    *sum = _mm256_dpbusd_avx_epi32(*sum, values, weights[vector]);
                }
            }
        }
    }
    // SAFETY: as above.
    sums.map(|sums| unsafe { transmute::<[__m256i; VECTORS], [i32; LANES]>(sums) })
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

/// The same, where the values are.
#[inline(always)]
pub(super) fn round(values: &mut [f32]) -> f32 {
    let scale = Scale::of(values);
    for value in values {
        *value = nearest(*value * scale.of_values);
    }
    scale.unit
}
