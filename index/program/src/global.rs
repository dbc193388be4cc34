//! Options that every subcommand understands.

use grasp_log::{GLOBAL, LogForm, LogOptions};
use grasp_terminal::Progress;

/// Options that every subcommand understands.
#[derive(Debug, clap::Args)]
pub struct Global {
    /// Worker threads; 0 takes one per core. The result is the same for any number.
    #[arg(long, global = true, help_heading = GLOBAL, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,
    /// Show no progress: no bar on a terminal, and no line every ten seconds on standard error
    /// elsewhere.
    #[arg(long, global = true, help_heading = GLOBAL)]
    no_progress: bool,
    #[command(flatten)]
    pub(crate) log: LogOptions,
    /// The program's name.
    #[arg(skip)]
    pub(crate) program: &'static str,
}

impl Global {
    /// How far long work has come.
    #[must_use]
    pub fn progress(&self) -> Progress {
        if self.no_progress {
            return Progress::hidden();
        }
        Progress::new(self.program, self.log.form() == LogForm::Text)
    }

    /// Takes as many threads as were asked for.
    pub(crate) fn start_threads(&self) -> anyhow::Result<()> {
        if self.threads > 0 {
            rayon::ThreadPoolBuilder::new().num_threads(self.threads.into()).build_global()?;
        }
        Ok(())
    }
}
