//! A training that begins with a trained network.

use super::{JOINTS, masked_batch, masked_trainer};
use crate::{Factors, Trainer, learning_rate};
use grasp_network::Network;

/// Trains a network for some steps, from a trainer on.
fn trained(mut trainer: Trainer, steps: u64) -> Trainer {
    for step in 0..steps {
        trainer.step(&masked_batch(40, step), learning_rate(1e-2, step, steps)).expect("a valid batch");
    }
    trainer
}

fn network(trainer: &Trainer) -> Network {
    Network::from_weights(trainer.architecture().clone(), trainer.weights()).expect("finite weights")
}

fn start(network: &Network, seed: u64) -> Trainer {
    let inputs = masked_batch(200, 1000).inputs;
    Trainer::from_network(network, JOINTS, seed, &inputs).expect("a supported architecture")
}

#[test]
fn it_begins_with_the_weights_of_the_network() {
    let network = network(&trained(masked_trainer(1), 30));
    let (begun, weights) = (start(&network, 2), network.weights());
    assert_eq!(begun.steps(), 0);
    let begun = begun.weights();
    assert_eq!(begun.len(), weights.len());
    for (begun, weight) in begun.iter().zip(&weights) {
        assert!((begun - weight).abs() < 1e-4 * weight.abs().max(1.0), "{begun} {weight}");
    }
}

#[test]
fn its_kernels_are_as_large_as_random_ones() {
    let network = network(&trained(masked_trainer(1), 30));
    let (begun, random) = (start(&network, 2).state, masked_trainer(2).state);
    for block in &begun.plan.blocks {
        let size = |parameters: &[f32]| {
            parameters[block.matrix.clone()].iter().map(|weight| weight * weight).sum::<f32>()
        };
        let ratio = size(&begun.parameters) / size(&random.parameters);
        assert!((0.99..1.01).contains(&ratio), "{ratio}");
    }
}

#[test]
fn what_was_learned_is_gone_on_from() {
    let learned = trained(masked_trainer(1), 60);
    let loss = |trainer: &mut Trainer| trainer.differentiate(&masked_batch(40, 7)).total(&Factors::default());
    let mut begun = start(&network(&learned), 2);
    let (before, fresh) = (loss(&mut begun), loss(&mut masked_trainer(2)));
    // The joints' places are learned anew, and so not all is known.
    assert!(before < fresh, "{before} {fresh}");
    let mut more = trained(begun, 60);
    assert!(loss(&mut more) < before);
}

#[test]
fn the_same_start_is_the_same_training() {
    let network = network(&trained(masked_trainer(1), 10));
    let [one, other] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| trained(start(&network, 2), 5).state)
    });
    assert!(one == other);
}
