//! A hand whose joints a tracker of the user's own has found.

use std::f64::consts::FRAC_PI_2;

use serde::Deserialize;
use thiserror::Error;

use super::square::Square;

/// Bones between landmarks: the thumb's, then each finger's from the wrist to its tip.
const BONES: [[usize; 2]; 20] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 4],
    [0, 5],
    [5, 6],
    [6, 7],
    [7, 8],
    [0, 9],
    [9, 10],
    [10, 11],
    [11, 12],
    [0, 13],
    [13, 14],
    [14, 15],
    [15, 16],
    [0, 17],
    [17, 18],
    [18, 19],
    [19, 20],
];
/// What lies between the wrist, the thumb's root and the knuckles is palm.
const PALM: [[usize; 3]; 4] = [[0, 1, 5], [0, 5, 9], [0, 9, 13], [0, 13, 17]];
const WRIST: usize = 0;
const MIDDLE_KNUCKLE: usize = 9;
const KNUCKLES: [usize; 2] = [5, 17];
/// Half a finger's breadth, and the breadth over the knuckles, in lengths of the hand: 9 and 65 of
/// 187 mm (T. M. Greiner, "Hand anthropometry of U.S. Army personnel", Natick/TR-92/011, 1991).
const HALF_FINGER: f64 = 0.048;
const BREADTH: f64 = 0.35;
/// The log-odds of a hand change by 1 in so many of its lengths.
const SOFT: f64 = 0.005;
/// The least and the most log-odds: trackers are a finger's breadth off now and then, but what is
/// far from every joint is another hand. They are large because colours take what else has seen the
/// hand at a tenth ([`crate::segment::adapt::AdaptParams`]).
const MOST_SURE: [f64; 2] = [-60.0, 6.0];
/// The same where nobody has looked at what a tracker says.
#[cfg(feature = "landmarks")]
const UNSEEN: [f64; 2] = [-3.0, 3.0];
/// The side of the square that is looked at first, in lengths of the hand.
const SIDE: f64 = 1.6;
/// A palm that is shorter than this in the picture, in lengths of the hand, does not show where the
/// arm comes from.
const SHORT: f64 = 0.12;

/// What places are counted in, right and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LandmarkUnit {
    /// Pixels of the picture, upright as its EXIF orientation says.
    Pixel,
    /// Shares of its width and height, 0 to 1.
    Share,
}

/// The places of a hand's 21 joints in a picture: wrist, four of the thumb from its root to its
/// tip, four of each finger from its knuckle to its tip, index finger first. The order is that of
/// MediaPipe's hand landmarks and of OpenPose's hands.
///
/// They are read from a file `{"unit": "pixel" or "share", "landmarks": [...]}`, whose 21 places
/// are each `[x, y]`, `[x, y, z]` or `{"x": .., "y": ..}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "File")]
pub struct Landmarks {
    places: Box<[[f64; 2]; 21]>,
    unit: LandmarkUnit,
}

/// The same as a file has them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "{\"unit\": .., \"landmarks\": [..]}")]
struct File {
    unit: LandmarkUnit,
    landmarks: Vec<Place>,
}

/// What else a tracker says of a place is left alone.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a place is [x, y], [x, y, z] or {\"x\": .., \"y\": ..}, all of them numbers")]
enum Place {
    List([f64; 2]),
    Deep([f64; 3]),
    Named { x: f64, y: f64 },
}

impl Place {
    fn xy(&self) -> [f64; 2] {
        match *self {
            Self::List(place) => place,
            Self::Deep([x, y, _]) | Self::Named { x, y } => [x, y],
        }
    }
}

impl TryFrom<File> for Landmarks {
    type Error = LandmarksError;

    fn try_from(file: File) -> Result<Self, LandmarksError> {
        let places: Vec<[f64; 2]> = file.landmarks.iter().map(Place::xy).collect();
        Self::new(&places, file.unit)
    }
}

/// The same in pixels of a picture that they were checked to be in.
#[derive(Clone, Debug, PartialEq)]
pub struct Joints {
    points: [[f64; 2]; 21],
    /// About how long the hand is: as its longest finger, or its knuckles, say.
    length: f64,
    /// The least and the most log-odds of a hand by them.
    sure: [f64; 2],
}

/// What is wrong with landmarks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LandmarksError {
    /// There are not 21.
    #[error("{0} landmarks, 21 expected: the wrist, then four of the thumb and of each finger")]
    Count(usize),
    /// One is nowhere.
    #[error("landmark {0} is not at a place: both its numbers must be finite")]
    NotFinite(usize),
    /// They show no hand.
    #[error("the landmarks are all within {0:.1} pixels: a hand is larger")]
    Small(f64),
    /// One is farther away than a hand reaches.
    #[error("landmark {0} lies far outside the picture: is the unit right?")]
    Far(usize),
    /// They lie elsewhere.
    #[error("no landmark lies in the picture of {width} x {height} pixels")]
    Outside {
        /// The picture's width.
        width: usize,
        /// Its height.
        height: usize,
    },
}

/// The least length of a hand in pixels.
const LEAST: f64 = 8.0;
/// How far outside the picture a landmark may lie, in its sides.
const FAR: f64 = 10.0;

impl Landmarks {
    /// Landmarks at these places.
    ///
    /// # Errors
    /// Where there are not 21 of them, or one is nowhere.
    pub fn new(places: &[[f64; 2]], unit: LandmarkUnit) -> Result<Self, LandmarksError> {
        let places = <[[f64; 2]; 21]>::try_from(places).map_err(|_| LandmarksError::Count(places.len()))?;
        match places.iter().position(|place| !place.iter().all(|v| v.is_finite())) {
            Some(at) => Err(LandmarksError::NotFinite(at)),
            None => Ok(Self { places: Box::new(places), unit }),
        }
    }

    /// Where they are in a picture of this size.
    ///
    /// # Errors
    /// Where none of them lies in it, or they are too near each other to be a hand's.
    pub fn of_picture(&self, width: usize, height: usize) -> Result<Joints, LandmarksError> {
        let size = [width, height].map(|side| side as f64);
        let unit = if self.unit == LandmarkUnit::Share { size } else { [1.0; 2] };
        let places = self.places.map(|[x, y]| [x * unit[0], y * unit[1]]);
        let near = |place: &[f64; 2]| {
            place.iter().zip(size).all(|(v, side)| (-FAR * side..=(1.0 + FAR) * side).contains(v))
        };
        if let Some(at) = places.iter().position(|place| !near(place)) {
            return Err(LandmarksError::Far(at));
        }
        let joints = Joints::new(places);
        let inside = |place: &[f64; 2]| place.iter().zip(size).all(|(v, most)| (0.0..=most).contains(v));
        if !joints.points.iter().any(inside) {
            return Err(LandmarksError::Outside { width, height });
        }
        if joints.length < LEAST { Err(LandmarksError::Small(joints.length)) } else { Ok(joints) }
    }
}

impl Joints {
    fn new(points: [[f64; 2]; 21]) -> Self {
        let bone = |[from, to]: [usize; 2]| distance(points[from], points[to]);
        let fingers = BONES.chunks(4).skip(1).map(|bones| bones.iter().copied().map(bone).sum());
        Self { points, length: fingers.fold(bone(KNUCKLES) / BREADTH, f64::max), sure: MOST_SURE }
    }

    /// About how long the hand is, in pixels.
    #[cfg(feature = "landmarks")]
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// The same where they may be another hand's, or another thing's.
    #[cfg(feature = "landmarks")]
    pub(super) fn doubted(self) -> Self {
        Self { sure: UNSEEN, ..self }
    }

    /// The same hand in a picture that is `factor` times as small.
    pub(crate) fn shrunk(&self, factor: usize) -> Self {
        let shrunk = Self::new(self.points.map(|place| place.map(|v| v / factor as f64)));
        Self { sure: self.sure, ..shrunk }
    }

    /// The square around the hand, and whether it shows where the arm comes from: it comes from
    /// below then.
    pub(super) fn square(&self) -> (Square, bool) {
        let corner = |pick: fn(f64, f64) -> f64| {
            [0, 1].map(|i| self.points.iter().map(|place| place[i]).reduce(pick).unwrap_or_default())
        };
        let (low, high) = (corner(f64::min), corner(f64::max));
        let [x, y] = [0, 1].map(|i| self.points[WRIST][i] - self.points[MIDDLE_KNUCKLE][i]);
        let is_long = libm::hypot(x, y) > SHORT * self.length;
        let turn = if is_long { FRAC_PI_2 - libm::atan2(y, x) } else { 0.0 };
        let centre = [0, 1].map(|i| 0.5 * (low[i] + high[i]));
        (Square { centre, side: SIDE * self.length, turn }, is_long)
    }

    /// The log-odds of the hand at a place of the picture, by how far from the bones it is.
    pub(crate) fn hand(&self, place: [f64; 2]) -> f32 {
        let length = self.length;
        let is_palm = PALM.iter().any(|corners| is_inside(place, corners.map(|at| self.points[at])));
        let bones = BONES.iter().map(|ends| from_bone(place, ends.map(|at| self.points[at])));
        let away = if is_palm { 0.0 } else { bones.fold(f64::INFINITY, f64::min) };
        let odds = (HALF_FINGER * length - away) / (SOFT * length);
        odds.clamp(self.sure[0], self.sure[1]) as f32
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// How far a place is from a bone.
fn from_bone([x, y]: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0] * along[0] + along[1] * along[1];
    let share = ((x - a[0]) * along[0] + (y - a[1]) * along[1]) / length.max(f64::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    distance([x, y], [a[0] + share * along[0], a[1] + share * along[1]])
}

/// Whether a place lies in a triangle, whichever way round that goes. One whose corners are at one
/// place, as trackers have joints that they do not see, holds nothing.
fn is_inside([x, y]: [f64; 2], corners: [[f64; 2]; 3]) -> bool {
    let sides = [0, 1, 2].map(|at| {
        let (a, b) = (corners[at], corners[(at + 1) % 3]);
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    });
    let is_within = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
    is_within && sides.iter().any(|side| *side != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat hand, its fingers up, the wrist at (100, 200): 180 pixels long.
    fn flat() -> [[f64; 2]; 21] {
        let finger = |x: f64| [120.0, 75.0, 50.0, 25.0].map(|y| [x, y]);
        let mut points = [[100.0, 200.0]; 21];
        for (at, place) in [[70.0, 180.0], [50.0, 150.0], [40.0, 130.0], [35.0, 110.0]].iter().enumerate() {
            points[1 + at] = *place;
        }
        for (number, x) in [75.0, 95.0, 115.0, 135.0].into_iter().enumerate() {
            points[5 + 4 * number..9 + 4 * number].copy_from_slice(&finger(x));
        }
        points
    }

    fn joints(points: &[[f64; 2]; 21]) -> Joints {
        Landmarks::new(points, LandmarkUnit::Pixel).unwrap().of_picture(640, 480).unwrap()
    }

    #[test]
    fn places_on_the_hand_are_likely_and_others_are_not() {
        let hand = joints(&flat());
        for place in [[100.0, 160.0], [95.0, 60.0], [40.0, 130.0], [100.0, 125.0]] {
            assert!(hand.hand(place) > 1.0, "{place:?}: {}", hand.hand(place));
        }
        for place in [[100.0, 260.0], [160.0, 60.0], [40.0, 60.0], [95.0, 0.0]] {
            assert!(hand.hand(place) < -1.0, "{place:?}: {}", hand.hand(place));
        }
        let small = hand.shrunk(4);
        assert_eq!(small.hand([24.0, 15.0]), hand.hand([96.0, 60.0]));
    }

    #[test]
    fn joints_at_one_place_are_no_palm() {
        let mut points = flat();
        (points[1], points[5]) = (points[0], points[0]);
        let hand = joints(&points);
        assert!(hand.hand([100.0, 199.0]) > 1.0 && hand.hand([115.0, 90.0]) > 1.0, "the hand");
        assert!(hand.hand([500.0, 400.0]) < -1.0, "{}", hand.hand([500.0, 400.0]));
    }

    #[test]
    fn the_square_stands_upright_around_the_hand() {
        let upright = joints(&flat()).square();
        assert!(upright.1 && upright.0.turn.abs() < 0.1, "{upright:?}");
        // Lying, the fingers to the right, the arm comes from the left.
        let lying = flat().map(|[x, y]| [300.0 - y, x]);
        let (square, is_known) = joints(&lying).square();
        assert!(is_known);
        let [x, y] = square.from_picture().apply([100.0, 100.0]);
        assert!(y > 0.7 && (x - 0.5).abs() < 0.2, "the wrist is below: {x} {y}");
    }

    #[test]
    fn what_is_no_hand_is_rejected() {
        let error = |points: &[[f64; 2]]| {
            let landmarks = Landmarks::new(points, LandmarkUnit::Pixel);
            landmarks.and_then(|landmarks| landmarks.of_picture(640, 480)).unwrap_err().to_string()
        };
        insta::assert_snapshot!(error(&[[1.0, 2.0]]), @"1 landmarks, 21 expected: the wrist, then four of the thumb and of each finger");
        insta::assert_snapshot!(error(&[[0.5, 0.5]; 21]), @"the landmarks are all within 0.0 pixels: a hand is larger");
        let mut points = flat();
        points[7][1] = f64::NAN;
        insta::assert_snapshot!(error(&points), @"landmark 7 is not at a place: both its numbers must be finite");
        points[7][1] = 1e308;
        insta::assert_snapshot!(error(&points), @"landmark 7 lies far outside the picture: is the unit right?");
        insta::assert_snapshot!(error(&flat().map(|[x, y]| [x + 900.0, y])), @"no landmark lies in the picture of 640 x 480 pixels");
    }

    #[test]
    fn a_file_that_is_none_of_landmarks_is_told_what_one_is() {
        let error = toml::from_str::<Landmarks>("unit = 'pixel'\nlandmarks = [7]").unwrap_err();
        assert!(error.to_string().contains("a place is [x, y], [x, y, z] or {"), "{error}");
    }

    #[test]
    fn shares_are_of_the_picture() {
        let shares = flat().map(|[x, y]| [x / 640.0, y / 480.0]);
        let joints = Landmarks::new(&shares, LandmarkUnit::Share).unwrap().of_picture(640, 480).unwrap();
        assert!((joints.length - self::joints(&flat()).length).abs() < 1e-9);
    }
}
