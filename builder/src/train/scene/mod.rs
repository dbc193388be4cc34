//! The scene network: it sees a part of a camera picture and finds the hand, its arm and what it
//! holds, whether it is a left hand, the grasp, its stage and how the hand is turned.

mod augment;
mod cut_out;
mod empty;
mod focus;
mod lesson;
mod validation;
mod views;

use std::sync::Arc;

use grasp_network::{Architecture, Convolution, Masks, Network};
use grasp_renders::{HandModel, Part};
use grasp_terminal::Work;
use grasp_train::{Factors, ROTATION, STAGES};
use rand_chacha::ChaCha8Rng;

use super::course::{Course, Lesson, Showing};
use super::figures::Figure;
use super::{Check, Options, Scenes, Schedule};
use focus::Focus;
use lesson::SIDE;
use validation::Validation;
use views::{SceneView, Views};

/// See the module.
#[derive(Debug)]
pub struct Scene {
    views: Views,
    focus: Focus,
}

impl Course for Scene {
    type Render = SceneView;
    type Validation = Validation;

    fn new(options: &Options) -> Self {
        let focus = Focus::of(options.kind);
        let scenes = Scenes::training(options.seed, options.poses()).with_hands(options.hands);
        let scenes = scenes.with_stages(focus.stages);
        Self { views: Views::new(scenes, focus.cut_out, &options.left_out, options.seed), focus }
    }

    /// 30 million multiply-adds.
    fn architecture(&self) -> Architecture {
        let convolution = |kernel, stride, outputs| Convolution { kernel, stride, outputs };
        Architecture {
            side: SIDE as u32,
            planes: 3,
            convolutions: vec![
                convolution(5, 2, 16),
                convolution(3, 2, 32),
                convolution(3, 1, 40),
                convolution(3, 2, 96),
                convolution(3, 1, 104),
                convolution(3, 1, 104),
                convolution(3, 2, 160),
                convolution(3, 1, 160),
                convolution(3, 1, 176),
            ],
            embedding: 128,
            heads: (self.views.classes() + 2 + STAGES + ROTATION) as u32,
            masks: Some(Masks { convolution: 5, count: Part::ALL.len() as u32, cells: 4 }),
        }
    }

    fn factors(&self) -> Factors {
        self.focus.factors
    }

    fn render(&self, number: u64, views: usize) -> anyhow::Result<Vec<SceneView>> {
        self.views.render(number, views)
    }

    fn lesson(&self, view: &SceneView, showing: Showing, rng: &mut ChaCha8Rng) -> Option<Lesson> {
        lesson::lesson((&self.views, &self.focus), view, showing, rng)
    }

    fn validation_scenes(schedule: &Schedule) -> u64 {
        schedule.validation
    }

    fn validation(
        &self,
        schedule: &Schedule,
        hand_model: Option<&Arc<HandModel>>,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<Validation> {
        Validation::render(&self.focus, schedule, hand_model, check, work)
    }

    fn measure(&self, validation: &Validation, network: &Network) -> Vec<Figure> {
        validation.measure(network)
    }
}
