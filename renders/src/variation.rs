//! How scenes differ from what the data say, as people and things do.

use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

use crate::grasp::{Example, Grasp, Object, Placement};
use crate::hand::{Digit, HandPose, JOINTS, joint_limits};
use crate::random::{between, normal, unit};
use crate::scene::SceneSpec;

/// How far joint angles spread between people at [`Variation::joints`] = 1, in degrees (standard deviation): each joint
/// of a finger, each of the thumb.
const SPREAD_DEG: [[f64; JOINTS]; 2] = [[3.0, 7.0, 7.0, 6.0, 0.0], [6.0, 6.0, 9.0, 8.0, 10.0]];
/// How much of a common spreading of the fingers each digit takes: the middle finger hardly any.
const FAN: [f64; 5] = [0.0, 1.0, 0.2, -0.5, -1.0];
/// An example's object: how far its place and its size spread (metres, logarithm of the ratio).
const EXAMPLE_PLACE: f64 = 0.003;
const EXAMPLE_SIZE: f64 = 0.2;
/// How far the way left to the object spreads at the stages before the grasp (logarithm of the ratio).
const AWAY: f64 = 0.4;

/// How far scenes differ. Spreads are standard deviations; what is 0 stays as the data say.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// Joint angles, 1 being as far as people's hands differ in one grasp; a half of that is each joint's own, the rest
    /// common to all fingers.
    pub joints: f64,
    /// How far the object is tilted in the hand, in degrees.
    pub tilt_deg: f64,
    /// How far the object's place in the palm moves, as a share of the palm.
    pub place: f64,
    /// How far an object's size may leave the share that the plan asks for, up or down (all alike).
    pub size: f64,
    /// How far the closing of the fingers differs at the stages before the grasp, as a share of the whole way.
    pub closure: f64,
    /// The share of scenes that are posed like one of the grasp's examples.
    pub examples: f64,
    /// Narrowest and widest sleeve, as shares of the wrist, and shortest and longest bare forearm in metres (all alike):
    /// `None` leaves the plan's.
    pub arms: Option<([f64; 2], [f64; 2])>,
}

impl Variation {
    /// None at all.
    pub const NONE: Variation = Variation {
        joints: 0.0,
        tilt_deg: 0.0,
        place: 0.0,
        size: 0.0,
        closure: 0.0,
        examples: 0.0,
        arms: None,
    };

    /// The scene, varied as its own parameters' hash says: the same scene is varied in the same way.
    pub fn of(&self, mut spec: SceneSpec) -> SceneSpec {
        if *self == Variation::NONE {
            return spec;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(spec.params_hash());
        let rng = &mut rng;
        let noise = self.joint_noise(rng);
        if let Some((sleeve, forearm)) = self.arms {
            spec.look.sleeve = between(rng, sleeve);
            spec.look.forearm = between(rng, forearm);
        }
        let examples: Vec<&Example> = spec.grasp.examples.iter().filter(|e| e.stage == spec.stage).collect();
        if !examples.is_empty() && unit(rng) < self.examples {
            let which = (unit(rng) * examples.len() as f64) as usize;
            let example = self.example(examples[which.min(examples.len() - 1)], &noise, rng);
            spec.object = example.object.object;
            spec.example = Some(example);
            return spec;
        }
        spec.object = self.object(&spec, rng);
        spec.grasp = Arc::new(self.grasp(&spec.grasp, &noise, rng));
        spec
    }

    /// What is added to every joint angle, in radians.
    fn joint_noise(&self, rng: &mut ChaCha8Rng) -> HandPose {
        let common: [f64; JOINTS] = std::array::from_fn(|_| normal(rng));
        let digits = Digit::ALL.map(|digit| {
            let is_thumb = digit == Digit::Thumb;
            std::array::from_fn(|joint| {
                let shared = match (is_thumb, joint) {
                    (true, _) => 0.0,
                    (false, 0) => common[0] * FAN[digit as usize],
                    (false, _) => common[joint],
                };
                let degrees = SPREAD_DEG[usize::from(is_thumb)][joint] * (normal(rng) + shared);
                (self.joints * degrees).to_radians()
            })
        });
        HandPose { digits }
    }

    fn example(&self, example: &Example, noise: &HandPose, rng: &mut ChaCha8Rng) -> Example {
        let mut varied = example.clone();
        add(&mut varied.pose, noise);
        let object = &mut varied.object;
        object.centre += Vector3::from_fn(|_, _| EXAMPLE_PLACE * normal(rng));
        let ratio = (EXAMPLE_SIZE * normal(rng)).exp();
        object.object = match object.object {
            Object::Sphere { radius } => Object::Sphere { radius: radius * ratio },
            Object::Cylinder { radius, length } => Object::Cylinder { radius: radius * ratio, length },
        };
        object.turn = self.tilt(rng) * object.turn;
        varied
    }

    /// The object, a little smaller or larger: never less than a third of the smallest that the grasp is for.
    fn object(&self, spec: &SceneSpec, rng: &mut ChaCha8Rng) -> Object {
        let [low, high] = spec.grasp.object.radius;
        let change = (high - low) * self.size * between(rng, [-1.0, 1.0]);
        let fit = |radius: f64| (radius + change).max(low / 3.0);
        match spec.object {
            Object::Sphere { radius } => Object::Sphere { radius: fit(radius) },
            Object::Cylinder { radius, length } => Object::Cylinder { radius: fit(radius), length },
        }
    }

    fn grasp(&self, grasp: &Grasp, noise: &HandPose, rng: &mut ChaCha8Rng) -> Grasp {
        let mut varied = grasp.clone();
        // Examples are of no use to a scene that is not posed like one.
        varied.examples.clear();
        for pose in [&mut varied.open, &mut varied.closed, &mut varied.relaxed] {
            add(pose, noise);
        }
        varied.object.axis = self.tilt(rng) * varied.object.axis;
        if let Placement::Palm { anchor, push } = &mut varied.object.placement {
            // The object still comes from about where it came from.
            let turn = self.tilt(rng);
            *push = UnitQuaternion::identity().nlerp(&turn, 0.5) * *push;
            for share in anchor {
                *share += self.place * normal(rng);
            }
        }
        for stage in &mut varied.stages {
            stage.closure = (stage.closure + self.closure * normal(rng)).clamp(0.0, 0.95);
            if self.closure > 0.0 {
                stage.away *= (AWAY * normal(rng)).exp();
            }
        }
        varied
    }

    /// A small turn about any axis.
    fn tilt(&self, rng: &mut ChaCha8Rng) -> UnitQuaternion<f64> {
        let axis = Vector3::from_fn(|_, _| normal(rng));
        let angle = (self.tilt_deg * normal(rng)).to_radians();
        match Unit::try_new(axis, 1e-9) {
            Some(axis) => UnitQuaternion::from_rotation_matrix(&Rotation3::from_axis_angle(&axis, angle)),
            None => UnitQuaternion::identity(),
        }
    }
}

/// Adds `noise` to the angles of a pose and keeps them within the joints' limits.
fn add(pose: &mut HandPose, noise: &HandPose) {
    for digit in Digit::ALL {
        let limits = joint_limits(digit);
        let angles = pose.digits[digit as usize].iter_mut().zip(&noise.digits[digit as usize]);
        for ((angle, noise), [low, high]) in angles.zip(limits) {
            *angle = (*angle + noise).clamp(low, high);
        }
    }
}
