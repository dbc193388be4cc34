//! Looks for the joints of the hand in a picture by the networks for palms and for hands.
//!
//! A palm says where its hand is and which way that points; the joints of the hand, seen so, say it
//! better, and are looked for once more there. What a palm's box and the joints are enlarged and
//! shifted by, to become the square of a hand, is that of MediaPipe's graphs
//! (`palm_detection_detection_to_roi`, `hand_landmark_landmarks_to_roi`).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::landmarks::{Joints, LandmarkUnit, Landmarks};
use super::square::{Square, Texels};
use crate::mediapipe::{HAND_SIDE, Hand, HandNetworks, HandNetworksError, PALM_SIDE, Palm};
use crate::picture::Picture;

/// The squares in which palms are looked for, one after the other until a hand is found: their
/// sides in longer sides of the picture, and their turns. The network knows hands that fill half of
/// what it sees, and mostly upright ones.
const LOOKS: [(f64, f64); 7] =
    [(1.0, 0.0), (1.6, 0.0), (1.0, FRAC_PI_2), (1.0, -FRAC_PI_2), (1.0, PI), (2.4, 0.0), (0.6, 0.0)];
/// So many palms of a look are asked for their hands.
const MOST_PALMS: usize = 3;
/// The least probability of a hand, of one that ends the search, and of one that is looked at once
/// more.
const PRESENT: f64 = 0.5;
const SURE: f64 = 0.8;
const LIKELY: f64 = 0.02;
/// Sides of a hand's square that are tried, in longer sides of its palm's box, and how far its
/// middle lies from the box's towards the fingers, in heights of the box; then the same of the box
/// of its joints. MediaPipe has the first of the sides.
const PALM_SIZES: [f64; 3] = [2.6, 2.0, 3.3];
const PALM_SHIFT: f64 = 0.5;
const JOINTS_SIZE: f64 = 2.0;
const JOINTS_SHIFT: f64 = 0.1;
/// The sides, in sides of a square in which something else has seen a hand, and the turns, in
/// eighths of the circle, by which the hand is looked for there: its palm may be hidden.
const ABOUT_SIZES: [f64; 2] = [1.0, 1.4];
const TURNS: [f64; 8] = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0];
const WRIST: usize = 0;
/// The knuckles of index, middle and ring finger: the middle one counts as both others together.
const KNUCKLES: [(usize, f64); 3] = [(5, 0.25), (9, 0.5), (13, 0.25)];
/// The joints whose box it is: fingers may be bent.
const BOXED: [usize; 12] = [0, 1, 2, 3, 5, 6, 9, 10, 13, 14, 17, 18];

/// Joints that were found.
#[derive(Clone, Debug)]
pub(super) struct HandJoints {
    /// Where they are.
    pub(super) joints: Joints,
    /// How probably there is a hand.
    pub(super) presence: f64,
    /// The logarithm of how much likelier a right hand is than a left one.
    pub(super) right_odds: f64,
}

/// Looks for joints in one picture.
pub(super) struct Seeker<'a> {
    networks: &'a HandNetworks,
    picture: &'a Picture,
    texels: Texels,
    pixels: Vec<f32>,
}

impl<'a> Seeker<'a> {
    pub(super) fn new(networks: &'a HandNetworks, picture: &'a Picture) -> Self {
        Self { networks, picture, texels: Texels::of(picture), pixels: Vec::new() }
    }

    /// The joints of the largest hand that the first look finds which finds one surely, or else of
    /// the surest one of all looks; `None` where none finds any.
    pub(super) fn in_picture(&mut self) -> Result<Option<HandJoints>, HandNetworksError> {
        let whole = Square::around(self.picture);
        let mut surest: Option<HandJoints> = None;
        for (size, turn) in LOOKS {
            let square = Square { side: size * whole.side, turn, ..whole };
            self.look(&square, PALM_SIDE);
            self.blacken(&square, PALM_SIDE);
            let palms = self.networks.palms(&self.pixels)?;
            let mut hands = Vec::new();
            for palm in palms.iter().take(MOST_PALMS) {
                hands.extend(self.hand_of_palm(&square, palm)?);
            }
            let sure = hands.iter().filter(|hand| hand.presence >= SURE);
            if let Some(largest) = sure.max_by(|a, b| a.joints.length().total_cmp(&b.joints.length())) {
                return Ok(Some(largest.clone()));
            }
            surest = hands.into_iter().chain(surest).max_by(|a, b| a.presence.total_cmp(&b.presence));
        }
        Ok(surest)
    }

    /// The joints of a hand that is about in a square, and stands about upright there or not.
    pub(super) fn about(&mut self, square: &Square) -> Result<Option<HandJoints>, HandNetworksError> {
        let sized = |size| Square { side: size * square.side, ..*square };
        let turned = |square: Square| {
            TURNS.into_iter().map(move |eighths| Square { turn: square.turn + eighths * FRAC_PI_4, ..square })
        };
        self.surest(ABOUT_SIZES.into_iter().map(sized).flat_map(turned))
    }

    /// The joints of a palm's hand.
    fn hand_of_palm(
        &mut self,
        square: &Square,
        palm: &Palm,
    ) -> Result<Option<HandJoints>, HandNetworksError> {
        self.surest(PALM_SIZES.into_iter().map(|size| around_palm(square, palm, size)))
    }

    /// The joints in the first square that shows them surely, or else in that which does most
    /// surely.
    fn surest(
        &mut self,
        squares: impl Iterator<Item = Square>,
    ) -> Result<Option<HandJoints>, HandNetworksError> {
        let mut surest: Option<HandJoints> = None;
        for square in squares {
            let seen = self.in_square(&square)?;
            surest = seen.into_iter().chain(surest).max_by(|a, b| a.presence.total_cmp(&b.presence));
            if surest.as_ref().is_some_and(|seen| seen.presence >= SURE) {
                break;
            }
        }
        Ok(surest)
    }

    /// The joints of the hand that stands upright in a square; `None` where there is none.
    fn in_square(&mut self, square: &Square) -> Result<Option<HandJoints>, HandNetworksError> {
        let Some(first) = self.hand(square)?.filter(|hand| hand.presence >= LIKELY) else { return Ok(None) };
        let nearer = around_joints(&in_picture(square, &first));
        let (square, hand) = match self.hand(&nearer)? {
            Some(second) if second.presence >= PRESENT => (nearer, second),
            _ if first.presence >= PRESENT => (*square, first),
            _ => return Ok(None),
        };
        let landmarks = Landmarks::new(&in_picture(&square, &hand), LandmarkUnit::Pixel);
        // Joints that show no hand, or lie beside the picture, are none.
        let joints = landmarks.and_then(|all| all.of_picture(self.picture.width(), self.picture.height()));
        let Hand { presence, right_odds, .. } = hand;
        Ok(joints.ok().map(|joints| HandJoints { joints: joints.doubted(), presence, right_odds }))
    }

    fn hand(&mut self, square: &Square) -> Result<Option<Hand>, HandNetworksError> {
        self.look(square, HAND_SIDE);
        self.networks.hand(&self.pixels)
    }

    /// Has the square's colours in `pixels`, 0 to 1.
    fn look(&mut self, square: &Square, side: usize) {
        square.planes(&self.texels, side, &mut self.pixels);
        self.pixels.iter_mut().for_each(|value| *value = 0.5 * (*value + 1.0));
    }

    /// Makes black what is not in the picture, as the palm network was taught.
    fn blacken(&mut self, square: &Square, side: usize) {
        let map = square.to_picture();
        let size = [self.picture.width(), self.picture.height()].map(|v| v as f64);
        for (at, pixel) in self.pixels.chunks_exact_mut(3).enumerate() {
            let place = map.apply([at % side, at / side].map(|v| (v as f64 + 0.5) / side as f64));
            if !place.iter().zip(size).all(|(v, most)| (0.0..most).contains(v)) {
                pixel.fill(0.0);
            }
        }
    }
}

/// The joints of a square in pixels of the picture.
fn in_picture(square: &Square, hand: &Hand) -> [[f64; 2]; 21] {
    let map = square.to_picture();
    hand.joints.map(|place| map.apply(place))
}

/// The square of a palm's hand, its fingers up, its side `sizes` sides of the palm's box.
fn around_palm(square: &Square, palm: &Palm, sizes: f64) -> Square {
    let map = square.to_picture();
    let [middle, wrist, knuckle] = [palm.middle, palm.wrist(), palm.knuckle()].map(|place| map.apply(place));
    let size = palm.size.map(|side| side * square.side);
    around(middle, size, upright([0, 1].map(|i| wrist[i] - knuckle[i])), sizes, PALM_SHIFT)
}

/// The square of a hand whose joints are known, its fingers up.
fn around_joints(joints: &[[f64; 2]; 21]) -> Square {
    let knuckle = [0, 1].map(|i| KNUCKLES.iter().map(|(at, share)| share * joints[*at][i]).sum::<f64>());
    let turn = upright([0, 1].map(|i| joints[WRIST][i] - knuckle[i]));
    let (sin, cos) = libm::sincos(turn);
    // Across and down in the square that is turned.
    let axes = [[cos, -sin], [sin, cos]];
    let ends = axes.map(|axis| {
        let along = BOXED.iter().map(|at| axis[0] * joints[*at][0] + axis[1] * joints[*at][1]);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    });
    let [across, down] = ends.map(|[low, high]| 0.5 * (low + high));
    let middle = [0, 1].map(|i| across * axes[0][i] + down * axes[1][i]);
    around(middle, ends.map(|[low, high]| high - low), turn, JOINTS_SIZE, JOINTS_SHIFT)
}

/// The turn by which a direction in the picture points down.
fn upright([x, y]: [f64; 2]) -> f64 {
    FRAC_PI_2 - libm::atan2(y, x)
}

fn around(middle: [f64; 2], [width, height]: [f64; 2], turn: f64, sizes: f64, shift: f64) -> Square {
    let (sin, cos) = libm::sincos(turn);
    let centre = [middle[0] - shift * height * sin, middle[1] - shift * height * cos];
    Square { centre, side: sizes * width.max(height), turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use proptest::prelude::*;

    use crate::mediapipe::tests_support::{Answer, onnx};
    use crate::picture;
    use crate::segment::{Finder, SegmentParams};
    use crate::{MaskSource, Prepared};

    /// Cells of the palm network's fine grid.
    const CELLS: usize = 24;

    /// Networks that see one palm of a quarter of the square's side, which points up, in a cell of
    /// it, and everywhere an upright hand, so probably, a right one so probably.
    fn networks(cell: [usize; 2], presence: Answer, right: f32) -> HandNetworks {
        let (mut boxes, mut logits) = (vec![0.0; 2016 * 18], vec![-20.0; 2016]);
        let at = 2 * (cell[1] * CELLS + cell[0]);
        boxes[18 * at..18 * at + 10]
            .copy_from_slice(&[0.0, 0.0, 48.0, 48.0, 0.0, 24.0, 0.0, 0.0, 0.0, -24.0]);
        logits[at] = 4.0;
        let places = upright_hand().map(|[x, y]| [x as f32, y as f32 - 20.0, 0.0]);
        let answers = [
            Answer::Values(places.as_flattened().to_vec()),
            presence,
            Answer::Values(vec![right]),
            Answer::Values(vec![0.0; 63]),
        ];
        let palm = onnx(PALM_SIDE, &[Answer::Values(boxes), Answer::Values(logits)]);
        HandNetworks::from_onnx(palm, onnx(HAND_SIDE, &answers)).unwrap()
    }

    fn bright(is_so: bool) -> Picture {
        Picture::new(640, 480, vec![if is_so { [250; 3] } else { [5; 3] }; 640 * 480]).unwrap()
    }

    #[test]
    fn joints_are_looked_for_where_a_palm_was_seen() {
        let networks = networks([8, 12], Answer::Brightness, 0.9);
        let (light, dark) = (bright(true), bright(false));
        let seen = Seeker::new(&networks, &light).in_picture().unwrap().unwrap();
        let (square, _) = seen.joints.square();
        // The cell's middle is at 227, 253 of the picture, and a hand's middle is above its palm's.
        let [x, y] = [square.centre[0] - 227.0, square.centre[1] - 253.0];
        assert!(x.abs() < 60.0 && (-160.0..0.0).contains(&y), "{x}, {y}");
        assert!((100.0..500.0).contains(&seen.joints.length()), "{}", seen.joints.length());
        assert!((seen.right_odds - 9f64.ln()).abs() < 1e-4);
        assert!(Seeker::new(&networks, &dark).in_picture().unwrap().is_none());
    }

    fn sample() -> Picture {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/pictures/camera");
        picture::decode(&picture::read(&folder.join("09-pinch.jpg")).unwrap()).unwrap().picture
    }

    /// The sample, nearly grey, beside as much blue.
    fn faint() -> Picture {
        let sample = sample();
        let faint = |pixel: &[u8; 3]| {
            let grey = pixel.iter().map(|v| u32::from(*v)).sum::<u32>() / 3;
            pixel.map(|v| ((85 * grey + 15 * u32::from(v)) / 100) as u8)
        };
        let rows = sample.rgb().chunks(sample.width());
        let pixels = rows.flat_map(|row| row.iter().map(faint).chain(row.iter().map(|_| [20, 60, 200])));
        Picture::new(2 * sample.width(), sample.height(), pixels.collect()).unwrap()
    }

    fn prepared(picture: Picture, by: Finder) -> Prepared {
        let params = SegmentParams { by, ..SegmentParams::default() };
        Prepared::new(picture, false, &MaskSource::Camera, &params).unwrap()
    }

    #[test]
    fn where_they_find_no_hand_it_is_that_of_the_scene_network() {
        let nothing = networks([8, 12], Answer::Values(vec![0.0]), 0.9);
        let in_the_blue = networks([18, 12], Answer::Values(vec![1.0]), 0.9);
        for (picture, networks) in [(sample(), nothing), (faint(), in_the_blue)] {
            let by_scene = prepared(picture.clone(), Finder::Scene);
            let found = prepared(picture, Finder::Landmarks(networks));
            assert!(found.mask == by_scene.mask);
            let odds = [found, by_scene].map(|prepared| prepared.scene.unwrap().prediction.right_odds);
            assert_eq!(odds[0], odds[1]);
        }
    }

    #[test]
    fn which_hand_the_networks_see_counts() {
        let odds = [0.99f32, 0.01].map(|right| {
            let networks = networks([12, 10], Answer::Values(vec![1.0]), right);
            prepared(sample(), Finder::Landmarks(networks)).scene.unwrap().prediction.right_odds
        });
        assert!((odds[0] - odds[1] - 2.0 * 99f64.ln()).abs() < 1e-3, "{odds:?}");
    }

    /// A hand with its fingers up, in a box of 60 by 100 pixels without fingertips.
    fn upright_hand() -> [[f64; 2]; 21] {
        let mut joints = [[100.0, 200.0]; 21];
        for finger in 0..5 {
            for joint in 0..4 {
                joints[1 + 4 * finger + joint] = [70.0 + 15.0 * finger as f64, 160.0 - 30.0 * joint as f64];
            }
        }
        joints
    }

    #[test]
    fn the_square_of_joints_is_around_them_with_room() {
        let square = around_joints(&upright_hand());
        // Down to the second joint of the thumb, and 5 pixels aside at most.
        assert!(square.turn.abs() < 0.2, "{square:?}");
        let places = upright_hand().map(|place| square.from_picture().apply(place));
        assert!(places.as_flattened().iter().all(|share| (0.0..1.0).contains(share)), "{places:?}");
        assert!(places[0][1] > places[9][1], "the wrist is below");
    }

    proptest! {
        #[test]
        fn a_turned_hand_has_the_same_square_turned(turn in -3.1f64..3.1, x in -50.0f64..900.0, y in 0.0f64..700.0) {
            let straight = around_joints(&upright_hand());
            let frame = Square { centre: [x, y], side: 1.0, turn };
            let moved = upright_hand().map(|place| frame.to_picture().apply(place));
            let square = around_joints(&moved);
            prop_assert!((square.side - straight.side).abs() < 1e-6);
            let [there, back] = [frame.to_picture().apply(straight.centre), square.centre];
            prop_assert!((there[0] - back[0]).abs() < 1e-6 && (there[1] - back[1]).abs() < 1e-6);
            let seen = moved.map(|place| square.from_picture().apply(place));
            let same = upright_hand().map(|place| straight.from_picture().apply(place));
            for (a, b) in seen.as_flattened().iter().zip(same.as_flattened()) {
                prop_assert!((a - b).abs() < 1e-6);
            }
        }
    }
}
