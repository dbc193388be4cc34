//! Trains the network that [`grasp_network::Architecture`] describes.
//!
//! Each convolution and the embedding's dense layer are followed by batch normalisation; values are
//! dropped before the embedding. The heads are, in this order, the logits of the classes, those of
//! [`STAGES`] stages, and [`ROTATION`] values that [`rotation_of`] makes a rotation matrix of.
//! Where the network has masks, their logits shall answer with given shares. The places of joints
//! may be learned besides, by a head that the trained network is without. An [`Optimiser`] makes
//! the sum of the [`Losses`] small.
//!
//! ```
//! use grasp_network::{Architecture, Convolution, Masks};
//! use grasp_train::{Batch, LossWeights, Target, Trainer, learning_rate};
//!
//! let convolutions = vec![Convolution { kernel: 3, stride: 2, outputs: 4 }];
//! // A mask of 8 x 8 values.
//! let masks = Some(Masks { convolution: 0, count: 1, cells: 2 });
//! let architecture = Architecture { side: 8, planes: 1, convolutions, embedding: 5, heads: 15, masks };
//! let mut trainer = Trainer::new(&architecture, 0, 1)?;
//! let target = Target {
//!     class: 3,
//!     stage: 2,
//!     rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     weights: LossWeights { class: 0.0, ..LossWeights::ALL },
//! };
//! let steps = 10;
//! while trainer.steps() < steps {
//!     let masks = vec![1.0; 32 * 8 * 8];
//!     let (inputs, targets) = (vec![0.5; 32 * 8 * 8], vec![target; 32]);
//!     let batch = Batch { inputs, targets, masks, ..Batch::default() };
//!     let losses = trainer.step(&batch, learning_rate(2e-3, trainer.steps(), steps))?;
//!     assert!(losses.total(&batch.factors).is_finite());
//! }
//! let resumed = Trainer::load(&trainer.save())?;
//! assert_eq!(resumed.weights(), trainer.weights());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Work is done on the threads of the rayon pool that calls ([`rayon::ThreadPool::install`]).

mod affine;
mod batch;
mod checkpoint;
mod columns;
mod convolution;
mod dense;
mod dropout;
mod joint_loss;
mod losses;
mod mask_loss;
mod matrix;
mod network;
mod normalisation;
mod optimiser;
mod parameters;
mod plan;
mod random;
mod rotation;
mod trainer;
mod warm_start;

pub use batch::{Batch, BatchError, Factors, LossWeights, Target};
pub use checkpoint::CheckpointError;
pub use losses::Losses;
pub use optimiser::{Optimiser, learning_rate};
pub use plan::{ROTATION, STAGES};
pub use rotation::rotation_of;
pub use trainer::Trainer;

#[cfg(test)]
mod tests;
