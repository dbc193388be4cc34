//! The inner loops in integers, by the instructions of a path.

use super::kernel::{self, compute};
use super::packed::PackedIntegers;
use super::winograd::{self, Winograd};
use crate::path::{Level, Path};
use crate::scratch::TileBuffers;

/// Integers that stand for values, and what each of them counts.
#[derive(Clone, Copy, Debug)]
pub(super) enum Integers<'a> {
    /// For instructions that sum products of bytes.
    Bytes(&'a [u8], f32),
    /// For all others.
    Words(&'a [i16], f32),
}

/// Whether a path has instructions that sum products of bytes.
pub(super) fn sums_bytes(path: Path) -> bool {
    match path.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::AvxVnni => true,
        _ => false,
    }
}

/// Computes a layer, window by window; see [`compute`]. The numbers of pixels are the fastest that
/// were measured. A dense layer has one pixel, which more at a time would compute again and again.
pub(super) fn run(path: Path, layer: &PackedIntegers, input: Integers<'_>, output: &mut [f32]) {
    let is_dense = layer.pixels.len() == 1;
    match (path.level(), input) {
        // SAFETY: the level says that the processor has the instructions: only `Path::available`,
        // which asked it, makes one.
        #[cfg(target_arch = "x86_64")]
        (Level::Avx512Vnni, Integers::Bytes(bytes, unit)) => unsafe {
            match is_dense {
                true => avx512_vnni::<1>(layer, bytes, unit, output),
                false => avx512_vnni::<8>(layer, bytes, unit, output),
            }
        },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Level::AvxVnni, Integers::Bytes(bytes, unit)) => unsafe {
            match is_dense {
                true => avx_vnni::<1>(layer, bytes, unit, output),
                false => avx_vnni::<3>(layer, bytes, unit, output),
            }
        },
        // SAFETY: as above; what has AVX-512 has AVX2.
        #[cfg(target_arch = "x86_64")]
        (Level::Avx512 | Level::Avx2, Integers::Words(words, unit)) => unsafe {
            match is_dense {
                true => avx2_words::<1>(layer, words, unit, output),
                false => avx2_words::<2>(layer, words, unit, output),
            }
        },
        (Level::Portable, Integers::Words(words, unit)) => match is_dense {
            true => portable_words::<1>(layer, words, unit, output),
            false => portable_words::<2>(layer, words, unit, output),
        },
        _ => unreachable!("values are rounded as the path takes them"),
    }
}

/// Computes a layer, tile by tile, of values as words; see [`winograd::compute`].
pub(super) fn run_tiles(
    path: Path,
    layer: &Winograd,
    (words, unit): (&[i16], f32),
    output: &mut [f32],
    buffers: &mut TileBuffers,
) {
    match path.level() {
        // SAFETY: as above; what has AVX-512 has AVX2.
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::Avx512 | Level::AvxVnni | Level::Avx2 => unsafe {
            avx2_tiles(layer, words, unit, output, buffers)
        },
        Level::Portable => portable_tiles(layer, words, unit, output, buffers),
    }
}

/// Rounds values to integers, as bytes, and returns what each counts; see [`kernel::to_bytes`].
pub(super) fn to_bytes(path: Path, values: &[f32], bytes: &mut [u8]) -> f32 {
    match path.level() {
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::Avx512 => unsafe { avx512_to_bytes(values, bytes) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::AvxVnni | Level::Avx2 => unsafe { avx2_to_bytes(values, bytes) },
        Level::Portable => kernel::to_bytes(values, bytes),
    }
}

/// The same, as words; see [`kernel::to_words`].
pub(super) fn to_words(path: Path, values: &[f32], words: &mut [i16]) -> f32 {
    match path.level() {
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::Avx512 => unsafe { avx512_to_words(values, words) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::AvxVnni | Level::Avx2 => unsafe { avx2_to_words(values, words) },
        Level::Portable => kernel::to_words(values, words),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vnni")]
fn avx512_vnni<const PIXELS: usize>(layer: &PackedIntegers, input: &[u8], unit: f32, output: &mut [f32]) {
    compute::<PIXELS>(layer, unit, output, |quads, _, starts| kernel::vnni(layer, quads, input, starts));
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avxvnni")]
fn avx_vnni<const PIXELS: usize>(layer: &PackedIntegers, input: &[u8], unit: f32, output: &mut [f32]) {
    compute::<PIXELS>(layer, unit, output, |quads, _, starts| kernel::vnni_256(layer, quads, input, starts));
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_words<const PIXELS: usize>(layer: &PackedIntegers, input: &[i16], unit: f32, output: &mut [f32]) {
    compute::<PIXELS>(layer, unit, output, |quads, width, starts| {
        kernel::words_256(layer, quads, width, input, starts)
    });
}

fn portable_words<const PIXELS: usize>(layer: &PackedIntegers, input: &[i16], unit: f32, output: &mut [f32]) {
    compute::<PIXELS>(layer, unit, output, |quads, width, starts| {
        kernel::words(layer, quads, width, input, starts)
    });
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_tiles(layer: &Winograd, input: &[i16], unit: f32, output: &mut [f32], buffers: &mut TileBuffers) {
    winograd::compute::<4>(layer, unit, input, output, buffers, |weights, values| {
        winograd::pairs_256(weights, values)
    });
}

fn portable_tiles(layer: &Winograd, input: &[i16], unit: f32, output: &mut [f32], buffers: &mut TileBuffers) {
    winograd::compute::<2>(layer, unit, input, output, buffers, winograd::pairs);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn avx512_to_bytes(values: &[f32], bytes: &mut [u8]) -> f32 {
    kernel::to_bytes(values, bytes)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_to_bytes(values: &[f32], bytes: &mut [u8]) -> f32 {
    kernel::to_bytes(values, bytes)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn avx512_to_words(values: &[f32], words: &mut [i16]) -> f32 {
    kernel::to_words(values, words)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_to_words(values: &[f32], words: &mut [i16]) -> f32 {
    kernel::to_words(values, words)
}
