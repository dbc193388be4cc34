//! Which messages are written.

use grasp_terminal::PHASE;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;

use crate::form::LogForm;

/// What all targets of our own begin with: other crates' events are about their own inside.
const OWN: &str = "grasp";

/// The least level that is written; each contains those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum LogLevel {
    /// What ended the work, or a request by a fault of the program.
    Error,
    /// What was left out, and what to doubt.
    Warn,
    /// What happens.
    #[default]
    Info,
    /// Each request of a service, too.
    Debug,
}

impl LogLevel {
    fn filter(self) -> LevelFilter {
        match self {
            Self::Error => LevelFilter::ERROR,
            Self::Warn => LevelFilter::WARN,
            Self::Info => LevelFilter::INFO,
            Self::Debug => LevelFilter::DEBUG,
        }
    }

    /// The events that are written in a form.
    pub(crate) fn targets(self, form: LogForm) -> Targets {
        let phases = match (form, self) {
            // A person is told by the bar, or by lines while it takes long.
            (LogForm::Text, Self::Info) => LevelFilter::WARN,
            _ => self.filter(),
        };
        Targets::new().with_target(OWN, self.filter()).with_target(PHASE, phases)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::Level;

    #[test]
    fn only_own_events_are_written_and_people_see_phases_from_debug_on() {
        for (form, level, sees_phases) in [
            (LogForm::Text, LogLevel::Info, false),
            (LogForm::Text, LogLevel::Debug, true),
            (LogForm::Json, LogLevel::Info, true),
            (LogForm::Json, LogLevel::Warn, false),
        ] {
            let targets = level.targets(form);
            assert_eq!(targets.would_enable(PHASE, &Level::INFO), sees_phases, "{form:?} {level:?}");
            assert!(targets.would_enable("grasp_serve::guard", &Level::WARN));
            assert!(!targets.would_enable("hyper::proto", &Level::ERROR));
        }
        assert!(!LogLevel::Info.targets(LogForm::Json).would_enable("grasp_serve::guard", &Level::DEBUG));
    }
}
