//! A progress bar on a terminal, silence elsewhere.

use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Whether bars are drawn at all: never without a terminal, so that logs stay readable.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    visible: bool,
}

impl Progress {
    /// Bars on standard error if it is a terminal and `wanted`.
    #[must_use]
    pub fn new(wanted: bool) -> Self {
        Self { visible: wanted && std::io::stderr().is_terminal() }
    }

    /// No bars at all.
    #[must_use]
    pub fn hidden() -> Self {
        Self { visible: false }
    }

    /// A bar from 0 to `len` that says `doing`, counts `unit`s and estimates the time left.
    #[must_use]
    pub fn bar(self, len: u64, doing: &'static str, unit: &str) -> ProgressBar {
        if !self.visible {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::with_draw_target(Some(len), ProgressDrawTarget::stderr());
        let template =
            format!("{{msg:>12}} [{{bar:32}}] {{human_pos}}/{{human_len}} {unit}, {{per_sec}}, {{eta}} left");
        // The template is ours and constant but for the unit; should it ever fail to parse, a plain bar serves.
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(doing);
        bar
    }

    /// A spinner for work whose length is not known.
    #[must_use]
    pub fn spinner(self, doing: &'static str) -> ProgressBar {
        if !self.visible {
            return ProgressBar::hidden();
        }
        let spinner = ProgressBar::new_spinner();
        spinner.set_message(doing);
        spinner.enable_steady_tick(Duration::from_millis(120));
        spinner
    }
}
