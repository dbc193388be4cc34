//! Where the picture ends that a square is cut from.

use rand_chacha::ChaCha8Rng;

use crate::random::{between, unit};

/// How often the picture ends within a square around a hand: arms come in from outside, and many
/// pictures are cut close to the hand.
const CUT: f64 = 0.4;
/// Where it ends below, and how often and where beside and above, in sides of the square from its
/// middle.
const BELOW: [f64; 2] = [0.14, 0.5];
const BESIDE: f64 = 0.25;
const FAR: [f64; 2] = [0.2, 0.5];
/// By how much the picture is turned against a square in which the arm comes from below, at most.
const TURN: f64 = std::f64::consts::FRAC_PI_4;
/// How much lower or narrower than its longer side a whole picture is.
const SHAPES: [f64; 3] = [1.0, 0.75, 0.5625];

/// The picture that a square is cut from, in the square's own coordinates: sides from its middle,
/// right and down. What lies beyond looks like its border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Border {
    /// Cosine and sine of the picture's turn.
    along: [f32; 2],
    low: [f32; 2],
    high: [f32; 2],
}

impl Border {
    /// Of a picture that goes on wherever it is looked at.
    pub(super) const NONE: Self = Self { along: [1.0, 0.0], low: [f32::MIN; 2], high: [f32::MAX; 2] };

    /// Of a square around a hand.
    pub(super) fn near(rng: &mut ChaCha8Rng) -> Self {
        let turn = between(rng, [-TURN, TURN]);
        let is_cut = unit(rng) < CUT;
        let mut end = |share: f64, range: [f64; 2]| {
            let (is_here, at) = (unit(rng) < share, between(rng, range));
            if is_cut && is_here { at as f32 } else { f32::MAX }
        };
        let below = end(1.0, BELOW);
        let [left, right, above] = [0; 3].map(|_| end(BESIDE, FAR));
        Self { along: cos_sin(turn), low: [-left, -above], high: [right, below] }
    }

    /// Of the smallest square around a whole picture, which may lie in it at any turn.
    pub(super) fn whole(rng: &mut ChaCha8Rng) -> Self {
        let turn = std::f64::consts::TAU * unit(rng);
        let shape = SHAPES[(unit(rng) * SHAPES.len() as f64) as usize];
        let half = [0.5, (0.5 * shape) as f32];
        Self { along: cos_sin(turn), low: half.map(|v| -v), high: half }
    }

    /// The place that is seen at a place of the square, 0 to 1 right and down.
    pub(super) fn within(&self, u: f32, v: f32) -> [f32; 2] {
        let ([cos, sin], x, y) = (self.along, u - 0.5, v - 0.5);
        let [x, y] = [cos * x + sin * y, cos * y - sin * x];
        let x = x.clamp(self.low[0], self.high[0]);
        let y = y.clamp(self.low[1], self.high[1]);
        [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y]
    }
}

fn cos_sin(turn: f64) -> [f32; 2] {
    let (sin, cos) = libm::sincos(turn);
    [cos as f32, sin as f32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn what_lies_within_stays_and_what_lies_beyond_goes_to_the_border() {
        let quarter = Border { along: [0.0, 1.0], low: [-0.5, -0.1], high: [0.3, f32::MAX] };
        let is_near = |a: [f32; 2], b: [f32; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(is_near(quarter.within(0.45, 0.6), [0.45, 0.6]));
        // A quarter turn: the picture's right is the square's down, its down the square's left.
        assert!(is_near(quarter.within(0.5, 0.9), [0.5, 0.8]));
        assert!(is_near(quarter.within(0.9, 0.5), [0.6, 0.5]));
    }

    #[test]
    fn squares_around_hands_are_cut_now_and_then_and_keep_their_middle() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let borders: Vec<Border> = (0..400).map(|_| Border::near(&mut rng)).collect();
        let cut = borders.iter().filter(|border| border.high[1] < 1.0).count();
        assert!((120..200).contains(&cut), "{cut}");
        assert!(borders.iter().all(|border| border.within(0.5, 0.5) == [0.5; 2]));
    }
}
