//! Options that every subcommand understands.

use grasp_terminal::Progress;

/// Options that every subcommand understands.
#[derive(Debug, clap::Args)]
pub(crate) struct Global {
    /// Worker threads; 0 takes one per core. The result is the same for any number.
    #[arg(long, global = true, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub(super) threads: u16,
    /// Show no progress: no bar on a terminal, and no line every ten seconds on standard error
    /// elsewhere.
    #[arg(long, global = true)]
    no_progress: bool,
}

impl Global {
    /// How far long work has come.
    pub(crate) fn progress(&self) -> Progress {
        Progress::new("grasp-builder", !self.no_progress)
    }
}
