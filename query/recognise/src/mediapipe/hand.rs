//! What the hand network says: where a hand's joints are.

/// Pixels a side of what it looks at.
pub(crate) const HAND_SIDE: usize = 224;
const JOINTS: usize = 21;
/// How many values its answer has: the joints' places, right, down and deep; whether there is a
/// hand; which it is; and the places in space, which are left alone.
pub(super) const SIZES: [usize; 4] = [3 * JOINTS, 1, 1, 3 * JOINTS];
/// A probability is no farther than this from 0 and from 1.
const LEAST: f64 = 1e-3;

/// A hand in the square that was looked at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hand {
    /// The joints' places in shares of the square, in the order of
    /// [`crate::scene::Landmarks`].
    pub(crate) joints: [[f64; 2]; JOINTS],
    /// How probably there is a hand.
    pub(crate) presence: f64,
    /// The logarithm of how much likelier a right hand is than a left one.
    pub(crate) right_odds: f64,
}

/// The hand of an answer: the joints' places in pixels, and the probabilities of a hand and of a
/// right one. `None` where these are no numbers.
pub(super) fn hand(places: &[f32], presence: f32, right: f32) -> Option<Hand> {
    let mut joints = [[0.0; 2]; JOINTS];
    for (joint, place) in joints.iter_mut().zip(places.chunks_exact(3)) {
        *joint = [0, 1].map(|i| f64::from(place[i]) / HAND_SIDE as f64);
    }
    let is_sound = joints.as_flattened().iter().all(|v| v.is_finite());
    let right = f64::from(right).clamp(LEAST, 1.0 - LEAST);
    let hand = Hand { joints, presence: f64::from(presence), right_odds: libm::log(right / (1.0 - right)) };
    (is_sound && hand.presence.is_finite() && hand.right_odds.is_finite()).then_some(hand)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_shares_of_the_square_and_the_hand_has_odds() {
        let mut places = [0.0; 63];
        places[3..6].copy_from_slice(&[112.0, 56.0, 9.0]);
        let found = hand(&places, 0.9, 0.8).unwrap();
        assert_eq!(found.joints[1], [0.5, 0.25]);
        assert!((found.right_odds - 4f64.ln()).abs() < 1e-6);
        assert!((6.0..7.0).contains(&hand(&places, 0.9, 1.0).unwrap().right_odds));
    }

    #[test]
    fn what_is_no_number_is_no_hand() {
        let mut places = [0.0; 63];
        assert_eq!(hand(&places, f32::NAN, 0.2), None);
        assert_eq!(hand(&places, 0.5, f32::NAN), None);
        places[61] = f32::INFINITY;
        assert_eq!(hand(&places, 0.9, 0.2), None);
    }
}
