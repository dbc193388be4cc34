//! Joints: from joint angles to the places of the bones.

use nalgebra::{Rotation3, Unit, Vector3};
use serde::Deserialize;

use super::HandShape;

/// Joints a digit; a finger leaves the last one unused.
pub(crate) const JOINTS: usize = 5;

/// One digit's joint angles in radians.
///
/// A finger: spread (positive toward the thumb), flexion of the knuckle, of the middle joint, of
/// the end joint, unused. The thumb: `radial` (angle of its metacarpal from x toward y, in the
/// plane of the palm), `palmar` (angle out of that plane toward the palm's side), `pronation` (how
/// far the nail is turned from the back of the hand toward the thumb's side and on), flexion of the
/// knuckle, of the end joint.
pub type Joints = [f64; JOINTS];

/// Names of a finger's and of the thumb's joints, in the order of [`Joints`].
pub const JOINT_NAMES: [[&str; JOINTS]; 2] =
    [["spread", "knuckle", "middle", "end", "unused"], ["radial", "palmar", "pronation", "knuckle", "end"]];

/// Lowest and highest angle of each joint in degrees: fingers, then thumb. Ranges of active motion
/// after A. I. Kapandji, "The Physiology of the Joints", rounded.
const LIMITS_DEG: [[[f64; 2]; JOINTS]; 2] = [
    [[-25.0, 25.0], [-25.0, 95.0], [-5.0, 112.0], [-10.0, 80.0], [0.0, 0.0]],
    [[-20.0, 80.0], [-15.0, 80.0], [0.0, 150.0], [-15.0, 65.0], [-25.0, 85.0]],
];

/// The five digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Digit {
    /// The thumb.
    Thumb,
    /// The index finger.
    Index,
    /// The middle finger.
    Middle,
    /// The ring finger.
    Ring,
    /// The little finger.
    Little,
}

impl Digit {
    /// All five, thumb first.
    pub const ALL: [Digit; 5] = [Digit::Thumb, Digit::Index, Digit::Middle, Digit::Ring, Digit::Little];
    /// The four fingers.
    pub const FINGERS: [Digit; 4] = [Digit::Index, Digit::Middle, Digit::Ring, Digit::Little];

    /// The digit's name.
    pub fn name(self) -> &'static str {
        ["thumb", "index", "middle", "ring", "little"][self as usize]
    }
}

/// Lowest and highest angles of a digit's joints in radians.
pub fn joint_limits(digit: Digit) -> [[f64; 2]; JOINTS] {
    LIMITS_DEG[usize::from(digit == Digit::Thumb)].map(|pair| pair.map(f64::to_radians))
}

/// All joint angles of a hand, in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandPose {
    /// Thumb, index, middle, ring, little.
    pub digits: [Joints; 5],
}

impl HandPose {
    /// The pose a share `t` of the way from `self` to `other`.
    pub fn toward(&self, other: &HandPose, t: f64) -> HandPose {
        let mut pose = *self;
        for (mine, theirs) in pose.digits.iter_mut().zip(&other.digits) {
            for (a, b) in mine.iter_mut().zip(theirs) {
                *a += (b - *a) * t;
            }
        }
        pose
    }
}

/// A digit in place: its joints' centres from the palm to the tip, the radius of the flesh at each,
/// and the direction out of the nail.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chain {
    /// Knuckle, middle joint, end joint, centre of the tip (thumb: root, knuckle, end joint, tip).
    pub(crate) points: [Vector3<f64>; 4],
    pub(crate) radii: [f64; 4],
    /// Unit vector out of the nail.
    pub(crate) nail: Vector3<f64>,
}

impl Chain {
    /// Distance from `p` to the flesh of bones `from..3`, taken as capsules of changing radius.
    pub(crate) fn distance(&self, p: &Vector3<f64>, from: usize) -> f64 {
        (from..3).map(|bone| self.bone_distance(p, bone)).fold(f64::INFINITY, f64::min)
    }

    /// Distance from `p` to the flesh of one bone.
    pub(crate) fn bone_distance(&self, p: &Vector3<f64>, bone: usize) -> f64 {
        let (a, b) = (self.points[bone], self.points[bone + 1]);
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        let radius = self.radii[bone] + (self.radii[bone + 1] - self.radii[bone]) * t;
        (p - a - along * t).norm() - radius
    }
}

/// Where the joints of a hand shape sit.
#[derive(Debug, Clone)]
pub struct Skeleton {
    shape: HandShape,
    /// The centre of each digit's first joint.
    roots: [Vector3<f64>; 5],
}

/// The knuckles' places as shares of the palm's length (x), breadth (y) and thickness (z), and the
/// tilt of the flexion axis in degrees: bent fingers converge toward the thumb's root.
const KNUCKLES: [([f64; 3], f64); 4] = [
    ([1.00, 0.275, -0.06], -4.0),
    ([1.00, 0.0, 0.0], 0.0),
    ([0.94, -0.235, -0.05], 6.0),
    ([0.85, -0.435, -0.20], 12.0),
];

/// The thumb's root (trapezium), in the same shares.
const THUMB_ROOT: [f64; 3] = [0.28, 0.28, -0.30];

impl Skeleton {
    /// The skeleton of a hand shape.
    pub fn new(shape: &HandShape) -> Skeleton {
        let shares = [THUMB_ROOT, KNUCKLES[0].0, KNUCKLES[1].0, KNUCKLES[2].0, KNUCKLES[3].0];
        let roots = shares.map(|share| palm_point(shape, share));
        Skeleton { shape: shape.clone(), roots }
    }

    /// The skeleton of a hand shape whose knuckles and thumb's root are where they were measured.
    pub(crate) fn with_roots(shape: &HandShape, roots: [Vector3<f64>; 5]) -> Skeleton {
        Skeleton { shape: shape.clone(), roots }
    }

    /// The hand shape behind the skeleton.
    pub fn shape(&self) -> &HandShape {
        &self.shape
    }

    /// A point given in shares of the palm's length, breadth and thickness, in metres.
    pub(crate) fn palm_point(&self, shares: [f64; 3]) -> Vector3<f64> {
        palm_point(&self.shape, shares)
    }

    /// The centre of a digit's first joint: a finger's knuckle, the thumb's root.
    pub(crate) fn root(&self, digit: Digit) -> Vector3<f64> {
        self.roots[digit as usize]
    }

    /// The straight digit whose first bone points `along` (unit length); a thumb's nail is turned
    /// by `pronation`.
    pub(crate) fn along(&self, digit: Digit, along: &Vector3<f64>, pronation: f64) -> Chain {
        match digit {
            Digit::Thumb => {
                let (radial, palmar) =
                    (libm::atan2(along.y, along.x), libm::asin((-along.z).clamp(-1.0, 1.0)));
                self.chain(digit, &[radial, palmar, pronation, 0.0, 0.0])
            }
            _ => {
                let tilt = KNUCKLES[digit as usize - 1].1.to_radians();
                let level = Rotation3::from_axis_angle(&Vector3::x_axis(), -tilt) * along;
                let (spread, knuckle) =
                    (libm::atan2(level.y, level.x), libm::asin((-level.z).clamp(-1.0, 1.0)));
                self.chain(digit, &[spread, knuckle, 0.0, 0.0, 0.0])
            }
        }
    }

    /// The digit's place at the given joint angles.
    pub(crate) fn chain(&self, digit: Digit, joints: &Joints) -> Chain {
        match digit {
            Digit::Thumb => self.thumb(joints),
            _ => self.finger(digit, joints),
        }
    }

    /// All five digits.
    pub(crate) fn chains(&self, pose: &HandPose) -> [Chain; 5] {
        Digit::ALL.map(|digit| self.chain(digit, &pose.digits[digit as usize]))
    }

    fn finger(&self, digit: Digit, &[spread, knuckle, middle, end, _]: &Joints) -> Chain {
        let measures = &self.shape.digits[digit as usize];
        let tilt = KNUCKLES[digit as usize - 1].1.to_radians();
        let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
        let base = Rotation3::from_axis_angle(&x, tilt) * Rotation3::from_axis_angle(&z, spread);
        let bend = |angle: f64| base * Rotation3::from_axis_angle(&y, angle);
        let tip_radius = 0.42 * measures.tip_breadth;
        let lengths = [measures.bones[0], measures.bones[1], measures.bones[2] - tip_radius];
        let angles = [knuckle, knuckle + middle, knuckle + middle + end];
        let mut points = [self.root(digit); 4];
        for i in 0..3 {
            points[i + 1] = points[i] + bend(angles[i]) * x.into_inner() * lengths[i];
        }
        Chain {
            points,
            radii: [
                0.47 * measures.breadth,
                0.46 * measures.breadth,
                0.46 * measures.tip_breadth,
                tip_radius,
            ],
            nail: bend(angles[2]) * z.into_inner(),
        }
    }

    fn thumb(&self, &[radial, palmar, pronation, knuckle, end]: &Joints) -> Chain {
        let measures = &self.shape.digits[0];
        let ((sin_p, cos_p), (sin_r, cos_r)) = (libm::sincos(palmar), libm::sincos(radial));
        let along = Vector3::new(cos_p * cos_r, cos_p * sin_r, -sin_p);
        let dorsal = Vector3::z() - along * along.z;
        let dorsal = dorsal / dorsal.norm();
        let (sin, cos) = libm::sincos(pronation);
        let nail = dorsal * cos - along.cross(&dorsal) * sin;
        let axis = Unit::new_normalize(nail.cross(&along));
        let tip_radius = 0.42 * measures.tip_breadth;
        let lengths = [measures.bones[0], measures.bones[1], measures.bones[2] - tip_radius];
        let angles = [0.0, knuckle, knuckle + end];
        let mut points = [self.root(Digit::Thumb); 4];
        for i in 0..3 {
            let turn = Rotation3::from_axis_angle(&axis, angles[i]);
            points[i + 1] = points[i] + turn * along * lengths[i];
        }
        Chain {
            points,
            radii: [
                0.60 * measures.breadth,
                0.53 * measures.breadth,
                0.49 * measures.tip_breadth,
                tip_radius,
            ],
            nail: Rotation3::from_axis_angle(&axis, knuckle + end) * nail,
        }
    }
}

fn palm_point(shape: &HandShape, [x, y, z]: [f64; 3]) -> Vector3<f64> {
    Vector3::new(x * shape.palm_length, y * shape.palm_breadth, z * shape.palm_thickness)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: HandPose =
        HandPose { digits: [[0.9, 0.2, 0.8, 0.0, 0.0], [0.0; 5], [0.0; 5], [0.0; 5], [0.0; 5]] };

    #[test]
    fn a_flat_hand_is_as_long_as_its_measures_say() {
        let shape = HandShape::mean();
        let middle = Skeleton::new(&shape).chains(&FLAT)[2];
        let tip = middle.points[3].x + middle.radii[3];
        assert!((tip - shape.length()).abs() < 1e-9);
        assert!(middle.points[3].y.abs() < 1e-12);
    }

    #[test]
    fn bending_moves_a_fingertip_to_the_palms_side_and_the_nail_with_it() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let bent = skeleton.chain(Digit::Index, &[0.0, 1.0, 0.5, 0.0, 0.0]);
        let flat = skeleton.chain(Digit::Index, &[0.0; 5]);
        assert!(bent.points[3].z < flat.points[3].z - 0.05);
        assert!(bent.nail.x > 0.9, "{:?}", bent.nail);
        assert!((flat.nail - Vector3::z()).norm() < 0.1);
    }

    #[test]
    fn the_thumb_lies_on_the_y_side_and_bends_away_from_its_nail() {
        let skeleton = Skeleton::new(&HandShape::mean());
        let straight = skeleton.chain(Digit::Thumb, &[0.7, 0.5, 1.2, 0.0, 0.0]);
        let bent = skeleton.chain(Digit::Thumb, &[0.7, 0.5, 1.2, 0.4, 0.4]);
        assert!(straight.points[3].y > 0.03);
        let moved = bent.points[3] - straight.points[3];
        assert!(moved.dot(&straight.nail) < -0.01);
    }

    #[test]
    fn capsule_distance_is_zero_on_the_skin() {
        let chain = Skeleton::new(&HandShape::mean()).chain(Digit::Ring, &[0.0; 5]);
        let tip = chain.points[3] + Vector3::x() * chain.radii[3];
        assert!(chain.distance(&tip, 0).abs() < 1e-9);
        assert!(chain.distance(&chain.points[1], 0) < 0.0);
    }
}
