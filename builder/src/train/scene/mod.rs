//! The networks of scenes: each sees a part of a camera picture and says where the hand, its arm and
//! what it holds are, whether it is a left hand, the grasp, its stage and how the hand is turned.
//! What each of them is for is its [`Focus`], and its layers are those of a [`design`].

mod augment;
mod cut_out;
mod design;
mod empty;
mod focus;
mod lesson;
mod validation;
mod views;

use std::sync::Arc;

use grasp_network::{Architecture, Network};
use grasp_renders::HandModel;
use grasp_terminal::Work;
use grasp_train::{Factors, ROTATION, STAGES};
use rand_chacha::ChaCha8Rng;

use super::course::{Course, Lesson, Showing};
use super::figures::Figure;
use super::{Check, Options, Scenes, Schedule};
use focus::Focus;
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

    fn architecture(&self) -> Architecture {
        self.focus.design.architecture(self.views.classes() + 2 + STAGES + ROTATION)
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
