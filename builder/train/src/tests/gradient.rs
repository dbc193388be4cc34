//! Gradients against central differences of the reference.

use super::reference::forward;
use super::{JOINTS, batch, masked, masked_batch, masked_trainer, small, trainer};
use crate::network::{Activations, Mode, Outputs};
use crate::{Batch, Factors, Trainer};
use grasp_network::{Architecture, Masks};

/// A forward and a backward pass with the loss `sum(outputs * weights)`, which is smooth wherever
/// no rectifier switches: the outputs, heads before masks before joints, and the gradient of every
/// parameter.
fn gradients(trainer: &Trainer, inputs: &[f32], dropout: u64, weights: &[f32]) -> (Vec<f32>, Vec<f32>) {
    let plan = &trainer.state.plan;
    let mut activations = Activations::default();
    let mut gradients = vec![f32::NAN; plan.parameters];
    let parameters = &trainer.state.parameters;
    activations.forward(plan, parameters, inputs, Mode::Training { dropout });
    let (heads, rest) = weights.split_at(activations.outputs.heads.len());
    let (masks, joints) = rest.split_at(activations.outputs.masks.len());
    let weights = Outputs { heads: heads.to_vec(), masks: masks.to_vec(), joints: joints.to_vec() };
    activations.backward(plan, parameters, inputs, dropout, &weights, &mut gradients);
    let Outputs { heads, masks, joints } = activations.outputs;
    ([heads, masks, joints].concat(), gradients)
}

#[test]
fn every_parameter_has_the_gradient_of_the_reference() {
    compare_gradients(&small(), 0);
}

#[test]
fn masks_of_any_convolution_and_joints_have_the_gradient_of_the_reference() {
    for convolution in 0..3 {
        let masks = Some(Masks { convolution, count: 1 + convolution, cells: 2 });
        compare_gradients(&Architecture { masks, ..masked() }, JOINTS);
    }
}

fn compare_gradients(architecture: &Architecture, joints: usize) {
    const DROPOUT: u64 = 9;
    // More than one slice, the last one incomplete.
    let samples = 19;
    let mut trainer = Trainer::new(architecture, joints, 3).expect("a supported architecture");
    let inputs = batch(samples, 4).inputs;
    // Scales and shifts that differ, so that none is taken for another.
    let noise = crate::random::symmetric;
    for (index, value) in trainer.state.parameters.iter_mut().enumerate() {
        *value += 0.2 * noise(5, index as u64);
    }
    let plan = &trainer.state.plan;
    let outputs = samples * (plan.heads() + plan.mask_values() + 3 * joints);
    let weights: Vec<_> = (0..outputs).map(|i| noise(6, i as u64)).collect();
    let (outputs, gradients) = gradients(&trainer, &inputs, DROPOUT, &weights);

    let mut parameters: Vec<_> = trainer.state.parameters.iter().map(|&v| f64::from(v)).collect();
    let expected = forward(plan, &parameters, &inputs, DROPOUT);
    assert_eq!(outputs.len(), expected.len());
    for (output, expected) in outputs.iter().zip(&expected) {
        assert!((f64::from(*output) - expected).abs() < 1e-4, "{output} {expected}");
    }
    let loss = |parameters: &[f64]| {
        let outputs = forward(plan, parameters, &inputs, DROPOUT);
        outputs.iter().zip(&weights).map(|(v, weight)| v * f64::from(*weight)).sum::<f64>()
    };
    for (index, gradient) in gradients.iter().enumerate() {
        const STEP: f64 = 1e-6;
        let value = parameters[index];
        parameters[index] = value + STEP;
        let above = loss(&parameters);
        parameters[index] = value - STEP;
        let below = loss(&parameters);
        parameters[index] = value;
        let expected = (above - below) / (2.0 * STEP);
        let error = (f64::from(*gradient) - expected).abs();
        assert!(error < 1e-3 * (1.0 + expected.abs()), "parameter {index}: {gradient} {expected}");
    }
}

#[test]
fn the_gradient_of_a_step_is_that_of_its_losses() {
    compare_slope(trainer(7), batch(19, 8));
    compare_slope(masked_trainer(7), masked_batch(19, 8));
    let factors = Factors { stage: 2.0, rotation: 0.3, masks: 0.5, joints: 1.2 };
    compare_slope(masked_trainer(7), Batch { factors, ..masked_batch(19, 8) });
}

fn compare_slope(mut trainer: Trainer, batch: Batch) {
    let total = |trainer: &mut Trainer| f64::from(trainer.differentiate(&batch).total(&batch.factors));
    total(&mut trainer);
    let gradients = trainer.gradients.clone();
    // Along the gradient, where f32 sees the most of it.
    let squares: f32 = gradients.iter().map(|g| g * g).sum();
    let mut moved = |step: f32| {
        let before = trainer.state.parameters.clone();
        trainer.state.parameters.iter_mut().zip(&gradients).for_each(|(v, g)| *v += step * g);
        let total = total(&mut trainer);
        trainer.state.parameters = before;
        total
    };
    let step = 1e-3 / squares.sqrt();
    let slope = (moved(step) - moved(-step)) / f64::from(2.0 * step);
    assert!((slope / f64::from(squares) - 1.0).abs() < 0.01, "{slope} {squares}");
}
