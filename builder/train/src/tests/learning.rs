//! What is learned, and that it is the same again.

use super::reference::folded_outputs;
use super::{batch, masked_batch, masked_trainer, trainer};
use crate::network::{Activations, Mode};
use crate::{Batch, BatchError, Trainer, learning_rate};
use grasp_network::{Network, Scratch};

/// Steps on batches by their number.
fn train(trainer: &mut Trainer, steps: std::ops::Range<u64>) {
    for step in steps {
        trainer.step(&batch(40, step), 1e-2).expect("a valid batch");
    }
}

/// The same with masks.
fn train_masked(trainer: &mut Trainer, steps: std::ops::Range<u64>) {
    for step in steps {
        trainer.step(&masked_batch(40, step), 1e-2).expect("a valid batch");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_weights() {
    let weights = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut trainer = trainer(1);
        let mut masked = masked_trainer(1);
        pool.install(|| {
            train(&mut trainer, 0..5);
            train_masked(&mut masked, 0..5);
        });
        [trainer.state, masked.state]
    });
    assert!(weights[0] == weights[1] && weights[0] == weights[2]);
    let mut other = trainer(2);
    train(&mut other, 0..5);
    assert!(other.state.parameters != weights[0][0].parameters);
}

#[test]
fn folded_weights_answer_as_the_trainer_does() {
    let mut trainer = trainer(1);
    train(&mut trainer, 0..30);
    let inputs = batch(5, 1000).inputs;
    let weights = trainer.weights();
    let plan = &trainer.state.plan;
    let expected = inputs.chunks(plan.inputs()).flat_map(|input| folded_outputs(plan, &weights, input));
    let network = Network::from_weights(plan.architecture.clone(), weights.clone()).expect("weights");
    let mut scratch = Scratch::default();
    let outputs = trainer.outputs(&inputs);
    assert_eq!(outputs.len(), 5 * plan.heads());
    for (input, outputs) in inputs.chunks(plan.inputs()).zip(outputs.chunks(plan.heads())) {
        let heads = network.run(&mut scratch, input).heads;
        assert!(heads.iter().zip(outputs).all(|(a, b)| (a - b).abs() < 1e-3), "{heads:?} {outputs:?}");
    }
    for (output, expected) in outputs.iter().zip(expected) {
        assert!((f64::from(*output) - expected).abs() < 1e-3, "{output} {expected}");
    }
}

#[test]
fn folded_weights_answer_with_the_masks_of_the_trainer() {
    let mut trainer = masked_trainer(1);
    train_masked(&mut trainer, 0..30);
    let inputs = batch(5, 1000).inputs;
    let plan = &trainer.state.plan;
    let (averaged, statistics) = (&trainer.state.averaged, &trainer.state.statistics);
    let mut activations = Activations::default();
    activations.forward(plan, averaged, &inputs, Mode::Inference { statistics });
    let network = Network::from_weights(plan.architecture.clone(), trainer.weights()).expect("weights");
    let (masks, mut scratch) = (plan.masks.as_ref().expect("masks"), Scratch::default());
    let samples = activations.outputs.masks.chunks(masks.values());
    for (input, logits) in inputs.chunks(plan.inputs()).zip(samples) {
        let output = network.run(&mut scratch, input).masks;
        assert_eq!(output.len(), logits.len());
        for (from, to) in masks.masks.runs(masks.side) {
            let pairs = logits[from..from + 2].iter().zip(&output[to..to + 2]);
            pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-2, "{from}: {a} {b}"));
        }
    }
}

/// Class and stage by which quarter of the picture is bright, and how much; the rotation stays.
fn quarters(samples: usize, seed: u64) -> Batch {
    let mut batch = batch(samples, seed);
    let samples = batch.targets.iter_mut().zip(batch.inputs.chunks_mut(7 * 7 * 2)).enumerate();
    for (index, (target, input)) in samples {
        let random = crate::random::bits(seed, index as u64);
        (target.class, target.stage) = (random as u32 & 3, (random >> 8) as u32 % 3);
        target.weights = crate::LossWeights::ALL;
        target.rotation = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        for (at, value) in input.iter_mut().enumerate() {
            let (y, x) = (at / 14, at / 2 % 7);
            let quarter = u32::from(y > 3) * 2 + u32::from(x > 3);
            *value *= 0.3;
            *value += if quarter == target.class { 1.0 + target.stage as f32 } else { 0.0 };
        }
    }
    batch
}

#[test]
fn a_toy_problem_is_learned() {
    let mut trainer = trainer(1);
    let steps = 600;
    for step in 0..steps {
        trainer.step(&quarters(64, step), learning_rate(1e-2, step, steps)).expect("a valid batch");
    }
    let batch = quarters(500, 99_999);
    let outputs = trainer.outputs(&batch.inputs);
    let highest = |values: &[f32]| {
        let best = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        best.map(|(index, _)| index as u32)
    };
    let answers = outputs.chunks(13).zip(&batch.targets);
    let right = answers
        .filter(|(o, t)| highest(&o[..4]) == Some(t.class) && highest(&o[4..7]) == Some(t.stage))
        .count();
    assert!(right >= 470, "{right} of 500");
    for values in outputs.chunks(13) {
        let rotation = crate::rotation_of([7, 8, 9, 10, 11, 12].map(|i| values[i]));
        let errors = rotation.as_flattened().iter().zip(batch.targets[0].rotation.as_flattened());
        assert!(errors.map(|(a, b)| (a - b) * (a - b)).sum::<f32>() < 0.05, "{rotation:?}");
    }
}

/// One mask that shows which quarter is bright, and one that shows the others; two joints in its
/// middle and opposite.
#[test]
fn masks_and_joints_are_learned() {
    let masked_quarters = |samples, seed| {
        let mut batch = quarters(samples, seed);
        for target in &batch.targets {
            let is_bright = |at: usize| u32::from(at / 8 >= 4) * 2 + u32::from(at % 8 >= 4) == target.class;
            let bright = (0..64).map(|at| f32::from(u8::from(is_bright(at))));
            let [y, x] = [target.class / 2, target.class % 2].map(|v| v as f32 - 0.5);
            batch.joints.extend([x, y, 0.3, -x, -y, 0.3]);
            batch.masks.extend(bright.clone().chain(bright.map(|share| 1.0 - share)));
        }
        batch
    };
    let mut trainer = masked_trainer(1);
    let steps = 300;
    let mut losses = crate::Losses::default();
    for step in 0..steps {
        let batch = masked_quarters(64, step);
        losses = trainer.step(&batch, learning_rate(1e-2, step, steps)).expect("a valid batch");
    }
    assert!(losses.joints < 0.2, "{losses:?}");
    let batch = masked_quarters(100, 99_999);
    let network = trainer.architecture().clone();
    let network = Network::from_weights(network, trainer.weights()).expect("weights");
    let mut scratch = Scratch::default();
    let right: usize = batch
        .inputs
        .chunks(7 * 7 * 2)
        .zip(batch.masks.chunks(128))
        .map(|(input, masks)| {
            let output = network.run(&mut scratch, input).masks;
            output.iter().zip(masks).filter(|(logit, share)| (**logit > 0.0) == (**share > 0.5)).count()
        })
        .sum();
    assert!(right >= 12_000, "{right} of 12800");
}

#[test]
fn a_sample_without_weight_has_no_mask() {
    let (mut one, mut other) = (masked_trainer(1), masked_trainer(1));
    let mut batch = masked_batch(8, 1);
    let losses = one.differentiate(&batch);
    // The samples 1 and 5.
    batch.masks[128..256].fill(0.5);
    batch.masks[640..768].fill(1.0);
    assert_eq!(other.differentiate(&batch), losses);
    assert!(one.gradients == other.gradients && losses.masks > 0.0);
    batch.targets.iter_mut().for_each(|target| target.weights.masks = 0.0);
    assert_eq!(other.differentiate(&batch).masks, 0.0);
    let masks = &other.state.plan.masks.as_ref().expect("masks").layer;
    assert!(other.gradients[masks.matrix.clone()].iter().all(|gradient| *gradient == 0.0));
}

#[test]
fn a_batch_that_does_not_fit_changes_nothing() {
    let mut trainer = trainer(1);
    let before = trainer.state.clone();
    let good = batch(4, 1);
    let bad = |change: fn(&mut Batch)| {
        let mut batch = good.clone();
        change(&mut batch);
        batch
    };
    let mut error = |batch: Batch| trainer.step(&batch, 1e-3).expect_err("a bad batch").to_string();
    assert_eq!(error(bad(|b| b.targets[2].class = 4)), "sample 2: the network has no such class");
    assert_eq!(error(bad(|b| b.targets[1].stage = 3)), "sample 1: there is no such stage");
    assert_eq!(error(bad(|b| b.inputs[98] = f32::NAN)), "sample 1: its inputs are not finite");
    assert!(error(bad(|b| b.targets[0].weights.stage = -1.0)).contains("weights"));
    assert!(error(bad(|b| b.targets[0].rotation[1][1] = f32::NAN)).contains("rotation"));
    assert!(error(bad(|b| b.inputs.truncate(300))).starts_with("300 input values where 392"));
    let too_small = BatchError::TooSmall { samples: 0 }.to_string();
    assert_eq!(error(Batch::default()), too_small);
    let masks = "256 mask values where 0 were expected: a sample has 0";
    assert_eq!(error(bad(|b| b.masks = vec![0.5; 256])), masks);
    assert!(trainer.state == before);
}

#[test]
fn masks_that_do_not_fit_change_nothing() {
    let mut trainer = masked_trainer(1);
    let before = trainer.state.clone();
    let good = masked_batch(4, 1);
    let mut error = |change: fn(&mut Batch)| {
        let mut batch = good.clone();
        change(&mut batch);
        trainer.step(&batch, 1e-3).expect_err("a bad batch").to_string()
    };
    let missing = "0 mask values where 512 were expected: a sample has 128";
    assert_eq!(error(|b| b.masks.clear()), missing);
    let range = "sample 1: its masks are not shares from 0 to 1";
    assert_eq!(error(|b| b.masks[128] = 1.1), range);
    assert_eq!(error(|b| b.masks[128] = -0.1), range);
    assert_eq!(error(|b| b.masks[255] = f32::NAN), range);
    assert!(error(|b| b.targets[0].weights.masks = f32::NAN).contains("weights"));
    assert!(trainer.state == before);
}
