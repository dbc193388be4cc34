//! A watch or a bracelet parts the skin of an arm; here the arm is made whole again.
//!
//! Without it, a hand would seem to end at its watch, and the wrist be looked for within the hand.

use super::{Mask, component, distance};

/// The arm beyond the band crosses the picture's border for at least this long, in radii of a disc
/// of the hand's area.
const ARM_WIDTH: f32 = 0.5;
/// A band is at most this wide, in the same radii.
const WIDEST: f32 = 0.6;
/// What lies on a way between both parts of at most this many times the shortest is band.
const DETOUR: f32 = 1.5;

/// The region with the gaps filled that lie between its largest part and parts that leave the
/// picture.
pub fn bridge(region: &Mask) -> Mask {
    let (width, height) = (region.width(), region.height());
    let (labels, regions) = component::label(region, |_| 0.0);
    let Some(hand) = regions.iter().rev().max_by_key(|region| region.area) else {
        return region.clone();
    };
    let radius = (hand.area as f32 / std::f32::consts::PI).sqrt();
    let arms = regions
        .iter()
        .filter(|part| part.label != hand.label && part.on_border as f32 >= ARM_WIDTH * radius)
        .map(|part| part.label);
    let mut filled = region.pixels().to_vec();
    let mut from_hand = None;
    for arm in arms {
        let from_hand = from_hand
            .get_or_insert_with(|| distance::thirds(width, height, |at| labels[at] == hand.label, false));
        let from_arm = distance::thirds(width, height, |at| labels[at] == arm, false);
        let way = |at: usize| from_hand[at] + from_arm[at];
        let shortest = (0..filled.len()).map(way).min().unwrap_or(0) as f32;
        if shortest > 3.0 * WIDEST * radius {
            continue;
        }
        for (at, inside) in filled.iter_mut().enumerate() {
            *inside |= u8::from(way(at) as f32 <= DETOUR * shortest + 3.0);
        }
    }
    Mask::from_values(width, height, &filled, |v| v == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hand of 30 x 30, a gap of `gap` columns, and an arm of 16 rows that ends `beyond` columns
    /// after it.
    fn hand_and_arm(gap: usize, beyond: usize) -> Mask {
        let (width, height) = (100, 60);
        let inside: Vec<bool> = (0..width * height)
            .map(|at| {
                let (x, y) = (at % width, at / width);
                let hand = (30..60).contains(&x) && (15..45).contains(&y);
                let arm = (60 + gap..60 + gap + beyond).contains(&x) && (22..38).contains(&y);
                hand || arm
            })
            .collect();
        Mask::from_values(width, height, &inside, |v| v)
    }

    #[test]
    fn a_watch_between_hand_and_arm_is_filled() {
        let whole = bridge(&hand_and_arm(8, 32));
        assert!((60..68).all(|x| whole.get(x, 30)));
        assert!(!whole.get(64, 5), "the rest of the picture stays");
        assert_eq!(component::label(&whole, |_| 0.0).1.len(), 1);
    }

    #[test]
    fn what_does_not_leave_the_picture_or_lies_far_off_is_no_arm() {
        for apart in [hand_and_arm(8, 20), hand_and_arm(20, 20)] {
            assert_eq!(bridge(&apart), apart);
        }
        let nothing = Mask::from_grey(4, 4, &[0; 16]);
        assert_eq!(bridge(&nothing), nothing);
    }
}
