//! The losses of the heads and their gradient.

use crate::batch::{Factors, LossWeights, Target};
use crate::plan::{ROTATION, STAGES};
use crate::rotation::Orthonormal;

/// The probability that the true class's target keeps; the rest is spread over all classes, so that
/// logits do not grow without bound.
const CLASS_TARGET: f64 = 0.94;
/// Added under the root, so that a rotation without error has a gradient.
const EPSILON: f64 = 1e-4;

/// The mean losses of a batch: over its samples by their weights, 0 where no sample has one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Cross entropy of the class, labels smoothed: 0.94 and 0.06 spread over all classes.
    pub class: f32,
    /// Cross entropy of the stage.
    pub stage: f32,
    /// The Frobenius norm of the rotation matrix's error.
    pub rotation: f32,
    /// Binary cross entropy of the masks, the mean over their values; 0 without masks.
    pub masks: f32,
    /// The mean distance of the joints from their places; 0 without joints.
    pub joints: f32,
}

impl Losses {
    /// What training makes small.
    pub fn total(&self, factors: &Factors) -> f32 {
        let heads = self.class + factors.stage * self.stage + factors.rotation * self.rotation;
        heads + factors.masks * self.masks + factors.joints * self.joints
    }
}

/// The losses of a batch's heads, `heads` values a sample; those of masks and joints are left at 0.
/// Writes the gradient of the total.
pub(crate) fn losses(
    heads: usize,
    outputs: &[f32],
    targets: &[Target],
    factors: &Factors,
    gradients: &mut [f32],
) -> Losses {
    let share = |weight: fn(&LossWeights) -> f32| {
        let sum: f64 = targets.iter().map(|target| f64::from(weight(&target.weights))).sum();
        if sum > 0.0 { 1.0 / sum } else { 0.0 }
    };
    let shares = [share(|w| w.class), share(|w| w.stage), share(|w| w.rotation)];
    let mut sums = [0.0; 3];
    let samples = outputs.chunks_exact(heads).zip(gradients.chunks_exact_mut(heads));
    for (target, (outputs, gradients)) in targets.iter().zip(samples) {
        let LossWeights { class, stage, rotation, .. } = target.weights;
        let [class, stage, rotation] =
            [f64::from(class) * shares[0], f64::from(stage) * shares[1], f64::from(rotation) * shares[2]];
        let (classes, rest) = outputs.split_at(heads - STAGES - ROTATION);
        let (stages, columns) = rest.split_at(STAGES);
        let (class_gradients, rest) = gradients.split_at_mut(heads - STAGES - ROTATION);
        let (stage_gradients, column_gradients) = rest.split_at_mut(STAGES);
        sums[0] += class * cross_entropy(classes, target.class, CLASS_TARGET, class, class_gradients);
        let factor = f64::from(factors.stage) * stage;
        sums[1] += stage * cross_entropy(stages, target.stage, 1.0, factor, stage_gradients);
        let factor = f64::from(factors.rotation) * rotation;
        sums[2] += rotation * rotation_error(columns, &target.rotation, factor, column_gradients);
    }
    let [class, stage, rotation] = sums.map(|sum| sum as f32);
    Losses { class, stage, rotation, masks: 0.0, joints: 0.0 }
}

/// The cross entropy of `softmax(logits)` and the target, which has `kept` on the label and the
/// rest spread over all. Writes its gradient times `factor`.
fn cross_entropy(logits: &[f32], label: u32, kept: f64, factor: f64, gradients: &mut [f32]) -> f64 {
    let highest = logits.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
    let shifted = |logit: f32| f64::from(logit) - f64::from(highest);
    let sum: f64 = logits.iter().map(|&logit| shifted(logit).exp()).sum();
    let spread = (1.0 - kept) / logits.len() as f64;
    let mut loss = 0.0;
    for (index, (&logit, gradient)) in logits.iter().zip(gradients).enumerate() {
        let target = spread + if index == label as usize { kept } else { 0.0 };
        loss += target * (sum.ln() - shifted(logit));
        *gradient = (factor * (shifted(logit).exp() / sum - target)) as f32;
    }
    loss
}

/// `sqrt(|R - truth|^2 + 1e-4)`, in the Frobenius norm. Writes its gradient times `factor`.
fn rotation_error(values: &[f32], truth: &[[f32; 3]; 3], factor: f64, gradients: &mut [f32]) -> f64 {
    let mut six = [0.0; ROTATION];
    six.iter_mut().zip(values).for_each(|(to, from)| *to = f64::from(*from));
    let rotation = Orthonormal::new(six);
    let mut errors = rotation.columns;
    for (column, errors) in errors.iter_mut().enumerate() {
        errors.iter_mut().zip(truth).for_each(|(error, row)| *error -= f64::from(row[column]));
    }
    let squares: f64 = errors.as_flattened().iter().map(|error| error * error).sum();
    let loss = (squares + EPSILON).sqrt();
    let six = rotation.backward(errors.map(|column| column.map(|error| factor * error / loss)));
    gradients.iter_mut().zip(six).for_each(|(to, from)| *to = from as f32);
    loss
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::rotation_of;

    const FACTORS: Factors = Factors { stage: 0.4, rotation: 0.7, masks: 2.0, joints: 1.5 };
    const TARGET: Target = Target {
        class: 4,
        stage: 1,
        rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        weights: LossWeights { class: 0.5, stage: 2.0, rotation: 1.5, ..LossWeights::ALL },
    };

    fn outputs() -> Vec<f32> {
        (0..30).map(|i| ((i * 37 % 23) as f32 - 11.0) / 6.0).collect()
    }

    fn total(outputs: &[f32], targets: &[Target]) -> f64 {
        let losses = losses(15, outputs, targets, &FACTORS, &mut vec![0.0; outputs.len()]);
        f64::from(losses.total(&FACTORS))
    }

    #[test]
    fn the_gradient_is_that_of_the_total() {
        let targets = [TARGET, Target { class: 0, weights: LossWeights::ALL, ..TARGET }];
        let mut gradients = vec![0.0; 30];
        losses(15, &outputs(), &targets, &FACTORS, &mut gradients);
        for (index, gradient) in gradients.iter().enumerate() {
            let at = |step: f32| {
                let mut outputs = outputs();
                outputs[index] += step;
                total(&outputs, &targets)
            };
            let expected = (at(1e-2) - at(-1e-2)) / 2e-2;
            assert!((f64::from(*gradient) - expected).abs() < 1e-4, "{index}: {gradient} {expected}");
        }
    }

    #[test]
    fn a_perfect_answer_has_the_least_losses() {
        let mut outputs = vec![-2.0; 15];
        outputs[4] = -2.0 + (0.95f32 / 0.01).ln();
        outputs[7] = 30.0;
        outputs[9..].copy_from_slice(&[0.0, 3.0, 0.0, -0.1, 0.0, 0.0]);
        let losses = losses(15, &outputs, &[TARGET], &FACTORS, &mut [0.0; 15]);
        let entropy = -(0.95 * 0.95f32.ln() + 5.0 * 0.01 * 0.01f32.ln());
        assert!((losses.class - entropy).abs() < 1e-5, "{losses:?}");
        assert!(losses.stage < 1e-6 && (losses.rotation - 0.01).abs() < 1e-5, "{losses:?}");
    }

    #[test]
    fn a_sample_without_weight_is_left_out() {
        let weights = LossWeights { class: 0.0, stage: 0.0, rotation: 0.0, ..LossWeights::ALL };
        let targets = [TARGET, Target { weights, ..TARGET }];
        let mut gradients = vec![1.0; 30];
        let both = losses(15, &outputs(), &targets, &FACTORS, &mut gradients);
        assert_eq!(gradients[15..], [0.0; 15]);
        assert_eq!(both, losses(15, &outputs()[..15], &targets[..1], &FACTORS, &mut [0.0; 15]));
        assert_eq!(losses(15, &outputs(), &[targets[1]; 2], &FACTORS, &mut gradients), Losses::default());
        assert_eq!(gradients, [0.0; 30]);
    }

    #[test]
    fn six_values_become_a_rotation() {
        let rotation = rotation_of([2.0, 0.0, 0.0, 5.0, 0.0, 3.0]);
        let expected = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
        let mut values = rotation.as_flattened().iter().zip(expected.as_flattened());
        assert!(values.all(|(a, b)| (a - b).abs() < 1e-6), "{rotation:?}");
        assert!(rotation_of([0.0; 6]).as_flattened().iter().all(|value| value.is_finite()));
    }
}
