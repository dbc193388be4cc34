//! `moveit_msgs/Grasp`: what a robot does to make the same grasp.

use std::path::Path;

use grasp_robot::{
    Arm, Camera, Frame, Object, ObservedHand, Problem, RobotError, RobotHand, Setting, Strategy, moveit,
};
use nalgebra::{Isometry3, Translation3};

use super::{Hand, rotation};
use crate::messages::geometry::PoseStamped;
use crate::messages::moveit::Grasp;
use crate::messages::standard::{Header, Time};

/// A robot, what it is to grasp, and from where that is seen.
#[derive(Debug)]
pub(crate) struct Robot {
    hand: RobotHand,
    object: Object,
    camera: Camera,
    arm: Option<Arm>,
    /// What the world is called among frames.
    world: String,
}

/// Why there is no grasp.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoGrasp {
    /// The object's pose is in a frame that is not known.
    #[error(
        "the object's pose is in the frame {frame:?}: give it in that of the pictures, {pictures:?}, or in {world:?} \
         (--world-frame)"
    )]
    Frame {
        /// Of the pose.
        frame: String,
        /// Of the pictures.
        pictures: String,
        /// Of the world.
        world: String,
    },
    /// The object's pose is none.
    #[error("the object's pose has numbers that are none, or a quaternion whose length is not 1")]
    Pose,
    /// The robot cannot.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The strategy cannot be carried out, which a message would not say.
    #[error("no grasp, as it is not feasible: {}", messages(.0))]
    Infeasible(Vec<Problem>),
    /// The strategy is no message.
    #[error("no grasp: {0}")]
    Message(#[from] serde_json::Error),
}

fn messages(problems: &[Problem]) -> String {
    problems.iter().map(|problem| problem.message.as_str()).collect::<Vec<_>>().join("; ")
}

impl NoGrasp {
    /// A short name that is the same for what has the same cause.
    pub(crate) fn kind(&self) -> String {
        match self {
            Self::Frame { frame, .. } => format!("frame {frame}"),
            Self::Pose => "pose".to_owned(),
            Self::Robot(error) => error.kind().to_owned(),
            Self::Infeasible(problems) => {
                let kinds: Vec<_> = problems.iter().map(|problem| problem.kind).collect();
                format!("infeasible {kinds:?}")
            }
            Self::Message(_) => "message".to_owned(),
        }
    }
}

impl Robot {
    /// Reads what is named.
    ///
    /// # Errors
    /// Where a description cannot be read.
    pub(crate) fn read(
        hand: &str,
        [object, camera]: [&Path; 2],
        arm: Option<&str>,
        world: &str,
    ) -> Result<Self, RobotError> {
        let robot = Self {
            hand: RobotHand::find(hand)?,
            object: Object::read(object)?,
            camera: Camera::read(camera)?,
            arm: arm.map(Arm::find).transpose()?,
            world: world.to_owned(),
        };
        // What cannot be is said now, not with the first picture.
        robot.setting(robot.object.clone())?;
        Ok(robot)
    }

    fn setting(&self, object: Object) -> Result<Setting, RobotError> {
        let setting = Setting::new(self.hand.clone(), object, self.camera.clone())?;
        Ok(setting.with_arm(self.arm.clone()))
    }

    /// The object where `pose` says that it is, in pictures of the frame `pictures`.
    fn placed(&self, pose: &PoseStamped, pictures: &str) -> Result<Object, NoGrasp> {
        let frame = match pose.header.frame_id.as_str() {
            frame if frame == pictures => Frame::Camera,
            frame if frame == self.world => Frame::World,
            frame => {
                let (frame, pictures, world) = (frame.to_owned(), pictures.to_owned(), self.world.clone());
                return Err(NoGrasp::Frame { frame, pictures, world });
            }
        };
        let at = pose.pose.position;
        let place = [at.x, at.y, at.z];
        let turned = rotation(&pose.pose.orientation).ok_or(NoGrasp::Pose)?;
        if !place.iter().all(|metres| metres.abs() < FARTHEST) {
            return Err(NoGrasp::Pose);
        }
        let pose = Isometry3::from_parts(Translation3::from(place), turned);
        Ok(Object { frame, pose, ..self.object.clone() })
    }

    /// The grasp that imitates a hand, of the object where `object` says that it is, or where its
    /// file does.
    ///
    /// # Errors
    /// [`NoGrasp`]: where it cannot be.
    pub(crate) fn grasp(&self, hand: &Hand, object: Option<&PoseStamped>) -> Result<Grasp, NoGrasp> {
        let placed = object.map(|pose| self.placed(pose, &hand.header.frame_id)).transpose()?;
        let seen = ObservedHand {
            grasp: hand.grasp().0.to_owned(),
            side: hand.side,
            camera_from_hand: hand.rotation,
            spread_deg: hand.spread_deg,
        };
        let strategy = self.setting(placed.unwrap_or_else(|| self.object.clone()))?.strategy(&seen)?;
        self.message(&strategy, hand.header.stamp)
    }

    fn message(&self, strategy: &Strategy, stamp: Time) -> Result<Grasp, NoGrasp> {
        if !strategy.feasible {
            return Err(NoGrasp::Infeasible(strategy.problems.clone()));
        }
        let id = format!("{} of {}", strategy.grasp, strategy.object);
        let mut grasp: Grasp = serde_json::from_value(moveit::message(strategy, &id))?;
        for header in headers(&mut grasp) {
            header.stamp = stamp;
            if header.frame_id == WORLD {
                header.frame_id.clone_from(&self.world);
            }
        }
        Ok(grasp)
    }
}

/// What strategies call the world.
const WORLD: &str = "world";
/// Nothing that is grasped lies farther away, in metres.
const FARTHEST: f64 = 1e3;

fn headers(grasp: &mut Grasp) -> [&mut Header; 6] {
    [
        &mut grasp.pre_grasp_posture.header,
        &mut grasp.grasp_posture.header,
        &mut grasp.grasp_pose.header,
        &mut grasp.pre_grasp_approach.direction.header,
        &mut grasp.post_grasp_retreat.direction.header,
        &mut grasp.post_place_retreat.direction.header,
    ]
}
