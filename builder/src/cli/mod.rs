//! The command line: one file a subcommand, and what several share in files of their own.

mod build;
mod experiment;
mod export;
mod grow;
mod inspect;
mod merge;
mod plan;
mod preset;
mod preset_defaults;
mod queries;
mod render;
mod report;
mod seed;
mod shard;
mod split;
mod train;
mod verify;
mod work;

use std::process::ExitCode;

use anyhow::Context as _;
use clap::{CommandFactory as _, Parser, Subcommand};
use grasp_program::status::{INTERRUPTED, SUCCESS};
use grasp_program::{Completions, Global, Man};

use crate::interrupt::Interrupted;

/// Name and version.
const PROGRAM: [&str; 2] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")];

/// Renders views of grasping hands and builds the index that grasp-query searches.
#[derive(Debug, Parser)]
#[command(name = "grasp-builder", version, propagate_version = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  grasp-builder build --out grasp.idx                    40 hands from all sides, as an index
  grasp-builder render --out rendered --hands 10         a render set of ten hand shapes, as PNGs
  grasp-builder render --out more --hand-shape slender   another, of one hand shape
  grasp-builder build rendered more --out grasp.idx      index two render sets, yours among them
  grasp-builder shard --shard 3/12 --out parts           one of twelve parts, a machine for each
  grasp-builder merge parts --out grasp.idx              the index of all parts
  grasp-builder split grasp.idx --segments 4 --out-dir s the same in four files, for a machine each
  grasp-builder add grasp.idx --hand-shape broad         more entries in the same index
  grasp-builder add grasp.idx more --segment new.idx     the same as an index of their own
  grasp-builder inspect grasp.idx                        what is in an index
  grasp-builder verify grasp.idx                         read every byte and check it
  grasp-builder export grasp.idx --descriptors x.npy --labels y.csv
                                                         what it holds, for other programs
  grasp-builder train --out hand.network                 a descriptor's network, from renders
  grasp-builder experiment scale --out scale             how the search grows with the index
  grasp-builder experiment shapes --out shapes           indexes of ever more hand shapes, to score
  grasp-builder experiment networks hand.network         how well a network does on other hands

Exit status: 0 done, 2 an error, 130 stopped by Ctrl-C (nothing half-written is left, and the
message says what is kept).";

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Render),
    Build(build::Build),
    Shard(shard::Shard),
    Merge(merge::Merge),
    Split(split::Split),
    Add(grow::Add),
    Remove(grow::Remove),
    Compact(grow::Compact),
    Train(train::Train),
    Experiment(experiment::Experiment),
    Inspect(inspect::Inspect),
    Verify(verify::Verify),
    Export(export::Export),
    Queries(queries::Queries),
    Completions(Completions),
    Man(Man),
}

/// Parses the command line, runs it and turns the outcome into an exit status.
#[must_use]
pub fn main() -> ExitCode {
    grasp_program::start(
        PROGRAM,
        |arguments: &mut Arguments| &mut arguments.global,
        |arguments| match run(arguments) {
            Err(error) if error.chain().any(|cause| cause.is::<Interrupted>()) => {
                tracing::error!(subject = PROGRAM[0], "stopped: {}", arguments.command.when_stopped());
                Ok(INTERRUPTED)
            }
            outcome => outcome.map(|()| SUCCESS),
        },
    )
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    // Every command asks the indexes that it reads, after the work, whether they were overwritten
    // meanwhile.
    grasp_index::guard_against_truncation().context("cannot listen for faults")?;
    match &arguments.command {
        Command::Render(command) => command.run(&arguments.global),
        Command::Build(command) => command.run(&arguments.global),
        Command::Shard(command) => command.run(&arguments.global),
        Command::Merge(command) => command.run(&arguments.global),
        Command::Split(command) => command.run(&arguments.global),
        Command::Add(command) => command.run(&arguments.global),
        Command::Remove(command) => command.run(&arguments.global),
        Command::Compact(command) => command.run(&arguments.global),
        Command::Train(command) => command.run(&arguments.global),
        Command::Experiment(command) => command.run(&arguments.global),
        Command::Inspect(command) => command.run(),
        Command::Verify(command) => command.run(),
        Command::Export(command) => command.run(&arguments.global),
        Command::Queries(command) => command.run(&arguments.global),
        Command::Completions(command) => command.run(Arguments::command()),
        Command::Man(command) => command.run(Arguments::command()),
    }
}

impl Command {
    /// What is kept when the work is stopped, and how to go on with it.
    fn when_stopped(&self) -> String {
        match self {
            Self::Build(command) => command.when_stopped(),
            Self::Train(command) => command.when_stopped(),
            Self::Render(_) => {
                "what is rendered is kept; run the same command again to go on from there".to_owned()
            }
            Self::Shard(_) => {
                "nothing of this part is kept, and parts that are finished stay; run the same command again"
                    .to_owned()
            }
            Self::Merge(_) => {
                "nothing of the merge is kept, and the parts stay; run the same command again".to_owned()
            }
            Self::Add(_) | Self::Remove(_) | Self::Compact(_) => {
                "nothing of the new index is kept, and the old one is as it was; run the same command again"
                    .to_owned()
            }
            Self::Experiment(experiment) if experiment.keeps_results() => {
                "what is measured or built is kept; run the same command again to go on from there".to_owned()
            }
            _ => "nothing half-written is left; run the same command again".to_owned(),
        }
    }
}
