//! What one step of training learns from.

use crate::plan::{Plan, STAGES};
use thiserror::Error;

/// How much a sample counts in each of the losses; 0 leaves it out of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossWeights {
    /// In the loss of the class.
    pub class: f32,
    /// In the loss of the stage.
    pub stage: f32,
    /// In the loss of the rotation.
    pub rotation: f32,
    /// In the loss of the masks, where the network has any.
    pub masks: f32,
    /// In the loss of the joints, where their places are learned.
    pub joints: f32,
}

impl LossWeights {
    /// The sample counts in full in every loss.
    pub const ALL: Self = Self { class: 1.0, stage: 1.0, rotation: 1.0, masks: 1.0, joints: 1.0 };
}

impl Default for LossWeights {
    fn default() -> Self {
        Self::ALL
    }
}

/// What the network shall answer for one sample. What has no weight is not read, but must be in
/// range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The class, counted from 0.
    pub class: u32,
    /// The stage, counted from 0.
    pub stage: u32,
    /// The rotation matrix, row by row.
    pub rotation: [[f32; 3]; 3],
    /// How much the sample counts.
    pub weights: LossWeights,
}

/// The samples of one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// The samples' inputs one after another, each row by row, the planes of a pixel together.
    pub inputs: Vec<f32>,
    /// What the network shall answer, a target a sample.
    pub targets: Vec<Target>,
    /// The shares, 0 to 1, that the masks shall answer with, one sample's after another's, each
    /// `[mask][y][x]` as in [`grasp_network::Output`]; empty for networks without masks.
    pub masks: Vec<f32>,
    /// The places of the joints, one sample's after another's, three values each: in any unit and
    /// frame, values of about 1; empty where no joints are learned.
    pub joints: Vec<f32>,
    /// The weight of each loss.
    pub factors: Factors,
}

/// The weight of each loss in what training makes small; that of the class is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// The stage's loss.
    pub stage: f32,
    /// The rotation's.
    pub rotation: f32,
    /// The masks': few of their values are hand or object, and the mean over all is small.
    pub masks: f32,
    /// The joints'.
    pub joints: f32,
}

impl Default for Factors {
    fn default() -> Self {
        Self { stage: 0.3, rotation: 1.0, masks: 3.0, joints: 3.0 }
    }
}

/// A batch that nothing can be learned from. The trainer is left as it was.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum BatchError {
    /// There are too few samples to normalise over.
    #[error("a batch of {samples} samples: at least 2 are needed to normalise over")]
    TooSmall {
        /// The number of targets.
        samples: usize,
    },
    /// The inputs do not fit the targets, or are no multiple of a sample's.
    #[error("{found} input values where {expected} were expected: a sample has {sample}")]
    Length {
        /// Values in the inputs.
        found: usize,
        /// What the number of samples asks for.
        expected: usize,
        /// The values of one sample.
        sample: usize,
    },
    /// The masks do not fit the targets.
    #[error("{found} mask values where {expected} were expected: a sample has {sample}")]
    MaskLength {
        /// Values in the masks.
        found: usize,
        /// What the number of samples asks for.
        expected: usize,
        /// The values of one sample.
        sample: usize,
    },
    /// The joints do not fit the targets.
    #[error("{found} values of joints where {expected} were expected: a sample has {sample}")]
    JointLength {
        /// Values of the joints.
        found: usize,
        /// What the number of samples asks for.
        expected: usize,
        /// The values of one sample.
        sample: usize,
    },
    /// An input, a rotation, a joint or a weight is infinite or not a number, a weight is negative,
    /// or a share is not from 0 to 1.
    #[error("sample {sample}: {what}")]
    Value {
        /// The sample, counted from 0.
        sample: usize,
        /// What is wrong with it.
        what: &'static str,
    },
}

impl Batch {
    pub(crate) fn check(&self, plan: &Plan) -> Result<(), BatchError> {
        let (samples, sample) = (self.targets.len(), plan.inputs());
        if samples < 2 {
            return Err(BatchError::TooSmall { samples });
        }
        let (found, expected) = (self.inputs.len(), samples.saturating_mul(sample));
        if found != expected {
            return Err(BatchError::Length { found, expected, sample });
        }
        for (sample, (target, inputs)) in self.targets.iter().zip(self.inputs.chunks(sample)).enumerate() {
            let fault = |what| Err(BatchError::Value { sample, what });
            if target.class as usize >= plan.classes() {
                return fault("the network has no such class");
            }
            if target.stage as usize >= STAGES {
                return fault("there is no such stage");
            }
            if !target.rotation.as_flattened().iter().all(|value| value.is_finite()) {
                return fault("its rotation is not finite");
            }
            let LossWeights { class, stage, rotation, masks, joints } = target.weights;
            let weights = [class, stage, rotation, masks, joints];
            if !weights.iter().all(|weight| (0.0..=f32::MAX).contains(weight)) {
                return fault("its weights are not finite or negative");
            }
            if !inputs.iter().all(|value| value.is_finite()) {
                return fault("its inputs are not finite");
            }
        }
        self.check_masks(plan.mask_values())?;
        self.check_joints(3 * plan.joints())
    }

    /// Checks the joints, so many values a sample.
    fn check_joints(&self, sample: usize) -> Result<(), BatchError> {
        let (found, expected) = (self.joints.len(), self.targets.len().saturating_mul(sample));
        if found != expected {
            return Err(BatchError::JointLength { found, expected, sample });
        }
        if let Some(at) = self.joints.iter().position(|value| !value.is_finite()) {
            return Err(BatchError::Value { sample: at / sample, what: "its joints are not finite" });
        }
        Ok(())
    }

    /// Checks the masks, so many values a sample.
    fn check_masks(&self, sample: usize) -> Result<(), BatchError> {
        let (found, expected) = (self.masks.len(), self.targets.len().saturating_mul(sample));
        if found != expected {
            return Err(BatchError::MaskLength { found, expected, sample });
        }
        if let Some(at) = self.masks.iter().position(|share| !(0.0..=1.0).contains(share)) {
            let what = "its masks are not shares from 0 to 1";
            return Err(BatchError::Value { sample: at / sample, what });
        }
        Ok(())
    }
}
