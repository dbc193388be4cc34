//! The trained values at the start, and what becomes of them at the end.

use crate::normalisation::Normalisation;
use crate::plan::{MaskPlan, Plan, ROTATION};
use crate::random::{key, symmetric};

/// Random kernels and matrices of the variance that keeps a layer's values at the same size (He et
/// al., 2015: 2 over the inputs before a rectifier at 0, 1 elsewhere), evenly distributed; scales
/// of 1, no shifts, and a rotation head whose bias is the rotation by nothing.
pub(crate) fn initial(plan: &Plan, seed: u64) -> Vec<f32> {
    let mut parameters = vec![0.0; plan.parameters];
    for (index, block) in plan.blocks.iter().enumerate() {
        let gain = if index < plan.convolutions.len() { 2.0 } else { 1.0 };
        fill(key(seed, index as u64), gain, block.taps, &mut parameters[block.matrix.clone()]);
        parameters[block.scale.clone()].fill(1.0);
    }
    let stream = key(seed, plan.blocks.len() as u64);
    fill(stream, 1.0, plan.embedding(), &mut parameters[plan.head.matrix.clone()]);
    let bias = &mut parameters[plan.head.bias.clone()];
    let columns = plan.heads() - ROTATION;
    bias[columns] = 1.0;
    bias[columns + 4] = 1.0;
    if let Some(MaskPlan { layer, .. }) = &plan.masks {
        let stream = key(seed, plan.blocks.len() as u64 + 1);
        fill(stream, 1.0, layer.shape.inputs, &mut parameters[layer.matrix.clone()]);
    }
    if let Some(layer) = &plan.joints {
        let stream = key(seed, plan.blocks.len() as u64 + 2);
        fill(stream, 1.0, layer.shape.inputs, &mut parameters[layer.matrix.clone()]);
    }
    parameters
}

fn fill(key: u64, gain: f32, inputs: usize, values: &mut [f32]) {
    // Values evenly distributed in [-r, r] have the variance r^2 / 3.
    let range = (3.0 * gain / inputs as f32).sqrt();
    for (index, value) in values.iter_mut().enumerate() {
        *value = range * symmetric(key, index as u64);
    }
}

/// Means of 0 and variances of 1.
pub(crate) fn initial_statistics(plan: &Plan) -> Vec<f32> {
    let mut statistics = vec![0.0; plan.statistics];
    for block in &plan.blocks {
        statistics[block.variance.clone()].fill(1.0);
    }
    statistics
}

/// The weights in the layout of [`grasp_network::Architecture`]: each normalisation becomes a
/// factor of its kernel and a bias. The joints are left out.
pub(crate) fn fold(plan: &Plan, parameters: &[f32], statistics: &[f32]) -> Vec<f32> {
    let mut weights = Vec::with_capacity(plan.parameters);
    for block in &plan.blocks {
        let normalisation = Normalisation::of_statistics(
            &statistics[block.mean.clone()],
            &statistics[block.variance.clone()],
            &parameters[block.scale.clone()],
            &parameters[block.shift.clone()],
        );
        for row in parameters[block.matrix.clone()].chunks_exact(block.outputs) {
            weights.extend(row.iter().zip(&normalisation.factor).map(|(weight, factor)| weight * factor));
        }
        weights.extend(&normalisation.offset);
    }
    for layer in std::iter::once(&plan.head).chain(plan.masks.as_ref().map(|masks| &masks.layer)) {
        weights.extend(&parameters[layer.matrix.clone()]);
        weights.extend(&parameters[layer.bias.clone()]);
    }
    weights
}
