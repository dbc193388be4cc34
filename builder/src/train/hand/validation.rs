//! How well a network does on hands, and on poses, that it was not trained on.

use std::sync::Arc;

use anyhow::bail;
use grasp_network::{Network, Scratch};
use grasp_renders::{HandModel, PoseGroup};
use grasp_terminal::Work;
use grasp_train::{ROTATION, STAGES};
use rayon::prelude::*;

use super::render::render;
use super::sample::{Sample, Shown};
use crate::train::figures::{Figure, highest, median_deg};
use crate::train::rotation;
use crate::train::window::render_all;
use crate::train::{Check, Scenes, Schedule};

/// The same for every training, so that their figures can be compared.
const SEED: u64 = 999;
/// Views of a scene that is asked about.
const VIEWS: usize = 12;
/// Scenes whose renders are searched, for each that is asked about, and views of each.
const REFERENCE_SCENES: u64 = 2;
const REFERENCE_VIEWS: usize = 32;
/// How many neighbours vote.
const NEIGHBOURS: usize = 10;

/// Renders to measure by.
#[derive(Debug)]
pub struct Validation {
    /// Like those that the network is trained on.
    reference: Vec<Shown>,
    /// Other hands; other hands in the recorded poses that can be held out.
    groups: [Vec<Shown>; 2],
}

/// How a network does on one group of renders.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Figures {
    /// The share whose class is right, by the network itself.
    top1: f64,
    /// The median error of the rotation, in degrees.
    rotation_deg: f64,
    /// The share whose class is that of most of the 10 nearest reference renders.
    neighbours_top1: f64,
}

impl Validation {
    /// Renders what a training with these `poses` is measured by, `hand_model` in the place of
    /// other hands if there is one.
    ///
    /// # Errors
    /// Where a scene cannot be built, or `check` has stopped the work.
    pub(super) fn render(
        schedule: &Schedule,
        poses: PoseGroup,
        hand_model: Option<&Arc<HandModel>>,
        check: Check<'_>,
        work: &Work,
    ) -> anyhow::Result<Self> {
        let asked = schedule.validation;
        let plain = |scenes: &Scenes, count: u64, views: usize| -> anyhow::Result<Vec<Shown>> {
            let renders = render_all(0..count, check, |number| render(scenes, number, views))?;
            let shown: Vec<Shown> = renders.par_iter().filter_map(Sample::plain).collect();
            work.inc(count);
            if shown.is_empty() {
                bail!("no render to measure by shows a hand");
            }
            Ok(shown)
        };
        let of_hand = |scenes: Scenes| scenes.with_hand_model(hand_model.cloned());
        Ok(Self {
            reference: plain(&Scenes::training(SEED, poses), REFERENCE_SCENES * asked, REFERENCE_VIEWS)?,
            groups: [
                plain(&of_hand(Scenes::other_hands(SEED, poses)), asked, VIEWS)?,
                plain(&of_hand(Scenes::held_out_poses(SEED)), asked, VIEWS)?,
            ],
        })
    }

    /// How many scenes are rendered.
    pub(super) fn scenes(schedule: &Schedule) -> u64 {
        (REFERENCE_SCENES + 2) * schedule.validation
    }

    /// How a network does on other hands, and on them in the recorded poses that can be held out:
    /// held out or trained on, as the training was asked to.
    pub(super) fn measure(&self, network: &Network) -> Vec<Figure> {
        let reference = answers(network, &self.reference);
        let of_group = |(name, group): (&str, &Vec<Shown>)| {
            let Figures { top1, rotation_deg, neighbours_top1 } =
                figures(&answers(network, group), &reference);
            [
                Figure::new(&format!("{name}_top1"), top1),
                Figure::new(&format!("{name}_rotation_deg"), rotation_deg),
                Figure::new(&format!("{name}_neighbours_top1"), neighbours_top1),
            ]
        };
        ["hands", "poses"].into_iter().zip(&self.groups).flat_map(of_group).collect()
    }
}

/// What a network makes of a picture, and what is right.
struct Answer {
    embedding: Vec<f32>,
    class: usize,
    /// The angle between the answered and the right rotation, in degrees.
    error_deg: f64,
    right_class: usize,
}

fn answers(network: &Network, pictures: &[Shown]) -> Vec<Answer> {
    let answer = |scratch: &mut Scratch, picture: &Shown| {
        let output = network.run(scratch, &picture.planes);
        let (classes, _) = output.heads.split_at(output.heads.len() - STAGES - ROTATION);
        Answer {
            embedding: output.embedding.to_vec(),
            class: highest(classes),
            error_deg: rotation::of_heads(output.heads).angle_to(&picture.labels.orientation).to_degrees(),
            right_class: picture.labels.class,
        }
    };
    pictures.par_iter().map_init(Scratch::default, answer).collect()
}

fn figures(asked: &[Answer], reference: &[Answer]) -> Figures {
    let share = |right: usize| right as f64 / asked.len() as f64;
    let found = |answer: &&Answer| class_of_neighbours(&answer.embedding, reference) == answer.right_class;
    Figures {
        top1: share(asked.iter().filter(|answer| answer.class == answer.right_class).count()),
        rotation_deg: median_deg(asked.iter().map(|answer| answer.error_deg)),
        neighbours_top1: share(asked.par_iter().filter(found).count()),
    }
}

/// The class that most of the nearest have; of several, the first.
fn class_of_neighbours(embedding: &[f32], reference: &[Answer]) -> usize {
    let squared = |other: &Answer| -> f32 {
        embedding.iter().zip(&other.embedding).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let mut distances: Vec<(f32, usize)> =
        reference.iter().map(|other| (squared(other), other.right_class)).collect();
    let nearest = NEIGHBOURS.min(distances.len());
    if nearest < distances.len() {
        distances.select_nth_unstable_by(nearest, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    let mut votes = Vec::new();
    for &(_, class) in &distances[..nearest] {
        if votes.len() <= class {
            votes.resize(class + 1, 0.0);
        }
        votes[class] += 1.0;
    }
    highest(&votes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(place: f32, class: usize, error_deg: f64, right_class: usize) -> Answer {
        Answer { embedding: vec![place, 1.0], class, error_deg, right_class }
    }

    #[test]
    fn the_nearest_ten_vote_and_no_others() {
        let near = (0..10).map(|i| answer(0.1 * i as f32, 0, 0.0, if i < 4 { 5 } else { i % 3 }));
        let far = (0..30).map(|_| answer(9.0, 0, 0.0, 4));
        let reference: Vec<Answer> = far.chain(near).collect();
        assert_eq!(class_of_neighbours(&[0.0, 1.0], &reference), 5);
        assert_eq!(class_of_neighbours(&[9.0, 1.0], &reference), 4);
        assert_eq!(class_of_neighbours(&[0.0, 1.0], &reference[..3]), 4);
    }

    #[test]
    fn figures_are_shares_and_a_median() {
        let reference = [answer(0.0, 0, 0.0, 1)];
        let asked = [answer(0.0, 1, 30.0, 1), answer(0.0, 2, 10.0, 1), answer(0.0, 1, 20.0, 2)];
        let Figures { top1, rotation_deg, neighbours_top1 } = figures(&asked, &reference);
        assert_eq!((top1, rotation_deg, neighbours_top1), (1.0 / 3.0, 20.0, 2.0 / 3.0));
    }
}
