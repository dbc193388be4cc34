//! What the network is shown of a view.

use grasp_index::turned_orientation;
use grasp_renders::random::unit;
use grasp_renders::{Framing, Layers, Part, Picture};
use grasp_train::{LossWeights, Target};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use super::augment::augment;
use super::cut_out::CutOut;
use super::design::SIDE;
use super::focus::Focus;
use super::views::{SceneView, Views};
use crate::train::course::{Lesson, Showing};
use crate::train::{joints, rotation};

/// How much class and stage count where the hand is yet to be found.
const WEIGHT_OF_FAR: f32 = 0.4;
/// The least area that is seen of a hand, in texels.
const LEAST: f32 = 230.0;

/// A picture of a view with a new background, light and materials; `None` where the hand is hidden.
pub(super) fn lesson(
    (views, focus): (&Views, &Focus),
    view: &SceneView,
    showing: Showing,
    rng: &mut ChaCha8Rng,
) -> Option<Lesson> {
    if view.layers.hand_area() < LEAST {
        return None;
    }
    if unit(rng) < focus.nothing {
        return Some(of_nothing(views, focus, rng));
    }
    let cut_out = view.is_cut_out.then(|| CutOut::random(rng));
    let (framing, is_far) = match cut_out {
        Some(cut_out) if cut_out.has_thing() => (focus.near(&view.layers, rng), false),
        Some(_) => (Framing::cut_out(&view.layers, rng), false),
        None => focus.framing(&view.layers, rng),
    };
    let mut picture = view.layers.paint(&framing, SIDE, rng);
    if showing.is_hard {
        augment(&mut picture, rng);
    }
    let orientation = turned_orientation(framing.turn.to_degrees(), &view.layers.camera_from_hand);
    if let Some(cut_out) = cut_out {
        let arm = orientation * -Vector3::x();
        cut_out.apply(&mut picture, [arm.x as f32, arm.y as f32]);
    }
    let weight = if is_far { WEIGHT_OF_FAR } else { 1.0 };
    let mut target = Target {
        class: view.class.map_or(views.none(), |class| class as u32),
        stage: view.stage as u32,
        rotation: rotation::rows(&orientation),
        weights: LossWeights { class: weight, stage: weight, rotation: 1.0, masks: 1.0, joints: 1.0 },
    };
    if view.class.is_none() {
        target.weights.stage = 0.0;
    }
    if showing.is_mirrored {
        mirror(&mut picture);
        target.weights = LossWeights { stage: 0.0, rotation: 0.0, joints: 0.0, ..target.weights };
        if view.class.is_some() {
            target.class = views.mirrored();
        }
    }
    let joints = view.joints.values(&orientation);
    Some(Lesson {
        planes: planes(&picture),
        target,
        masks: masks(&picture, focus.design.mask_side()),
        joints,
    })
}

/// A picture without a hand.
fn of_nothing(views: &Views, focus: &Focus, rng: &mut ChaCha8Rng) -> Lesson {
    let layers = Layers::of_nothing(views.randomised());
    let picture = layers.paint(&Framing::near(&layers, rng), SIDE, rng);
    let weights = LossWeights { class: 1.0, stage: 0.0, rotation: 0.0, masks: 1.0, joints: 0.0 };
    let target = Target { class: views.none(), stage: 0, rotation: [[0.0; 3]; 3], weights };
    Lesson {
        planes: planes(&picture),
        target,
        masks: masks(&picture, focus.design.mask_side()),
        joints: joints::unknown(),
    }
}

/// A picture as the network's input.
pub(super) fn planes(picture: &Picture) -> Vec<f32> {
    picture.rgb.iter().map(|value| 2.0 * value - 1.0).collect()
}

/// The shares of hand, forearm and object, at the resolution that the network answers in.
pub(super) fn masks(picture: &Picture, cells: usize) -> Vec<f32> {
    let length = picture.side / cells;
    let mut out = Vec::with_capacity(Part::ALL.len() * cells * cells);
    for mask in &picture.masks {
        for cell in 0..cells * cells {
            let at = cell / cells * length * picture.side + cell % cells * length;
            let pixels = (0..length).flat_map(|y| (0..length).map(move |x| y * picture.side + x));
            out.push(pixels.map(|pixel| mask[at + pixel]).sum::<f32>() / (length * length) as f32);
        }
    }
    out
}

/// Flips a picture, left to right.
fn mirror(picture: &mut Picture) {
    for row in picture.rgb.chunks_exact_mut(3 * picture.side) {
        row.as_chunks_mut::<3>().0.reverse();
    }
    for mask in &mut picture.masks {
        mask.chunks_exact_mut(picture.side).for_each(<[f32]>::reverse);
    }
}
