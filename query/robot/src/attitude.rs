//! How an object lies to the palm that comes to it, and how far that is from how it lay where an
//! error's window was simulated.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::window::{LiesAlong, Window};
use super::{ApproachSide, Shape};

/// Sides of a box that differ by less, in metres, are as long.
const AS_LONG: f64 = 1e-3;

/// How an object lies to a palm.
#[derive(Clone, Debug)]
pub(super) struct Attitude {
    pub(super) from: ApproachSide,
    /// How far the approach is from exactly that side, in radians.
    lean: f64,
    /// The object's axes in the palm's frame, of length 1: of a box with sides as long several.
    axes: Vec<Vector3<f64>>,
}

/// How far an attitude is from the one that was simulated, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Off {
    /// Of the approach, against the vertical or the object.
    tilt: f64,
    /// About the approach, against the object.
    turn: f64,
}

impl Attitude {
    /// Of an object to a palm that is turned so in the world; `None` where that comes from below.
    pub(super) fn new(
        palm: &UnitQuaternion<f64>,
        shape: &Shape,
        world_from_object: &Isometry3<f64>,
    ) -> Option<Self> {
        let approach = palm * Vector3::z();
        let from = ApproachSide::nearest(&approach)?;
        let palm_from_object = palm.inverse() * world_from_object.rotation;
        let mut lean = match from {
            ApproachSide::Top => angle(-approach.z),
            ApproachSide::Side => approach.z.clamp(-1.0, 1.0).asin().abs(),
        };
        let own = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| palm_from_object * axis);
        let axes = match shape {
            Shape::Cylinder { .. } => own[2..].to_vec(),
            Shape::Sphere { .. } => Vec::new(),
            Shape::Box { size } => {
                // What was simulated of boxes was met on a face.
                lean = lean.max(angle(own.iter().map(|axis| axis.z.abs()).fold(0.0, f64::max)));
                let longest = size.iter().copied().fold(0.0, f64::max);
                let is_longest = size.map(|length| length > longest - AS_LONG);
                own.into_iter()
                    .zip(is_longest)
                    .filter(|(_, is_longest)| *is_longest)
                    .map(|(axis, _)| axis)
                    .collect()
            }
        };
        Some(Self { from, lean, axes })
    }

    /// What is left of `window` for an object that lies so: where that is not how it was simulated,
    /// its angles are narrower by what is used up, or below 0. `None` where the hand came from
    /// another side, or the object lay across rather than along.
    pub(super) fn left_of(&self, window: &Window) -> Option<Window> {
        let off = self.off(window.axis).filter(|_| window.from == self.from)?;
        let left = |most: Option<f64>, used: f64| most.map(|most| most - used);
        // About an approach from above is about the vertical.
        let (yawed, rolled) = match self.from {
            ApproachSide::Top => (off.turn, 0.0),
            ApproachSide::Side => (0.0, off.turn),
        };
        Some(Window {
            tilt_rad: left(window.tilt_rad, off.tilt),
            yaw_rad: left(window.yaw_rad, yawed),
            roll_rad: left(window.roll_rad, rolled),
            ..window.clone()
        })
    }

    fn off(&self, simulated: Option<LiesAlong>) -> Option<Off> {
        let square = Off { tilt: self.lean, turn: 0.0 };
        // A ball lies in no way, and windows of a file may leave open how theirs lay.
        let Some(simulated) = simulated.filter(|_| !self.axes.is_empty()) else { return Some(square) };
        let along = match simulated {
            LiesAlong::X => Vector3::x(),
            LiesAlong::Z => Vector3::z(),
            LiesAlong::None => return None,
        };
        let parallel = |axis: &Vector3<f64>| axis.dot(&along).abs();
        let nearest = self.axes.iter().max_by(|a, b| parallel(a).total_cmp(&parallel(b)))?;
        if parallel(nearest) < FRAC_1_SQRT_2 {
            return None;
        }
        Some(match simulated {
            LiesAlong::X => Off {
                tilt: self.lean.max(nearest.z.abs().min(1.0).asin()),
                turn: nearest.y.abs().atan2(nearest.x.abs()),
            },
            _ => Off { tilt: self.lean.max(angle(parallel(nearest))), turn: 0.0 },
        })
    }
}

fn angle(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0).acos()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTTLE: Shape = Shape::Cylinder { radius: 0.035, height: 0.16 };
    const BOX: Shape = Shape::Box { size: [0.16, 0.06, 0.10] };
    const BALL: Shape = Shape::Sphere { radius: 0.035 };

    fn turned(x: f64, y: f64, z: f64) -> Isometry3<f64> {
        let [x, y, z] = [x, y, z].map(f64::to_radians);
        Isometry3::from_parts(Vector3::zeros().into(), UnitQuaternion::from_euler_angles(x, y, z))
    }

    /// What is left of a tilt of 15, a yaw of 45 and a roll of 40 degrees, in degrees to the
    /// nearest.
    fn left(
        from: ApproachSide,
        tilt: [f64; 3],
        shape: Shape,
        object: Isometry3<f64>,
        axis: Option<LiesAlong>,
    ) -> Option<[f64; 3]> {
        let window = Window {
            position_m: 0.02,
            yaw_rad: Some(45.0_f64.to_radians()),
            tilt_rad: Some(15.0_f64.to_radians()),
            roll_rad: Some(40.0_f64.to_radians()),
            force_n: None,
            object: "any".into(),
            width_m: 0.07,
            from,
            axis,
            engine: "none".into(),
        };
        let palm = from.turned() * UnitQuaternion::new(Vector3::from(tilt.map(f64::to_radians)));
        let left = Attitude::new(&palm, &shape, &object)?.left_of(&window)?;
        Some([left.tilt_rad?, left.yaw_rad?, left.roll_rad?].map(|angle| angle.to_degrees().round() + 0.0))
    }

    #[test]
    fn a_window_is_narrower_by_what_the_attitude_uses_up() {
        use ApproachSide::{Side, Top};
        let upright = turned(0.0, 0.0, 0.0);
        let lying = turned(0.0, 90.0, 0.0);
        let x = Some(LiesAlong::X);
        assert_eq!(left(Side, [0.0; 3], BOTTLE, upright, x), Some([15.0, 45.0, 40.0]));
        assert_eq!(left(Side, [0.0, 10.0, 0.0], BOTTLE, upright, x), Some([5.0, 45.0, 40.0]));
        assert_eq!(left(Side, [0.0, -32.0, 0.0], BOTTLE, upright, x), Some([-17.0, 45.0, 40.0]));
        // About the vertical, which makes no difference to what is round; about the approach, which
        // does.
        assert_eq!(left(Side, [30.0, 0.0, 0.0], BOTTLE, upright, x), Some([15.0, 45.0, 40.0]));
        assert_eq!(left(Side, [0.0, 0.0, 12.0], BOTTLE, upright, x), Some([15.0, 45.0, 28.0]));
        // Along its axis.
        assert_eq!(left(Side, [0.0; 3], BOTTLE, lying, x), None);
        assert_eq!(left(Top, [0.0; 3], BOTTLE, upright, x), None);
        assert_eq!(left(Top, [0.0; 3], BOTTLE, upright, Some(LiesAlong::Z)), Some([15.0, 45.0, 40.0]));
        assert_eq!(left(Top, [0.0, 7.0, 0.0], BOTTLE, upright, Some(LiesAlong::Z)), Some([8.0, 45.0, 40.0]));
        // From above a turn is a yaw.
        assert_eq!(left(Top, [0.0; 3], BOTTLE, turned(0.0, 90.0, 20.0), x), Some([15.0, 25.0, 40.0]));
        assert_eq!(left(Top, [5.0, 0.0, 0.0], BOX, turned(0.0, 0.0, 20.0), x), Some([10.0, 25.0, 40.0]));
        // A box on its edge.
        assert_eq!(left(Top, [0.0; 3], BOX, turned(20.0, 0.0, 0.0), x), Some([-5.0, 45.0, 40.0]));
        // A ball lies in no way; nothing else lies as a ball does.
        assert_eq!(left(Side, [0.0, 10.0, 0.0], BALL, lying, x), Some([5.0, 45.0, 40.0]));
        assert_eq!(left(Top, [0.0; 3], BOTTLE, lying, Some(LiesAlong::None)), None);
        assert_eq!(left(Side, [0.0; 3], BOTTLE, lying, None), Some([15.0, 45.0, 40.0]));
    }

    #[test]
    fn a_cube_lies_as_it_is_met() {
        let cube = Shape::Box { size: [0.06; 3] };
        for object in [turned(0.0, 0.0, 0.0), turned(0.0, 90.0, 0.0), turned(90.0, 0.0, 90.0)] {
            let left = left(ApproachSide::Top, [0.0; 3], cube, object, Some(LiesAlong::X));
            assert_eq!(left, Some([15.0, 45.0, 40.0]));
        }
    }
}
