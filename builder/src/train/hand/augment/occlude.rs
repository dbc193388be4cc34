//! What hides a part of the hand: things before it, the picture's edge, a sleeve.

use grasp_renders::random::{between, normal, unit};
use rand_chacha::ChaCha8Rng;

use super::picture::Picture;

/// The least share of the hand that a thing leaves.
const LEFT: f32 = 0.6;
/// The least share of the hand that a cut of the arm leaves.
const LEFT_OF_ARM: f32 = 0.5;
/// An arm that points this much toward the camera or away from it is not cut.
const FORESHORTENED: f32 = 0.35;
/// The longest part of a picture that is cut off its arm, at its full length.
const CUT: f64 = 0.38;

/// Cuts the arm off across its direction, nearer or further from the hand.
pub(super) fn cut_arm(picture: &mut Picture, [x, y]: [f32; 2], rng: &mut ChaCha8Rng) {
    let length = libm::hypotf(x, y);
    let (askew, far) = (0.2 * normal(rng), unit(rng));
    if length <= FORESHORTENED {
        return;
    }
    let (sin, cos) = libm::sincosf(askew as f32);
    let [x, y] = [x / length, y / length];
    let [x, y] = [x * cos - y * sin, x * sin + y * cos];
    let (low, high) = picture.reach([x, y]);
    let cut = high - (far * far * CUT) as f32 * length * (high - low);
    picture.hide(LEFT_OF_ARM, |px, py| x * px + y * py > cut);
}

/// One to three things: a straight edge, a round one, a bar.
pub(super) fn occlude(picture: &mut Picture, rng: &mut ChaCha8Rng) {
    let things = 1 + usize::from(unit(rng) < 0.4) + usize::from(unit(rng) < 0.2);
    let pixel = picture.side as f64 / 48.0;
    for _ in 0..things {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(rng));
        let (sin, cos) = (sin as f32, cos as f32);
        let [at_x, at_y] = on_hand(picture, rng);
        match (unit(rng) * 3.0) as u32 {
            0 => {
                let (low, high) = picture.reach([cos, sin]);
                let cut = high - (0.3 * unit(rng)) as f32 * (high - low);
                picture.hide(LEFT, |x, y| cos * x + sin * y > cut);
            }
            1 => {
                let radius = (between(rng, [2.0, 10.0]) * pixel) as f32;
                let x = at_x + (3.0 * pixel * normal(rng)) as f32;
                let y = at_y + (3.0 * pixel * normal(rng)) as f32;
                let aspect = between(rng, [0.6, 1.4]) as f32;
                picture.hide(LEFT, |px, py| {
                    let along = cos * (px - x) + sin * (py - y);
                    let across = (cos * (py - y) - sin * (px - x)) * aspect;
                    along * along + across * across < radius * radius
                });
            }
            _ => {
                let half = (between(rng, [0.8, 4.8]) * pixel) as f32;
                picture.hide(LEFT, |x, y| (cos * (x - at_x) + sin * (y - at_y)).abs() < half);
            }
        }
    }
}

/// A place on the hand; any place where none was hit soon.
fn on_hand(picture: &Picture, rng: &mut ChaCha8Rng) -> [f32; 2] {
    let mut place = [0; 2];
    for _ in 0..60 {
        place = [0; 2].map(|_: usize| (unit(rng) * picture.side as f64) as usize);
        if picture.mask[place[1] * picture.side + place[0]] > 0.5 {
            break;
        }
    }
    place.map(|v| v as f32)
}
