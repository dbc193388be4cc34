//! The memory that a network runs in.

use crate::buffers::Buffers;
use crate::layer::Layer;

/// The memory that a network runs in: one for each thread, used again for each picture.
///
/// It fits itself to the network that it is used with.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(crate) buffers: Buffers,
    /// For each of the buffers, the bytes that stand for its values; empty where none are read.
    pub(crate) bytes: Vec<Vec<u8>>,
    /// The same in words.
    pub(crate) words: Vec<Vec<i16>>,
    /// What each integer of a buffer counts.
    pub(crate) units: Vec<f32>,
    /// Which of the buffers are rounded: whose bytes there are.
    is_rounded: Vec<bool>,
    /// Whether they are rounded to bytes; to words, if not.
    in_bytes: bool,
}

impl Scratch {
    /// Fits itself to a network of these layers, some of whose buffers are read as integers, in
    /// bytes or in words.
    pub(crate) fn fit(&mut self, layers: &[Layer], is_rounded: &[bool], in_bytes: bool) {
        let is_new = self.buffers.fit(layers);
        // Networks of the same layers may have their masks read from others.
        let is_read = is_new || self.is_rounded != is_rounded || self.in_bytes != in_bytes;
        if is_read {
            let size = |(buffer, is_rounded): (&Vec<f32>, &bool)| if *is_rounded { buffer.len() } else { 0 };
            let sizes: Vec<usize> = self.buffers.values.iter().zip(is_rounded).map(size).collect();
            let [bytes, words] = [usize::from(in_bytes), usize::from(!in_bytes)];
            self.bytes = sizes.iter().map(|size| vec![0; size * bytes]).collect();
            self.words = sizes.iter().map(|size| vec![0; size * words]).collect();
            self.units = vec![0.0; sizes.len()];
            self.is_rounded = is_rounded.to_vec();
            self.in_bytes = in_bytes;
        }
    }
}
