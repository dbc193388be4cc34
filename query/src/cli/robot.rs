//! Options that ask for a robot's strategy.

#[cfg(feature = "serve")]
use std::path::Path;
use std::path::PathBuf;

use grasp_robot::{Arm, Camera, Object, RobotError, RobotHand, Setting};

use super::name_or_file::NameOrFile;

/// The options' heading.
const HEADING: &str = "What a robot does";

/// What the robot is to do.
#[derive(Debug, clap::Args)]
pub(super) struct RobotArguments {
    /// Say what this robot hand does to grasp alike: barrett, parallel-gripper, or a HAND.toml that
    /// describes another.
    #[arg(long, help_heading = HEADING, value_name = "HAND", requires_all = ["object", "camera"], value_parser = NameOrFile::new(RobotHand::names()), hide_possible_values = true)]
    robot: Option<String>,
    /// The object: shape, size and pose.
    #[arg(long, help_heading = HEADING, value_name = "OBJECT.toml", requires = "robot")]
    object: Option<PathBuf>,
    /// The camera: its pose in the world, and where it saw the hand.
    #[arg(long, help_heading = HEADING, value_name = "CAMERA.toml", requires = "robot")]
    camera: Option<PathBuf>,
    /// Say by which joint angles this arm carries the hand: kuka-kr6-r700, or an ARM.toml that
    /// describes another and where it stands.
    #[arg(long, help_heading = HEADING, value_name = "ARM", requires = "robot", value_parser = NameOrFile::new(Arm::names()), hide_possible_values = true)]
    arm: Option<String>,
    /// Print the strategy alone, as YAML in the shape of a moveit_msgs/Grasp message; what is not
    /// feasible is no message, and exit status 1.
    #[arg(long, help_heading = HEADING, value_enum, value_name = "FORMAT", requires = "robot", conflicts_with = "json")]
    format: Option<Format>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// moveit_msgs/Grasp.
    Moveit,
}

impl RobotArguments {
    /// Reads what is named; `None` where no robot is.
    pub(super) fn read(&self) -> Result<Option<Setting>, RobotError> {
        let (Some(robot), Some(object), Some(camera)) = (&self.robot, &self.object, &self.camera) else {
            return Ok(None);
        };
        let (hand, object, camera) = (RobotHand::find(robot)?, Object::read(object)?, Camera::read(camera)?);
        let arm = self.arm.as_deref().map(Arm::find).transpose()?;
        Ok(Some(Setting::new(hand, object, camera)?.with_arm(arm)))
    }

    /// Whether strategies are written for MoveIt instead of records.
    pub(super) fn is_moveit(&self) -> bool {
        self.format == Some(Format::Moveit)
    }
}

/// What is sent to a service.
#[cfg(feature = "serve")]
impl RobotArguments {
    /// The robot hand's name, and its description where that is a file; the object's and the
    /// camera's files.
    pub(super) fn files(&self) -> Option<(&str, [Option<&Path>; 3])> {
        let (robot, object, camera) = (self.robot.as_ref()?, self.object.as_deref(), self.camera.as_deref());
        Some((robot, [grasp_robot::described(robot), object, camera]))
    }

    /// The arm's name, and its description where that is a file.
    pub(super) fn arm(&self) -> Option<(&str, Option<&Path>)> {
        self.arm.as_deref().map(|arm| (arm, grasp_robot::described(arm)))
    }
}
