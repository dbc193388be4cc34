//! Frames of one hand in a row, fused: what was seen before counts for what is seen now (the
//! paper's Section VIII, further work).
//!
//! **The class** is a hidden state of a Markov chain that stays as it is with probability `1 -
//! switch` from one frame to the next, and is otherwise any class, as probable as it is without a
//! picture (1 / C unless a prior is given). Its forward filter is
//!
//! ```text
//! b'(c) = (1 - switch) b(c) + switch prior(c)                predict; b' = prior before the first frame
//! b(c)  = b'(c) p(c | frame) / sum over all classes          update
//! ```
//!
//! where a frame's calibrated probability stands for its likelihood, all classes being alike
//! before.
//!
//! **The orientation** follows by a Kalman filter on rotations: its variance P grows by the square
//! of `motion_deg` a frame, and the frame's orientation, whose variance R is the square of its own
//! spread, is taken over by the share P / (P + R) of the way along the shortest turn. A frame
//! farther off than three standard deviations is not followed at once: it makes the filter less
//! sure of itself. Each hand has its own: a frame that is taken for the other hand says nothing of
//! how the first is turned, for the hand's axes are mirrored.
//!
//! Where `switch` is 1, every frame may show another hand: each stands alone.

use nalgebra::UnitQuaternion;

use crate::prior::weigh;
use crate::side::Side;

/// How far, in standard deviations, a frame's orientation may be from the one foreseen.
const GATE: f64 = 3.0;
/// The share of the way to a frame beyond the gate that is added to the standard deviation.
const SURPRISE: f64 = 0.5;
/// Neighbours that agree to less than this do so by chance, in degrees.
const LEAST_SPREAD: f64 = 5.0;

/// How a hand may change between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceParams {
    /// The probability that the grasp changes, 0 to 1; at 1 the hand may be another one, too.
    pub switch: f64,
    /// How far the hand turns, in degrees (standard deviation).
    pub motion_deg: f64,
}

impl Default for SequenceParams {
    fn default() -> Self {
        // Frames of one view err alike, which the filter does not know: with a switch of 0.05 it
        // lost by the frames before what it gained by them (48 development sequences; with 0.2 and
        // 0.4 it gained).
        Self { switch: 0.2, motion_deg: 5.0 }
    }
}

/// What one frame says by itself, or what a filter makes of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// The probability of each class, by its number in the index; they sum to 1.
    pub classes: Vec<f64>,
    /// Which hand the frame shows.
    pub side: Side,
    /// How it is turned.
    pub turn: Turn,
}

/// How a hand is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// `camera_from_hand`.
    pub rotation: UnitQuaternion<f64>,
    /// How far it may be off, in degrees.
    pub spread_deg: f64,
}

/// The filter over the frames so far.
#[derive(Clone, Debug)]
pub struct Filter {
    params: SequenceParams,
    prior: Option<Vec<f64>>,
    classes: Option<Vec<f64>>,
    left: Option<Turn>,
    right: Option<Turn>,
}

impl Filter {
    /// A filter that has seen nothing. `prior` is how probable each class is without a picture; all
    /// alike where there is none.
    pub fn new(params: SequenceParams, prior: Option<Vec<f64>>) -> Self {
        Self { params, prior, classes: None, left: None, right: None }
    }

    /// Takes the next frame in and says what is believed now.
    pub fn update(&mut self, frame: &Belief) -> Belief {
        self.predict();
        let classes = match &self.classes {
            Some(foreseen) if foreseen.len() == frame.classes.len() => both(foreseen, &frame.classes),
            _ => {
                let prior = self.prior.as_ref();
                prior.map_or_else(|| frame.classes.clone(), |prior| weigh(&frame.classes, prior))
            }
        };
        self.classes = Some(classes.clone());
        let turn = self.turn(frame.side);
        let turn = *turn.insert(turn.as_ref().map_or(frame.turn, |foreseen| fuse(foreseen, &frame.turn)));
        Belief { classes, side: frame.side, turn }
    }

    /// A frame without a hand: time goes by.
    pub fn pass(&mut self) {
        self.predict();
    }

    /// A frame that shows this hand and says nothing: time goes by. Says what is still believed of
    /// the hand, where it was ever seen.
    pub fn skip(&mut self, side: Side) -> Option<Belief> {
        self.predict();
        let turn = (*self.turn(side))?;
        Some(Belief { classes: self.classes.clone()?, side, turn })
    }

    fn turn(&mut self, side: Side) -> &mut Option<Turn> {
        match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
        }
    }

    fn predict(&mut self) {
        let switch = self.params.switch.clamp(0.0, 1.0);
        if let Some(classes) = &mut self.classes {
            let alike = 1.0 / classes.len().max(1) as f64;
            let prior = self.prior.as_deref().unwrap_or_default().iter().copied();
            for (probability, prior) in classes.iter_mut().zip(prior.chain(std::iter::repeat(alike))) {
                *probability = (1.0 - switch) * *probability + switch * prior;
            }
        }
        for turn in [&mut self.left, &mut self.right] {
            *turn = turn.filter(|_| switch < 1.0);
            if let Some(turn) = turn {
                turn.spread_deg = libm::hypot(turn.spread_deg, self.params.motion_deg).min(180.0);
            }
        }
    }
}

/// How probable the classes are by what was foreseen and by a frame.
fn both(foreseen: &[f64], frame: &[f64]) -> Vec<f64> {
    let products: Vec<f64> = foreseen.iter().zip(frame).map(|(a, b)| a * b).collect();
    let sum: f64 = products.iter().sum();
    // Frames that contradict each other to the last digit: the newer one is right.
    match sum > 0.0 {
        true => products.iter().map(|product| product / sum).collect(),
        false => frame.to_vec(),
    }
}

fn fuse(foreseen: &Turn, frame: &Turn) -> Turn {
    let apart = foreseen.rotation.angle_to(&frame.rotation).to_degrees();
    let noise = frame.spread_deg.max(LEAST_SPREAD);
    if apart > GATE * libm::hypot(foreseen.spread_deg, noise) {
        let spread_deg = libm::hypot(foreseen.spread_deg, SURPRISE * apart).min(180.0);
        return Turn { rotation: foreseen.rotation, spread_deg };
    }
    let (own, seen) = (foreseen.spread_deg.powi(2), noise.powi(2));
    let gain = own / (own + seen);
    let turn = foreseen.rotation.rotation_to(&frame.rotation).powf(gain);
    Turn { rotation: turn * foreseen.rotation, spread_deg: (own * seen / (own + seen)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame(classes: [f64; 3], degrees: f64, spread_deg: f64) -> Belief {
        let rotation = UnitQuaternion::from_euler_angles(0.0, 0.0, degrees.to_radians());
        Belief { classes: classes.to_vec(), side: Side::Right, turn: Turn { rotation, spread_deg } }
    }

    fn yaw(belief: &Belief) -> f64 {
        belief.turn.rotation.euler_angles().2.to_degrees()
    }

    #[test]
    fn the_forward_filter_by_hand() {
        let mut filter = Filter::new(SequenceParams { switch: 0.3, motion_deg: 0.0 }, None);
        let first = frame([0.6, 0.3, 0.1], 0.0, 10.0);
        assert_eq!(filter.update(&first), first);
        // Predicted 0.7 b + 0.1: 0.52, 0.31, 0.17; times the frame: 0.104, 0.155, 0.051, in all
        // 0.31.
        let second = filter.update(&frame([0.2, 0.5, 0.3], 0.0, 10.0));
        for (found, expected) in second.classes.iter().zip([0.104 / 0.31, 0.5, 0.051 / 0.31]) {
            assert!((found - expected).abs() < 1e-12, "{second:?}");
        }
        // Two frames alike, the hand at rest: the mean, and the standard deviation of a mean of
        // two.
        let mut third = Filter::new(SequenceParams { motion_deg: 0.0, ..SequenceParams::default() }, None);
        third.update(&frame([1.0, 0.0, 0.0], 0.0, 10.0));
        let mean = third.update(&frame([1.0, 0.0, 0.0], 20.0, 10.0));
        assert!((yaw(&mean) - 10.0).abs() < 1e-9 && (mean.turn.spread_deg - 50f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_prior_counts_once() {
        let prior = vec![0.8, 0.1, 0.1];
        let mut filter = Filter::new(SequenceParams { switch: 0.0, motion_deg: 0.0 }, Some(prior.clone()));
        // Frames that say nothing leave it as it is, however many they are.
        for _ in 0..5 {
            let belief = filter.update(&frame([1.0 / 3.0; 3], 0.0, 10.0));
            assert!(belief.classes.iter().zip(&prior).all(|(a, b)| (a - b).abs() < 1e-12), "{belief:?}");
        }
    }

    #[test]
    fn one_frame_that_is_far_off_is_not_followed_and_two_are() {
        let mut filter = Filter::new(SequenceParams::default(), None);
        for _ in 0..5 {
            filter.update(&frame([0.8, 0.1, 0.1], 10.0, 10.0));
        }
        let flip = frame([0.8, 0.1, 0.1], 170.0, 10.0);
        assert!((yaw(&filter.update(&flip)) - 10.0).abs() < 1e-9);
        assert!((yaw(&filter.update(&flip)) - 170.0).abs() < 10.0);
    }

    #[test]
    fn each_hand_is_turned_by_itself() {
        let mut filter = Filter::new(SequenceParams::default(), None);
        let right = frame([0.8, 0.1, 0.1], 10.0, 10.0);
        let left = Belief { side: Side::Left, ..frame([0.8, 0.1, 0.1], -40.0, 10.0) };
        filter.update(&right);
        let seen = filter.update(&left);
        assert_eq!((seen.side, seen.turn), (Side::Left, left.turn));
        assert!(seen.classes[0] > 0.8, "the grasp is that of both: {seen:?}");
        let again = filter.update(&right);
        assert!((yaw(&again) - 10.0).abs() < 1e-9 && again.turn.spread_deg < 10.0, "{again:?}");
    }

    #[test]
    fn where_all_may_change_each_frame_stands_alone() {
        let mut filter = Filter::new(SequenceParams { switch: 1.0, motion_deg: 5.0 }, None);
        for degrees in [0.0, 20.0, 170.0] {
            let next = frame([0.5, 0.3, 0.2], degrees, 10.0);
            let seen = filter.update(&next);
            assert_eq!(seen.turn, next.turn);
            assert!(seen.classes.iter().zip(&next.classes).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        assert_eq!(filter.skip(Side::Right), None);
    }

    #[test]
    fn frames_that_show_nothing_make_unsure() {
        let mut filter = Filter::new(SequenceParams { switch: 0.2, motion_deg: 8.0 }, None);
        assert_eq!(filter.skip(Side::Right), None);
        filter.update(&frame([1.0, 0.0, 0.0], 0.0, 10.0));
        let after = (0..60).filter_map(|_| filter.skip(Side::Right)).last().unwrap();
        assert!(after.classes.iter().all(|p| (p - 1.0 / 3.0).abs() < 1e-3), "{after:?}");
        assert!(after.turn.spread_deg > 60.0);
    }

    proptest! {
        #[test]
        fn beliefs_are_probabilities_and_rotations(
            frames in prop::collection::vec(((0.0..1.0, 0.0..1.0, 0.0..1.0), -180.0..180.0, 0.0..180.0), 1..20),
            switch in 0.0..=1.0, motion_deg in 0.0..90.0,
        ) {
            let mut filter = Filter::new(SequenceParams { switch, motion_deg }, None);
            for ((a, b, c), degrees, spread) in frames {
                let sum: f64 = a + b + c + 1e-9;
                let belief = filter.update(&frame([a / sum, b / sum, (c + 1e-9) / sum], degrees, spread));
                prop_assert!((belief.classes.iter().sum::<f64>() - 1.0).abs() < 1e-9);
                prop_assert!(belief.classes.iter().all(|p| (0.0..=1.0 + 1e-12).contains(p)));
                prop_assert!((belief.turn.rotation.norm() - 1.0).abs() < 1e-9);
                prop_assert!((0.0..=180.0).contains(&belief.turn.spread_deg));
            }
        }
    }
}
