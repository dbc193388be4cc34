//! What the node says: to standard error in the form of ROS, and to `/rosout`.

use std::collections::HashSet;
use std::io::{self, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use grasp_terminal::text::printable;
use ros2_client::builtin_interfaces::Time;
use ros2_client::log::LogLevel;
use ros2_client::{NodeLoggingHandle, RosoutRaw as _};

/// How much a line matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    Debug,
    Info,
    Warn,
    Error,
    Fatal,
}

impl Level {
    /// A level by its name in any case.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let levels = [Self::Debug, Self::Info, Self::Warn, Self::Error, Self::Fatal];
        levels.into_iter().find(|level| level.name().eq_ignore_ascii_case(name))
    }

    fn name(self) -> &'static str {
        match self {
            Self::Debug => "DEBUG",
            Self::Info => "INFO",
            Self::Warn => "WARN",
            Self::Error => "ERROR",
            Self::Fatal => "FATAL",
        }
    }

    fn of_rosout(self) -> LogLevel {
        match self {
            Self::Debug => LogLevel::Debug,
            Self::Info => LogLevel::Info,
            Self::Warn => LogLevel::Warn,
            Self::Error => LogLevel::Error,
            Self::Fatal => LogLevel::Fatal,
        }
    }
}

/// How many kinds of things are warned of; beyond that, further kinds are not.
const MOST_WARNINGS: usize = 100;

/// The node's voice. It can be shared between threads.
pub(crate) struct Log {
    /// As ROS calls loggers: the node's full name with dots.
    name: String,
    least: Level,
    rosout: Option<NodeLoggingHandle>,
    said: Mutex<HashSet<String>>,
}

impl Log {
    /// The voice of a node by its full name. Lines below `least` are not said.
    pub(crate) fn new(node: &str, least: Level, rosout: Option<NodeLoggingHandle>) -> Self {
        let name = node.trim_start_matches('/').replace('/', ".");
        Self { name, least, rosout, said: Mutex::default() }
    }

    /// Says a line. What stands in it of others' names is made printable.
    pub(crate) fn say(&self, level: Level, line: &str) {
        if level < self.least {
            return;
        }
        let line = printable(line);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        // Nobody may be left to read it.
        let _ = writeln!(
            io::stderr(),
            "[{}] [{}.{:09}] [{}]: {line}",
            level.name(),
            now.as_secs(),
            now.subsec_nanos(),
            self.name
        );
        if let Some(rosout) = &self.rosout {
            rosout.rosout_raw(Time::now(), level.of_rosout(), &self.name, &line, file!(), "", line!());
        }
    }

    /// Says what goes well.
    pub(crate) fn info(&self, line: &str) {
        self.say(Level::Info, line);
    }

    /// Warns of something that may come with every picture: once of each kind, and of what is like
    /// it only for those who debug.
    pub(crate) fn warn(&self, kind: &str, line: &str) {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new = said.len() < MOST_WARNINGS && said.insert(kind.to_owned());
        drop(said);
        self.say(if is_new { Level::Warn } else { Level::Debug }, line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_names_in_any_case() {
        assert_eq!(Level::named("WARN"), Some(Level::Warn));
        assert_eq!(Level::named("debug"), Some(Level::Debug));
        assert_eq!(Level::named("loud"), None);
        assert!(Level::Debug < Level::Info && Level::Error < Level::Fatal);
    }

    #[test]
    fn a_kind_is_warned_of_once_and_not_without_end() {
        let log = Log::new("/arm/grasp", Level::Fatal, None);
        assert_eq!(log.name, "arm.grasp");
        for kind in 0..3 * MOST_WARNINGS {
            log.warn(&(kind / 2).to_string(), "again");
        }
        assert_eq!(log.said.lock().unwrap().len(), MOST_WARNINGS);
    }
}
