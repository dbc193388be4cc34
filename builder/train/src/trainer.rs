//! Training, step by step.

use crate::batch::{Batch, BatchError};
use crate::joint_loss::joint_loss;
use crate::losses::{Losses, losses};
use crate::mask_loss::mask_loss;
use crate::network::{Activations, Mode, Outputs};
use crate::optimiser::{Moments, Optimiser, average};
use crate::parameters::{fold, initial, initial_statistics};
use crate::plan::Plan;
use crate::random::key;
use grasp_network::{Architecture, ArchitectureError};

/// The share of the running statistics that stays at each step.
const STATISTICS_DECAY: f32 = 0.98;
/// The share of the averaged weights that stays at each step, once there have been enough.
const AVERAGE_DECAY: f32 = 0.999;
/// Samples that [`Trainer::outputs`] computes at once.
const SAMPLES_AT_ONCE: usize = 128;

/// What a checkpoint holds, and what the next step follows from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct State {
    pub(crate) plan: Plan,
    pub(crate) optimiser: Optimiser,
    pub(crate) seed: u64,
    /// Steps done.
    pub(crate) steps: u64,
    pub(crate) parameters: Vec<f32>,
    pub(crate) moments: Moments,
    /// The exponential moving average of the parameters.
    pub(crate) averaged: Vec<f32>,
    /// The running means and variances of each layer.
    pub(crate) statistics: Vec<f32>,
}

impl State {
    /// Before the first step.
    pub(crate) fn at_start(plan: Plan, seed: u64, parameters: Vec<f32>, statistics: Vec<f32>) -> Self {
        Self {
            optimiser: Optimiser::default(),
            seed,
            steps: 0,
            moments: Moments::new(plan.parameters),
            averaged: parameters.clone(),
            parameters,
            statistics,
            plan,
        }
    }
}

/// A network in training.
///
/// Work is done on the threads of the rayon pool that calls. The same seed and batches give the
/// same bytes on any number of threads; a processor without AVX-512 may round differently.
pub struct Trainer {
    pub(crate) state: State,
    activations: Activations,
    pub(crate) gradients: Vec<f32>,
    output_gradients: Outputs,
}

impl Trainer {
    /// A network with random weights. The positions of `joints` joints are an auxiliary target of
    /// its embedding, which makes it see the hand's pose; [`Self::weights`] omit that head.
    ///
    /// # Errors
    /// The architecture or the number of joints is not supported, or the architecture has fewer
    /// heads than two classes, [`STAGES`](crate::STAGES) and [`ROTATION`](crate::ROTATION) need.
    pub fn new(architecture: &Architecture, joints: usize, seed: u64) -> Result<Self, ArchitectureError> {
        let plan = Plan::new(architecture, joints)?;
        let (parameters, statistics) = (initial(&plan, seed), initial_statistics(&plan));
        Ok(Self::from_state(State::at_start(plan, seed, parameters, statistics)))
    }

    pub(crate) fn from_state(state: State) -> Self {
        Self {
            activations: Activations::default(),
            gradients: vec![0.0; state.plan.parameters],
            output_gradients: Outputs::default(),
            state,
        }
    }

    /// The same, with weights that are moved like this from now on.
    #[must_use]
    pub fn with_optimiser(mut self, optimiser: Optimiser) -> Self {
        self.state.optimiser = optimiser;
        self
    }

    /// How many joints' places are learned besides.
    pub fn joints(&self) -> usize {
        self.state.plan.joints()
    }

    /// The shape of the network.
    pub fn architecture(&self) -> &Architecture {
        &self.state.plan.architecture
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.state.steps
    }

    /// Learns from a batch, and returns its losses as they were before. Losses that are not finite
    /// mean that training has diverged; a checkpoint of that is rejected when it is loaded.
    ///
    /// # Errors
    /// The batch does not fit the network; nothing has been learned then.
    pub fn step(&mut self, batch: &Batch, learning_rate: f32) -> Result<Losses, BatchError> {
        batch.check(&self.state.plan)?;
        let losses = self.differentiate(batch);
        let State { plan, optimiser, steps, parameters, moments, averaged, statistics, .. } = &mut self.state;
        *steps += 1;
        moments.step(plan, *optimiser, parameters, &self.gradients, *steps, learning_rate);
        // Both averages begin with a short memory: what they started from counts for nothing.
        let done = *steps as f32;
        let decay = STATISTICS_DECAY.min((done - 1.0) / done);
        self.activations.update_statistics(plan, decay, statistics);
        let decay = AVERAGE_DECAY.min((done - 1.0) / (done + 9.0));
        average(decay, parameters, averaged);
        Ok(losses)
    }

    /// Computes the losses of a batch and the gradient of every parameter.
    pub(crate) fn differentiate(&mut self, batch: &Batch) -> Losses {
        let State { plan, seed, steps, parameters, .. } = &self.state;
        // The initial weights take the streams that count up from 0.
        let dropout = key(!*seed, *steps);
        let inputs = batch.inputs.as_slice();
        self.activations.forward(plan, parameters, inputs, Mode::Training { dropout });
        let Outputs { heads, masks, joints } = &self.activations.outputs;
        let (of, factors) = (&mut self.output_gradients, &batch.factors);
        of.heads.resize(heads.len(), 0.0);
        let mut losses = losses(plan.heads(), heads, &batch.targets, factors, &mut of.heads);
        if let Some(plan) = &plan.masks {
            of.masks.resize(masks.len(), 0.0);
            let (wanted, times) = (&batch.masks, factors.masks);
            losses.masks = mask_loss(plan, masks, wanted, &batch.targets, times, &mut of.masks);
        }
        of.joints.resize(joints.len(), 0.0);
        let (wanted, times) = (&batch.joints, factors.joints);
        losses.joints = joint_loss(plan.joints(), joints, wanted, &batch.targets, times, &mut of.joints);
        let (from, to) = (&self.output_gradients, &mut self.gradients);
        self.activations.backward(plan, parameters, inputs, dropout, from, to);
        losses
    }

    /// The averaged weights in the layout of [`Architecture`], normalisation by the running
    /// statistics folded into kernels and biases.
    pub fn weights(&self) -> Vec<f32> {
        fold(&self.state.plan, &self.state.averaged, &self.state.statistics)
    }

    /// The heads of each sample of `inputs`, by the averaged weights. An incomplete last sample is
    /// left out.
    pub fn outputs(&self, inputs: &[f32]) -> Vec<f32> {
        let State { plan, averaged, statistics, .. } = &self.state;
        let mode = Mode::Inference { statistics };
        let mut activations = Activations::default();
        let complete = inputs.len() - inputs.len() % plan.inputs();
        let mut outputs = Vec::with_capacity(complete / plan.inputs() * plan.heads());
        for inputs in inputs[..complete].chunks(SAMPLES_AT_ONCE * plan.inputs()) {
            activations.forward(plan, averaged, inputs, mode);
            outputs.extend(&activations.outputs.heads);
        }
        outputs
    }
}
