//! Options that ask for a robot's strategy.

use std::path::{Path, PathBuf};

use anyhow::bail;
use grasp_robot::{Arm, Camera, Object, RobotHand, Setting};

use super::name_or_file::NameOrFile;
use crate::live::camera;

/// The options' heading.
const HEADING: &str = "What a robot does";

/// What the robot is to do.
#[derive(Debug, clap::Args)]
pub(super) struct RobotArguments {
    /// Plan the same grasp for this robot hand: allegro, barrett, franka-hand,
    /// parallel-gripper, robotiq-2f-85, a HAND.toml that describes another, or a gripper's
    /// HAND.urdf with a HAND.toml beside it.
    #[arg(long, help_heading = HEADING, value_name = "HAND", requires_all = ["object", "cameras"], value_parser = NameOrFile::new(RobotHand::names()), hide_possible_values = true)]
    robot: Option<String>,
    /// The object: shape, size and pose.
    #[arg(long, help_heading = HEADING, value_name = "OBJECT.toml", requires = "robot")]
    object: Option<PathBuf>,
    /// The camera. A number (0 is /dev/video0) or a device: it gives the frames, in place of
    /// files (Linux). A CAMERA.toml, with --robot: its pose in the world, and where it saw the
    /// hand. Both may be given.
    #[arg(id = "cameras", long = "camera", value_name = "CAMERA", value_parser = parse_camera)]
    cameras: Vec<CameraArgument>,
    /// Say by which joint angles this arm carries the hand: franka-panda, kuka-kr6-r700, ur5e, or
    /// an ARM.toml that describes another and where it stands.
    #[arg(long, help_heading = HEADING, value_name = "ARM", requires = "robot", value_parser = NameOrFile::new(Arm::names()), hide_possible_values = true)]
    arm: Option<String>,
}

/// How a strategy is printed.
#[derive(Debug, clap::Args)]
pub(super) struct MessageArguments {
    /// Print the strategy alone, as YAML in the shape of a moveit_msgs/Grasp message; what is not
    /// feasible is no message, and exit status 1.
    #[arg(long, help_heading = HEADING, value_enum, value_name = "FORMAT", requires = "robot", conflicts_with = "json")]
    format: Option<Format>,
}

/// `--camera`.
#[derive(Clone, Debug)]
enum CameraArgument {
    /// What gives frames.
    Device(PathBuf),
    /// The description of where it stands.
    Pose(PathBuf),
}

fn parse_camera(text: &str) -> Result<CameraArgument, String> {
    match camera::device(text) {
        Some(device) => Ok(CameraArgument::Device(device)),
        None if text.is_empty() => Err("a number, a device or a CAMERA.toml is needed".into()),
        None => Ok(CameraArgument::Pose(text.into())),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// moveit_msgs/Grasp.
    Moveit,
}

impl RobotArguments {
    /// Reads what is named; `None` where no robot is.
    pub(super) fn read(&self) -> anyhow::Result<Option<Setting>> {
        let pose = self.pose()?;
        let (Some(robot), Some(object)) = (&self.robot, &self.object) else {
            if let Some(pose) = pose {
                bail!(
                    "--camera {} is a description of where a camera stands, which --robot needs; a camera is named by its number, as in --camera 0, or by its device, as in --camera /dev/video0",
                    pose.display()
                );
            }
            return Ok(None);
        };
        let Some(pose) = pose else {
            bail!("--robot needs --camera CAMERA.toml as well, which says where the camera stands");
        };
        let (hand, object, camera) = (RobotHand::find(robot)?, Object::read(object)?, Camera::read(pose)?);
        let arm = self.arm.as_deref().map(Arm::find).transpose()?;
        Ok(Some(Setting::new(hand, object, camera)?.with_arm(arm)))
    }

    /// The description of where the camera stands.
    fn pose(&self) -> anyhow::Result<Option<&Path>> {
        self.only(|argument| match argument {
            CameraArgument::Pose(path) => Some(path),
            CameraArgument::Device(_) => None,
        })
    }

    /// The camera that gives the frames.
    pub(super) fn device(&self) -> anyhow::Result<Option<&Path>> {
        self.only(|argument| match argument {
            CameraArgument::Device(path) => Some(path),
            CameraArgument::Pose(_) => None,
        })
    }

    fn only(&self, of: impl Fn(&CameraArgument) -> Option<&PathBuf>) -> anyhow::Result<Option<&Path>> {
        let mut named = self.cameras.iter().filter_map(of);
        let first = named.next();
        if let (Some(first), Some(second)) = (first, named.next()) {
            bail!("--camera {} and --camera {}: name one", first.display(), second.display());
        }
        Ok(first.map(PathBuf::as_path))
    }
}

impl MessageArguments {
    /// Whether strategies are written for MoveIt instead of records.
    pub(super) fn is_moveit(&self) -> bool {
        self.format == Some(Format::Moveit)
    }
}

/// What is sent to a service.
#[cfg(feature = "serve")]
impl RobotArguments {
    /// The robot hand's name, and its description where that is a file.
    pub(super) fn hand(&self) -> Result<Option<(&str, Option<String>)>, grasp_robot::RobotError> {
        let hand = self.robot.as_deref().map(|name| Ok((name, RobotHand::description(name)?)));
        hand.transpose()
    }

    /// The object's and the camera's files.
    pub(super) fn files(&self) -> [Option<&Path>; 2] {
        [self.object.as_deref(), self.pose().ok().flatten()]
    }

    /// The arm's name, and its description where that is a file.
    pub(super) fn arm(&self) -> Option<(&str, Option<&Path>)> {
        self.arm.as_deref().map(|arm| (arm, grasp_robot::described(arm)))
    }
}
