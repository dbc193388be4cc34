//! A hand that moves through a video, which the sample pictures were made into: it is followed, and
//! what is found is what a search of each frame by itself finds.

use std::path::Path;

use grasp_recognise::picture::{self, Picture};
use grasp_recognise::segment::SegmentParams;
use grasp_recognise::{MaskSource, Prepared, Side, Tracker};

/// The samples, and their grasps' places in the network's order.
const SAMPLES: [(&str, usize); 4] =
    [("01-large-diameter", 0), ("02-small-diameter", 1), ("10-power-sphere", 4), ("12-precision-disc", 5)];
/// Frames of each video.
const FRAMES: usize = 16;

/// A sample at half its size, as it is recognised.
fn sample(name: &str) -> Picture {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/pictures/camera");
    let bytes = picture::read(&folder.join(format!("{name}.jpg"))).unwrap();
    picture::decode(&bytes).unwrap().picture.shrunk_to(320)
}

/// A picture, turned clockwise about its middle, enlarged and shifted; what lies beyond its border
/// looks like the border.
fn moved(picture: &Picture, degrees: f64, size: f64, shift: [f64; 2]) -> Picture {
    let (width, height) = (picture.width(), picture.height());
    let (sin, cos) = degrees.to_radians().sin_cos();
    let middle = [width, height].map(|side| 0.5 * side as f64);
    let pixels = (0..width * height).map(|at| {
        let [x, y] = [0, 1].map(|i| [at % width, at / width][i] as f64 - middle[i] - shift[i]);
        let from = [(cos * x + sin * y) / size + middle[0], (cos * y - sin * x) / size + middle[1]];
        let [x, y] =
            [(from[0], width), (from[1], height)].map(|(v, side)| (v.max(0.0) as usize).min(side - 1));
        picture.rgb()[y * width + x]
    });
    Picture::new(width, height, pixels.collect()).unwrap()
}

/// A frame of a hand that swings, turns, and comes nearer: at most 7 pixels and 5 degrees a frame.
fn frame(picture: &Picture, at: usize) -> Picture {
    let time = at as f64 / FRAMES as f64 * std::f64::consts::TAU;
    let shift = [18.0 * time.sin(), 12.0 * (1.0 - time.cos())];
    moved(picture, 12.0 * time.sin(), 1.0 + 0.15 * (1.0 - time.cos()), shift)
}

fn searched(picture: Picture) -> Prepared {
    Prepared::new(picture, true, &MaskSource::Camera, &SegmentParams::default()).unwrap()
}

fn followed(picture: Picture, tracker: &mut Tracker) -> Prepared {
    Prepared::next(picture, tracker, &SegmentParams::default()).unwrap()
}

/// The likeliest grasp of the likelier hand, by its place.
fn grasp(prepared: &Prepared) -> (Side, usize) {
    let scene = prepared.scene.as_ref().unwrap();
    let side = if scene.prediction.right_odds > 0.0 { Side::Right } else { Side::Left };
    let probabilities = scene.prediction.probabilities(side);
    let first = (0..6).max_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b])).unwrap();
    (side, first)
}

#[test]
fn a_hand_that_moves_is_followed_to_the_answers_of_a_search() {
    let (mut same, mut alike, mut turned_alike) = (0, 0, 0);
    let mut right = [0, 0];
    for (name, grasp_of_it) in SAMPLES {
        let picture = sample(name);
        let mut tracker = Tracker::default();
        for at in 0..FRAMES {
            let frame = frame(&picture, at);
            let alone = searched(frame.clone());
            let next = followed(frame, &mut tracker);
            let named = [grasp(&alone), grasp(&next)];
            same += usize::from(named[0] == named[1]);
            for (right, named) in right.iter_mut().zip(named) {
                *right += usize::from(named == (Side::Right, grasp_of_it));
            }
            alike += usize::from(alone.mask.iou(&next.mask).unwrap() > 0.9);
            let [a, b] = [&alone, &next].map(|prepared| prepared.scene.as_ref().unwrap().square.turn);
            turned_alike += usize::from((a - b).cos() > 0.9);
        }
        assert!(tracker.searches() <= 2, "{name}: looked for {} times", tracker.searches());
    }
    let all = SAMPLES.len() * FRAMES;
    let told = format!(
        "of {all}: {same} of the same grasp, {alike} of the same outline, {turned_alike} turned alike; right {right:?}"
    );
    println!("{told}");
    assert!(20 * alike >= 19 * all && 20 * turned_alike >= 18 * all, "{told}");
    // Where it is unsure of the grasp, a look of another turn may name another: as often the right
    // one.
    assert!(20 * same >= 17 * all && right[1] >= right[0], "{told}");
}

#[test]
fn a_hand_that_jumps_is_searched_for_and_found_as_in_a_picture_alone() {
    let picture = sample(SAMPLES[2].0);
    let mut tracker = Tracker::default();
    // To another corner of the picture, and to a picture of another size.
    let places = [[-70.0, -40.0], [80.0, 50.0], [-80.0, 50.0]];
    for (at, shift) in places.into_iter().enumerate() {
        let frame = moved(&picture, 0.0, 0.7, shift);
        let alone = searched(frame.clone());
        let next = followed(frame, &mut tracker);
        assert_eq!(tracker.searches(), at as u64 + 1, "the hand is elsewhere");
        assert!(next.mask == alone.mask, "{shift:?}");
    }
    let larger = sample(SAMPLES[0].0).shrunk_to(160);
    assert!(followed(larger.clone(), &mut tracker).mask == searched(larger).mask);
    // Where it stays, it is not searched for again, and what is lost is not followed.
    let before = tracker.searches();
    let frame = moved(&picture, 0.0, 0.7, [0.0; 2]);
    followed(frame.clone(), &mut tracker);
    followed(frame.clone(), &mut tracker);
    assert_eq!(tracker.searches(), before + 1);
    let wall = Picture::new(320, 240, vec![[120, 130, 140]; 320 * 240]).unwrap();
    assert!(Prepared::next(wall, &mut tracker, &SegmentParams::default()).is_err());
    assert_eq!(tracker.searches(), before + 2);
    assert!(followed(frame.clone(), &mut tracker).mask == searched(frame).mask);
}
