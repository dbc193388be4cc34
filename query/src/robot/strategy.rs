//! From what was seen to what the robot does: approach, grasp, retreat, relative to the object.
//!
//! As in the paper's Section VI no approach is searched for: the robot's palm comes from where the human hand came
//! from, turned as it was turned, to the place of the object that the human hand held.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::Serialize;
use utoipa::ToSchema;

use super::feasible::{Findings, Problem, ProblemKind};
use super::hand::{RobotGrasp, RobotHand};
use super::human::HumanGrasp;
use super::layout::Layout;
use super::window::{Window, confidence, doubts, tolerated};
use super::{Arm, ArmMotion, Camera, Object, RobotError};
use grasp_recognise::Side;
use grasp_recognise::orientation::xyzw;

/// A spread of this many degrees means that the orientation is unknown (the neighbours had none).
const UNKNOWN_SPREAD_DEG: f64 = 180.0;

/// A human hand that grasps, as it was recognised.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The human grasp.
    pub grasp: String,
    /// The hand.
    pub side: Side,
    /// How it is turned toward the camera.
    pub camera_from_hand: UnitQuaternion<f64>,
    /// How far the estimate of that may be off, as a standard deviation in degrees.
    pub spread_deg: f64,
}

/// What the robot does. JSON keys are an interface: they may be added to, never renamed. Metres, radians, newtons; quaternions x, y, z, w.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Strategy {
    /// The robot hand.
    pub robot: String,
    /// The human grasp that is imitated.
    pub human_grasp: String,
    /// The robot's grasp.
    pub grasp: String,
    /// The object.
    pub object: String,
    /// The link that an arm carries.
    pub wrist_link: String,
    /// The direction in which the hand comes to the object.
    pub approach_vector: Direction,
    /// The object's extent across the closing fingers.
    pub object_width: f64,
    /// The middle of the palm when the fingers close, in the object's frame.
    pub palm: Pose,
    /// The wrist at the same time, in the object's frame.
    pub wrist: Pose,
    /// The palm in the world.
    pub palm_in_world: Pose,
    /// The wrist in the world.
    pub wrist_in_world: Pose,
    /// What is done, in order.
    pub steps: Vec<Step>,
    /// The joints on the way to the object.
    pub open: BTreeMap<String, f64>,
    /// The joints that closing aims at.
    pub closed: BTreeMap<String, f64>,
    /// What the fingers may press with, by the hand's description. Nothing here keeps to it: see `simulated_force` of the step `grasp`.
    pub max_contact_force: f64,
    /// Links of the robot that may touch the object.
    pub touch_links: Vec<String>,
    /// What the robot may touch while it grasps: the object.
    pub allowed_touch_objects: Vec<String>,
    /// How uncertain the estimate is.
    pub estimate: Estimate,
    /// What error the grasp tolerates on an object as wide, from there; null where that was never simulated.
    pub tolerated: Option<Window>,
    /// How an arm carries the hand there; absent where none was named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<ArmMotion>,
    /// The probability that the estimate's error stays within what is tolerated, were it normal; 0 where the strategy is not
    /// feasible, null where the spread of the position or the window is unknown.
    pub quality: Option<f64>,
    /// Where everything is in the world, as drawings show it.
    pub layout: Layout,
    /// Whether this can be tried at all: false where there are `problems`.
    pub feasible: bool,
    /// What cannot be right.
    pub problems: Vec<Problem>,
    /// What speaks against trying this: the problems' messages, then what is merely doubtful.
    pub warnings: Vec<String>,
}

/// A position and a rotation in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Pose {
    /// `object` (about its middle) or `world`.
    pub frame: &'static str,
    /// Metres.
    pub position: [f64; 3],
    /// A unit quaternion, x, y, z, w.
    pub quaternion_xyzw: [f64; 4],
}

/// A unit vector in a frame.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Direction {
    /// `object`, `world`, or a link of the robot.
    pub frame: String,
    /// Of length 1.
    pub vector: [f64; 3],
}

/// A part of the sequence.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(tag = "step", rename_all = "lowercase")]
pub enum Step {
    /// The fingers are brought into the open posture, away from the object.
    Preshape {
        /// Every joint's value.
        joints: BTreeMap<String, f64>,
    },
    /// The hand moves straight to the object.
    Approach {
        /// Where the wrist starts.
        from: Pose,
        /// Where it ends.
        to: Pose,
        /// The way's direction.
        direction: Direction,
        /// The way's length.
        distance: f64,
        /// The least length that will do.
        min_distance: f64,
    },
    /// The fingers close until they meet the object.
    Grasp {
        /// What they aim at.
        joints: BTreeMap<String, f64>,
        /// What they may press with, by the hand's description.
        max_contact_force: f64,
        /// What one link pressed with in the simulation of such an object, at most; null where that is unknown.
        simulated_force: Option<f64>,
    },
    /// The hand lifts the object.
    Retreat {
        /// The way's direction.
        direction: Direction,
        /// The way's length.
        distance: f64,
        /// The least length that will do.
        min_distance: f64,
    },
}

/// How uncertain the estimate is, as standard deviations.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Estimate {
    /// Of the hand's position in each direction; null where it is unknown.
    pub position_m: Option<f64>,
    /// Of its orientation, the whole angle: of the yaw at most as much.
    pub orientation_rad: f64,
    /// `given`, or `assumed`: that the hand holds the object as people do.
    pub hand_position: &'static str,
}

impl Strategy {
    /// The strategy of `hand` that imitates `seen` on `object`.
    ///
    /// # Errors
    /// [`RobotError`]: the grasp has no counterpart, the orientation is unknown, the object lies in its table or is too wide.
    pub fn new(hand: &RobotHand, seen: &Seen, object: &Object, camera: &Camera) -> Result<Self, RobotError> {
        let (name, grasp) = hand.for_human(&seen.grasp)?;
        let human = HumanGrasp::named(&seen.grasp)
            .ok_or_else(|| RobotError::UnknownHuman { grasp: seen.grasp.clone() })?;
        if seen.spread_deg >= UNKNOWN_SPREAD_DEG {
            return Err(RobotError::NoOrientation);
        }
        let world_from_object = object.in_world(camera)?;
        let world_from_hand = camera.world_from_camera.rotation * seen.camera_from_hand;
        let turned = world_from_hand * human.hand_from_palm(seen.side);
        let middle: Point3<f64> = world_from_object.translation.vector.into();
        let grip = camera.hand.map_or(middle, |wrist| {
            camera.world_from_camera * wrist + world_from_hand * human.centre(seen.side).coords
        });
        let placed = Placed::new(hand, grasp, object, &world_from_object, turned, grip)?;

        let estimate = Estimate {
            position_m: camera.position_spread,
            orientation_rad: seen.spread_deg.to_radians(),
            hand_position: if camera.hand.is_some() { "given" } else { "assumed" },
        };
        let layout = Layout::new(hand, grasp, object, &world_from_object, &placed);
        let mut findings = Findings::new(hand, object, &layout, grip);
        findings.doubts.extend(doubts(&estimate, grasp, placed.width, &placed.approach));
        Ok(Self::assemble(hand, seen, (name, grasp), object, layout, &placed, estimate, findings))
    }

    /// What is doubtful about a strategy that may be tried all the same: the warnings that are no problems.
    pub fn doubts(&self) -> &[String] {
        self.warnings.get(self.problems.len()..).unwrap_or_default()
    }

    /// Says how `arm` carries the hand there; where it cannot, the strategy is not feasible.
    pub fn carried_by(mut self, arm: &Arm) -> Self {
        let motion = arm.carry(&self);
        if let Some(end) = &motion.unreachable {
            let message = format!(
                "unreachable: {} cannot carry the hand beyond {:.0} mm of the {}: {}",
                motion.arm,
                1e3 * end.distance,
                end.step,
                end.why
            );
            self.warnings.insert(self.problems.len(), message.clone());
            self.problems.push(Problem { kind: ProblemKind::Unreachable, message });
            self.feasible = false;
            self.quality = Some(0.0);
        }
        self.arm = Some(motion);
        self
    }

    #[expect(clippy::too_many_arguments, reason = "the one place where all parts come together")]
    fn assemble(
        hand: &RobotHand,
        seen: &Seen,
        (name, grasp): (&str, &RobotGrasp),
        object: &Object,
        layout: Layout,
        placed: &Placed,
        estimate: Estimate,
        Findings { problems, doubts }: Findings,
    ) -> Self {
        let object_from_world = layout.object.pose.isometry().inverse();
        let wrist_from_palm = Translation3::from(hand.wrist_from_palm);
        let palm = placed.world_from_palm;
        let wrist = palm * wrist_from_palm.inverse();
        let start = Translation3::from(-placed.approach * hand.approach.distance) * wrist;
        let open = posture(&grasp.open, placed.width);
        let closed = posture(&grasp.closed, placed.width);
        let in_object = |pose: &Isometry3<f64>| Pose::new("object", &(object_from_world * pose));
        let approach_vector = Direction {
            frame: "object".into(),
            vector: (object_from_world.rotation * placed.approach).into(),
        };
        let tolerated = tolerated(grasp, placed.width, &placed.approach);
        let quality = match problems.is_empty() {
            true => tolerated.as_ref().and_then(|window| confidence(&estimate, window)),
            false => Some(0.0),
        };
        let steps = vec![
            Step::Preshape { joints: open.clone() },
            Step::Approach {
                from: in_object(&start),
                to: in_object(&wrist),
                direction: approach_vector.clone(),
                distance: hand.approach.distance,
                min_distance: hand.approach.least,
            },
            Step::Grasp {
                joints: closed.clone(),
                max_contact_force: hand.max_contact_force,
                simulated_force: tolerated.as_ref().and_then(|window| window.force_n),
            },
            Step::Retreat {
                direction: Direction { frame: "world".into(), vector: [0.0, 0.0, 1.0] },
                distance: hand.retreat.distance,
                min_distance: hand.retreat.least,
            },
        ];
        Self {
            robot: hand.name.clone(),
            human_grasp: seen.grasp.clone(),
            grasp: name.to_owned(),
            object: object.name.clone(),
            wrist_link: hand.wrist_link.clone(),
            approach_vector,
            object_width: placed.width,
            palm: in_object(&palm),
            wrist: in_object(&wrist),
            palm_in_world: Pose::new("world", &palm),
            wrist_in_world: Pose::new("world", &wrist),
            steps,
            open,
            closed,
            max_contact_force: hand.max_contact_force,
            touch_links: hand.touch_links.clone(),
            allowed_touch_objects: vec![object.name.clone()],
            estimate,
            tolerated,
            arm: None,
            quality,
            layout,
            feasible: problems.is_empty(),
            warnings: problems.iter().map(|problem| problem.message.clone()).chain(doubts).collect(),
            problems,
        }
    }
}

impl Pose {
    pub(super) fn new(frame: &'static str, pose: &Isometry3<f64>) -> Self {
        Self { frame, position: pose.translation.vector.into(), quaternion_xyzw: xyzw(&pose.rotation) }
    }

    /// The same as a rigid motion.
    pub(super) fn isometry(&self) -> Isometry3<f64> {
        let [x, y, z, w] = self.quaternion_xyzw;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Translation3::from(self.position), rotation)
    }
}

/// A palm that is where it closes.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) world_from_palm: Isometry3<f64>,
    /// The palm's z in the world.
    pub(super) approach: Vector3<f64>,
    /// The object's extent across the fingers, in metres.
    pub(super) width: f64,
}

impl Placed {
    /// Puts a palm that is turned so before the object, aimed at `grip`, as near as the grasp wants and the table allows.
    pub(super) fn new(
        hand: &RobotHand,
        grasp: &RobotGrasp,
        object: &Object,
        world_from_object: &Isometry3<f64>,
        turned: UnitQuaternion<f64>,
        grip: Point3<f64>,
    ) -> Result<Self, RobotError> {
        // Through the middle, where the fingers close: the extent of the whole would be that of its far, tilted ends.
        let half = |direction: Vector3<f64>| {
            object.shape.half_chord(&world_from_object.inverse_transform_vector(&direction))
        };
        let approach = turned * Vector3::z();
        let width = 2.0 * half(turned * Vector3::y());
        if let Some(widest) = grasp.widest.filter(|widest| width > *widest) {
            return Err(RobotError::TooWide {
                object: object.name.clone(),
                hand: hand.name.clone(),
                width,
                widest,
            });
        }
        let middle = world_from_object.translation.vector;
        let along = (middle - grip.coords).dot(&approach) - half(approach) - grasp.standoff.at(width);
        let mut palm = grip + approach * along - turned * Vector3::y() * grasp.middle.at(width);
        let down = -approach.z;
        if let Some(table) = object.table.filter(|_| down > 0.0) {
            let tilt = approach.xy().norm();
            let missing = table + grasp.table_clearance * down + grasp.table_reach * tilt - palm.z;
            if missing > 0.0 {
                palm -= approach * (missing / down);
            }
        }
        Ok(Self { world_from_palm: Isometry3::from_parts(palm.coords.into(), turned), approach, width })
    }
}

/// The joints' values for an object of this width, in metres.
pub(super) fn posture(joints: &BTreeMap<String, super::hand::Value>, width: f64) -> BTreeMap<String, f64> {
    joints.iter().map(|(name, value)| (name.clone(), value.at(width))).collect()
}
