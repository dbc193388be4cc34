//! `grasp-builder train`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{bail, ensure};
use grasp_network::Network;
use grasp_program::{Global, output_file};
use grasp_terminal::text::{counted, shown};

use super::seed::DEFAULT_SEED;
use crate::descriptor::read_network;
use crate::interrupt;
use crate::same_file::is_same_file;
use crate::train::{
    DEFAULT_VALIDATE_EVERY, Files, Kind, LeftOut, Optimiser, Options, Schedule, Trained, train,
};

/// Train the network of a learned descriptor on renders that are drawn as it goes.
///
/// The network never sees the same picture twice: hands, poses, objects and views are drawn without
/// end, and each render is shown about three times, every time in another light, turned and cut in
/// another way and behind other things. FILE.csv says how it went: losses, and how well the network
/// does on hands that no training draws, and on these hands in a fifth of the recorded poses.
/// Stopped at any moment, the same command goes on from the checkpoint, and writes the same bytes
/// as if it had not been stopped, on any number of threads.
///
/// The learned descriptor's network that comes with this program was trained by `--optimiser adam`
/// and the default options otherwise, and so on all recorded poses; the scene network twice, the
/// second time `--from` the first; the naming network in three trainings more, the thing network in
/// six others, the mask network in one, from random weights.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  grasp-builder train --out hand.network                     like the shipped one, in an hour
  grasp-builder build --descriptor learned --network hand.network --out grasp.idx
                                                             an index that is searched by it
  grasp-builder train --out small.network --samples 300000   ten minutes, for a first look
  grasp-builder train --out more.network --from hand.network --keep 50 --seed 8
                                                             go on with one, and average both
  grasp-builder train --out left-out.network --hold-out-poses
                                                             how well are unknown poses told apart?

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C.")]
pub(crate) struct Train {
    /// The network to write; the curve goes to FILE.csv.
    #[arg(long, value_name = "FILE", value_parser = output_file())]
    out: PathBuf,
    /// Which network: the learned descriptor's, or one that finds hands in camera pictures, that
    /// names them by the hand or by what it holds, or that cuts both out.
    #[arg(long, value_enum, default_value_t)]
    kind: Kind,
    /// Pictures to show the network in all; full batches of 64 are. By default as many as the
    /// shipped network of that kind was shown in its last training: 3,200,000 (hand), 1,600,000
    /// (scene), 1,000,000 (naming, thing), 640,000 (mask).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(64..=1_000_000_000))]
    samples: Option<u64>,
    /// Begin with the weights of a trained network of the same kind, and not with random ones. Give
    /// another seed than it was trained with: else it is shown the same pictures again.
    #[arg(long, value_name = "NETWORK")]
    from: Option<PathBuf>,
    /// Average the trained weights with those that it began with, of which so many percent count:
    /// less is forgotten of pictures unlike renders. The curve is of the trained weights.
    #[arg(long, value_name = "PERCENT", requires = "from", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=99))]
    keep: u8,
    /// The learning rate after the warm-up: 0.002 unless given, and 0.001 with --from. A smaller
    /// one forgets less of what the network has learned.
    #[arg(long, value_name = "R", value_parser = parse_rate, allow_negative_numbers = true)]
    rate: Option<f32>,
    /// How weights are moved. The shipped networks were trained by `adam`, the mask network and, at
    /// last, the thing network by `muon`.
    #[arg(long, value_enum, default_value_t)]
    optimiser: Optimiser,
    /// What all randomness comes from.
    #[arg(long, default_value_t = DEFAULT_SEED, value_name = "N")]
    seed: u64,
    /// What a training that was stopped goes on from: written every two minutes and at Ctrl-C,
    /// removed in the end. By default FILE.checkpoint.
    #[arg(long, value_name = "FILE", value_parser = output_file())]
    checkpoint: Option<PathBuf>,
    /// Measure, and add a line to the curve, each time that so many pictures have been shown.
    #[arg(long, default_value_t = DEFAULT_VALIDATE_EVERY, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    validate_every: u64,
    /// Leave a fifth of the recorded poses out of the training, for experiments: the curve's
    /// figures of these poses are then those of poses that the network has not seen.
    #[arg(long)]
    hold_out_poses: bool,
    /// Train on so many percent of the other recorded poses, for experiments.
    #[arg(long, value_name = "PERCENT", requires = "hold_out_poses", default_value_t = 100, value_parser = clap::value_parser!(u8).range(0..=100))]
    recorded_poses: u8,
    /// Train on so many hand shapes, for experiments; without it, on ever new ones.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    hands: Option<u64>,
    /// Leave out a kind of what is random in scenes (--kind scene, naming, thing or mask), for
    /// experiments: what does it bring? May be given several times.
    #[arg(long, value_name = "KIND", value_enum)]
    without: Vec<LeftOut>,
}

impl Train {
    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        interrupt::catch()?;
        ensure!(
            self.without.is_empty() || self.kind != Kind::Hand,
            "--without leaves something out of scenes, and the network of a learned descriptor is shown \
             none: give --kind scene, naming, thing or mask as well"
        );
        let start = self.from.as_deref().map(read_network).transpose()?;
        let options = Options {
            kind: self.kind,
            samples: self.samples.unwrap_or_else(|| self.kind.default_samples()),
            seed: self.seed,
            hold_out_poses: self.hold_out_poses,
            recorded_percent: self.recorded_poses,
            hands: self.hands,
            validate_every: self.validate_every,
            start: start.as_ref().map(Network::fingerprint),
            optimiser: self.optimiser,
            peak_rate: self.rate,
            keep_percent: self.keep,
            left_out: self.left_out(),
        };
        let files = self.files();
        if [&files.network, &files.curve].into_iter().any(|file| is_same_file(file, &files.checkpoint)) {
            let checkpoint = shown(&files.checkpoint);
            bail!("--checkpoint {checkpoint} is where the network or its curve goes: name another file");
        }
        let schedule = Schedule::standard(self.kind);
        let Trained { network, curve } =
            train(&options, schedule, start.as_ref(), &files, global.progress(), &interrupt::check)?;
        let mut stdout = std::io::stdout().lock();
        let samples = counted(schedule.samples(schedule.steps(options.samples)), ["sample", "samples"]);
        writeln!(
            stdout,
            "{}: network {:016x}, {:.1} MB, trained on {samples}, seed {}",
            shown(&files.network),
            network.fingerprint(),
            network.to_bytes().len() as f64 / 1e6,
            self.seed
        )?;
        if let Some(last) = curve.last() {
            writeln!(stdout, "  {last}")?;
        }
        writeln!(stdout, "  curve: {}", shown(&files.curve))?;
        Ok(())
    }

    /// Each once, in one order: the same training, however it is asked for.
    fn left_out(&self) -> Vec<LeftOut> {
        let mut left_out = self.without.clone();
        left_out.sort_unstable();
        left_out.dedup();
        left_out
    }

    fn files(&self) -> Files {
        let files = Files::beside(&self.out);
        match &self.checkpoint {
            Some(checkpoint) => Files { checkpoint: checkpoint.clone(), ..files },
            None => files,
        }
    }

    /// What is kept when the training is stopped, and how to go on with it.
    pub(super) fn when_stopped(&self) -> String {
        let checkpoint = self.files().checkpoint;
        if checkpoint.exists() {
            let checkpoint = shown(&checkpoint);
            format!("what is trained is kept in {checkpoint}; run the same command again to go on from there")
        } else {
            "nothing was trained yet; run the same command again".to_owned()
        }
    }
}

fn parse_rate(text: &str) -> Result<f32, String> {
    let rate: f32 = text.parse().map_err(|_| "a number is needed, for example 0.0003")?;
    if rate > 0.0 && rate <= 0.1 { Ok(rate) } else { Err("it must be above 0 and at most 0.1".to_owned()) }
}
