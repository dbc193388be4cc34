use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn hands() -> impl Strategy<Value = HandImage> {
    (8..30usize, 8..30usize).prop_flat_map(|(width, height)| {
        prop::collection::vec(any::<u8>(), width * height).prop_map(move |pixels| {
            let mask = vec![1; width * height];
            HandImage::from_mask(width, height, &pixels, &mask).expect("a full mask is a hand")
        })
    })
}

/// A block of hand, `left..right` by `top..bottom`, in a picture of 50 x 40.
fn block(left: usize, right: usize, top: usize, bottom: usize) -> HandImage {
    let mut grey = vec![0u8; 50 * 40];
    for (x, y) in (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y))) {
        grey[y * 50 + x] = (50 + x * 3 + y) as u8;
    }
    HandImage::from_segmented(50, 40, &grey, 0).expect("the block is large enough")
}

#[test]
fn the_crop_is_the_box_of_the_mask() {
    let hand = block(10, 22, 5, 33);
    assert_eq!((hand.width(), hand.height()), (12, 28));
    assert_eq!(hand.pixels()[0], 50 + 30 + 5);
    assert!(hand.mask().iter().all(|&inside| inside == 1));
}

#[test]
fn outside_the_mask_is_black() {
    let mut mask = vec![1u8; 100];
    mask[55] = 0;
    let hand = HandImage::from_mask(10, 10, &[200; 100], &mask).expect("a hand");
    assert_eq!((hand.pixels()[55], hand.mask()[55]), (0, 0));
    assert_eq!((hand.pixels()[54], hand.mask()[54]), (200, 1));
}

#[test]
fn a_black_pixel_of_a_mask_is_hand() {
    let mut grey = vec![200u8; 100];
    grey[0] = 0;
    let hand = HandImage::from_mask(10, 10, &grey, &[255; 100]).expect("a hand");
    assert_eq!(hand.mask()[0], 1);
}

#[test]
fn sizes_that_overflow_are_told() {
    let result = HandImage::from_segmented(usize::MAX, 2, &[1; 10], 0);
    assert!(matches!(result, Err(HandImageError::SizeMismatch { .. })));
}

#[test]
fn a_positive_turn_is_clockwise() {
    // Bright at the top; a quarter turn clockwise brings it to the right.
    let pixels: Vec<u8> = (0..16 * 16).map(|at| if at < 16 * 4 { 250 } else { 50 }).collect();
    let hand = HandImage::from_mask(16, 16, &pixels, &[1; 256]).expect("a hand");
    let turned = hand.rotated(FRAC_PI_2);
    assert_eq!((turned.pixels()[8 * 16 + 14], turned.pixels()[8 * 16 + 1]), (250, 50));
}

#[test]
fn shrinking_keeps_the_aspect_and_the_grey() {
    let hand = block(0, 50, 0, 25).shrunk_to(20);
    assert_eq!((hand.width(), hand.height()), (20, 10));
    let mean = |hand: &HandImage| {
        hand.pixels().iter().map(|&p| f64::from(p)).sum::<f64>() / hand.pixels().len() as f64
    };
    assert!((mean(&hand) - mean(&block(0, 50, 0, 25))).abs() < 2.0);
    // The longer side counts, whichever it is, and no side is so short that nothing is described.
    for (side, size) in [(40, (25, 40)), (39, (24, 39)), (20, (13, 20)), (3, (5, 8))] {
        let tall = block(0, 25, 0, 40).shrunk_to(side);
        assert_eq!((tall.width(), tall.height()), size);
        assert!(tall.mask().iter().all(|&inside| inside == 1));
    }
    let small = block(0, 10, 0, 10);
    assert_eq!(small.shrunk_to(20), small);
}

#[test]
fn a_thumbnail_is_centred() {
    let thumbnail = block(0, 40, 0, 20).thumbnail(20);
    assert_eq!(thumbnail.len(), 400);
    assert!(thumbnail[..4 * 20].iter().all(|&grey| grey == 0));
    assert!(thumbnail[16 * 20..].iter().all(|&grey| grey == 0));
    assert!(thumbnail[7 * 20..13 * 20].iter().all(|&grey| grey > 0));
    assert_eq!([0, 1].map(|side| block(0, 40, 0, 20).thumbnail(side).len()), [0, 1]);
}

proptest! {
    #[test]
    fn mirroring_twice_changes_nothing(hand in hands()) {
        prop_assert_eq!(hand.mirrored().mirrored(), hand);
    }

    #[test]
    fn quarter_turns_move_every_pixel(hand in hands()) {
        let turned = hand.rotated(FRAC_PI_2);
        prop_assert_eq!((turned.width(), turned.height()), (hand.height(), hand.width()));
        for (x, y) in (0..hand.height()).flat_map(|y| (0..hand.width()).map(move |x| (x, y))) {
            let there = turned.pixels()[x * turned.width() + hand.height() - 1 - y];
            prop_assert_eq!(there, hand.pixels()[y * hand.width() + x]);
        }
        prop_assert_eq!(turned.rotated(-FRAC_PI_2), hand);
    }

    #[test]
    fn any_turn_keeps_most_of_the_hand(hand in hands(), angle in -PI..PI) {
        let area = |hand: &HandImage| hand.mask().iter().filter(|&&inside| inside != 0).count() as f64;
        let ratio = area(&hand.rotated(angle)) / area(&hand);
        prop_assert!((0.7..1.4).contains(&ratio), "{}", ratio);
    }

    #[test]
    fn a_turned_hand_is_turned_upright_by_so_much_less(angle in -180.0..180.0f64) {
        let hand = wedge();
        let turned = hand.rotated(angle.to_radians());
        let apart = hand.upright_turn_deg() - angle - turned.upright_turn_deg();
        prop_assert!(around(apart) < 3.0, "{apart}");
    }

    #[test]
    fn a_turn_is_of_whole_tenths_within_one_turn(hand in specks()) {
        let turn = hand.upright_turn_deg();
        prop_assert!((-180.0..180.0).contains(&turn));
        prop_assert!((turn * 10.0 - (turn * 10.0).round()).abs() < 1e-9);
        prop_assert_eq!(turn, hand.rotated(0.0).upright_turn_deg());
    }

    /// By definition, from the turned pixels themselves.
    #[test]
    fn an_upright_hand_is_longest_downward_and_has_its_longer_tail_there(hand in specks()) {
        let places = turned_places(&hand, hand.upright_turn_deg());
        let n = places.len() as f64;
        let mean = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / n);
        let moment = |across: i32, down: i32| {
            let product = |[x, y]: &[f64; 2]| (x - mean[0]).powi(across) * (y - mean[1]).powi(down);
            places.iter().map(product).sum::<f64>() / n
        };
        // The angle is rounded to tenths of a degree: each moment is off by its derivative's share.
        let rounding = 2.0 * 0.05f64.to_radians();
        prop_assert!(moment(1, 1).abs() <= rounding * (moment(0, 2) - moment(2, 0)).abs() + 1e-9);
        prop_assert!(moment(0, 2) >= moment(2, 0) - 1e-9);
        prop_assert!(moment(0, 3) >= -3.0 * rounding * moment(1, 2).abs() - 1e-9);
    }

    #[test]
    fn an_arm_is_all_that_lies_some_breadths_behind_the_uppermost_pixel(
        hand in specks(), turn_deg in -180.0..180.0f64, lengths in 0.2..1.5f64
    ) {
        let places = turned_places(&hand, turn_deg);
        let ends = |axis: usize| {
            places.iter().fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at[axis]), high.max(at[axis])])
        };
        let ([left, right], [top, _]) = (ends(0), ends(1));
        let end = top + lengths * (right - left + 1.0);
        prop_assume!(places.iter().all(|place| (place[1] - end).abs() > 1e-9));
        let mut kept = hand.mask().to_vec();
        let of_hand = kept.iter_mut().filter(|value| **value != 0);
        of_hand.zip(&places).for_each(|(value, place)| *value = u8::from(place[1] < end));
        let expected =
            HandImage::crop_any_size(hand.width(), hand.height(), hand.pixels(), |at| kept[at] != 0);
        prop_assert_eq!(hand.without_arm(turn_deg, lengths), expected.expect("the uppermost pixel is kept"));
    }
}

/// Where the pixels of a hand lie, right and down, once it is turned clockwise, row by row.
fn turned_places(hand: &HandImage, turn_deg: f64) -> Vec<[f64; 2]> {
    let (sin, cos) = libm::sincos(turn_deg.to_radians());
    let at = |at: usize| [(at % hand.width()) as f64, (at / hand.width()) as f64];
    let inside = (0..hand.mask().len()).filter(|place| hand.mask()[*place] != 0);
    inside.map(at).map(|[x, y]| [cos * x - sin * y, sin * x + cos * y]).collect()
}

/// A hand that points up and to the right, thinner at its end.
fn wedge() -> HandImage {
    let mut grey = vec![0u8; 90 * 90];
    for (x, y) in (0..90usize).flat_map(|y| (0..90usize).map(move |x| (x, y))) {
        // Along the diagonal from the lower left, 10 to 80; across it, ever less.
        let (along, across) = ((x + 89 - y) / 2, x.abs_diff(89 - y));
        if (10..80).contains(&along) && across * 5 < 90 - along {
            grey[y * 90 + x] = 200;
        }
    }
    HandImage::from_segmented(90, 90, &grey, 0).expect("the wedge is large enough")
}

/// Any masks.
fn specks() -> impl Strategy<Value = HandImage> {
    (8..20usize, 8..20usize).prop_flat_map(|(width, height)| {
        prop::collection::vec(0..4u8, width * height).prop_filter_map("a mask too small", move |mask| {
            HandImage::from_mask(width, height, &vec![90; width * height], &mask).ok()
        })
    })
}

/// How far an angle is from whole turns, in degrees.
fn around(degrees: f64) -> f64 {
    let within = degrees.rem_euclid(360.0);
    within.min(360.0 - within)
}

#[test]
fn the_thin_end_points_down_and_a_mirror_image_turns_the_other_way() {
    let hand = wedge();
    // It points up and to the right: 135 degrees clockwise from there is down.
    assert!(around(hand.upright_turn_deg() - 135.0) < 1.0, "{}", hand.upright_turn_deg());
    assert!(around(hand.mirrored().upright_turn_deg() + hand.upright_turn_deg()) < 0.2);
    let upright = hand.rotated(hand.upright_turn_deg().to_radians());
    assert!(upright.height() > 2 * upright.width());
    assert!(around(upright.upright_turn_deg()) < 1.5, "{}", upright.upright_turn_deg());
}

/// Of a thin end that points all but straight up, on either side, rounding makes the same.
#[test]
fn a_half_turn_is_the_lower_end_of_the_range() {
    for speck in [3, 7] {
        let is_hand = |x: usize, y: usize| y >= 60 || (4..7).contains(&x) || (x, y) == (speck, 59);
        let mask: Vec<u8> = (0..11 * 200).map(|at| u8::from(is_hand(at % 11, at / 11))).collect();
        let hand = HandImage::from_mask(11, 200, &[90; 11 * 200], &mask).expect("a hand");
        assert_eq!(hand.upright_turn_deg(), -180.0);
    }
}

#[test]
fn a_hand_with_no_axis_is_turned_somehow() {
    let square = HandImage::from_mask(9, 9, &[90; 81], &[1; 81]).expect("a square is a hand");
    assert!((-180.0..180.0).contains(&square.upright_turn_deg()));
}
