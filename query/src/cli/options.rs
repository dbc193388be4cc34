//! Options of recognition that several subcommands share.

use std::ops::{RangeBounds as _, RangeInclusive};
use std::path::{Path, PathBuf};

#[cfg(feature = "landmarks")]
use anyhow::Context as _;
use anyhow::bail;
use grasp_index::VoteOptions;

use super::effort::EffortArguments;
#[cfg(feature = "landmarks")]
use grasp_recognise::HandNetworks;
use grasp_recognise::networks::Networks;
use grasp_recognise::segment::{Finder, SegmentParams};
use grasp_recognise::sequence::SequenceParams;
use grasp_recognise::{Accept, DEFAULT_ROLLS, HandChoice, RecogniseOptions, ranges};

/// Under this heading stand options of those who study the method. `-h` leaves them out.
const RESEARCH: &str = "Research";

/// How pictures are recognised.
#[derive(Debug, clap::Args)]
pub(super) struct RecogniseArguments {
    /// Which hand the pictures show; `auto` tries both: neighbours, networks and where the
    /// arm comes from say which it is.
    #[arg(long, value_enum, default_value_t = HandArgument::Auto)]
    hand: HandArgument,
    /// Look at camera pictures mirrored, turned, in other light and enlarged as well, and join the
    /// answers: ten times the time, a few more of them right, fewer that hang on how a picture
    /// happens to be taken.
    #[arg(long)]
    thorough: bool,
    #[command(flatten)]
    effort: EffortArguments,
    // Behind all that everybody needs: its last option is for research.
    #[command(flatten)]
    segment: SegmentArguments,
    /// Turn each picture this many times, evenly over the circle, and take the turn whose
    /// neighbours are nearest; 1: as it is, or upright where the index's descriptors are.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "N", default_value_t = DEFAULT_ROLLS, value_parser = parse_rolls)]
    rolls: usize,
    /// How many neighbours vote; without it, what the index was calibrated with.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "N", value_parser = parse_k)]
    k: Option<usize>,
    /// Width of the vote's kernel as a distance between descriptors (Equation 3), in place of the
    /// index's own.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "D", conflicts_with = "sigma_scale", value_parser = parse_positive, allow_negative_numbers = true)]
    sigma: Option<f64>,
    /// Width of the vote's kernel as a multiple of the index's measured sigma.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "X", value_parser = parse_positive, allow_negative_numbers = true)]
    sigma_scale: Option<f64>,
    /// Take the vote's sigma from Equation 5 as it is printed, instead of from its words.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, conflicts_with_all = ["sigma", "sigma_scale"])]
    literal_sigma: bool,
    /// Average Euler angles, as Equation 4 is printed, instead of rotations.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true)]
    euler_mean: bool,
    /// Whether a hand may be unknown: by the limits that the index was calibrated with, or not at
    /// all.
    #[arg(long, value_enum, default_value_t = AcceptChoice::Calibrated)]
    accept: AcceptChoice,
    /// A hand is unknown where its nearest entry lies farther than D, whatever the index was
    /// calibrated with.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "D", conflicts_with = "accept", value_parser = parse_positive, allow_negative_numbers = true)]
    unknown_at: Option<f64>,
}

/// `--hand`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum HandArgument {
    /// Try both and take the likelier one.
    Auto,
    /// A left hand.
    Left,
    /// A right hand.
    Right,
}

impl From<HandArgument> for HandChoice {
    fn from(argument: HandArgument) -> Self {
        match argument {
            HandArgument::Auto => Self::Auto,
            HandArgument::Left => Self::Left,
            HandArgument::Right => Self::Right,
        }
    }
}

/// What finds the hand.
#[derive(Debug, clap::Args)]
pub(super) struct SegmentArguments {
    /// What finds the hand in a camera picture.
    #[arg(long, value_enum, default_value_t = SegmentBy::Scene)]
    segment: SegmentBy,
    /// Where --segment landmarks has its networks: a folder with palm_detection.onnx and
    /// hand_landmark.onnx, made of MediaPipe's as docs/landmarks.md says.
    #[arg(long, value_name = "DIR", required_if_eq("segment", "landmarks"))]
    landmarks_models: Option<PathBuf>,
    /// Look at scenes by networks of your own: a folder with scene.network, naming.network,
    /// thing.network or mask.network, as `grasp-builder train` writes them; any that it lacks
    /// stay built in.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "DIR")]
    networks: Option<PathBuf>,
}

/// `--segment`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SegmentBy {
    /// A network that was trained on scenes, and the colour of skin: it knows hands by their shape,
    /// and sees the object.
    Scene,
    /// The colour of skin, as in the paper.
    Skin,
    /// MediaPipe's networks, which find the hand's joints and say which hand it is, and then the
    /// network of scenes. They are files of yours (--landmarks-models).
    Landmarks,
}

impl SegmentArguments {
    /// How hands are found.
    ///
    /// # Errors
    /// Where networks that are asked for cannot be used, or none are asked for that are named.
    pub(super) fn params(&self) -> anyhow::Result<SegmentParams> {
        let networks = match (&self.networks, self.segment) {
            (None, _) => Networks::default(),
            (Some(folder), SegmentBy::Skin) => bail!(
                "the networks in {} look at scenes, which --segment skin leaves out: leave out one of them",
                folder.display()
            ),
            (Some(folder), _) => Networks::read(folder)?,
        };
        Ok(SegmentParams { by: self.finder()?, networks, ..SegmentParams::default() })
    }

    fn finder(&self) -> anyhow::Result<Finder> {
        match (self.segment, &self.landmarks_models) {
            (SegmentBy::Scene, None) => Ok(Finder::Scene),
            (SegmentBy::Skin, None) => Ok(Finder::Skin),
            (SegmentBy::Landmarks, Some(folder)) => by_landmarks(folder),
            (SegmentBy::Landmarks, None) => bail!("--segment landmarks needs --landmarks-models DIR"),
            (SegmentBy::Scene | SegmentBy::Skin, Some(folder)) => bail!(
                "the networks in {} are for --segment landmarks: add that, or leave them out",
                folder.display()
            ),
        }
    }

    /// The same as options, without folders that are only here.
    pub(super) fn named(&self) -> String {
        let by = match self.segment {
            SegmentBy::Scene => "",
            SegmentBy::Skin => " --segment skin",
            SegmentBy::Landmarks => " --segment landmarks --landmarks-models DIR",
        };
        let networks = if self.networks.is_some() { " --networks DIR" } else { "" };
        format!("{by}{networks}")
    }
}

#[cfg(feature = "landmarks")]
fn by_landmarks(folder: &Path) -> anyhow::Result<Finder> {
    let networks = HandNetworks::read(folder)
        .context("--segment landmarks needs two networks, made as docs/landmarks.md says")?;
    Ok(Finder::Landmarks(networks))
}

#[cfg(not(feature = "landmarks"))]
fn by_landmarks(_: &Path) -> anyhow::Result<Finder> {
    bail!(
        "--segment landmarks is not part of this program: install it with `cargo install --locked --path query \
         --features landmarks` (docs/landmarks.md)"
    )
}

/// `--accept`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum AcceptChoice {
    /// Every hand has a class.
    Always,
    /// A hand that the index has nothing like, or of which no class stands out, is unknown.
    Calibrated,
}

impl RecogniseArguments {
    /// The options of recognition.
    ///
    /// # Errors
    /// As [`SegmentArguments::params`].
    pub(super) fn options(&self) -> anyhow::Result<RecogniseOptions> {
        Ok(RecogniseOptions {
            hand: self.hand.into(),
            rolls: self.rolls,
            thorough: self.thorough,
            k: self.k,
            effort: self.effort.effort(),
            vote: VoteOptions {
                sigma: self.sigma,
                sigma_scale: self.sigma_scale,
                literal_sigma: self.literal_sigma,
                euler_mean: self.euler_mean,
            },
            accept: match (self.unknown_at, self.accept) {
                (Some(farthest), _) => Accept::Within(farthest),
                (None, AcceptChoice::Always) => Accept::Always,
                (None, AcceptChoice::Calibrated) => Accept::Calibrated,
            },
            segment: self.segment.params()?,
            ..RecogniseOptions::default()
        })
    }

    /// Rejects networks of one's own where a service is to find the hand.
    #[cfg(feature = "serve")]
    pub(super) fn refuse_networks(&self) -> anyhow::Result<()> {
        if self.segment.segment == SegmentBy::Landmarks {
            bail!("a service finds hands by itself: with --server, leave out --segment landmarks");
        }
        if self.segment.networks.is_some() {
            bail!(
                "a service looks by the networks that it was started with: with --server, leave out --networks"
            );
        }
        Ok(())
    }

    /// Whether the program finds out the hand itself.
    pub(super) fn hand_is_free(&self) -> bool {
        self.hand == HandArgument::Auto
    }
}

/// How a hand may change between the frames of a sequence.
#[derive(Debug, clap::Args)]
pub(super) struct FrameArguments {
    /// The probability that the grasp changes from one frame of a sequence to the next.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "P", default_value_t = SequenceParams::default().switch, value_parser = parse_probability, allow_negative_numbers = true)]
    switch: f64,
    /// How far the hand turns from one frame of a sequence to the next, in degrees.
    #[arg(long, help_heading = RESEARCH, hide_short_help = true, value_name = "DEG", default_value_t = SequenceParams::default().motion_deg, value_parser = parse_degrees, allow_negative_numbers = true)]
    motion: f64,
}

impl FrameArguments {
    pub(super) fn params(&self) -> SequenceParams {
        SequenceParams { switch: self.switch, motion_deg: self.motion }
    }
}

pub(super) fn parse_probability(text: &str) -> Result<f64, String> {
    let (least, most) = ranges::PROBABILITY.into_inner();
    let number = text.parse().ok().filter(|number| ranges::PROBABILITY.contains(number));
    number.ok_or_else(|| format!("a number from {least} to {most} is needed"))
}

fn parse_degrees(text: &str) -> Result<f64, String> {
    let (least, most) = ranges::MOTION_DEG.into_inner();
    let degrees = text.parse().ok().filter(|degrees| ranges::MOTION_DEG.contains(degrees));
    degrees.ok_or_else(|| format!("an angle from {least} to {most} degrees is needed"))
}

fn parse_rolls(text: &str) -> Result<usize, String> {
    parse_count(text, &ranges::ROLLS)
}

pub(super) fn parse_k(text: &str) -> Result<usize, String> {
    parse_count(text, &ranges::NEIGHBOURS)
}

fn parse_count(text: &str, range: &RangeInclusive<usize>) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| range.contains(count));
    count.ok_or_else(|| format!("an integer from {} to {} is needed", range.start(), range.end()))
}

fn parse_positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| ranges::POSITIVE.contains(number));
    number.ok_or_else(|| "a number above 0 is needed".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the service, Python and ROS, which have the ranges from the library as well.
    #[test]
    fn the_ranges_are_those_of_the_library() {
        for (parse, range) in
            [(parse_rolls as fn(&str) -> Result<usize, String>, ranges::ROLLS), (parse_k, ranges::NEIGHBOURS)]
        {
            let (least, most) = range.into_inner();
            assert_eq!((parse(&least.to_string()), parse(&most.to_string())), (Ok(least), Ok(most)));
            let said = format!("an integer from {least} to {most} is needed");
            for wrong in [least - 1, most + 1] {
                assert_eq!(parse(&wrong.to_string()), Err(said.clone()));
            }
        }
        for (parse, range, said) in [
            (
                parse_probability as fn(&str) -> Result<f64, String>,
                ranges::PROBABILITY,
                "a number from 0 to 1 is needed",
            ),
            (parse_degrees, ranges::MOTION_DEG, "an angle from 0 to 180 degrees is needed"),
        ] {
            let (least, most) = range.into_inner();
            assert_eq!((parse(&least.to_string()), parse(&most.to_string())), (Ok(least), Ok(most)));
            for wrong in [least - 1e-9, most + 1e-9, f64::NAN] {
                assert_eq!(parse(&wrong.to_string()), Err(said.into()));
            }
        }
    }
}
