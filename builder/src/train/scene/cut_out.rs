//! Hands that are cut out of their picture, as where a mask is given.

use grasp_renders::random::{between, unit};
use grasp_renders::{Part, Picture};
use rand_chacha::ChaCha8Rng;

/// How often the thing is left in, and in how many of the others the forearm is.
const WITH_THING: f64 = 0.28;
const WITH_FOREARM: f64 = 0.75;
/// In how many of those it is cut in two, and how far behind the hand's middle, in roots of the
/// hand's area.
const SHORT: f64 = 0.6;
const LENGTHS: [f64; 2] = [0.45, 1.7];
/// How often the border is not where it ought to be.
const ROUGH: f64 = 0.4;
/// How often the picture has no colours.
const GREY: f64 = 0.15;

/// What is left of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CutOut {
    parts: [bool; Part::ALL.len()],
    /// How far behind the hand's middle the forearm is cut.
    arm: Option<f32>,
    border: Option<Border>,
    is_grey: bool,
}

/// A border that is found badly.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Border {
    /// How often the shares are smoothed.
    smoothed: usize,
    /// The smoothed share at which the border is drawn.
    at: f32,
}

impl CutOut {
    pub(super) fn random(rng: &mut ChaCha8Rng) -> Self {
        let has_thing = unit(rng) < WITH_THING;
        let has_forearm = unit(rng) < WITH_FOREARM || has_thing;
        let length = between(rng, LENGTHS) as f32;
        let arm = (unit(rng) < SHORT).then_some(length);
        let smoothed = 1 + (2.0 * unit(rng)) as usize;
        let border = Border { smoothed, at: between(rng, [0.3, 0.7]) as f32 };
        let border = (unit(rng) < ROUGH).then_some(border);
        Self { parts: [true, has_forearm, has_thing], arm, border, is_grey: unit(rng) < GREY }
    }

    /// Whether the thing is left in.
    pub(super) fn has_thing(&self) -> bool {
        self.parts[Part::Object as usize]
    }

    /// Makes all black that is cut away. `arm`: the direction in which the arm goes on in the
    /// picture, right and down.
    pub(super) fn apply(&self, picture: &mut Picture, arm: [f32; 2]) {
        if let Some(length) = self.arm {
            shorten(picture, arm, length);
        }
        for (mask, _) in picture.masks.iter_mut().zip(self.parts).filter(|(_, is_left)| !is_left) {
            mask.fill(0.0);
        }
        let mut left: Vec<f32> = (0..picture.side * picture.side)
            .map(|at| picture.masks.iter().map(|mask| mask[at]).sum::<f32>().min(1.0))
            .collect();
        if let Some(Border { smoothed, at }) = self.border {
            (0..smoothed).for_each(|_| left = smooth(&left, picture.side));
            // As steep as the border of a mask that was made smaller.
            left.iter_mut().for_each(|share| *share = (0.5 + 2.0 * (*share - at)).clamp(0.0, 1.0));
        }
        for (pixel, left) in picture.rgb.as_chunks_mut::<3>().0.iter_mut().zip(left) {
            if self.is_grey {
                let [r, g, b] = *pixel;
                *pixel = [0.3 * r + 0.59 * g + 0.11 * b; 3];
            }
            pixel.iter_mut().for_each(|value| *value *= left);
        }
    }
}

/// Takes away what lies of the forearm so far behind the hand's middle.
fn shorten(picture: &mut Picture, arm: [f32; 2], length: f32) {
    let side = picture.side;
    let place = |at: usize| [at % side, at / side].map(|v| v as f32 + 0.5);
    let mut sum = [0.0f32; 3];
    for (at, share) in picture.masks[Part::Hand as usize].iter().enumerate() {
        let [x, y] = place(at);
        sum = [sum[0] + share * x, sum[1] + share * y, sum[2] + share];
    }
    let [x, y, area] = sum;
    for (at, share) in picture.masks[Part::Forearm as usize].iter_mut().enumerate() {
        let behind = (place(at)[0] * area - x) * arm[0] + (place(at)[1] * area - y) * arm[1];
        if behind > length * area.sqrt() * area {
            *share = 0.0;
        }
    }
}

/// The mean of each pixel and its eight neighbours; the border goes on beyond itself.
fn smooth(values: &[f32], side: usize) -> Vec<f32> {
    let near = |at: usize, by: usize| (at + by).saturating_sub(1).min(side - 1);
    let mean = |at: usize| {
        let (x, y) = (at % side, at / side);
        (0..9).map(|tap| values[near(y, tap / 3) * side + near(x, tap % 3)]).sum::<f32>() / 9.0
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    const SIDE: usize = 16;

    /// A white picture: the hand at the left, its forearm below it, the thing at the right.
    fn picture() -> Picture {
        let part = |is_in: fn(usize, usize) -> bool| {
            (0..SIDE * SIDE).map(|at| f32::from(u8::from(is_in(at % SIDE, at / SIDE)))).collect()
        };
        let masks =
            [part(|x, y| x < 6 && y < 8), part(|x, y| x < 6 && y >= 8), part(|x, y| x >= 10 && y < 8)];
        Picture { side: SIDE, rgb: vec![1.0; 3 * SIDE * SIDE], masks }
    }

    #[test]
    fn all_but_the_hand_and_what_is_left_with_it_is_black() {
        let mut cut = picture();
        let parts = [true, false, true];
        CutOut { parts, arm: None, border: None, is_grey: false }.apply(&mut cut, [0.0, 1.0]);
        let bright = |x: usize, y: usize| cut.rgb[3 * (y * SIDE + x)];
        assert_eq!([bright(2, 2), bright(12, 2)], [1.0; 2]);
        assert_eq!([bright(2, 12), bright(8, 2)], [0.0; 2]);
        assert!(cut.masks[1].iter().all(|share| *share == 0.0));
        assert_eq!(cut.masks[2], picture().masks[2]);
    }

    #[test]
    fn an_arm_ends_where_it_is_cut() {
        let mut cut = picture();
        // The hand's middle is at (3, 4), its area 48.
        let cut_out = CutOut { parts: [true, true, false], arm: Some(1.0), border: None, is_grey: false };
        cut_out.apply(&mut cut, [0.0, 1.0]);
        let column: Vec<f32> = (0..SIDE).map(|y| cut.rgb[3 * (y * SIDE + 2)]).collect();
        let end = (4.0 + 48f32.sqrt()) as usize;
        assert!(
            column[..end].iter().all(|value| *value == 1.0) && column[end + 1..] == [0.0; SIDE][end + 1..]
        );
    }

    #[test]
    fn hands_are_always_left_and_borders_lie_about_where_they_are() {
        let (mut with_thing, mut with_forearm) = (0, 0);
        for seed in 0..200 {
            let cut_out = CutOut::random(&mut ChaCha8Rng::seed_from_u64(seed));
            let mut cut = picture();
            cut_out.apply(&mut cut, [0.0, 1.0]);
            assert!(cut.rgb.iter().all(|value| (0.0..=1.0).contains(value)));
            assert_eq!([cut.rgb[3 * (3 * SIDE + 2)], cut.rgb[3 * (14 * SIDE + 14)]], [1.0, 0.0]);
            with_thing += usize::from(cut_out.has_thing());
            with_forearm += usize::from(cut_out.parts[1]);
        }
        assert!((35..80).contains(&with_thing) && (140..185).contains(&with_forearm));
    }
}
