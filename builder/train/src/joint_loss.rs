//! The loss of the joints' places and its gradient.

use crate::batch::Target;

/// Added under the root, so that a joint in its place has a gradient.
const EPSILON: f64 = 1e-4;

/// The mean distance of the joints from their places: over the samples by their weights, 0 where no
/// sample has one. Writes the gradient of what it adds to the total, `times` as much.
pub(crate) fn joint_loss(
    joints: usize,
    found: &[f32],
    wanted: &[f32],
    targets: &[Target],
    times: f32,
    gradients: &mut [f32],
) -> f32 {
    let sum: f64 = targets.iter().map(|target| f64::from(target.weights.joints)).sum();
    if joints == 0 || sum == 0.0 {
        gradients.fill(0.0);
        return 0.0;
    }
    let values = 3 * joints;
    let samples = found.chunks_exact(values).zip(wanted.chunks_exact(values));
    let mut loss = 0.0;
    for ((target, (found, wanted)), gradients) in
        targets.iter().zip(samples).zip(gradients.chunks_exact_mut(values))
    {
        let factor = f64::from(target.weights.joints) / (sum * joints as f64);
        let places = found.as_chunks::<3>().0.iter().zip(wanted.as_chunks::<3>().0);
        for ((found, wanted), gradient) in places.zip(gradients.as_chunks_mut::<3>().0) {
            let error: [f64; 3] = std::array::from_fn(|i| f64::from(found[i]) - f64::from(wanted[i]));
            let distance = (error.iter().map(|v| v * v).sum::<f64>() + EPSILON).sqrt();
            loss += factor * distance;
            *gradient = error.map(|v| (f64::from(times) * factor * v / distance) as f32);
        }
    }
    loss as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::LossWeights;

    #[test]
    fn the_loss_is_the_mean_distance_of_what_counts() {
        let target = |joints| Target {
            class: 0,
            stage: 0,
            rotation: [[0.0; 3]; 3],
            weights: LossWeights { joints, ..LossWeights::ALL },
        };
        let wanted = [0.5f32; 12];
        let mut found = wanted;
        (found[0], found[5]) = (3.5, -1.5);
        found[6..].fill(100.0);
        let mut gradients = [1.0; 12];
        let loss = joint_loss(2, &found, &wanted, &[target(1.0), target(0.0)], 3.0, &mut gradients);
        assert!((loss - 2.5).abs() < 1e-4, "{loss}");
        let expected = [1.5, 0.0, 0.0, 0.0, 0.0, -1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!(gradients.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{gradients:?}");
        let mut gradients = [1.0; 12];
        assert_eq!(joint_loss(2, &found, &wanted, &[target(0.0); 2], 3.0, &mut gradients), 0.0);
        assert_eq!(gradients, [0.0; 12]);
    }
}
