//! The robot hand of a simulation.

use grasp_robot::{RobotError, RobotHand};

use super::name_or_file::NameOrFile;

/// `--robot`, where there is a physics engine to try it in.
#[derive(Debug, clap::Args)]
pub(super) struct SimulatedHand {
    /// The robot hand: barrett, or a HAND.toml with other grasps of it.
    #[arg(long, value_name = "HAND", default_value = "barrett", value_parser = NameOrFile::new(RobotHand::names()), hide_possible_values = true)]
    robot: String,
}

impl SimulatedHand {
    /// The hand of that name, or that the file describes.
    pub(super) fn find(&self) -> Result<RobotHand, RobotError> {
        RobotHand::find(&self.robot)
    }
}
