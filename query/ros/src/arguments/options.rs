//! The node's options, which are its parameters.

use std::ffi::{OsStr, OsString};
use std::ops::RangeBounds as _;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::builder::BoolishValueParser;
use clap::{ArgAction, CommandFactory as _, Parser, ValueEnum};
use grasp_index::Effort;
use grasp_recognise::segment::{Finder, SegmentParams};
use grasp_recognise::{Accept, DEFAULT_ROLLS, HandChoice, RecogniseOptions, ranges};
use ros2_client::ParameterValue;

const EXAMPLES: &str = "\
Each option is a parameter of the node as well, with underscores; an option wins.

Arguments of ROS:
  --ros-args [-p NAME:=VALUE] [-r FROM:=TO] [--params-file FILE] [--log-level LEVEL]

Topics, in the node's namespace:
  image, or image/compressed    sensor_msgs/Image, CompressedImage    read
  camera_info, beside image     sensor_msgs/CameraInfo                read
  object_pose                   geometry_msgs/PoseStamped             read
  ~/detections                  vision_msgs/Detection2DArray          published
  ~/pose                        geometry_msgs/PoseStamped             published
  ~/markers                     visualization_msgs/MarkerArray        published
  ~/grasp                       moveit_msgs/Grasp                     published

Examples:
  grasp-ros --ros-args -r image:=/camera/image_raw
  grasp-ros --index grasp.idx --image-transport compressed --ros-args -r image:=/camera/image_raw
  grasp-ros --ros-args -p hand:=right -r __ns:=/arm -r image:=/camera/image_raw
  grasp-ros --robot barrett --object query/data/objects/bottle.toml \\
    --camera query/data/objects/camera.toml

The domain is ROS_DOMAIN_ID's. With ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, or
ROS_LOCALHOST_ONLY=1, only this machine is spoken to.";

/// Recognises which of six grasps the hand in a camera's pictures makes, and how it is turned, as a
/// node of ROS 2.
#[derive(Clone, Debug, Parser)]
#[command(name = "grasp-ros", version, after_help = EXAMPLES, args_override_self = true)]
pub(crate) struct Options {
    /// The index; without it, what GRASP_INDEX names, else ./grasp.idx, else grasp/grasp.idx in
    /// the user's data folder (~/.local/share on Linux), else grasp.idx beside this program.
    #[arg(long, value_name = "FILE", env = "GRASP_INDEX", hide_env_values = true, value_parser = clap::value_parser!(OsString))]
    index: Option<OsString>,
    /// Read the index into memory instead of mapping it, e.g. from a network file system.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, value_parser = BoolishValueParser::new(), num_args = 0..=1, require_equals = true, default_value = "false", default_missing_value = "true")]
    pub(crate) no_mmap: bool,
    /// How pictures come: as they are (image), or as JPEG or PNG (image/compressed).
    #[arg(long, value_enum, default_value_t = Transport::Raw)]
    pub(crate) image_transport: Transport,
    /// Which hand the pictures show; `auto` tries both: neighbours, networks and where the arm
    /// comes from say which it is.
    #[arg(long, value_enum, default_value_t = Hand::Auto)]
    hand: Hand,
    /// What finds the hand: a network that was trained on scenes, or the colour of skin.
    #[arg(long, value_enum, default_value_t = Segment::Scene)]
    segment: Segment,
    /// The pictures are segmented already: a hand on black.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, value_parser = BoolishValueParser::new(), num_args = 0..=1, require_equals = true, default_value = "false", default_missing_value = "true")]
    pub(crate) segmented: bool,
    /// Answer each picture by all pictures so far, as frames of one hand.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, value_parser = BoolishValueParser::new(), num_args = 0..=1, require_equals = true, default_value = "false", default_missing_value = "true")]
    pub(crate) sequence: bool,
    /// Find this share of the true 10 nearest, on average, as measured when the index was built.
    #[arg(long, value_name = "SHARE", default_value_t = 0.95, value_parser = parse_share)]
    recall: f64,
    /// Compare with every entry of the index instead of searching its tables.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, value_parser = BoolishValueParser::new(), num_args = 0..=1, require_equals = true, default_value = "false", default_missing_value = "true")]
    exact: bool,
    /// Whether a hand may be unknown: by the limits that the index was calibrated with, or not at
    /// all.
    #[arg(long, value_enum, default_value_t = AcceptChoice::Calibrated)]
    accept: AcceptChoice,
    /// How many neighbours vote; 0: what the index was calibrated with.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=*ranges::NEIGHBOURS.end() as i64))]
    k: u32,
    /// Turn each picture this many times, evenly over the circle, and take the turn whose
    /// neighbours are nearest.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_ROLLS as u32, value_parser = clap::value_parser!(u32).range(*ranges::ROLLS.start() as i64..=*ranges::ROLLS.end() as i64))]
    rolls: u32,
    /// Look at each picture in eight more variants, mirrored, turned, in other light and enlarged,
    /// and join the answers: for pictures that come seldom.
    #[arg(long, value_name = "BOOL", action = ArgAction::Set, value_parser = BoolishValueParser::new(), num_args = 0..=1, require_equals = true, default_value = "false", default_missing_value = "true")]
    thorough: bool,
    /// How far in front of the camera the hand is assumed to be, in metres, where no object's pose
    /// says it: one picture does not.
    #[arg(long, value_name = "METRES", default_value_t = 1.0, value_parser = parse_depth)]
    pub(crate) depth: f64,
    /// Whether the pictures are rectified, so that their camera is CameraInfo's P instead of its K;
    /// `auto`: where the last part of their topic's name begins with image_rect.
    #[arg(long, value_enum, default_value_t = Rectified::Auto)]
    rectified: Rectified,
    /// Publish how this robot hand makes the same grasp: one that comes with the program (barrett,
    /// allegro, ...), or a HAND.toml that describes another. Needs --object and --camera.
    #[arg(long, value_name = "HAND", default_value = "", hide_default_value = true)]
    robot: String,
    /// The object: shape, size, and the pose that it has until object_pose says another.
    #[arg(long, value_name = "OBJECT.toml", value_parser = clap::value_parser!(OsString), default_value = "", hide_default_value = true)]
    object: OsString,
    /// The camera: its pose in the world.
    #[arg(long, value_name = "CAMERA.toml", value_parser = clap::value_parser!(OsString), default_value = "", hide_default_value = true)]
    camera: OsString,
    /// The arm whose reach limits the grasp: one that comes with the program (kuka-kr6-r700, ur5e,
    /// ...), or an ARM.toml that describes another.
    #[arg(long, value_name = "ARM", default_value = "", hide_default_value = true)]
    arm: String,
    /// What the world is called among frames.
    #[arg(long, value_name = "FRAME", default_value = "world")]
    pub(crate) world_frame: String,
}

/// `--image-transport`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Transport {
    /// `sensor_msgs/Image`.
    Raw,
    /// `sensor_msgs/CompressedImage`.
    Compressed,
}

/// `--rectified`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Rectified {
    /// Their topic's name says.
    Auto,
    /// They are.
    True,
    /// They are as the lens made them.
    False,
}

/// `--hand`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Hand {
    /// Try both: neighbours, networks and where the arm comes from say which it is.
    Auto,
    /// A left hand.
    Left,
    /// A right hand.
    Right,
}

/// `--segment`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Segment {
    /// A network that was trained on scenes, and the colour of skin.
    Scene,
    /// The colour of skin, as in the paper.
    Skin,
}

/// `--accept`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AcceptChoice {
    /// Every hand has a class.
    Always,
    /// A hand that the index has nothing like, or of which no class stands out, is unknown.
    Calibrated,
}

impl Options {
    /// The parameters' names.
    pub(super) fn names() -> Vec<String> {
        let command = Self::command();
        let named = command.get_arguments().filter_map(|argument| argument.get_long());
        named.map(|name| name.replace('-', "_")).collect()
    }

    /// Rejects options that mean nothing without others.
    ///
    /// # Errors
    /// Where one is missing.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let scene = [&self.object, &self.camera].map(|path| !path.is_empty());
        if !self.robot.is_empty() && scene != [true; 2] {
            bail!("--robot needs --object and --camera: what is grasped, and from where it is seen");
        }
        if self.robot.is_empty() && (scene != [false; 2] || !self.arm.is_empty()) {
            bail!("--object, --camera and --arm are for a robot: name one with --robot");
        }
        Ok(())
    }

    /// The index that was named, if one was.
    pub(crate) fn index(&self) -> Option<PathBuf> {
        self.index.as_ref().filter(|name| !name.is_empty()).map(PathBuf::from)
    }

    /// The robot hand, the files of object and camera, and the arm if there is one; `None` where no
    /// robot is named.
    pub(crate) fn robot(&self) -> Option<(&str, [&Path; 2], Option<&str>)> {
        let files = [Path::new(&self.object), Path::new(&self.camera)];
        let arm = Some(self.arm.as_str()).filter(|arm| !arm.is_empty());
        (!self.robot.is_empty()).then_some((&self.robot, files, arm))
    }

    /// Whether pictures that come by a topic of this name are rectified. `image_proc` calls such
    /// topics `image_rect` and `image_rect_color`, drivers of depth cameras `image_rect_raw`.
    pub(crate) fn is_rectified(&self, topic: &str) -> bool {
        match self.rectified {
            Rectified::Auto => topic.rsplit('/').next().is_some_and(|name| name.starts_with("image_rect")),
            Rectified::True => true,
            Rectified::False => false,
        }
    }

    /// How pictures are recognised.
    pub(crate) fn recognition(&self) -> RecogniseOptions {
        RecogniseOptions {
            hand: match self.hand {
                Hand::Auto => HandChoice::Auto,
                Hand::Left => HandChoice::Left,
                Hand::Right => HandChoice::Right,
            },
            rolls: self.rolls as usize,
            thorough: self.thorough,
            k: Some(self.k as usize).filter(|k| *k > 0),
            effort: if self.exact { Effort::Exact } else { Effort::Recall(self.recall) },
            accept: match self.accept {
                AcceptChoice::Always => Accept::Always,
                AcceptChoice::Calibrated => Accept::Calibrated,
            },
            segment: SegmentParams {
                by: match self.segment {
                    Segment::Scene => Finder::Scene,
                    Segment::Skin => Finder::Skin,
                },
                ..SegmentParams::default()
            },
            ..RecogniseOptions::default()
        }
    }

    /// The parameters as ROS lists them.
    pub(crate) fn parameters(&self) -> Vec<(&'static str, ParameterValue)> {
        let text = |text: &str| ParameterValue::String(text.to_owned());
        let path = |path: &OsStr| ParameterValue::String(path.to_string_lossy().into_owned());
        let choice = |name: Option<clap::builder::PossibleValue>| {
            ParameterValue::String(name.map(|name| name.get_name().to_owned()).unwrap_or_default())
        };
        vec![
            ("index", path(self.index.as_deref().unwrap_or_default())),
            ("no_mmap", ParameterValue::Boolean(self.no_mmap)),
            ("image_transport", choice(self.image_transport.to_possible_value())),
            ("hand", choice(self.hand.to_possible_value())),
            ("segment", choice(self.segment.to_possible_value())),
            ("segmented", ParameterValue::Boolean(self.segmented)),
            ("sequence", ParameterValue::Boolean(self.sequence)),
            ("recall", ParameterValue::Double(self.recall)),
            ("exact", ParameterValue::Boolean(self.exact)),
            ("accept", choice(self.accept.to_possible_value())),
            ("k", ParameterValue::Integer(self.k.into())),
            ("rolls", ParameterValue::Integer(self.rolls.into())),
            ("thorough", ParameterValue::Boolean(self.thorough)),
            ("depth", ParameterValue::Double(self.depth)),
            ("rectified", choice(self.rectified.to_possible_value())),
            ("robot", text(&self.robot)),
            ("object", path(&self.object)),
            ("camera", path(&self.camera)),
            ("arm", text(&self.arm)),
            ("world_frame", text(&self.world_frame)),
        ]
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| ranges::RECALL.contains(share));
    share.ok_or_else(|| "a number above 0 and at most 1 is needed, such as 0.95".into())
}

fn parse_depth(text: &str) -> Result<f64, String> {
    let depth = text.parse().ok().filter(|depth: &f64| *depth > 0.0 && *depth <= 100.0);
    depth.ok_or_else(|| "a distance above 0 and at most 100 m is needed".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_index::SearchOptions;

    #[test]
    fn the_defaults_are_those_of_the_program() {
        let options = Options::try_parse_from(["grasp-ros"]).unwrap().recognition();
        assert_eq!(format!("{options:?}"), format!("{:?}", RecogniseOptions::default()));
        assert_eq!(Effort::Recall(0.95), SearchOptions::default().effort);
    }

    #[test]
    fn the_ranges_are_those_of_the_program() {
        let takes = |option: &str, value: usize| {
            Options::try_parse_from(["grasp-ros", option, &value.to_string()]).is_ok()
        };
        // No neighbours: as many as the index was calibrated with.
        for (option, least, most) in
            [("--rolls", *ranges::ROLLS.start(), *ranges::ROLLS.end()), ("--k", 0, *ranges::NEIGHBOURS.end())]
        {
            assert!(takes(option, least) && takes(option, most) && !takes(option, most + 1), "{option}");
        }
        assert!(
            !takes("--rolls", 0) && !takes("--recall", 0) && takes("--recall", 1) && !takes("--recall", 2)
        );
    }

    #[test]
    fn every_option_is_a_parameter() {
        let options = Options::try_parse_from(["grasp-ros"]).unwrap();
        let listed: Vec<&str> = options.parameters().into_iter().map(|(name, _)| name).collect();
        assert_eq!(listed, Options::names());
    }

    #[test]
    fn the_command_is_sound() {
        Options::command().debug_assert();
    }
}
