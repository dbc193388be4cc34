//! The command line: one file a subcommand, and what several share in files of their own.

mod build;
mod completions;
mod experiment;
mod export;
mod form;
mod global;
mod grow;
mod inspect;
mod man;
mod merge;
mod plan;
mod preset;
mod queries;
mod render;
mod shard;
mod split;
mod train;
mod verify;

use std::io::{self, Write as _};
use std::process::ExitCode;

use anyhow::Context as _;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use grasp_terminal::error::message;
use grasp_terminal::text::printable_lines;

use crate::interrupt::{self, Interrupted};
use global::Global;

/// Name and version.
const PROGRAM: [&str; 2] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")];
/// Everything went well.
const SUCCESS: u8 = 0;
/// Something failed; the message says what and what to do.
const ERROR: u8 = 2;

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
  grasp-builder build --out grasp.idx                    render 40 hands from all sides and index them
  grasp-builder render --out renders --hands 10          write a render set of ten hand shapes as PNG files
  grasp-builder render --out more --hand-shape slender   another, of one hand shape
  grasp-builder build renders more --out grasp.idx       index two render sets (any program may have made them)
  grasp-builder shard --shard 3/12 --out parts           one of twelve parts, each on a machine of its own
  grasp-builder merge parts --out grasp.idx              the index of all parts
  grasp-builder split grasp.idx --segments 4 --out-dir s the same in four files, for a machine each
  grasp-builder add grasp.idx --hand-shape broad         more entries in the same index
  grasp-builder add grasp.idx more --segment new.idx     the same in an index of their own, to be searched beside it
  grasp-builder inspect grasp.idx                        what is in an index
  grasp-builder verify grasp.idx                         read every byte and check it
  grasp-builder export grasp.idx --descriptors x.npy --labels y.csv
                                                         its descriptors and labels, for other programs
  grasp-builder train --out hand.network                 the network of a learned descriptor, from renders
  grasp-builder experiment scale --out scale             how the search grows with the index
  grasp-builder experiment shapes --out shapes           indexes of ever more hand shapes, to score

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
    Completions(completions::Completions),
    Man(man::Man),
}

/// Parses the command line, runs it and turns the outcome into an exit status.
#[must_use]
pub fn main() -> ExitCode {
    let (arguments, command) = match parse() {
        Ok(parsed) => parsed,
        Err(message) => {
            // `--help` and `--version` come this way too, with exit code 0.
            let status = u8::try_from(message.exit_code()).unwrap_or(ERROR);
            return match print_usage(&message) {
                Ok(()) => ExitCode::from(status),
                Err(problem) if problem.kind() == io::ErrorKind::BrokenPipe => ExitCode::from(SUCCESS),
                Err(_) => ExitCode::from(ERROR),
            };
        }
    };
    let status = grasp_log::run(&arguments.global.log, PROGRAM, &command, || match run(&arguments) {
        Ok(()) => SUCCESS,
        Err(error) => report(&error, &arguments.command),
    });
    ExitCode::from(status)
}

/// The command line, and the name of its command.
fn parse() -> clap::error::Result<(Arguments, String)> {
    let matches = Arguments::command().try_get_matches()?;
    let command = matches.subcommand_name().unwrap_or_default().to_owned();
    Ok((Arguments::from_arg_matches(&matches)?, command))
}

/// Prints a usage error, or the help that was asked for. An argument with control characters, such
/// as the odd name of a file that begins with a dash, is escaped, which costs the colours.
fn print_usage(message: &clap::Error) -> io::Result<()> {
    let plain = message.render().to_string();
    let safe = printable_lines(&plain);
    if safe == plain { message.print() } else { io::stderr().write_all(safe.as_bytes()) }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.global.threads > 0 {
        rayon::ThreadPoolBuilder::new().num_threads(arguments.global.threads.into()).build_global()?;
    }
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

/// Prints on standard error what went wrong, once, and picks the exit status.
fn report(error: &anyhow::Error, command: &Command) -> u8 {
    if is_closed_pipe(error) {
        return SUCCESS;
    }
    let is_interrupted = error.chain().any(|cause| cause.is::<Interrupted>());
    let message =
        if is_interrupted { format!("stopped: {}", command.when_stopped()) } else { message(error.chain()) };
    tracing::error!(subject = PROGRAM[0], "{message}");
    if is_interrupted { interrupt::EXIT_STATUS } else { ERROR }
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
            Self::Experiment(_) => {
                "what is measured or built is kept; run the same command again to go on from there".to_owned()
            }
            _ => "nothing half-written is left; run the same command again".to_owned(),
        }
    }
}

/// A reader that has seen enough (`| head`) is no failure of ours.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
