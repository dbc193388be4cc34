//! The scene networks on real small pictures: those of `tests/pictures`.

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

use grasp_index::HandImage;
use grasp_recognise::networks::Networks;
use grasp_recognise::picture::{self, Picture};
use grasp_recognise::scene::{LandmarkUnit, Landmarks, Prediction, find};
use grasp_recognise::segment::{Finder, Mask, SegmentParams};
use grasp_recognise::{MaskSource, Prepared, Side};

const NAMES: [&str; 6] = [
    "01-large-diameter",
    "02-small-diameter",
    "04-abducted-thumb",
    "09-pinch",
    "10-power-sphere",
    "12-precision-disc",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/pictures")
}

fn read(path: &Path) -> Picture {
    picture::decode(&picture::read(path).unwrap()).unwrap().picture
}

fn camera(name: &str) -> Picture {
    read(&folder().join(format!("camera/{name}.jpg")))
}

fn found(name: &str) -> Prepared {
    let bytes = picture::read(&folder().join(format!("camera/{name}.jpg"))).unwrap();
    Prepared::decode(&bytes, &MaskSource::Camera, &SegmentParams::default()).expect(name)
}

/// A picture turned by a quarter, clockwise.
fn turned(picture: &Picture) -> Picture {
    let (width, height) = (picture.width(), picture.height());
    let pixels = (0..width * height).map(|at| {
        let (x, y) = (at % height, at / height);
        picture.rgb()[(height - 1 - x) * width + y]
    });
    Picture::new(height, width, pixels.collect()).unwrap()
}

fn middle(mask: &Mask) -> [f64; 2] {
    let inside = (0..mask.width() * mask.height()).filter(|at| mask.pixels()[*at] != 0);
    let sum = inside.fold([0.0; 2], |sum: [f64; 2], at| {
        [sum[0] + (at % mask.width()) as f64, sum[1] + (at / mask.width()) as f64]
    });
    sum.map(|sum| sum / mask.area() as f64)
}

#[test]
fn the_hand_is_found_in_every_sample_by_colours_and_network_alike() {
    for name in NAMES {
        let found = found(name);
        let share = found.mask.area() as f64 / found.mask.pixels().len() as f64;
        assert!((0.03..0.4).contains(&share), "{name}: {share}");
        // Colours and the network have found the same.
        let agreement = found.scene.unwrap().found.agreement(&found.skin.unwrap());
        assert!(agreement > 0.5, "{name}: {agreement}");
    }
}

#[test]
fn a_picture_that_is_turned_is_looked_at_as_it_was() {
    for name in NAMES {
        let picture = camera(name);
        let networks = Networks::default();
        let [before, after] =
            [&picture, &turned(&picture)].map(|picture| find(&networks, picture).unwrap().square());
        let turn = (before.turn - FRAC_PI_2 - after.turn).cos();
        assert!(turn > 0.7, "{name}: {before:?} {after:?}");
        let [x, y] = before.centre;
        let expected = [picture.height() as f64 - y, x];
        let off = (expected[0] - after.centre[0]).hypot(expected[1] - after.centre[1]);
        assert!(off < 0.2 * before.side, "{name}: {before:?} {after:?}");
    }
}

#[test]
fn what_hand_and_object_are_is_as_likely_for_either_hand_in_all() {
    let scene = found(NAMES[0]).scene.unwrap();
    for side in [Side::Left, Side::Right] {
        let probabilities = scene.prediction.probabilities(side);
        assert_eq!(probabilities.len(), 7, "six grasps, and none");
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_hand_stands_in_the_middle_of_its_square() {
    for name in NAMES {
        let found = found(name);
        let off = found.scene.unwrap().square.from_picture().apply(middle(&found.mask));
        assert!(off.iter().all(|place| (0.2..0.8).contains(place)), "{name}: {off:?}");
    }
}

/// A hand image's mask and picture.
fn segmented(name: &str) -> Prepared {
    let bytes = picture::read(&folder().join(format!("segmented/{name}.png"))).unwrap();
    Prepared::decode(&bytes, &MaskSource::Segmented, &SegmentParams::default()).expect(name)
}

fn cut_out(picture: &Picture, mask: &Mask) -> Prediction {
    let size = (picture.width(), picture.height());
    let hand = HandImage::from_mask(size.0, size.1, &picture.grey(), mask.pixels()).unwrap();
    let turn = hand.upright_turn_deg().to_radians();
    Prediction::of_cut_out(&Networks::default(), picture, mask, turn, &[Side::Right, Side::Left]).unwrap()
}

#[test]
fn a_hand_that_is_cut_out_is_known_from_its_mirror_image() {
    let mut right = 0;
    for name in NAMES {
        let Prepared { picture, mask, .. } = segmented(name);
        let prediction = cut_out(&picture, &mask);
        for side in [Side::Right, Side::Left] {
            let probabilities = prediction.probabilities(side);
            assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{name}");
        }
        right += usize::from(prediction.right_odds > 0.0);
    }
    assert!(right >= 5, "{right} of {}", NAMES.len());
}

#[test]
fn what_lies_around_a_hand_that_is_cut_out_is_not_looked_at() {
    let Prepared { picture, mask, .. } = segmented("09-pinch");
    let of = |picture: &Picture| cut_out(picture, &mask).probabilities(Side::Right);
    let beyond = picture.rgb().iter().zip(mask.pixels()).enumerate();
    let rgb = beyond.map(|(at, (rgb, inside))| if *inside != 0 { *rgb } else { [at as u8, 200, 90] });
    let other = Picture::new(picture.width(), picture.height(), rgb.collect()).unwrap();
    assert_eq!(of(&picture), of(&other));
    let nothing = Mask::from_values(8, 8, &[0u8; 64], |value| value > 0);
    let small = Picture::new(8, 8, vec![[9; 3]; 64]).unwrap();
    assert!(Prediction::of_cut_out(&Networks::default(), &small, &nothing, 0.0, &[Side::Right]).is_none());
}

#[test]
fn a_hand_that_is_cut_out_is_known_again_when_it_is_turned() {
    for name in ["01-large-diameter", "10-power-sphere"] {
        let Prepared { picture, mask, .. } = segmented(name);
        let turn_mask = |mask: &Mask| {
            let (width, height) = (mask.width(), mask.height());
            let values: Vec<u8> = (0..width * height)
                .map(|at| mask.pixels()[(height - 1 - at % height) * width + at / height])
                .collect();
            Mask::from_values(height, width, &values, |value| value > 0)
        };
        let before = cut_out(&picture, &mask).probabilities(Side::Right);
        let after = cut_out(&turned(&picture), &turn_mask(&mask)).probabilities(Side::Right);
        for (before, after) in before.iter().zip(&after) {
            assert!((before - after).abs() < 0.15, "{name}: {before} {after}");
        }
    }
}

#[test]
fn a_wall_has_no_hand() {
    let wall = Picture::new(160, 120, vec![[120, 130, 140]; 160 * 120]).unwrap();
    assert!(find(&Networks::default(), &wall).is_none());
    let single = Picture::new(1, 1, vec![[200, 150, 120]]).unwrap();
    // Whatever it says of a pixel, it returns.
    let _ = find(&Networks::default(), &single);
}

/// Where the joints of the hand that pinches are, to a few pixels (`landmarks/09-pinch.json`).
const JOINTS: [[f64; 2]; 21] = [
    [451.0, 113.0],
    [421.0, 146.0],
    [381.0, 202.0],
    [355.0, 247.0],
    [330.0, 287.0],
    [302.0, 174.0],
    [272.0, 242.0],
    [280.0, 282.0],
    [290.0, 310.0],
    [295.0, 171.0],
    [265.0, 242.0],
    [275.0, 285.0],
    [282.0, 315.0],
    [297.0, 169.0],
    [262.0, 239.0],
    [272.0, 287.0],
    [281.0, 318.0],
    [302.0, 166.0],
    [297.0, 222.0],
    [297.0, 247.0],
    [295.0, 267.0],
];

/// Two pictures of one size, side by side.
fn beside(left: &Picture, right: &Picture) -> Picture {
    let (width, height) = (left.width(), left.height());
    let rows = left.rgb().chunks(width).zip(right.rgb().chunks(width));
    let pixels = rows.flat_map(|(left, right)| left.iter().chain(right)).copied();
    Picture::new(2 * width, height, pixels.collect()).unwrap()
}

#[test]
fn joints_say_which_of_two_hands_is_meant() {
    let (pinch, ball) = (camera("09-pinch"), camera("10-power-sphere"));
    let (width, height) = (pinch.width() as f64, pinch.height() as f64);
    let shares = |shift: f64| JOINTS.map(|[x, y]| [(x + shift) / (2.0 * width), y / height]);
    for by in [Finder::Scene, Finder::Skin] {
        let params = SegmentParams { by: by.clone(), ..SegmentParams::default() };
        for (picture, shift) in [(beside(&pinch, &ball), 0.0), (beside(&ball, &pinch), width)] {
            let landmarks = Landmarks::new(&shares(shift), LandmarkUnit::Share).unwrap();
            let found = Prepared::new(picture, false, &MaskSource::Landmarks(landmarks), &params).unwrap();
            let shrunk = 2.0 * width / found.picture.width() as f64;
            let [x, y] = middle(&found.mask).map(|v| v * shrunk);
            let off = (x - shift - 335.0).hypot(y - 205.0);
            assert!(off < 60.0, "{by:?}, {shift}: the hand is found at {x}, {y}");
        }
    }
}
