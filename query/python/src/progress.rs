//! Work on another thread that Python watches: it hears how far the work is, and may stop it.

use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, channel, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

/// How long Ctrl-C waits at most while nothing is reported.
const PATIENCE: Duration = Duration::from_millis(100);

/// Where the work reports to.
pub(crate) struct Progress {
    report: SyncSender<(&'static str, f64)>,
    answer: Receiver<ControlFlow<()>>,
}

impl Progress {
    /// Says what share (0 to 1) of a phase is done, and learns whether to go on.
    pub(crate) fn report(&self, phase: &'static str, share: f64) -> ControlFlow<()> {
        let heard = self.report.send((phase, share)).is_ok();
        let answer = if heard { self.answer.recv().ok() } else { None };
        answer.unwrap_or(ControlFlow::Break(()))
    }
}

/// Does `work` on a thread of its own. Meanwhile this thread, which may be Python's first one and
/// so the only one that hears of Ctrl-C, calls `callback` with each report; where that raises, the
/// work is asked to stop, and what was raised is returned.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<&Py<PyAny>>,
    work: impl FnOnce(Progress) -> T + Send,
) -> PyResult<T> {
    py.detach(|| {
        let (report, reports) = sync_channel(0);
        let (answers, answer) = channel();
        thread::scope(|scope| {
            let worker =
                thread::Builder::new().spawn_scoped(scope, move || work(Progress { report, answer }))?;
            let mut raised = None;
            loop {
                let heard = reports.recv_timeout(PATIENCE);
                if heard == Err(RecvTimeoutError::Disconnected) {
                    break;
                }
                if raised.is_none() {
                    raised = Python::attach(|py| tell(py, callback, heard.ok())).err();
                }
                if heard.is_ok() {
                    let go_on = raised.is_none();
                    let _ =
                        answers.send(if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) });
                }
            }
            let done = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            raised.map_or(Ok(done), Err)
        })
    })
}

fn tell(py: Python<'_>, callback: Option<&Py<PyAny>>, heard: Option<(&'static str, f64)>) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(callback), Some(report)) = (callback, heard) {
        callback.call1(py, report)?;
    }
    Ok(())
}
