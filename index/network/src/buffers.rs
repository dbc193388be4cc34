//! Where a network's values lie while it runs.

use crate::architecture::Architecture;
use crate::layer::Layer;
use crate::masks::Masks;
use crate::output::Output;
use crate::pixels::Borders;

/// A picture and the outputs of the layers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buffers {
    /// What they fit.
    layers: Vec<Layer>,
    /// The picture, then the output of each layer, with the padding that the next layer needs: it
    /// stays 0.
    pub(crate) values: Vec<Vec<f32>>,
    /// The masks in [`Output`]'s order.
    masks: Vec<f32>,
}

impl Buffers {
    /// Fits itself to these layers, unless it does. Returns whether it had to.
    pub(crate) fn fit(&mut self, layers: &[Layer]) -> bool {
        // Buffers of the same sizes do not suffice: the zeros of the padding lie elsewhere.
        if self.layers == layers {
            return false;
        }
        let picture = layers.first().map(Layer::padded_values);
        let outputs = layers.iter().enumerate().map(|(at, layer)| {
            let side = layer.output_side + 2 * Borders::of_output(layers, at);
            side * side * layer.output_planes
        });
        self.values = picture.into_iter().chain(outputs).map(|values| vec![0.0; values]).collect();
        self.layers = layers.to_vec();
        true
    }

    /// Copies a picture into the first layer's padded input.
    pub(crate) fn set_input(&mut self, input: &[f32]) {
        let (Some(layer), Some(buffer)) = (self.layers.first(), self.values.first_mut()) else { return };
        assert_eq!(input.len(), layer.input_values(), "the values of a picture");
        let padding = layer.padding * layer.input_planes;
        let row = layer.input_side * layer.input_planes;
        let rows = buffer.chunks_exact_mut(row + 2 * padding).skip(layer.padding);
        for (padded, values) in rows.zip(input.chunks_exact(row)) {
            padded[padding..][..row].copy_from_slice(values);
        }
    }

    /// What the last layers have left in the buffers.
    pub(crate) fn output(&mut self, architecture: &Architecture) -> Output<'_> {
        self.spread(architecture.masks);
        let dense = self.values.get(architecture.convolutions.len() + 1..);
        match dense {
            Some([embedding, heads, ..]) => Output { embedding, heads, masks: &self.masks },
            _ => Output { embedding: &[], heads: &[], masks: &[] },
        }
    }

    /// Brings the outputs of the last layer, the masks', into the masks' order.
    fn spread(&mut self, masks: Option<Masks>) {
        let last = self.layers.last().zip(self.values.last());
        let Some((masks, (layer, values))) = masks.zip(last) else {
            self.masks.clear();
            return;
        };
        self.masks.resize(values.len(), 0.0);
        let cells = masks.cells as usize;
        for (from, to) in masks.runs(layer.output_side) {
            self.masks[to..][..cells].copy_from_slice(&values[from..][..cells]);
        }
    }
}
