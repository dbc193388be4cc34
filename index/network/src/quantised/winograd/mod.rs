//! Convolutions of 3 x 3 by fewer products: Winograd's minimal filtering F(2 x 2, 3 x 3), in
//! integers (A. Lavin and S. Gray, "Fast Algorithms for Convolutional Neural Networks", CVPR 2016).
//!
//! A tile of 2 x 2 outputs reads a window of 4 x 4 inputs. Window and kernel are transformed into 16
//! values each, sums and differences of their own; products of the same place are summed over the
//! input planes; and the 16 sums are transformed into the tile's outputs. These are 16 products a
//! plane where the windows of the four outputs have 36. In integers all of this is exact: the bits
//! are those of the convolution window by window.
//!
//! Transformed values have up to 12 bits: this is for paths that sum products of words.
//! Instructions that sum those of bytes do twice as many at once, and windows are as quick.

mod kernel;
mod transform;

pub(crate) use kernel::TileBuffers;
#[cfg(target_arch = "x86_64")]
pub(super) use kernel::pairs_256;
pub(super) use kernel::{compute, pairs};

use bytemuck::AnyBitPattern;

use super::packed::{PackedIntegers, Quads, Scales, TOGETHER};
use crate::layer::{LANES, Layer, Rectifier};
use crate::pixels::Pixel;

/// Places of a window of 4 x 4.
const PLACES: usize = 16;
/// Outputs that are computed together.
pub(super) const WIDTH: usize = 16;
/// Inputs whose products one instruction sums.
const PAIR: usize = 2;
/// The largest product: a transformed weight sums up to nine of 127, a transformed value four of
/// 255.
const LARGEST_PRODUCT: usize = (9 * 127) * (4 * 255);
/// The most input planes: an output sums nine places, and does not overflow.
const MOST_PLANES: usize = i32::MAX as usize / (9 * LARGEST_PRODUCT);

/// The transformed weights of two inputs for a block of outputs, aligned to cache lines.
#[derive(Clone, Copy, Debug, AnyBitPattern)]
#[repr(C, align(64))]
pub(super) struct Pairs(pub(super) [[i16; PAIR]; WIDTH]);

/// A tile of 2 x 2 outputs.
#[derive(Clone, Copy, Debug)]
struct Tile {
    /// The first value of its window in the input's buffer.
    input: usize,
    /// The first value of each output pixel.
    outputs: [usize; 4],
}

/// A layer's transformed weights, and where its tiles lie.
#[derive(Clone, Debug)]
pub(super) struct Winograd {
    /// `[block][place][pair of inputs]`; those of outputs past the last are 0.
    weights: Vec<Pairs>,
    scales: Vec<Scales>,
    /// Values of a pixel of the input.
    planes: usize,
    /// Values from a row of the input's buffer to the next.
    row_step: usize,
    outputs: usize,
    tiles: Vec<Tile>,
    rectifier: Rectifier,
}

impl Winograd {
    /// Whether a layer of integers can be computed so: in whole tiles, whole vectors
    /// and without overflow.
    pub(super) fn is_supported(layer: &Layer) -> bool {
        layer.kernel == 3
            && layer.stride == 1
            && layer.output_side.is_multiple_of(2)
            && (kernel::PLANES..=MOST_PLANES).contains(&layer.input_planes)
    }

    /// Transforms the weights of `layer`.
    pub(super) fn new(packed: &PackedIntegers, layer: &Layer) -> Self {
        let (planes, blocks) = (layer.input_planes, layer.output_planes.div_ceil(WIDTH));
        let pairs = planes / PAIR;
        let mut weights: Vec<Pairs> = bytemuck::zeroed_vec(PLACES * blocks * pairs);
        let of_block = packed.weights.chunks_exact(layer.inputs() / TOGETHER);
        for (block, quads) in of_block.flat_map(|quads| [(quads, 0), (quads, WIDTH)]).take(blocks).enumerate()
        {
            let (quads, first) = quads;
            for pair in 0..pairs {
                let mut kernels = [[0; PAIR * WIDTH]; 9];
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
