//! The command line: one file or folder a subcommand, and what several share in files of their own.

mod answering;
mod effort;
mod evaluate;
mod experiment;
mod figures;
mod index_file;
mod labelled;
#[cfg(feature = "serve")]
mod listen;
mod name_or_file;
mod options;
mod outputs;
mod pictures;
#[cfg(feature = "serve")]
mod quiz;
mod recognise;
mod robot;
mod search;
mod selection;
#[cfg(feature = "serve")]
mod serve;
#[cfg(feature = "serve")]
mod signals;
#[cfg(feature = "simulate")]
mod simulate;
#[cfg(feature = "simulate")]
mod simulated_hand;
#[cfg(feature = "serve")]
mod token;
mod watch;

use std::process::ExitCode;

use anyhow::Context as _;
use clap::{CommandFactory as _, Parser, Subcommand};
use grasp_program::status::SUCCESS;
use grasp_program::{Completions, Global, Man};

/// Name and version.
const PROGRAM: [&str; 2] = [env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")];

/// Recognises which of six grasps a hand in a picture makes, and how the hand is turned toward the
/// camera.
#[derive(Debug, Parser)]
#[command(name = "grasp-query", version, propagate_version = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  grasp-builder build --out grasp.idx                    the index that pictures are recognised by
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg
                                                         which grasp is this?
  grasp-query recognise --json tests/pictures/camera     a JSON record for each picture of a folder
  grasp-query recognise tests/pictures/camera/09-pinch.jpg --explain why.png
                                                         draw how the answer came about
  grasp-query recognise tests/pictures/camera/01-large-diameter.jpg --robot barrett \\
    --object query/data/objects/bottle.toml --camera query/data/objects/camera.toml
                                                         how a robot hand grasps alike
  cat tests/pictures/camera/*.jpg | grasp-query recognise -
                                                         every frame of a stream
  grasp-query watch tests/pictures/camera --out seen.mjpg
                                                         answers drawn into the frames of a video
  grasp-query simulate --grasp wrap                      does a robot hand hold it, by physics?
  grasp-query evaluate tests/pictures/labels.csv         score labelled pictures
  grasp-query experiment paper tests/pictures/labels.csv --out results
                                                         the paper's experiments over them
  grasp-query quiz tests/pictures/labels.csv             how well does a person do on them?
  grasp-builder queries --out q.npy                      raw descriptors, to search for
  grasp-query search q.npy --out ids.npy                 the nearest entries of raw descriptors
  grasp-query serve                                      answer over HTTP, with a page at /

The files are in the source tree; your own work the same way.

Exit status: 0 all recognised, 1 some picture was rejected or unknown or a strategy is not feasible,
2 an error.";

#[derive(Debug, Subcommand)]
enum Command {
    #[command(visible_alias = "recognize")]
    Recognise(Box<recognise::Recognise>),
    Watch(Box<watch::Watch>),
    Evaluate(evaluate::Evaluate),
    Experiment(experiment::Experiment),
    #[cfg(feature = "serve")]
    Quiz(quiz::Quizzing),
    Search(search::Search),
    #[cfg(feature = "simulate")]
    Simulate(simulate::Simulate),
    #[cfg(feature = "serve")]
    Serve(serve::Serve),
    Completions(Completions),
    Man(Man),
}

/// Parses the command line, runs it and turns the outcome into an exit status.
#[must_use]
pub fn main() -> ExitCode {
    grasp_program::start(PROGRAM, |arguments: &mut Arguments| &mut arguments.global, run)
}

fn run(arguments: &Arguments) -> anyhow::Result<u8> {
    // Every command asks its index, after the work, whether it was overwritten meanwhile: see
    // `grasp_answer::index_file::check`.
    grasp_index::guard_against_truncation().context("cannot listen for faults")?;
    match &arguments.command {
        Command::Recognise(command) => command.run(),
        Command::Watch(command) => command.run(),
        Command::Evaluate(command) => command.run(&arguments.global),
        Command::Experiment(command) => command.run(&arguments.global),
        #[cfg(feature = "serve")]
        Command::Quiz(command) => command.run(),
        Command::Search(command) => command.run(&arguments.global),
        #[cfg(feature = "simulate")]
        Command::Simulate(command) => command.run(),
        #[cfg(feature = "serve")]
        Command::Serve(command) => command.run(&arguments.global),
        Command::Completions(command) => command.run(Arguments::command()).map(|()| SUCCESS),
        Command::Man(command) => command.run(Arguments::command()).map(|()| SUCCESS),
    }
}
