//! How well a scene network does on hands that it was not trained on.

use std::sync::Arc;

use anyhow::ensure;
use grasp_network::{Network, Scratch};
use grasp_renders::{HandModel, Part, PoseGroup};
use grasp_terminal::Work;
use nalgebra::UnitQuaternion;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::design::SIDE;
use super::focus::Focus;
use super::lesson::{masks, planes};
use super::views::{SceneView, Views};
use crate::train::figures::{Figure, highest, median_deg};
use crate::train::rotation;
use crate::train::window::render_all;
use crate::train::{Check, Scenes, Schedule};

/// The same for every training, so that their figures can be compared.
const SEED: u64 = 998;
/// Views of a scene that is asked about.
const VIEWS: usize = 12;

/// Pictures of other hands, large enough for their grasps to be named.
#[derive(Debug)]
pub struct Validation {
    pictures: Vec<Labelled>,
    /// The classes that are grasps.
    grasps: usize,
}

/// A picture and what is right.
#[derive(Debug)]
struct Labelled {
    planes: Vec<f32>,
    masks: Vec<f32>,
    class: Option<usize>,
    rotation: UnitQuaternion<f64>,
}

impl Validation {
    pub(super) fn render(
        focus: &Focus,
        schedule: &Schedule,
        hand_model: Option<&Arc<HandModel>>,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<Self> {
        let scenes = Scenes::other_hands(SEED, PoseGroup::All).with_hand_model(hand_model.cloned());
        let views = Views::new(scenes, 0.0, &[], SEED);
        let render = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(SEED);
            rng.set_stream(number);
            let seen = views.render(number, VIEWS)?;
            Ok(seen.iter().map(|view| Labelled::new(focus, view, &mut rng)).collect())
        };
        let pictures: Vec<Labelled> = render_all(0..schedule.validation, check, render)?;
        work.inc(schedule.validation);
        ensure!(!pictures.is_empty(), "there is no scene to measure by");
        Ok(Self { pictures, grasps: views.classes() })
    }

    /// Shares of right classes and of hands told from mirrored ones, the rotation's median error,
    /// and how well the masks of hand and object cover theirs (intersection over union).
    pub(super) fn measure(&self, network: &Network) -> Vec<Figure> {
        let answer =
            |scratch: &mut Scratch, asked: &Labelled| Answer::new(network, scratch, asked, self.grasps);
        let answers: Vec<Answer> = self.pictures.par_iter().map_init(Scratch::default, answer).collect();
        let share = |of: &[&Answer], is_so: fn(&Answer) -> bool| {
            of.iter().filter(|answer| is_so(answer)).count() as f64 / of.len().max(1) as f64
        };
        let grasps: Vec<&Answer> = answers.iter().filter(|answer| answer.is_grasp).collect();
        let iou = |part: Part| {
            let [both, either] = answers.iter().fold([0.0; 2], |sum: [f64; 2], answer| {
                let [both, either] = answer.overlap[part as usize];
                [sum[0] + both, sum[1] + either]
            });
            both / either.max(1.0)
        };
        vec![
            Figure::new("hands_top1", share(&grasps, |answer| answer.is_right)),
            Figure::new("hands_rotation_deg", median_deg(grasps.iter().map(|answer| answer.error_deg))),
            Figure::new("hands_side", share(&grasps, |answer| answer.is_side_right)),
            Figure::new("hands_mask_iou", iou(Part::Hand)),
            Figure::new("forearms_mask_iou", iou(Part::Forearm)),
            Figure::new("objects_mask_iou", iou(Part::Object)),
        ]
    }
}

impl Labelled {
    fn new(focus: &Focus, view: &SceneView, rng: &mut ChaCha8Rng) -> Self {
        let framing = focus.near(&view.layers, rng);
        let picture = view.layers.paint(&framing, SIDE, rng);
        let rotation =
            grasp_index::turned_orientation(framing.turn.to_degrees(), &view.layers.camera_from_hand);
        Self {
            planes: planes(&picture),
            masks: masks(&picture, focus.design.mask_side()),
            class: view.class,
            rotation,
        }
    }
}

/// What a network makes of a picture.
struct Answer {
    is_grasp: bool,
    is_right: bool,
    is_side_right: bool,
    error_deg: f64,
    /// Of each part: cells that both the answer and the truth have, and that one of them has.
    overlap: [[f64; 2]; Part::ALL.len()],
}

impl Answer {
    fn new(network: &Network, scratch: &mut Scratch, asked: &Labelled, grasps: usize) -> Self {
        let mut flipped = asked.planes.clone();
        flipped.chunks_exact_mut(3 * SIDE).for_each(|row| row.as_chunks_mut::<3>().0.reverse());
        let mirrored = |heads: &[f32]| f64::from(heads[grasps]) - f64::from(log_sum(&heads[..grasps]));
        let other = mirrored(network.run(scratch, &flipped).heads);
        let output = network.run(scratch, &asked.planes);
        let cells = asked.masks.len() / Part::ALL.len();
        let overlap = std::array::from_fn(|part| {
            let range = part * cells..(part + 1) * cells;
            let pairs = output.masks[range.clone()].iter().zip(&asked.masks[range]);
            pairs.fold([0.0; 2], |sum, (logit, share)| {
                let (is_found, is_there) = (*logit > 0.0, *share > 0.5);
                [
                    sum[0] + f64::from(u8::from(is_found && is_there)),
                    sum[1] + f64::from(u8::from(is_found || is_there)),
                ]
            })
        });
        Self {
            is_grasp: asked.class.is_some(),
            is_right: asked.class == Some(highest(&output.heads[..grasps])),
            is_side_right: mirrored(output.heads) < other,
            error_deg: rotation::of_heads(output.heads).angle_to(&asked.rotation).to_degrees(),
            overlap,
        }
    }
}

/// The logarithm of the sum of exponentials.
fn log_sum(logits: &[f32]) -> f32 {
    let highest = logits.iter().copied().fold(f32::MIN, f32::max);
    highest + logits.iter().map(|logit| (logit - highest).exp()).sum::<f32>().ln()
}
