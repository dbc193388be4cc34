//! `grasp-query experiment`: one file an experiment.

mod opening;
mod paper;
mod report;
#[cfg(feature = "simulate")]
mod robot;
mod sequence;
mod shapes;
mod steadiness;
mod trust;
mod unknown;

use clap::Subcommand;
use grasp_program::Global;

use self::opening::OpeningArguments;
use self::paper::PaperArguments;
use self::report::ReportArguments;
#[cfg(feature = "simulate")]
use self::robot::{ImitationArguments, RobustnessArguments};
use self::sequence::SequenceArguments;
use self::shapes::ShapesArguments;
use self::steadiness::SteadinessArguments;
use self::trust::TrustArguments;
use self::unknown::UnknownArguments;

/// Repeat an experiment, over labelled pictures or in simulation, as tables and drawings.
#[derive(Debug, clap::Args)]
pub(super) struct Experiment {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    Paper(PaperArguments),
    Shapes(ShapesArguments),
    Unknown(UnknownArguments),
    Trust(TrustArguments),
    Opening(OpeningArguments),
    #[cfg(feature = "simulate")]
    Robustness(RobustnessArguments),
    #[cfg(feature = "simulate")]
    Imitation(ImitationArguments),
    Sequence(SequenceArguments),
    Steadiness(SteadinessArguments),
    Report(ReportArguments),
}

impl Experiment {
    pub(super) fn run(&self, global: &Global) -> anyhow::Result<u8> {
        match &self.name {
            Name::Paper(paper) => paper.run(global),
            Name::Shapes(shapes) => shapes.run(global),
            Name::Unknown(unknown) => unknown.run(global),
            Name::Trust(trust) => trust.run(global),
            Name::Opening(opening) => opening.run(global),
            #[cfg(feature = "simulate")]
            Name::Robustness(robustness) => robustness.run(global),
            #[cfg(feature = "simulate")]
            Name::Imitation(imitation) => imitation.run(global),
            Name::Sequence(sequence) => sequence.run(global),
            Name::Steadiness(steadiness) => steadiness.run(global),
            Name::Report(report) => report.run(global),
        }
    }
}
