//! A training that begins with a trained network instead of random weights.

use crate::network::{Activations, Mode};
use crate::normalisation::EPSILON;
use crate::parameters::{initial, initial_statistics};
use crate::plan::{Block, Plan};
use crate::trainer::{State, Trainer};
use grasp_network::{ArchitectureError, Network};

impl Trainer {
    /// A network with the weights of `network`, and random ones for the joints.
    ///
    /// A network has its normalisation folded into kernels and biases; in training each layer is
    /// normalised again. So `inputs`, some samples like those that it will be trained on, show
    /// which means and variances its layers have: scales and shifts are chosen such that
    /// [`Self::weights`] are those of the network, to rounding.
    ///
    /// # Errors
    /// As [`Trainer::new`].
    ///
    /// # Panics
    /// Where `inputs` holds no whole sample.
    pub fn from_network(
        network: &Network,
        joints: usize,
        seed: u64,
        inputs: &[f32],
    ) -> Result<Self, ArchitectureError> {
        let plan = Plan::new(network.architecture(), joints)?;
        assert!(inputs.len() >= plan.inputs(), "no sample to take means and variances from");
        let random = initial(&plan, seed);
        let (mut parameters, offsets) = unfold(&plan, &network.weights(), random.clone());
        let mut statistics = initial_statistics(&plan);
        // Means of 0, and variances that divide by 1: the layers as the network has them.
        for block in &plan.blocks {
            statistics[block.variance.clone()].fill((1.0 - EPSILON) as f32);
        }
        let mut activations = Activations::default();
        let whole = inputs.len() - inputs.len() % plan.inputs();
        activations.forward(
            &plan,
            &parameters,
            &inputs[..whole],
            Mode::Inference { statistics: &statistics },
        );
        for ((at, block), offset) in plan.blocks.iter().enumerate().zip(offsets) {
            let moments = moments(activations.raw(at), block.outputs);
            normalise(block, &moments, &offset, &random, &mut parameters, &mut statistics);
        }
        Ok(Self::from_state(State::at_start(plan, seed, parameters, statistics)))
    }
}

/// Puts the weights of a network in the places of a plan, scales of 1 and biases as shifts, and
/// returns the biases of the blocks. What the network is without stays as it is.
fn unfold(plan: &Plan, weights: &[f32], mut parameters: Vec<f32>) -> (Vec<f32>, Vec<Vec<f32>>) {
    let mut rest = weights;
    let mut take = |count: usize| {
        let (first, after) = rest.split_at(count);
        rest = after;
        first
    };
    let mut offsets = Vec::with_capacity(plan.blocks.len());
    for block in &plan.blocks {
        parameters[block.matrix.clone()].copy_from_slice(take(block.matrix.len()));
        let offset = take(block.outputs);
        parameters[block.shift.clone()].copy_from_slice(offset);
        offsets.push(offset.to_vec());
    }
    for layer in std::iter::once(&plan.head).chain(plan.masks.as_ref().map(|masks| &masks.layer)) {
        parameters[layer.matrix.clone()].copy_from_slice(take(layer.matrix.len()));
        parameters[layer.bias.clone()].copy_from_slice(take(layer.bias.len()));
    }
    (parameters, offsets)
}

/// The mean and the variance of each plane.
fn moments(values: &[f32], planes: usize) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0); planes];
    for values in values.chunks_exact(planes) {
        for ((sum, squares), value) in sums.iter_mut().zip(values) {
            *sum += f64::from(*value);
            *squares += f64::from(*value) * f64::from(*value);
        }
    }
    let count = (values.len() / planes) as f64;
    let mean = |(sum, squares): (f64, f64)| (sum / count, (squares / count - (sum / count).powi(2)).max(0.0));
    sums.into_iter().map(mean).collect()
}

/// Splits what a block does into a normalisation and the rest.
///
/// A normalised layer does not depend on its kernels' size, but how far a step moves them does:
/// they get that of the random ones.
fn normalise(
    block: &Block,
    moments: &[(f64, f64)],
    offset: &[f32],
    random: &[f32],
    parameters: &mut [f32],
    statistics: &mut [f32],
) {
    let size = |matrix: &[f32], plane: usize| {
        let column = matrix.iter().skip(plane).step_by(block.outputs);
        column.map(|weight| f64::from(*weight).powi(2)).sum::<f64>().sqrt()
    };
    for (plane, ((mean, variance), offset)) in moments.iter().zip(offset).enumerate() {
        let matrix = &mut parameters[block.matrix.clone()];
        let (old, new) = (size(matrix, plane), size(&random[block.matrix.clone()], plane));
        let larger = if old > 0.0 { new / old } else { 1.0 };
        matrix.iter_mut().skip(plane).step_by(block.outputs).for_each(|weight| *weight *= larger as f32);
        let (mean_now, variance_now) = (mean * larger, variance * larger * larger);
        parameters[block.scale.start + plane] = ((variance_now + EPSILON).sqrt() / larger) as f32;
        parameters[block.shift.start + plane] = (mean + f64::from(*offset)) as f32;
        statistics[block.mean.start + plane] = mean_now as f32;
        statistics[block.variance.start + plane] = variance_now as f32;
    }
}
