//! From what was seen to what the robot does: approach, grasp, retreat, relative to the object.
//!
//! As in the paper's Section VI no approach is searched for: the robot's palm comes from where the
//! human hand came from, turned as it was turned, to the place of the object that the human hand
//! held.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use serde::Serialize;

use super::attitude::Attitude;
use super::closing::Closing;
use super::feasible::{Findings, Problem, ProblemKind};
use super::hand::{RobotGrasp, RobotHand};
use super::human::HumanGrasp;
use super::layout::Layout;
use super::placed::{Placed, posture};
use super::pose::{Direction, Pose};
use super::step::Step;
use super::tolerance::{Estimate, confidence, doubts, tolerated};
use super::window::Window;
use super::{Arm, ArmMotion, Camera, Object, RobotError};
use grasp_recognise::Side;

/// A spread of this many degrees means that the orientation is unknown (the neighbours had none).
const UNKNOWN_SPREAD_DEG: f64 = 180.0;

/// A human hand that grasps, as it was recognised.
#[derive(Clone, Debug)]
pub struct ObservedHand {
    /// The human grasp.
    pub grasp: String,
    /// The hand.
    pub side: Side,
    /// How it is turned toward the camera.
    pub camera_from_hand: UnitQuaternion<f64>,
    /// How far the estimate of that may be off: the root mean square of the whole angle, in
    /// degrees.
    pub spread_deg: f64,
}

/// What the robot does. JSON keys are an interface: they may be added to, never renamed. Metres,
/// radians, newtons; quaternions x, y, z, w.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Strategy {
    /// The robot hand.
    pub robot: String,
    /// The human grasp that is imitated.
    pub human_grasp: String,
    /// The robot's grasp.
    pub grasp: String,
    /// What the robot hand does instead, where it cannot do what the human hand does; null where it
    /// can.
    pub instead: Option<String>,
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
    /// What the fingers may press with, by the hand's description. Nothing here keeps to it: see
    /// `simulated_force` of the step `grasp`.
    pub max_contact_force: f64,
    /// Links of the robot that may touch the object.
    pub touch_links: Vec<String>,
    /// What the robot may touch while it grasps: the object.
    pub allowed_touch_objects: Vec<String>,
    /// How uncertain the estimate is.
    pub estimate: Estimate,
    /// What error the grasp tolerates on an object as wide that lies so, less what the hand's own
    /// tilt uses up of it; null where that was never simulated, or nothing is left.
    pub tolerated: Option<Window>,
    /// How an arm carries the hand there; absent where none was named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<ArmMotion>,
    /// The probability that the estimate's error stays within what is tolerated, were it normal; 0
    /// where the strategy is not feasible, null where the spread of the position, how far the
    /// orientation may be off, or the window is unknown.
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

impl Strategy {
    /// The strategy of `hand` that imitates `seen` on `object`.
    ///
    /// # Errors
    /// [`RobotError`]: the grasp is none of the six or has no counterpart, the orientation is unknown,
    /// the object lies in its table or behind the camera, or is too wide.
    pub fn new(
        hand: &RobotHand,
        seen: &ObservedHand,
        object: &Object,
        camera: &Camera,
    ) -> Result<Self, RobotError> {
        // First what no description of a hand could mend.
        let human = HumanGrasp::named(&seen.grasp)
            .ok_or_else(|| RobotError::UnknownHuman { grasp: seen.grasp.clone() })?;
        let (name, grasp) = hand.for_human(&seen.grasp)?;
        if seen.spread_deg >= UNKNOWN_SPREAD_DEG {
            return Err(RobotError::NoOrientation);
        }
        let world_from_object = object.seen_by(camera)?;
        let world_from_hand = camera.world_from_camera.rotation * seen.camera_from_hand;
        let turned = world_from_hand * human.hand_from_palm(seen.side);
        let middle: Point3<f64> = world_from_object.translation.vector.into();
        let grip = camera.hand.map_or(middle, |wrist| {
            camera.world_from_camera * wrist + world_from_hand * human.centre(seen.side).coords
        });
        let placed = Placed::new(hand, grasp, object, &world_from_object, turned, grip);
        let placed = placed.map_err(|mut error| {
            if let RobotError::TooWide { width, others, .. } = &mut error {
                *others = hand.that_open_wider(&seen.grasp, *width);
            }
            error
        })?;

        let estimate = Estimate {
            position_m: camera.position_spread,
            orientation_rad: seen.spread_deg.to_radians(),
            hand_position: if camera.hand.is_some() { "given" } else { "assumed" },
        };
        let layout = Layout::new(hand, grasp, object, &world_from_object, &placed);
        let closing = Closing::new(hand, grasp, &placed, &object.shape, &world_from_object);
        let mut findings = Findings::new(object, &layout, closing, grip);
        if let Some(instead) = hand.instead.get(&seen.grasp) {
            findings.doubts.push(format!("{} cannot do {} as people do: {instead}", hand.name, seen.grasp));
        }
        let attitude = Attitude::new(&placed.world_from_palm.rotation, &object.shape, &world_from_object);
        findings.doubts.extend(doubts(&estimate, grasp, placed.width, attitude.as_ref()));
        let tolerated = tolerated(grasp, placed.width, attitude.as_ref()).ok();
        Ok(Self::assemble(
            hand,
            seen,
            (name, grasp),
            object,
            layout,
            &placed,
            (estimate, tolerated),
            findings,
        ))
    }

    /// What is doubtful about a strategy that may be tried all the same: the warnings that are no
    /// problems.
    pub fn doubts(&self) -> &[String] {
        self.warnings.get(self.problems.len()..).unwrap_or_default()
    }

    /// Says how `arm` carries the hand there; where it cannot, the strategy is not feasible.
    pub fn carried_by(mut self, arm: &Arm) -> Self {
        let forward = self.palm_in_world.isometry().rotation * Vector3::z();
        let motion = arm.carry(&self.wrist_in_world, forward, &self.steps);
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
        seen: &ObservedHand,
        (name, grasp): (&str, &RobotGrasp),
        object: &Object,
        layout: Layout,
        placed: &Placed,
        (estimate, tolerated): (Estimate, Option<Window>),
        Findings { problems, doubts }: Findings,
    ) -> Self {
        let object_from_world = layout.object.pose.isometry().inverse();
        let palm = placed.world_from_palm;
        let wrist = palm * hand.wrist_from_palm().inverse();
        let start = Translation3::from(-placed.approach * hand.approach.distance) * wrist;
        let open = posture(&grasp.open, placed.width);
        let closed = posture(&grasp.closed, placed.width);
        let in_object = |pose: &Isometry3<f64>| Pose::new("object", &(object_from_world * pose));
        let approach_vector = Direction {
            frame: "object".into(),
            vector: (object_from_world.rotation * placed.approach).into(),
        };
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
            instead: hand.instead.get(&seen.grasp).cloned(),
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
