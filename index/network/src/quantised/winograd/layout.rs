//! A layer laid out in tiles.

use bytemuck::AnyBitPattern;

use super::transform::{self, KERNEL, PLACES, PLANES};
use crate::layer::{LANES, Layer, Rectifier};
use crate::pixels::Pixel;
use crate::quantised::packed::{PackedIntegers, Quads, Scales, TOGETHER};

/// Outputs that are computed together.
pub(crate) const WIDTH: usize = 16;
/// Inputs whose products one instruction sums.
pub(crate) const PAIR: usize = 2;
/// The largest product: a transformed weight sums up to nine of 127, a transformed value four of
/// 255.
const LARGEST_PRODUCT: usize = (9 * 127) * (4 * 255);
/// The most input planes: an output sums nine places, and does not overflow.
const MOST_PLANES: usize = i32::MAX as usize / (9 * LARGEST_PRODUCT);

/// The transformed weights of two inputs for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug, AnyBitPattern)]
#[repr(C, align(64))]
pub(crate) struct Pairs(pub(super) [[i16; PAIR]; WIDTH]);

/// A tile of 2 x 2 outputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// The first value of its window in the input's buffer.
    pub(super) input: usize,
    /// The first value of each output pixel.
    pub(super) outputs: [usize; 4],
}

/// A layer's transformed weights, and where its tiles lie.
#[derive(Clone, Debug)]
pub(crate) struct Winograd {
    /// `[block][place][pair of inputs]`; those of outputs past the last are 0.
    pub(super) weights: Vec<Pairs>,
    pub(super) scales: Vec<Scales>,
    /// Values of a pixel of the input.
    pub(super) planes: usize,
    /// Values from a row of the input's buffer to the next.
    pub(super) row_step: usize,
    pub(super) outputs: usize,
    pub(super) tiles: Vec<Tile>,
    pub(super) rectifier: Rectifier,
}

impl Winograd {
    /// Whether a layer of integers can be computed so: in whole tiles, whole vectors, and without
    /// overflow.
    pub(crate) fn is_supported(layer: &Layer) -> bool {
        layer.kernel == KERNEL
            && layer.stride == 1
            && layer.output_side.is_multiple_of(2)
            && (PLANES..=MOST_PLANES).contains(&layer.input_planes)
    }

    /// Transforms the weights of `layer`.
    pub(crate) fn new(packed: &PackedIntegers, layer: &Layer) -> Self {
        let (planes, blocks) = (layer.input_planes, layer.output_planes.div_ceil(WIDTH));
        let pairs = planes / PAIR;
        let mut weights: Vec<Pairs> = bytemuck::zeroed_vec(PLACES * blocks * pairs);
        let of_block = packed.weights.chunks_exact(layer.inputs() / TOGETHER);
        let halves = of_block.flat_map(|quads| [(quads, 0), (quads, WIDTH)]);
        for (block, (quads, first)) in halves.take(blocks).enumerate() {
            for pair in 0..pairs {
                let mut kernels = [[0; PAIR * WIDTH]; KERNEL * KERNEL];
                for (tap, kernel) in kernels.iter_mut().enumerate() {
                    *kernel = of_pair(&quads[(tap * planes + pair * PAIR) / TOGETHER], first, pair);
                }
                for (place, transformed) in transform::of_weights(&kernels).iter().enumerate() {
                    weights[(block * PLACES + place) * pairs + pair] = Pairs(bytemuck::cast(*transformed));
                }
            }
        }
        Self {
            weights,
            scales: packed.scales.clone(),
            planes,
            row_step: packed.row_step,
            outputs: layer.output_planes,
            tiles: tiles(&packed.pixels, layer.output_side),
            rectifier: layer.rectifier,
        }
    }
}

/// The integers of one pair of inputs for [`WIDTH`] outputs, from `first` on.
fn of_pair(quads: &Quads, first: usize, pair: usize) -> [i16; PAIR * WIDTH] {
    let mut integers = [[0; PAIR]; WIDTH];
    for (to, [a, b, c, d]) in integers.iter_mut().zip(&quads.0[first..][..WIDTH]) {
        *to = if pair.is_multiple_of(2) { [*a, *b] } else { [*c, *d] }.map(i16::from);
    }
    bytemuck::cast(integers)
}

/// The tiles of a picture of `side * side` pixels, row by row.
fn tiles(pixels: &[Pixel], side: usize) -> Vec<Tile> {
    let corners = (0..side).step_by(2).flat_map(|y| (0..side).step_by(2).map(move |x| y * side + x));
    let tile = |corner: usize| Tile {
        input: pixels[corner].input,
        outputs: [0, 1, side, side + 1].map(|next| pixels[corner + next].output),
    };
    corners.map(tile).collect()
}

const _: () = assert!(LANES == 2 * WIDTH && TOGETHER.is_multiple_of(PAIR));
