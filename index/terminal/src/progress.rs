//! How far long work has come: a bar on a terminal, events in a log.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{self, IsTerminal as _};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::phase::Phase;
use crate::text;

/// How often an event says how far the work is, where no bar is drawn.
const EVERY: Duration = Duration::from_secs(10);
/// How many events back the pace is measured from.
const SAMPLES: usize = 6;

/// How progress is shown, if at all, by all work of a program.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    shown: Shown,
    /// What the events are about.
    program: &'static str,
    /// What events are counted from, so that many short pieces of work emit one every [`EVERY`] as
    /// well.
    since: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Bars,
    Events,
    Nothing,
}

impl Progress {
    /// Bars where standard error is a terminal for people, events whose subject is `program`
    /// elsewhere.
    #[must_use]
    pub fn new(program: &'static str, for_people: bool) -> Self {
        let shown = if for_people && io::stderr().is_terminal() { Shown::Bars } else { Shown::Events };
        Self { shown, program, since: Instant::now() }
    }

    /// Shows nothing.
    #[must_use]
    pub fn hidden() -> Self {
        Self { shown: Shown::Nothing, program: "", since: Instant::now() }
    }

    /// Work that is `doing` something to `len` things, which are called `unit` in the plural.
    #[must_use]
    pub fn bar(self, len: u64, doing: &'static str, unit: &'static str) -> Work {
        self.work(Some(len), doing, unit)
    }

    /// Work of which it is not known how long it takes.
    #[must_use]
    pub fn spinner(self, doing: &'static str) -> Work {
        self.work(None, doing, "")
    }

    fn work(self, len: Option<u64>, doing: &'static str, unit: &'static str) -> Work {
        let Self { shown, program, since } = self;
        let target = match shown {
            Shown::Bars => ProgressDrawTarget::stderr(),
            Shown::Events | Shown::Nothing => ProgressDrawTarget::hidden(),
        };
        let phase = (shown != Shown::Nothing).then(|| Arc::new(Phase::begin(program, doing, unit)));
        let bar = ProgressBar::with_draw_target(len, target);
        bar.set_message(doing);
        if shown == Shown::Bars {
            draw(&bar, len.is_some(), unit);
        }
        let logged = phase.clone().filter(|_| shown == Shown::Events);
        let log = logged.map(|phase| Log::start(phase, bar.clone(), since));
        Work { bar, log, phase, shown, program }
    }
}

/// Work in progress; what is shown of it ends when it is dropped.
#[derive(Debug)]
pub struct Work {
    bar: ProgressBar,
    log: Option<Log>,
    phase: Option<Arc<Phase>>,
    shown: Shown,
    program: &'static str,
}

impl Work {
    /// As many more things are done.
    pub fn inc(&self, done: u64) {
        self.bar.inc(done);
    }

    /// So many things are done in all.
    pub fn set_position(&self, done: u64) {
        self.bar.set_position(done);
    }

    /// Sets how many things there are to do.
    pub fn set_length(&self, len: u64) {
        self.bar.set_length(len);
    }

    /// What is being done now.
    pub fn set_message(&self, doing: impl Into<Cow<'static, str>>) {
        self.bar.set_message(doing);
    }

    /// The work goes on with its next phase; nothing new where that is what is done already.
    pub fn set_phase(&self, doing: &'static str) {
        if let Some(phase) = &self.phase {
            phase.enter(doing);
        }
    }

    /// Writes a line that stays, such as what was measured on the way.
    pub fn line(&self, line: &str) {
        match self.shown {
            Shown::Bars => self.bar.println(line),
            Shown::Events => tracing::info!(subject = self.program, "{line}"),
            Shown::Nothing => {}
        }
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        // In this order, so that no line follows what the program prints next.
        drop(self.log.take());
        let (done, total) = (self.bar.position(), self.bar.length());
        self.bar.finish_and_clear();
        if let Some(phase) = &self.phase {
            phase.end(done, total);
        }
    }
}

fn draw(bar: &ProgressBar, has_length: bool, unit: &str) {
    let template = if has_length {
        format!("{{msg:>12}} [{{bar:32}}] {{human_pos}}/{{human_len}} {unit}, {{pace}}{{eta}} left")
    } else {
        "{spinner} {msg}".to_owned()
    };
    let pace = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let _ = write!(out, "{}", pace(state.per_sec()));
    };
    // The template is ours and constant but for the unit; should it ever fail to parse, a plain bar
    // serves.
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style.with_key("pace", pace).progress_chars("=> "));
    }
    if !has_length {
        bar.enable_steady_tick(Duration::from_millis(120));
    }
}

/// The thread that emits events about one piece of work.
#[derive(Debug)]
struct Log {
    /// Never sent to: the thread ends when this is dropped.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Log {
    fn start(phase: Arc<Phase>, bar: ProgressBar, since: Instant) -> Self {
        let (end, ended) = channel::<()>();
        let write = move || {
            let started = Instant::now();
            // The pace of the last minute: work that begins with what is there already slows down
            // later.
            let mut samples = VecDeque::from([(started, 0)]);
            loop {
                let passed = since.elapsed();
                let lines = passed.as_secs() / EVERY.as_secs() + 1;
                let next = Duration::from_secs(lines * EVERY.as_secs()).saturating_sub(passed);
                if ended.recv_timeout(next) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
                let (now, done) = (Instant::now(), bar.position());
                let (then, before) = samples.front().copied().unwrap_or((started, 0));
                let state = State {
                    doing: bar.message(),
                    done,
                    len: bar.length(),
                    per_second: done.saturating_sub(before) as f64 / (now - then).as_secs_f64().max(1e-3),
                    elapsed: started.elapsed(),
                };
                samples.push_back((now, done));
                if samples.len() > SAMPLES {
                    samples.pop_front();
                }
                let unit = phase.unit();
                let counted = (!unit.is_empty()).then_some(unit);
                tracing::info!(
                    subject = phase.program(),
                    phase = phase.doing(),
                    done = counted.and(Some(state.done)),
                    total = counted.and(state.len),
                    unit = counted,
                    seconds = state.elapsed.as_secs_f64(),
                    "{}",
                    state.line(unit)
                );
            }
        };
        // Without a thread there are no events, which is no reason not to do the work.
        let thread = std::thread::Builder::new().name("progress".to_owned()).spawn(write).ok();
        Self { end: Some(end), thread }
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// How far a piece of work has come.
struct State {
    doing: String,
    done: u64,
    /// Unknown for work that counts nothing.
    len: Option<u64>,
    per_second: f64,
    elapsed: Duration,
}

impl State {
    fn line(&self, unit: &str) -> String {
        let Self { doing, done, .. } = self;
        let Some(len) = self.len.filter(|&len| len > 0) else {
            return format!("{doing}: {} so far", text::duration(self.elapsed));
        };
        let share = text::percent(*done as f64 / len as f64);
        let (counted, all) = (HumanCount(*done), HumanCount(len));
        let left = if self.per_second > 0.0 {
            // More seconds than that are more than anyone waits for.
            let seconds = (len.saturating_sub(*done) as f64 / self.per_second).min(1e9);
            format!("{}{} left", pace(self.per_second), text::duration(Duration::from_secs_f64(seconds)))
        } else {
            format!("{} so far", text::duration(self.elapsed))
        };
        format!("{doing}: {counted} of {all} {unit} ({share}), {left}")
    }
}

/// `1,203 a second, ` or, where each thing takes longer than that, `14 s each, `; nothing where it
/// is not known yet.
fn pace(per_second: f64) -> String {
    match per_second {
        _ if !per_second.is_finite() || per_second <= 0.0 => String::new(),
        _ if per_second >= 10.0 => format!("{} a second, ", HumanCount(per_second.round() as u64)),
        _ if per_second >= 1.0 => format!("{per_second:.1} a second, "),
        _ => format!("{} each, ", text::duration(Duration::from_secs_f64((1.0 / per_second).min(1e9)))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(done: u64, len: Option<u64>, per_second: f64) -> State {
        State { doing: "describing".to_owned(), done, len, per_second, elapsed: Duration::from_secs(20) }
    }

    #[test]
    fn a_line_says_what_how_far_how_fast_and_how_long_yet() {
        assert_eq!(
            state(12_345, Some(669_600), 1202.6).line("views"),
            "describing: 12,345 of 669,600 views (1.8 %), 1,203 a second, 9 min left"
        );
        assert_eq!(
            state(1, Some(12), 0.05).line("parts"),
            "describing: 1 of 12 parts (8.3 %), 20 s each, 4 min left"
        );
        assert_eq!(state(0, Some(12), 0.0).line("parts"), "describing: 0 of 12 parts (0 %), 20 s so far");
        assert_eq!(state(0, None, 0.0).line(""), "describing: 20 s so far");
    }

    #[test]
    fn work_ends_at_once_however_it_is_shown() {
        let started = Instant::now();
        for shown in [Shown::Nothing, Shown::Events] {
            let progress = Progress { shown, program: "test", since: Instant::now() };
            let work = progress.bar(2, "trying", "things");
            work.inc(1);
            work.line("tried one");
            drop(work);
            drop(progress.spinner("trying"));
        }
        assert!(started.elapsed() < Duration::from_secs(5));
    }
}
