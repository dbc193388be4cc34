//! When pieces of work begin and end, as events.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use indicatif::HumanCount;

use crate::text::duration;

/// The target of events that say when a piece of work begins and ends.
pub const PHASE: &str = "grasp::phase";

/// A piece of work, from its beginning to its end.
#[derive(Debug)]
pub(crate) struct Phase {
    program: &'static str,
    /// What is done to the things that are counted, and since when.
    now: Mutex<(&'static str, Instant)>,
    /// What the things are called in the plural; nothing where none are counted.
    unit: &'static str,
}

impl Phase {
    pub(crate) fn begin(program: &'static str, doing: &'static str, unit: &'static str) -> Self {
        began(program, doing);
        Self { program, now: Mutex::new((doing, Instant::now())), unit }
    }

    pub(crate) fn program(&self) -> &'static str {
        self.program
    }

    pub(crate) fn unit(&self) -> &'static str {
        self.unit
    }

    /// What is done now.
    pub(crate) fn doing(&self) -> &'static str {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).0
    }

    /// The work goes on with something else, unless that is what is done already.
    pub(crate) fn enter(&self, doing: &'static str) {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        if now.0 != doing {
            self.ended(*now, None);
            began(self.program, doing);
            *now = (doing, Instant::now());
        }
    }

    /// The work has ended, `done` things of `total`, where that is known.
    pub(crate) fn end(&self, done: u64, total: Option<u64>) {
        let now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let counted = (!self.unit.is_empty()).then_some((done, total.unwrap_or(done)));
        self.ended(*now, counted);
    }

    fn ended(&self, (doing, since): (&'static str, Instant), counted: Option<(u64, u64)>) {
        let (subject, unit) = (self.program, self.unit);
        let took = since.elapsed();
        let (time, seconds) = (duration(took), took.as_secs_f64());
        match counted {
            None => {
                tracing::info!(target: PHASE, subject, state = "ended", phase = doing, seconds, "{doing}: {time}")
            }
            Some((done, total)) => {
                let all = if done == total { String::new() } else { format!(" of {}", HumanCount(total)) };
                tracing::info!(
                    target: PHASE, subject, state = "ended", phase = doing, done, total, unit, seconds,
                    "{doing}: {}{all} {unit} in {time}", HumanCount(done)
                );
            }
        }
    }
}

fn began(subject: &'static str, doing: &'static str) {
    tracing::info!(target: PHASE, subject, state = "began", phase = doing, "{doing} begins");
}
