//! Which requests are worked on: as many as there are workers, and a few that wait; the rest is
//! turned away. A request enters when its body is whole, so that none that is slow to come takes
//! the place of one that is there.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Bounds what the processors do.
#[derive(Debug)]
pub(super) struct Gate {
    /// Requests that were let in.
    places: Arc<Semaphore>,
    /// Those of them that are worked on.
    workers: Arc<Semaphore>,
    all: usize,
}

/// A request that was let in, until it is dropped.
#[derive(Debug)]
pub(super) struct Place(#[expect(dead_code, reason = "held, not read")] OwnedSemaphorePermit);

/// The work panicked, or the program ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aborted;

impl Gate {
    /// At most `workers` at work and `queue` that wait.
    pub(super) fn new(workers: usize, queue: usize) -> Self {
        // No machine holds more requests, and a semaphore has a maximum of its own.
        let workers = workers.clamp(1, 4096);
        let all = workers + queue.min(65_536);
        Self { places: Arc::new(Semaphore::new(all)), workers: Arc::new(Semaphore::new(workers)), all }
    }

    /// A place, or `None` where all are taken.
    pub(super) fn enter(&self) -> Option<Place> {
        Arc::clone(&self.places).try_acquire_owned().ok().map(Place)
    }

    /// Whether one who came now would be turned away.
    pub(super) fn is_full(&self) -> bool {
        self.places.available_permits() == 0
    }

    /// Requests that were let in and are not answered.
    pub(super) fn inside(&self) -> usize {
        self.all - self.places.available_permits()
    }

    /// Does the work on a thread that may block, as soon as a worker is free. Where this future is
    /// dropped, work that has begun goes on, and its place stays taken: the bound holds whatever
    /// the asker does.
    pub(super) async fn run<T: Send + 'static>(
        &self,
        place: Place,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Aborted> {
        let worker = Arc::clone(&self.workers).acquire_owned().await.map_err(|_| Aborted)?;
        let work = move || {
            let _held = (worker, place);
            work()
        };
        tokio::task::spawn_blocking(work).await.map_err(|_| Aborted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn no_more_are_let_in_than_there_are_places_and_a_panic_gives_its_place_back() {
        let gate = Arc::new(Gate::new(1, 1));
        let (go, wait) = mpsc::channel::<()>();
        let first = gate.enter().unwrap();
        let running = tokio::spawn({
            let gate = Arc::clone(&gate);
            async move { gate.run(first, move || wait.recv().is_ok()).await }
        });
        let second = gate.enter().unwrap();
        assert!(gate.enter().is_none());
        assert_eq!(gate.inside(), 2);
        go.send(()).unwrap();
        assert!(running.await.unwrap().unwrap());
        assert!(gate.run(second, || panic!("a test's own panic")).await.is_err());
        assert_eq!(gate.inside(), 0);
        let third = gate.enter().unwrap();
        assert_eq!(gate.run(third, || 7).await.unwrap(), 7);
    }
}
