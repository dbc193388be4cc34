//! The service between requests: what it allows, holds and counts, and how a request passes through
//! it.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::Request;
use axum::response::Response;
use tokio::sync::Notify;
use tokio::time::Instant;

use crate::arrival;
use crate::budget::Budget;
use crate::current::{Current, LOST, Refresh, Served};
use crate::gate::{Gate, Place};
use crate::metrics::Metrics;
use crate::problem::Problem;
use crate::unusable::UnusableIndex;
use crate::wire::Token;

/// What the service allows.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The index's file.
    pub index: PathBuf,
    /// Where it has at most this many bytes, read it into memory instead of mapping it: it is then
    /// served on while another file is copied over it.
    pub most_read: u64,
    /// Requests that are worked on at a time.
    pub workers: usize,
    /// Requests that may wait besides.
    pub queue: usize,
    /// The most bytes of a request's body.
    pub most_bytes: usize,
    /// The most pixels of a picture.
    pub most_pixels: u64,
    /// How long a request may take to arrive, and how long to be answered.
    pub timeout: Duration,
    /// How often to look whether another index lies at the path.
    pub poll: Duration,
    /// How long requests under way may take when the program ends.
    pub drain: Duration,
    /// What askers must show; without it, the service answers under names of this machine alone.
    pub token: Option<Token>,
    /// Whether the page shall lead to the quiz.
    pub has_quiz: bool,
}

/// What whoever runs the service should know.
#[derive(Clone, Debug)]
pub enum Event {
    /// The index is open, for the first time or again, as this generation.
    Serving(u64),
    /// The file at the index's path cannot be used; the one before is served.
    Rejected(Arc<UnusableIndex>),
    /// The file that was served has been overwritten or truncated: requests are turned away until
    /// it is whole.
    Overwritten,
    /// The file at the index's path cannot be used, and the one before is lost.
    Unavailable(Arc<UnusableIndex>),
}

/// How the service ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every request that was let in was answered.
    Drained,
    /// So many were not, when the time was over.
    CutShort(usize),
}

/// The service between requests.
#[derive(Debug)]
pub struct Service {
    pub(crate) settings: Settings,
    pub(crate) current: Current,
    pub(crate) budget: Arc<Budget>,
    arriving: AtomicUsize,
    pub(crate) gate: Gate,
    pub(crate) metrics: Metrics,
    draining: AtomicBool,
    reload: Notify,
    /// A request has noticed that the index is lost.
    pub(crate) lost: Notify,
}

/// How soon to look again where the index is lost or another is on its way.
const SOON: Duration = Duration::from_millis(50);

/// The service, as requests share it.
pub(crate) type Shared = Arc<Service>;

/// How many bodies of the largest size may be in memory at a time.
const BODIES: usize = 4;

impl Service {
    /// A service that has not opened its index yet.
    pub fn new(settings: Settings) -> Arc<Self> {
        Arc::new(Self {
            current: Current::new(settings.index.clone(), settings.most_read),
            budget: Arc::new(Budget::new(settings.most_bytes.saturating_mul(BODIES))),
            arriving: AtomicUsize::new(0),
            gate: Gate::new(settings.workers, settings.queue),
            metrics: Metrics::default(),
            draining: AtomicBool::new(false),
            reload: Notify::new(),
            lost: Notify::new(),
            settings,
        })
    }

    /// Opens the index anew, whether or not another file lies at its path.
    pub fn reload(&self) {
        self.reload.notify_one();
    }

    /// Waits until `deadline` for the requests that were let in; no other is, and `/readyz` says
    /// so.
    pub(crate) async fn drain(&self, deadline: Instant) -> Ended {
        self.draining.store(true, Ordering::SeqCst);
        loop {
            let left = self.arriving() + self.gate.inside();
            if left == 0 {
                return Ended::Drained;
            }
            if Instant::now() >= deadline {
                return Ended::CutShort(left);
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    pub(crate) async fn refresh(self: &Arc<Self>, forced: bool) -> Option<Refresh> {
        let service = Arc::clone(self);
        tokio::task::spawn_blocking(move || service.current.refresh(forced)).await.ok()
    }

    /// Looks for another index now and then, and when it is told to.
    pub(crate) async fn watch(self: Arc<Self>, report: impl Fn(Event)) {
        let mut pause = self.settings.poll;
        loop {
            let forced = tokio::select! {
                () = tokio::time::sleep(pause) => false,
                () = self.lost.notified() => false,
                () = self.reload.notified() => true,
            };
            let refreshed = self.refresh(forced).await;
            let is_lost = self.current.is_lost();
            pause = match refreshed {
                Some(Refresh::Incomplete) => self.settings.poll.min(SOON),
                _ if is_lost => self.settings.poll.min(SOON),
                _ => self.settings.poll,
            };
            match refreshed {
                Some(Refresh::Replaced(generation)) => report(Event::Serving(generation)),
                Some(Refresh::Failed(why)) if is_lost => report(Event::Unavailable(why)),
                Some(Refresh::Failed(why)) => report(Event::Rejected(why)),
                Some(Refresh::Overwritten) => report(Event::Overwritten),
                Some(Refresh::Unchanged | Refresh::Incomplete) => {}
                None => self.metrics.panicked(),
            }
        }
    }

    pub(crate) fn is_draining(&self) -> bool {
        self.draining.load(Ordering::SeqCst)
    }

    /// The index to answer by.
    pub(crate) fn served(&self) -> Result<Arc<Served>, Problem> {
        let served = self.current.get().ok_or_else(|| Problem::not_ready("has not opened its index yet"))?;
        self.check(&served)?;
        Ok(served)
    }

    /// Whether what the index has said may be believed: asked after each answer, before it is sent.
    pub(crate) fn check(&self, served: &Served) -> Result<(), Problem> {
        if served.is_lost() {
            self.lost.notify_one();
            return Err(Problem::not_ready(LOST));
        }
        Ok(())
    }

    /// Requests whose bodies are under way.
    pub(crate) fn arriving(&self) -> usize {
        self.arriving.load(Ordering::SeqCst)
    }

    /// Reads what a request carries, and then lets it in: what is not whole takes nobody's place.
    pub(crate) async fn receive(&self, request: Request) -> Result<(Bytes, Place), Problem> {
        // Counted before it is asked: what is let in is waited for.
        let _arriving = Arriving::new(&self.arriving);
        if self.is_draining() {
            return Err(Problem::not_ready("is about to end"));
        }
        if self.gate.is_full() {
            return Err(Problem::busy());
        }
        let body = arrival::read(request.into_body(), self.settings.most_bytes, &self.budget);
        let time = self.settings.timeout;
        let body = tokio::time::timeout(time, body).await.map_err(|_| Problem::late(time))??;
        let place = self.gate.enter().ok_or_else(Problem::busy)?;
        Ok((body, place))
    }

    /// Answers on a thread that may block, in the time that there is.
    pub(crate) async fn work(
        &self,
        place: Place,
        work: impl FnOnce() -> Result<Response, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let answer = tokio::time::timeout(self.settings.timeout, self.gate.run(place, work)).await;
        answer.map_err(|_| Problem::too_slow())?.unwrap_or_else(|_| {
            self.metrics.panicked();
            Err(Problem::lost())
        })
    }
}

/// Counts a request whose body is under way.
#[derive(Debug)]
struct Arriving<'a>(&'a AtomicUsize);

impl<'a> Arriving<'a> {
    fn new(count: &'a AtomicUsize) -> Self {
        count.fetch_add(1, Ordering::SeqCst);
        Self(count)
    }
}

impl Drop for Arriving<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}
