//! The values of a batch in every layer, forward and backward.
//!
//! A batch is cut into slices of [`SLICE`] samples, whatever threads there are, and what the slices
//! have summed is added in their order: the results do not depend on the number of threads.

use crate::convolution;
use crate::dense::{self, DenseShape};
use crate::dropout::drop_values;
use crate::matrix::Before;
use crate::normalisation::{Normalisation, Sums, sums};
use crate::plan::{Block, MaskPlan, Plan};
use grasp_network::Architecture;
use rayon::prelude::*;

/// Samples of one slice.
const SLICE: usize = 16;

/// A slice on the way back through a convolution: its inputs, its values before normalisation,
/// their gradients, and where its part of the kernel's gradient goes.
type Slice<'a> = (((&'a [f32], &'a [f32]), &'a mut [f32]), &'a mut [f32]);

/// What normalises, and whether values are dropped.
#[derive(Clone, Copy)]
pub(crate) enum Mode<'a> {
    /// By the batch's own statistics; `dropout` is the key of the random numbers.
    Training { dropout: u64 },
    /// By known statistics, in the plan's layout; nothing is dropped.
    Inference { statistics: &'a [f32] },
}

/// One normalised layer: a convolution or the embedding.
#[derive(Default)]
struct Layer {
    /// Before normalisation.
    raw: Vec<f32>,
    /// After the rectifier.
    active: Vec<f32>,
    /// The loss's gradient with respect to `active`, then to `raw`.
    gradient: Vec<f32>,
    normalisation: Normalisation,
}

/// What the network returns for a batch, or the gradients with respect to it.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    /// `[sample][head]`.
    pub(crate) heads: Vec<f32>,
    /// Logits `[sample][y][x][mask][cell y][cell x]`, by the pixels of the convolution that they
    /// are read from; empty without masks.
    pub(crate) masks: Vec<f32>,
    /// `[sample][joint][x, y, z]`; empty without joints.
    pub(crate) joints: Vec<f32>,
}

/// The values of one batch, kept for the way back.
#[derive(Default)]
pub(crate) struct Activations {
    /// The convolutions, then the embedding.
    layers: Vec<Layer>,
    /// What enters the embedding after dropout, then the gradient with respect to it.
    dropped: Vec<f32>,
    pub(crate) outputs: Outputs,
    /// The kernels' gradients slice by slice.
    partial: Vec<f32>,
}

impl Activations {
    /// Computes every layer of `inputs`, some samples.
    pub(crate) fn forward(&mut self, plan: &Plan, parameters: &[f32], inputs: &[f32], mode: Mode<'_>) {
        let samples = inputs.len() / plan.inputs();
        self.layers.resize_with(plan.blocks.len(), Layer::default);
        for (index, (shape, block)) in plan.convolutions.iter().zip(&plan.blocks).enumerate() {
            let (before, from_here) = self.layers.split_at_mut(index);
            let layer = &mut from_here[0];
            let inputs = before.last().map_or(inputs, |layer| &layer.active);
            layer.raw.resize(samples * shape.output_values(), 0.0);
            let kernel = &parameters[block.matrix.clone()];
            let size = shape.output_values();
            let slices = layer.raw.par_chunks_mut(SLICE * size);
            let slices = slices.zip(inputs.par_chunks(SLICE * shape.input_values()));
            let slices = slices.map_init(Vec::new, |columns, (outputs, inputs)| {
                convolution::forward(shape, kernel, inputs, outputs, columns);
                sums(block.outputs, size, outputs)
            });
            let slices: Vec<_> = slices.collect();
            layer.activate(block, size, &slices, parameters, 0.0, mode);
        }

        let features = self.layers[..plan.convolutions.len()].last().map_or(inputs, |layer| &layer.active);
        self.dropped.resize(features.len(), 0.0);
        match mode {
            Mode::Training { dropout } => {
                drop_all(dropout, plan.features, features, &mut self.dropped);
            }
            Mode::Inference { .. } => self.dropped.copy_from_slice(features),
        }
        let (shape, block) = (embedding_shape(plan), embedding_block(plan));
        let layer = &mut self.layers[plan.convolutions.len()];
        layer.raw.resize(samples * shape.outputs, 0.0);
        dense::forward(shape, &parameters[block.matrix.clone()], &self.dropped, &mut layer.raw);
        let slices = layer.raw.par_chunks(SLICE * shape.outputs);
        let slices: Vec<_> = slices.map(|values| sums(shape.outputs, shape.outputs, values)).collect();
        layer.activate(block, shape.outputs, &slices, parameters, Architecture::LEAK, mode);

        plan.head.forward(parameters, &layer.active, &mut self.outputs.heads);
        if let Some(joints) = &plan.joints {
            joints.forward(parameters, &layer.active, &mut self.outputs.joints);
        }
        if let Some(MaskPlan { convolution, layer, .. }) = &plan.masks {
            let inputs = &self.layers[*convolution].active;
            layer.forward(parameters, inputs, &mut self.outputs.masks);
        }
    }

    /// Computes the gradient of every parameter after a forward pass in training, from that of the
    /// outputs.
    pub(crate) fn backward(
        &mut self,
        plan: &Plan,
        parameters: &[f32],
        inputs: &[f32],
        dropout: u64,
        output_gradients: &Outputs,
        gradients: &mut [f32],
    ) {
        let (convolutions, embedding) = self.layers.split_at_mut(plan.convolutions.len());
        let embedding = &mut embedding[0];
        embedding.gradient.resize(embedding.active.len(), 0.0);
        let heads = &output_gradients.heads;
        plan.head.parameter_gradients(&embedding.active, heads, gradients);
        plan.head.input_gradients(parameters, heads, Before::Replace, &mut embedding.gradient);
        if let Some(joints) = &plan.joints {
            let of_joints = &output_gradients.joints;
            joints.parameter_gradients(&embedding.active, of_joints, gradients);
            joints.input_gradients(parameters, of_joints, Before::Add, &mut embedding.gradient);
        }

        let (shape, block) = (embedding_shape(plan), embedding_block(plan));
        let totals = embedding.rectifier_backward(block, shape.outputs, Architecture::LEAK, gradients);
        let count = embedding.raw.len() / block.outputs;
        embedding.normalisation.backward(&totals, count, &embedding.raw, &mut embedding.gradient);
        let matrix = block.matrix.clone();
        dense::matrix_gradient(shape, &self.dropped, &embedding.gradient, &mut gradients[matrix.clone()]);
        let Some(last) = convolutions.last_mut() else { return };
        let (matrix, dropped) = (&parameters[matrix], &mut self.dropped);
        dense::input_gradients(shape, matrix, &embedding.gradient, Before::Replace, dropped);
        last.gradient.resize(self.dropped.len(), 0.0);
        drop_all(dropout, plan.features, &self.dropped, &mut last.gradient);

        for (index, (shape, block)) in plan.convolutions.iter().zip(&plan.blocks).enumerate().rev() {
            let (before, from_here) = convolutions.split_at_mut(index);
            let layer = &mut from_here[0];
            if let Some(MaskPlan { layer: masks, .. }) = plan.masks_of(index) {
                let of_masks = &output_gradients.masks;
                masks.parameter_gradients(&layer.active, of_masks, gradients);
                masks.input_gradients(parameters, of_masks, Before::Add, &mut layer.gradient);
            }
            let totals = layer.rectifier_backward(block, shape.output_values(), 0.0, gradients);
            let (normalisation, count) = (&layer.normalisation, layer.raw.len() / block.outputs);
            let (inputs, input_gradients) = match before.last_mut() {
                Some(before) => {
                    before.gradient.resize(before.active.len(), 0.0);
                    (before.active.as_slice(), Some(&mut before.gradient))
                }
                None => (inputs, None),
            };
            let kernel = &parameters[block.matrix.clone()];
            let (taken, size) = (SLICE * shape.input_values(), SLICE * shape.output_values());
            self.partial.resize(layer.gradient.len().div_ceil(size) * kernel.len(), 0.0);
            let back = |columns: &mut Vec<f32>, slice: Slice<'_>, targets: Option<&mut [f32]>| {
                let (((inputs, values), gradients), partial) = slice;
                normalisation.backward(&totals, count, values, gradients);
                convolution::backward(shape, kernel, inputs, gradients, partial, targets, columns);
            };
            let slices = inputs.par_chunks(taken).zip(layer.raw.par_chunks(size));
            let slices = slices.zip(layer.gradient.par_chunks_mut(size));
            let slices = slices.zip(self.partial.par_chunks_mut(kernel.len()));
            match input_gradients {
                Some(targets) => {
                    let slices = slices.zip(targets.par_chunks_mut(taken));
                    slices.for_each_init(Vec::new, |columns, (slice, targets)| {
                        back(columns, slice, Some(targets));
                    });
                }
                None => slices.for_each_init(Vec::new, |columns, slice| back(columns, slice, None)),
            }
            add_slices(&self.partial, &mut gradients[block.matrix.clone()]);
        }
    }

    /// A layer's values before normalisation: a convolution's, by its number, or the embedding's.
    pub(crate) fn raw(&self, layer: usize) -> &[f32] {
        &self.layers[layer].raw
    }

    /// Moves running statistics towards those of the last batch: `decay` is the share that stays.
    pub(crate) fn update_statistics(&self, plan: &Plan, decay: f32, statistics: &mut [f32]) {
        for (layer, block) in self.layers.iter().zip(&plan.blocks) {
            let count = layer.raw.len() / block.outputs;
            // The variance of those that the batch was drawn from.
            let unbiased = count as f32 / (count - 1) as f32;
            for (running, mean) in statistics[block.mean.clone()].iter_mut().zip(&layer.normalisation.mean) {
                *running = decay * *running + (1.0 - decay) * mean;
            }
            let variances = &layer.normalisation.variance;
            for (running, variance) in statistics[block.variance.clone()].iter_mut().zip(variances) {
                *running = decay * *running + (1.0 - decay) * unbiased * variance;
            }
        }
    }
}

impl Layer {
    /// From `raw` to `active`. A sample has `size` values; `slices` are the sums of `raw`.
    fn activate(
        &mut self,
        block: &Block,
        size: usize,
        slices: &[Sums],
        parameters: &[f32],
        slope: f32,
        mode: Mode<'_>,
    ) {
        let (scale, shift) = (&parameters[block.scale.clone()], &parameters[block.shift.clone()]);
        self.normalisation = match mode {
            Mode::Training { .. } => {
                let total = Sums::total(block.outputs, slices);
                Normalisation::of_batch(&total, self.raw.len() / block.outputs, scale, shift)
            }
            Mode::Inference { statistics } => Normalisation::of_statistics(
                &statistics[block.mean.clone()],
                &statistics[block.variance.clone()],
                scale,
                shift,
            ),
        };
        self.active.resize(self.raw.len(), 0.0);
        let slices = self.active.par_chunks_mut(SLICE * size).zip(self.raw.par_chunks(SLICE * size));
        slices.for_each(|(outputs, values)| self.normalisation.apply(slope, values, outputs));
    }

    /// Passes `gradient` back through the rectifier, and writes the gradients of scale and shift.
    /// Returns the sums that the way back through the normalisation needs.
    fn rectifier_backward(&mut self, block: &Block, size: usize, slope: f32, gradients: &mut [f32]) -> Sums {
        let normalisation = &self.normalisation;
        let slices = self.gradient.par_chunks_mut(SLICE * size).zip(self.raw.par_chunks(SLICE * size));
        let sums: Vec<_> = slices
            .map(|(gradients, values)| normalisation.rectifier_backward(slope, size, values, gradients))
            .collect();
        let total = Sums::total(block.outputs, &sums);
        let write = |target: &mut [f32], sums: &[f64]| {
            target.iter_mut().zip(sums).for_each(|(to, from)| *to = *from as f32);
        };
        write(&mut gradients[block.shift.clone()], &total.first);
        write(&mut gradients[block.scale.clone()], &total.second);
        total
    }
}

/// Sums equally long arrays, which lie one after another, in their order.
fn add_slices(partial: &[f32], total: &mut [f32]) {
    total.fill(0.0);
    for slice in partial.chunks_exact(total.len()) {
        total.iter_mut().zip(slice).for_each(|(sum, value)| *sum += value);
    }
}

/// Dropout of a batch of samples of `size` values.
fn drop_all(key: u64, size: usize, inputs: &[f32], outputs: &mut [f32]) {
    let samples = inputs.par_chunks(size).zip(outputs.par_chunks_mut(size));
    samples.enumerate().for_each(|(sample, (inputs, outputs))| drop_values(key, sample, inputs, outputs));
}

fn embedding_block(plan: &Plan) -> &Block {
    &plan.blocks[plan.convolutions.len()]
}

fn embedding_shape(plan: &Plan) -> DenseShape {
    DenseShape { inputs: plan.features, outputs: plan.embedding() }
}
