//! The loss of the masks and its gradient.

use crate::batch::Target;
use crate::plan::MaskPlan;
use rayon::prelude::*;

/// The mean over all values of the binary cross entropy of the logits and the wanted shares: over
/// the samples by their weights, 0 where no sample has one. Writes the gradient of what it
/// adds to the total, `times` as much.
///
/// Logits and gradients are in the layer's order, `wanted` in that of [`grasp_network::Output`].
pub(crate) fn mask_loss(
    plan: &MaskPlan,
    logits: &[f32],
    wanted: &[f32],
    targets: &[Target],
    times: f32,
    gradients: &mut [f32],
) -> f32 {
    let sum: f64 = targets.iter().map(|target| f64::from(target.weights.masks)).sum();
    let value = if sum > 0.0 { 1.0 / (sum * plan.values() as f64) } else { 0.0 };
    let cells = plan.masks.cells as usize;
    let samples = logits.par_chunks(plan.values()).zip(wanted.par_chunks(plan.values()));
    let samples = samples.zip(gradients.par_chunks_mut(plan.values())).zip(targets);
    let samples = samples.map(|(((logits, wanted), gradients), target)| {
        let factor = f64::from(target.weights.masks) * value;
        let mut loss = 0.0;
        for (from, to) in plan.masks.runs(plan.side) {
            let run = logits[from..][..cells].iter().zip(&wanted[to..][..cells]);
            for ((logit, share), gradient) in run.zip(&mut gradients[from..][..cells]) {
                let (entropy, slope) = cross_entropy(*logit, *share);
                loss += f64::from(entropy);
                *gradient = times * factor as f32 * slope;
            }
        }
        factor * loss
    });
    // Summed in the samples' order, whatever threads there are.
    let samples: Vec<f64> = samples.collect();
    samples.iter().sum::<f64>() as f32
}

/// The binary cross entropy of `sigmoid(logit)` and a share, and its derivative by the logit.
fn cross_entropy(logit: f32, share: f32) -> (f32, f32) {
    // Of a number that is not above 0: it does not overflow.
    let power = (-logit.abs()).exp();
    let probability = if logit >= 0.0 { 1.0 } else { power } / (1.0 + power);
    (logit.max(0.0) - logit * share + power.ln_1p(), probability - share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cross_entropy_is_that_of_its_definition() {
        for logit in [-15.0f32, -3.0, -0.1, 0.0, 0.1, 3.0, 15.0] {
            for share in [0.0f32, 0.3, 1.0] {
                let probability = 1.0 / (1.0 + (-f64::from(logit)).exp());
                let wanted = f64::from(share);
                let expected = -(wanted * probability.ln() + (1.0 - wanted) * (1.0 - probability).ln());
                let (entropy, slope) = cross_entropy(logit, share);
                assert!((f64::from(entropy) - expected).abs() < 1e-5, "{logit} {share}: {entropy}");
                assert!((f64::from(slope) - (probability - wanted)).abs() < 1e-6, "{logit} {share}");
            }
        }
    }

    #[test]
    fn large_logits_have_finite_losses() {
        assert_eq!(cross_entropy(1e30, 1.0), (0.0, 0.0));
        assert_eq!(cross_entropy(-1e30, 0.0), (0.0, 0.0));
        assert_eq!(cross_entropy(-1e30, 1.0), (1e30, -1.0));
        assert_eq!(cross_entropy(1e30, 0.0), (1e30, 1.0));
    }
}
