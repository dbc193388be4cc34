//! The memory that a network runs in.

use crate::buffers::Buffers;
use crate::layer::Layer;

/// The memory that a network runs in: one for each thread, used again for each picture.
///
/// It fits itself to the network that it is used with.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Where values are read as integers that are no bytes, they are rounded here.
    pub(crate) buffers: Buffers,
    /// For each of the buffers, the bytes that stand for its values; empty where none are read.
    pub(crate) bytes: Vec<Vec<u8>>,
    /// What each integer of a buffer counts.
    pub(crate) units: Vec<f32>,
    /// Which of the buffers are rounded: whose bytes there are.
    is_rounded: Vec<bool>,
}

impl Scratch {
    /// Fits itself to a network of these layers, some of whose buffers are read as integers.
    pub(crate) fn fit(&mut self, layers: &[Layer], is_rounded: &[bool]) {
        let is_new = self.buffers.fit(layers);
        // Networks of the same layers may have their masks read from others.
        if is_new || self.is_rounded != is_rounded {
            let buffers = self.buffers.values.iter().zip(is_rounded);
            let size = |(buffer, is_rounded): (&Vec<f32>, &bool)| if *is_rounded { buffer.len() } else { 0 };
            self.bytes = buffers.map(|buffer| vec![0; size(buffer)]).collect();
            self.units = vec![0.0; self.bytes.len()];
            self.is_rounded = is_rounded.to_vec();
        }
    }
}
