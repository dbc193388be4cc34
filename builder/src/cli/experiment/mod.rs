//! `grasp-builder experiment`: one file an experiment.

mod networks;
mod scale;
mod shapes;

use clap::Subcommand;
use grasp_program::Global;

use self::networks::Networks;
use self::scale::Scale;
use self::shapes::Shapes;

/// Vary something and measure what the search does, as a table and a picture.
#[derive(Debug, clap::Args)]
pub(crate) struct Experiment {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    Scale(Scale),
    Shapes(Shapes),
    Networks(Networks),
}

impl Experiment {
    /// Whether what was measured stays when it is stopped, so that it can be gone on with.
    pub(super) fn keeps_results(&self) -> bool {
        match self.name {
            Name::Scale(_) | Name::Shapes(_) => true,
            Name::Networks(_) => false,
        }
    }

    pub(crate) fn run(&self, global: &Global) -> anyhow::Result<()> {
        match &self.name {
            Name::Scale(scale) => scale.run(global),
            Name::Shapes(shapes) => shapes.run(global),
            Name::Networks(networks) => networks.run(global),
        }
    }
}
