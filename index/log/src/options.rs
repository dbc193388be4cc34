//! How a program is asked to log, and the one place where that begins.

use std::io;

use tracing_subscriber::Layer as _;
use tracing_subscriber::layer::SubscriberExt as _;

use crate::form::LogForm;
use crate::level::LogLevel;
use crate::lines::Lines;
use crate::panic;

/// Under this heading help texts list the options that every subcommand has.
pub const GLOBAL: &str = "Global options";

/// How messages on standard error are written; the same options for each program.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct LogOptions {
    /// How messages are written on standard error: as lines for people, or as JSON, one object per
    /// line, which also says when each piece of work begins and ends.
    #[arg(long, global = true, help_heading = GLOBAL, value_name = "FORM", default_value = "text", hide_possible_values = true, value_parser = clap::value_parser!(LogForm))]
    log: LogForm,
    /// The least level of message that is written: error, warn, info or debug; `debug` also logs
    /// every request of a service.
    #[arg(long, global = true, help_heading = GLOBAL, value_name = "LEVEL", default_value = "info", hide_possible_values = true, value_parser = clap::value_parser!(LogLevel))]
    log_level: LogLevel,
}

impl LogOptions {
    /// How messages are written.
    #[must_use]
    pub fn form(&self) -> LogForm {
        self.log
    }

    /// Writes all events of this process from now on. Only the first call has an effect.
    pub(crate) fn start(&self) {
        let targets = self.log_level.targets(self.log);
        // Standard error may be closed: nobody is left to read that an event was not written.
        let layer = tracing_subscriber::fmt::layer().with_writer(io::stderr).log_internal_errors(false);
        let layer = match self.log {
            LogForm::Text => layer.event_format(Lines).boxed(),
            LogForm::Json => {
                panic::log();
                layer.json().flatten_event(true).with_current_span(false).with_span_list(false).boxed()
            }
        };
        let subscriber = tracing_subscriber::registry().with(layer.with_filter(targets));
        // A process that has a subscriber keeps it.
        let _ = tracing::subscriber::set_global_default(subscriber);
    }
}
