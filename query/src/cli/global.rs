//! Options that every subcommand understands.

use grasp_log::{LogForm, LogOptions};
use grasp_terminal::Progress;

/// Options that every subcommand understands.
#[derive(Debug, clap::Args)]
pub(super) struct Global {
    /// Worker threads; 0 takes one per core. The answers are the same for any number.
    #[arg(long, global = true, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub(super) threads: u16,
    /// Show no progress: no bar on a terminal, and no line every ten seconds on standard error
    /// elsewhere.
    #[arg(long, global = true)]
    no_progress: bool,
    #[command(flatten)]
    pub(super) log: LogOptions,
}

impl Global {
    /// How far long work has come.
    pub(super) fn progress(&self) -> Progress {
        if self.no_progress {
            return Progress::hidden();
        }
        Progress::new(env!("CARGO_PKG_NAME"), self.log.form() == LogForm::Text)
    }
}
