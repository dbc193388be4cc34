//! The network of the learned descriptor: it sees a hand that was cut out and stands upright.

mod augment;
mod render;
mod sample;
mod validation;

use std::sync::Arc;

use grasp_network::{Architecture, Convolution, Network};
use grasp_renders::HandModel;
use grasp_terminal::Work;
use grasp_train::{ROTATION, STAGES};
use rand_chacha::ChaCha8Rng;

use super::course::{Course, Lesson, Showing};
use super::figures::Figure;
use super::{Check, Options, Scenes, Schedule};
use render::render;
use sample::Sample;
use validation::Validation;

/// See the module.
#[derive(Debug)]
pub struct Hand {
    scenes: Scenes,
    options: Options,
}

impl Course for Hand {
    type Render = Sample;
    type Validation = Validation;

    fn new(options: &Options) -> Self {
        let scenes = Scenes::training(options.seed, options.poses()).with_hands(options.hands);
        Self { scenes, options: options.clone() }
    }

    /// It distinguishes the classes, and hands that are mirrored.
    fn architecture(&self) -> Architecture {
        let convolution = |kernel, stride, outputs| Convolution { kernel, stride, outputs };
        Architecture {
            side: grasp_index::PLANES_SIDE as u32,
            planes: 2,
            convolutions: vec![
                convolution(5, 2, 24),
                convolution(3, 2, 48),
                convolution(3, 1, 64),
                convolution(3, 2, 128),
                convolution(3, 1, 128),
                convolution(3, 1, 128),
            ],
            embedding: 128,
            heads: (self.scenes.classes() + 1 + STAGES + ROTATION) as u32,
            masks: None,
        }
    }

    fn render(&self, number: u64, views: usize) -> anyhow::Result<Vec<Sample>> {
        render(&self.scenes, number, views)
    }

    fn lesson(&self, sample: &Sample, showing: Showing, rng: &mut ChaCha8Rng) -> Option<Lesson> {
        let shown = sample.varied(showing.is_hard, rng)?;
        let joints = sample.joints(&shown);
        let (target, planes) = if showing.is_mirrored {
            (shown.labels.target_mirrored(self.scenes.classes()), shown.mirrored().planes)
        } else {
            (shown.labels.target(), shown.planes)
        };
        Some(Lesson { planes, target, masks: Vec::new(), joints })
    }

    fn validation_scenes(schedule: &Schedule) -> u64 {
        Validation::scenes(schedule)
    }

    fn validation(
        &self,
        schedule: &Schedule,
        hand_model: Option<&Arc<HandModel>>,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<Validation> {
        Validation::render(schedule, self.options.poses_to_measure(), hand_model, check, work)
    }

    fn measure(&self, validation: &Validation, network: &Network) -> Vec<Figure> {
        validation.measure(network)
    }
}
