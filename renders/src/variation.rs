//! How scenes differ from what the data say, as people and things do.

use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

use crate::grasp::{Example, Grasp, Object, Placement, PoseGroup, RecordedPose};
use crate::hand::{Digit, HandPose, JOINTS, joint_limits};
use crate::random::{between, normal, unit};
use crate::scene::SceneSpec;

/// How far joint angles spread between people at [`Variation::joints`] = 1, in degrees: the
/// standard deviation of what is each joint's own, of a finger and of the thumb. Fingers have as
/// much in common besides, so that a joint's flexion has √2 times that, and its abduction
/// √(1 + [`FAN`]²).
const SPREAD_DEG: [[f64; JOINTS]; 2] = [[3.0, 7.0, 7.0, 6.0, 0.0], [6.0, 6.0, 9.0, 8.0, 10.0]];
/// How much of a common spreading of the fingers each digit takes: the middle finger hardly any.
const FAN: [f64; 5] = [0.0, 1.0, 0.2, -0.5, -1.0];
/// An example's object: how far its place and its size spread (metres, logarithm of the ratio).
const EXAMPLE_PLACE: f64 = 0.003;
const EXAMPLE_SIZE: f64 = 0.2;
/// How far the way left to the object spreads at the stages before the grasp (logarithm of the
/// ratio).
const AWAY: f64 = 0.4;
/// The power of an evenly drawn number that a forearm's length goes by: half of the arms are
/// shorter than a third of the longest. Chosen between the two development hands, one of which has
/// shorter arms than the other.
const SHORT_ARMS: f64 = 1.5;
/// How far on the way from one recorded pose to another a scene's pose lies; a little before the
/// first, too.
const MIXED: [f64; 2] = [-0.2, 0.5];

/// How far scenes differ. Spreads are standard deviations; what is 0 stays as the data say.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// Joint angles, 1 being as far as people's hands differ in one grasp. Of the variance of a
    /// finger's flexion a half is each joint's own, the rest common to all fingers.
    pub joints: f64,
    /// How far the object is tilted in the hand, in degrees.
    pub tilt_deg: f64,
    /// How far the object's place in the palm moves, as a share of the palm.
    pub place: f64,
    /// How far an object's size may leave the share that the plan asks for, up or down (all alike).
    pub size: f64,
    /// How far the closing of the fingers differs at the stages before the grasp, as a share of the
    /// whole way.
    pub closure: f64,
    /// The share of scenes that are posed like one of the grasp's examples.
    pub examples: f64,
    /// The share of scenes that are posed like people's recorded hands ([`RecordedPose`]) in the
    /// same grasp.
    pub recorded: f64,
    /// Which of the recorded poses these are.
    pub recorded_from: PoseGroup,
    /// Narrowest and widest sleeve, as shares of the wrist, every width as likely: `None` leaves
    /// the plan's.
    pub sleeve: Option<[f64; 2]>,
    /// Shortest and longest bare forearm in metres, shorter ones more often: `None` leaves the
    /// plan's.
    pub forearm: Option<[f64; 2]>,
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
        recorded: 0.0,
        recorded_from: PoseGroup::All,
        sleeve: None,
        forearm: None,
    };

    /// As people's hands, objects and arms differ; measured on development pictures of two hands
    /// that this project did not make. Longer arms or fewer examples help one of the two and cost
    /// the other as much.
    pub const PEOPLE: Variation = Variation {
        joints: 0.65,
        tilt_deg: 6.0,
        place: 0.04,
        size: 0.4,
        closure: 0.12,
        examples: 0.5,
        recorded: 0.25,
        recorded_from: PoseGroup::All,
        sleeve: Some([1.05, 1.5]),
        forearm: Some([0.0, 0.16]),
    };

    /// The scene, varied as its own parameters' hash says: the same scene is varied in the same
    /// way.
    pub fn vary(&self, mut spec: SceneSpec) -> SceneSpec {
        if *self == Variation::NONE {
            return spec;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(spec.params_hash());
        let rng = &mut rng;
        let noise = self.joint_noise(rng);
        if let Some(sleeve) = self.sleeve {
            spec.look.sleeve = between(rng, sleeve);
        }
        if let Some(forearm) = self.forearm {
            let [shortest, longest] = forearm;
            spec.look.forearm = shortest + (longest - shortest) * libm::pow(unit(rng), SHORT_ARMS);
        }
        let examples: Vec<&Example> = spec.grasp.examples.iter().filter(|e| e.stage == spec.stage).collect();
        let posed_like = unit(rng);
        if let Some(example) = pick(&examples, rng).filter(|_| posed_like < self.examples) {
            let example = self.example(example, &noise, rng);
            spec.object = example.object.object;
            spec.example = Some(example);
            return spec;
        }
        if (self.examples..self.examples + self.recorded).contains(&posed_like) {
            spec.held = self.recorded(&spec.grasp.name, &noise, rng);
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

    /// A pose somewhere between two recorded ones of a grasp, varied; `None` where none was
    /// recorded.
    fn recorded(&self, grasp: &str, noise: &HandPose, rng: &mut ChaCha8Rng) -> Option<HandPose> {
        let of_grasp = RecordedPose::all()
            .iter()
            .filter(|recorded| recorded.grasp == grasp && self.recorded_from.contains(recorded));
        // The surer its label, the more often a pose is taken.
        let poses: Vec<&HandPose> = of_grasp
            .flat_map(|recorded| std::iter::repeat_n(&recorded.pose, usize::from(recorded.confidence)))
            .collect();
        let (first, second) = (*pick(&poses, rng)?, *pick(&poses, rng)?);
        let mut pose = first.toward(second, between(rng, MIXED));
        add(&mut pose, noise);
        Some(pose)
    }

    fn example(&self, example: &Example, noise: &HandPose, rng: &mut ChaCha8Rng) -> Example {
        let mut varied = example.clone();
        add(&mut varied.pose, noise);
        let object = &mut varied.object;
        object.centre += Vector3::from_fn(|_, _| EXAMPLE_PLACE * normal(rng));
        let ratio = libm::exp(EXAMPLE_SIZE * normal(rng));
        object.object = match object.object {
            Object::Sphere { radius } => Object::Sphere { radius: radius * ratio },
            Object::Cylinder { radius, length } => Object::Cylinder { radius: radius * ratio, length },
        };
        object.turn = self.tilt(rng) * object.turn;
        varied
    }

    /// The object, a little smaller or larger: never less than a third of the smallest that the
    /// grasp is for.
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
                stage.away *= libm::exp(AWAY * normal(rng));
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

/// One of several, every one as likely; `None` of none.
fn pick<'a, T>(all: &'a [T], rng: &mut ChaCha8Rng) -> Option<&'a T> {
    let which = (unit(rng) * all.len() as f64) as usize;
    all.get(which.min(all.len().checked_sub(1)?))
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
