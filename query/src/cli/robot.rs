//! Options that ask for a robot's strategy.

use std::path::PathBuf;

use crate::output::record::{Answer, ErrorRecord};
use crate::recognise::Recognition;
use crate::robot::{Camera, Object, RobotError, RobotHand, Seen, Strategy, moveit};

/// What the robot is to do.
#[derive(Debug, clap::Args)]
pub(super) struct RobotArguments {
    /// Say what this robot hand does to grasp alike: barrett, parallel-gripper, or a HAND.toml that describes another.
    #[arg(long, value_name = "HAND", requires_all = ["object", "camera"])]
    robot: Option<String>,
    /// The object: shape, size and pose.
    #[arg(long, value_name = "OBJECT.toml", requires = "robot")]
    object: Option<PathBuf>,
    /// The camera: its pose in the world, and where it saw the hand.
    #[arg(long, value_name = "CAMERA.toml", requires = "robot")]
    camera: Option<PathBuf>,
    /// Print the strategy alone, as YAML in the shape of a moveit_msgs/Grasp message.
    #[arg(long, value_enum, value_name = "FORMAT", requires = "robot", conflicts_with = "json")]
    format: Option<Format>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// moveit_msgs/Grasp.
    Moveit,
}

/// The robot and all that is given to it, read once.
#[derive(Debug)]
pub(super) struct Setting {
    hand: RobotHand,
    object: Object,
    camera: Camera,
}

impl RobotArguments {
    /// Reads what is named; `None` where no robot is.
    pub(super) fn read(&self) -> Result<Option<Setting>, RobotError> {
        let (Some(robot), Some(object), Some(camera)) = (&self.robot, &self.object, &self.camera) else {
            return Ok(None);
        };
        let hand = RobotHand::find(robot)?;
        let setting = Setting { hand, object: Object::read(object)?, camera: Camera::read(camera)? };
        // Nothing that a picture shows can mend an object in its table.
        setting.object.in_world(&setting.camera)?;
        Ok(Some(setting))
    }

    /// Whether strategies are written for MoveIt instead of records.
    pub(super) fn is_moveit(&self) -> bool {
        self.format == Some(Format::Moveit)
    }
}

impl Setting {
    /// Puts the strategy into an answer, or why there is none. What is unknown is not imitated.
    pub(super) fn complete(&self, answer: &mut Answer, found: &Recognition) {
        if answer.reason.is_some() {
            return;
        }
        let seen = Seen {
            grasp: answer.grasp.clone(),
            side: found.best.side,
            camera_from_hand: found.best.vote.orientation.rotation,
            spread_deg: found.best.vote.orientation.spread_deg,
        };
        match Strategy::new(&self.hand, &seen, &self.object, &self.camera) {
            Ok(strategy) => answer.strategy = Some(strategy),
            Err(error) => {
                let message = error.to_string();
                answer.error = Some(ErrorRecord { kind: error.kind(), message, is_rejection: false });
            }
        }
    }
}

/// The YAML document of an answer, where it has a strategy.
pub(super) fn yaml(answer: &Answer) -> Option<String> {
    let id = answer.frame.map_or_else(|| answer.file.clone(), |frame| format!("{} {frame}", answer.file));
    answer.strategy.as_ref().map(|strategy| moveit::yaml(strategy, &id, answer.probability))
}
