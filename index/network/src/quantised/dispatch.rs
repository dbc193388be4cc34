//! The inner loops in integers, by the instructions of a path.

use super::kernel::{self, by_floats, compute};
use super::packed::{PackedIntegers, Quads, Weights};
use crate::lanes::Lanes;
use crate::path::{Level, Path};

/// Integers that stand for values, and what each of them counts.
#[derive(Clone, Copy, Debug)]
pub(super) enum Integers<'a> {
    /// For instructions that sum products of bytes.
    Bytes(&'a [u8], f32),
    /// For all others.
    Floats(&'a [f32], f32),
}

/// Whether a path has instructions that sum products of bytes.
pub(super) fn sums_bytes(path: Path) -> bool {
    match path.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::AvxVnni => true,
        _ => false,
    }
}

/// Computes a layer whose weights were packed for this path; see [`compute`].
pub(super) fn run(path: Path, layer: &PackedIntegers, input: Integers<'_>, output: &mut [f32]) {
    match (path.level(), &layer.weights, input) {
        // SAFETY: the level says that the processor has the instructions: only `Path::available`,
        // which asked it, makes one.
        #[cfg(target_arch = "x86_64")]
        (Level::Avx512Vnni, Weights::Quads(quads), Integers::Bytes(bytes, unit)) => unsafe {
            avx512_vnni(layer, quads, bytes, unit, output)
        },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Level::AvxVnni, Weights::Quads(quads), Integers::Bytes(bytes, unit)) => unsafe {
            avx_vnni(layer, quads, bytes, unit, output)
        },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Level::Avx512, Weights::Rows(rows), Integers::Floats(floats, unit)) => unsafe {
            avx512_integers(layer, rows, floats, unit, output)
        },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Level::Avx2, Weights::Rows(rows), Integers::Floats(floats, unit)) => unsafe {
            avx2_integers(layer, rows, floats, unit, output)
        },
        (_, Weights::Rows(rows), Integers::Floats(floats, unit)) => {
            portable_integers(layer, rows, floats, unit, output)
        }
        _ => unreachable!("weights and values are packed as the path takes them"),
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

/// Rounds values to integers where they are, and returns what each counts; see [`kernel::round`].
pub(super) fn round(path: Path, values: &mut [f32]) -> f32 {
    match path.level() {
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::Avx512Vnni | Level::Avx512 => unsafe { avx512_round(values) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Level::AvxVnni | Level::Avx2 => unsafe { avx2_round(values) },
        Level::Portable => kernel::round(values),
    }
}

// The numbers of pixels are the fastest that were measured.

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vnni")]
fn avx512_vnni(layer: &PackedIntegers, quads: &[Quads], input: &[u8], unit: f32, output: &mut [f32]) {
    let sums = |quads: &[Quads], starts| kernel::vnni(layer, quads, input, starts);
    compute::<8, _>(layer, quads, unit, output, sums);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avxvnni")]
fn avx_vnni(layer: &PackedIntegers, quads: &[Quads], input: &[u8], unit: f32, output: &mut [f32]) {
    let sums = |quads: &[Quads], starts| kernel::vnni_256(layer, quads, input, starts);
    compute::<3, _>(layer, quads, unit, output, sums);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn avx512_integers(layer: &PackedIntegers, rows: &[Lanes], input: &[f32], unit: f32, output: &mut [f32]) {
    let sums = |rows: &[Lanes], starts| by_floats(layer, rows, input, starts);
    compute::<4, _>(layer, rows, unit, output, sums);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_integers(layer: &PackedIntegers, rows: &[Lanes], input: &[f32], unit: f32, output: &mut [f32]) {
    let sums = |rows: &[Lanes], starts| by_floats(layer, rows, input, starts);
    compute::<2, _>(layer, rows, unit, output, sums);
}

fn portable_integers(layer: &PackedIntegers, rows: &[Lanes], input: &[f32], unit: f32, output: &mut [f32]) {
    let sums = |rows: &[Lanes], starts| by_floats(layer, rows, input, starts);
    compute::<2, _>(layer, rows, unit, output, sums);
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
fn avx512_round(values: &mut [f32]) -> f32 {
    kernel::round(values)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2_round(values: &mut [f32]) -> f32 {
    kernel::round(values)
}
