//! The memory that a network runs in.

use crate::buffers::Buffers;
use crate::layer::Layer;

/// The memory that a network runs in: one for each thread, used again for each picture.
///
/// It fits itself to the network that it is used with.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// The picture and the outputs of the layers.
    pub(crate) buffers: Buffers,
    /// For each of the buffers, the bytes that stand for its values; empty where none are read.
    pub(crate) bytes: Vec<Vec<u8>>,
    /// The same in words, for processors that do not sum products of bytes.
    pub(crate) words: Vec<Vec<i16>>,
    /// What each integer of a buffer counts.
    pub(crate) units: Vec<f32>,
    /// Where layers that are computed by tiles have what they compute.
    pub(crate) tiles: TileBuffers,
    /// Which of the buffers are rounded: whose bytes or words there are.
    is_rounded: Vec<bool>,
    /// Whether they are rounded to bytes; to words, if not.
    in_bytes: bool,
}

/// What layers that are computed tile by tile have while they are computed, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileBuffers {
    /// Transformed inputs, of one place of a window after the other: `[place][tile][plane]`.
    pub(crate) inputs: Vec<i16>,
    /// Sums of products for a block of outputs: `[tile][place][output]`.
    pub(crate) sums: Vec<i32>,
}

impl Scratch {
    /// Fits itself to a network of these layers, some of whose buffers are read as integers, in
    /// bytes or in words.
    pub(crate) fn fit(&mut self, layers: &[Layer], is_rounded: &[bool], in_bytes: bool) {
        let is_new = self.buffers.fit(layers);
        // Networks of the same layers may have their masks read from others.
        if is_new || self.is_rounded != is_rounded || self.in_bytes != in_bytes {
            let size = |(buffer, is_rounded): (&Vec<f32>, &bool)| if *is_rounded { buffer.len() } else { 0 };
            let sizes: Vec<usize> = self.buffers.values.iter().zip(is_rounded).map(size).collect();
            self.bytes = sizes.iter().map(|&size| vec![0; if in_bytes { size } else { 0 }]).collect();
            self.words = sizes.iter().map(|&size| vec![0; if in_bytes { 0 } else { size }]).collect();
            self.units = vec![0.0; sizes.len()];
            self.is_rounded = is_rounded.to_vec();
            self.in_bytes = in_bytes;
        }
    }
}
