//! Makes a render look like a picture that another program or a camera has segmented: other light,
//! a border found by somebody else, things in front of the hand, an arm cut elsewhere.

mod border;
mod light;
mod noise;
mod occlude;
mod picture;

use grasp_renders::random::unit;
use rand_chacha::ChaCha8Rng;

pub(super) use picture::Picture;

/// How often the arm is cut off.
const CUT_ARM: f64 = 0.25;
/// How often something hides a part of the hand.
const OCCLUDED: f64 = 0.5;
/// How often the border is found anew.
const OTHER_BORDER: f64 = 0.6;

/// Changes a picture in which the arm leaves the hand in the direction `arm` (x right, y down, its
/// length the share that is not foreshortened).
pub(super) fn augment(picture: &mut Picture, arm: [f32; 2], rng: &mut ChaCha8Rng) {
    if unit(rng) < CUT_ARM {
        occlude::cut_arm(picture, arm, rng);
    }
    if unit(rng) < OCCLUDED {
        occlude::occlude(picture, rng);
    }
    if unit(rng) < OTHER_BORDER {
        border::redraw(picture, rng);
    }
    light::relight(picture, rng);
}
