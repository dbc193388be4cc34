//! One trial: settle, approach, close, lift, hold.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::Vector;
use serde::Serialize;

use super::barrett::{DISTAL_JOINTS, FINGERS, INNER_JOINTS, SPREAD_JOINT};
use super::world::{Begin, DT, World};
use crate::placed::Placed;
use crate::{ApproachSide, Frame, Object, RobotError, RobotHand, Value};

/// The phases' lengths in seconds.
const SETTLE: f32 = 0.15;
const APPROACH_SPEED: f32 = 0.25;
const CLOSE: f32 = 1.3;
const LIFT_TIME: f32 = 0.9;
const HOLD: f32 = 1.2;
/// So much before the end, which rounding may miss.
const ALL_BUT: f32 = 0.03;
/// How high it is lifted, and how high the object must come, in metres.
const LIFT: f32 = 0.15;
const LIFTED: f32 = 0.10;
/// How far the object may move in the hand while it is held, in metres.
const SLIP: f32 = 0.010;

/// Where the hand closes, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// In a world whose z axis stands in the object's middle: the table is around it, and `f32` is
    /// fine enough however far off the object is.
    pub(super) begin: Begin,
    approach: Vector3<f64>,
    distance: f64,
    /// In the same world.
    world_from_object: Isometry3<f64>,
    object: Object,
}

/// How far the object is from where the hand takes it to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Offset {
    /// The object's displacement on the table along the world's x axis, in metres.
    pub x: f64,
    /// The same along its y axis.
    pub y: f64,
    /// The hand's turn about the vertical through the object's middle, in radians.
    pub yaw: f64,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Whether the object was lifted and stayed in the hand.
    pub success: bool,
    /// Whether the object came up by at least 100 mm and was there in the end.
    pub lifted: bool,
    /// How far the object rose, in millimetres.
    pub rise_mm: f64,
    /// How far it moved in the hand while it was held, in millimetres.
    pub slip_mm: f64,
    /// How far it was moved while the hand closed, in millimetres.
    pub pushed_mm: f64,
    /// The sum of the contacts' normal forces on the object in the end, in newtons.
    pub contact_force_n: f64,
    /// The greatest normal force of one link on the object in the end, in newtons.
    pub greatest_force_n: f64,
    /// The links that touch the object in the end.
    pub links: Vec<&'static str>,
    /// Simulated time, in seconds.
    pub seconds: f64,
}

/// The links' names, as [`super::world::Touch::part`] counts them.
pub(super) const LINKS: [&str; 1 + 2 * FINGERS] = [
    "palm",
    "finger 1 inner",
    "finger 1 distal",
    "finger 2 inner",
    "finger 2 distal",
    "finger 3 inner",
    "finger 3 distal",
];

impl Plan {
    /// The grasp called `grasp` of a Barrett hand whose palm is turned by `turned`, on an object
    /// that lies in the world.
    ///
    /// # Errors
    /// [`RobotError`]: the hand has no such grasp or no model to simulate it by, the object no
    /// table or lies in it.
    pub fn new(
        hand: &RobotHand,
        grasp: &str,
        object: &Object,
        turned: UnitQuaternion<f64>,
    ) -> Result<Self, RobotError> {
        if hand.model.as_deref() != Some("barrett") {
            return Err(RobotError::NoModel { hand: hand.name.clone() });
        }
        let grasp = hand.grasp_named(grasp)?;
        if object.table.is_none() || object.frame != Frame::World {
            return Err(RobotError::NoTable { object: object.name.clone() });
        }
        let world_from_object = object.checked(object.pose)?;
        let middle = world_from_object.translation.vector.into();
        let placed = Placed::new(hand, grasp, object, &world_from_object, turned, middle)?;
        // Every posture has a value for each joint that has limits: the file was checked.
        let mut joints = INNER_JOINTS.into_iter().chain(DISTAL_JOINTS).chain([SPREAD_JOINT]);
        if let Some(joint) = joints.find(|joint| !hand.limits.contains_key(*joint)) {
            return Err(RobotError::NoJoint { hand: hand.name.clone(), joint });
        }
        let angle = |posture: &BTreeMap<String, Value>, joint: &str| {
            posture.get(joint).map_or(0.0, |value| value.at(placed.width)) as f32
        };
        let open = std::array::from_fn(|finger| {
            [INNER_JOINTS[finger], DISTAL_JOINTS[finger]].map(|joint| angle(&grasp.open, joint))
        });
        let end = INNER_JOINTS.map(|joint| angle(&grasp.closed, joint));
        let [x, y, _] = world_from_object.translation.vector.into();
        let to_object = Translation3::new(-x, -y, 0.0_f64);
        let begin = Begin {
            palm: to_object * placed.world_from_palm,
            spread: angle(&grasp.open, SPREAD_JOINT),
            open,
            end,
            clutch: grasp.breakaway,
        };
        Ok(Self {
            begin,
            approach: placed.approach,
            distance: hand.approach.distance,
            world_from_object: to_object * world_from_object,
            object: object.clone(),
        })
    }

    /// When a phase has ended, in seconds: settled, approached, closed; then half way up, and all
    /// but held to the end.
    pub(super) fn moments(&self) -> [f32; 5] {
        let approached = SETTLE + self.distance as f32 / APPROACH_SPEED;
        let closed = approached + CLOSE;
        let held = closed + LIFT_TIME + HOLD;
        [SETTLE, approached, closed, closed + 0.5 * LIFT_TIME, held - ALL_BUT]
    }

    /// From where the hand comes, and how far, in metres.
    pub(super) fn way(&self) -> (Option<ApproachSide>, f64) {
        (ApproachSide::nearest(&self.approach), self.distance)
    }

    /// What is grasped.
    pub fn object(&self) -> &Object {
        &self.object
    }

    /// Carries the grasp out, the world being off by `offset`.
    pub fn run(&self, offset: Offset) -> Outcome {
        self.run_watched(offset, |_, _| {}).0
    }

    /// [`Self::run`], with the world in the end; `watch` sees every step of it.
    pub(super) fn run_watched(&self, offset: Offset, mut watch: impl FnMut(&World, f32)) -> (Outcome, World) {
        let middle = Translation3::from(self.world_from_object.translation.vector);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), offset.yaw);
        let yawed = middle * turn * middle.inverse();
        let approach = turn * self.approach;
        let mut begin = self.begin.clone();
        begin.palm = Translation3::from(-approach * self.distance) * (yawed * begin.palm);
        let object = Translation3::new(offset.x, offset.y, 0.0) * self.world_from_object;
        let mut world = World::new(&self.object, &object, &begin);
        let mut clock = Clock { now: 0.0, watch: &mut watch };

        clock.run(&mut world, SETTLE, |_, _| {});
        let settled = world.object();
        let way = Vector::new(approach.x as f32, approach.y as f32, approach.z as f32) * self.distance as f32;
        clock.run(&mut world, self.distance as f32 / APPROACH_SPEED, |world, share| {
            world.move_palm(way * share)
        });
        clock.run(&mut world, CLOSE, |world, _| world.close());
        let pushed = (world.object().translation - settled.translation).length();
        // The motors are off from here on: the worm gears hold.
        clock.run(&mut world, LIFT_TIME, |world, share| {
            // A smooth start and end: a jerk is no part of a lift.
            let smooth = share * share * (3.0 - 2.0 * share);
            world.move_palm(way + Vector::new(0.0, 0.0, LIFT * smooth));
        });
        let held = world.palm_from_object();
        clock.run(&mut world, HOLD, |_, _| {});

        let rise = world.object().translation.z - settled.translation.z;
        let slip = (world.palm_from_object().translation - held.translation).length();
        let touches = world.touches();
        let force = |part: usize| -> f32 {
            // The sum of nothing is -0.
            touches.iter().filter(|touch| touch.part == part).map(|touch| touch.force).fold(0.0, |a, b| a + b)
        };
        let forces: Vec<f32> = (0..LINKS.len()).map(force).collect();
        let lifted = rise > LIFTED;
        let outcome = Outcome {
            success: lifted && slip < SLIP,
            lifted,
            rise_mm: millimetres(rise),
            slip_mm: millimetres(slip),
            pushed_mm: millimetres(pushed),
            contact_force_n: f64::from(forces.iter().fold(0.0_f32, |sum, force| sum + force)),
            greatest_force_n: f64::from(forces.iter().copied().fold(0.0, f32::max)),
            links: LINKS
                .into_iter()
                .zip(&forces)
                .filter(|(_, force)| **force > 0.0)
                .map(|(name, _)| name)
                .collect(),
            seconds: f64::from(clock.now),
        };
        (outcome, world)
    }
}

/// Counts the time and lets somebody watch.
struct Clock<'a, W> {
    now: f32,
    watch: &'a mut W,
}

impl<W: FnMut(&World, f32)> Clock<'_, W> {
    /// Runs a phase; `act` is told how much of it is over, up to 1.
    fn run(&mut self, world: &mut World, seconds: f32, mut act: impl FnMut(&mut World, f32)) {
        let steps = (seconds / DT).round() as usize;
        for step in 1..=steps {
            act(world, step as f32 / steps as f32);
            world.step();
            self.now += DT;
            (self.watch)(world, self.now);
        }
    }
}

fn millimetres(metres: f32) -> f64 {
    1e3 * f64::from(metres)
}
