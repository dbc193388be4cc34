//! The bytes of large bodies, bounded over all requests. A body reserves what it will hold before
//! it is read; where too much is reserved, the smallest waits first in line, and bodies that have
//! stopped coming make room for those that come.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::Instant;

/// How long a body may wait for room.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long a body may make no progress while another one waits for room.
const STALLED: Duration = Duration::from_millis(300);
/// How often the first in line looks for bodies that have stalled.
const LOOK: Duration = Duration::from_millis(50);

/// Bytes that bodies may hold.
#[derive(Debug)]
pub(super) struct Budget {
    most: usize,
    state: Mutex<State>,
    /// Something was returned, or the line has changed.
    changed: Notify,
}

#[derive(Debug)]
struct State {
    free: usize,
    next: u64,
    held: HashMap<u64, Held>,
    /// Who waits, the smallest first and among equals the earliest.
    line: BTreeSet<(usize, u64)>,
}

#[derive(Debug)]
struct Held {
    bytes: usize,
    /// When it last made progress; `None` once the whole body is there.
    moved: Option<Instant>,
    eviction: Arc<Notify>,
    is_evicted: bool,
}

/// There was no room for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exhausted;

/// Bytes of the budget that one body has; returned when this is dropped.
#[derive(Debug)]
pub(super) struct Reservation {
    budget: Arc<Budget>,
    id: u64,
    eviction: Arc<Notify>,
}

impl Budget {
    pub(super) fn new(most: usize) -> Self {
        let state = State { free: most, next: 0, held: HashMap::new(), line: BTreeSet::new() };
        Self { most, state: Mutex::new(state), changed: Notify::new() }
    }

    /// Bytes that are reserved.
    pub(super) fn reserved(&self) -> usize {
        self.most - self.state().free
    }

    /// Reserves `bytes` as soon as there is room.
    ///
    /// # Errors
    /// [`Exhausted`] where there is none for [`PATIENCE`].
    pub(super) async fn reserve(self: &Arc<Self>, bytes: usize) -> Result<Reservation, Exhausted> {
        let waiting = Waiting::new(self, bytes.min(self.most));
        let granted = async {
            loop {
                let changed = self.changed.notified();
                if let Some(reservation) = waiting.try_reserve() {
                    return reservation;
                }
                // What stalls notifies nobody.
                let _ = tokio::time::timeout(LOOK, changed).await;
            }
        };
        tokio::time::timeout(PATIENCE, granted).await.map_err(|_| Exhausted)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Every change is made in one step that cannot panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Evicts stalled bodies, the largest first, until `bytes` will be free.
    fn make_room(&mut self, bytes: usize) {
        let coming: usize = self.held.values().filter(|held| held.is_evicted).map(|held| held.bytes).sum();
        let mut missing = bytes.saturating_sub(self.free + coming);
        let is_stalled =
            |held: &Held| !held.is_evicted && held.moved.is_some_and(|moved| moved.elapsed() >= STALLED);
        let mut stalled: Vec<&mut Held> = self.held.values_mut().filter(|held| is_stalled(held)).collect();
        stalled.sort_by_key(|held| (std::cmp::Reverse(held.bytes), held.moved));
        for held in stalled {
            if missing == 0 {
                return;
            }
            held.is_evicted = true;
            held.eviction.notify_one();
            missing = missing.saturating_sub(held.bytes);
        }
    }
}

/// A place in the line, given up when this is dropped.
#[derive(Debug)]
struct Waiting<'a> {
    budget: &'a Arc<Budget>,
    bytes: usize,
    id: u64,
}

impl<'a> Waiting<'a> {
    fn new(budget: &'a Arc<Budget>, bytes: usize) -> Self {
        let mut state = budget.state();
        let id = state.next;
        state.next += 1;
        state.line.insert((bytes, id));
        Self { budget, bytes, id }
    }

    fn try_reserve(&self) -> Option<Reservation> {
        let &Self { budget, bytes, id } = self;
        let mut state = budget.state();
        if state.line.first() != Some(&(bytes, id)) {
            return None;
        }
        let Some(free) = state.free.checked_sub(bytes) else {
            state.make_room(bytes);
            return None;
        };
        state.free = free;
        state.line.remove(&(bytes, id));
        let eviction = Arc::new(Notify::new());
        let held =
            Held { bytes, moved: Some(Instant::now()), eviction: Arc::clone(&eviction), is_evicted: false };
        state.held.insert(id, held);
        Some(Reservation { budget: Arc::clone(budget), id, eviction })
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.budget.state().line.remove(&(self.bytes, self.id));
        self.budget.changed.notify_waiters();
    }
}

impl Reservation {
    /// The body comes.
    pub(super) fn progressed(&self) {
        if let Some(held) = self.budget.state().held.get_mut(&self.id) {
            held.moved = Some(Instant::now());
        }
    }

    /// The whole body is there: it is kept from now on, whoever waits.
    pub(super) fn arrived(&self) {
        if let Some(held) = self.budget.state().held.get_mut(&self.id) {
            held.moved = None;
            held.is_evicted = false;
        }
    }

    /// Ready when the body has stalled while others wait: its reader drops the reservation then.
    pub(super) async fn evicted(&self) {
        self.eviction.notified().await;
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let mut state = self.budget.state();
        if let Some(held) = state.held.remove(&self.id) {
            state.free += held.bytes;
        }
        drop(state);
        self.budget.changed.notify_waiters();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn the_smallest_is_let_in_first_and_everything_is_returned() {
        let budget = Arc::new(Budget::new(100));
        let first = budget.reserve(90).await.unwrap();
        first.arrived();
        let order = Arc::new(Mutex::new(Vec::new()));
        let waiting: Vec<_> = [80, 30, 60]
            .into_iter()
            .map(|bytes| {
                let (budget, order) = (Arc::clone(&budget), Arc::clone(&order));
                tokio::spawn(async move {
                    let reservation = budget.reserve(bytes).await.unwrap();
                    reservation.arrived();
                    order.lock().unwrap().push(bytes);
                    tokio::time::sleep(Duration::from_millis(100)).await;
                })
            })
            .collect();
        tokio::time::sleep(Duration::from_secs(1)).await;
        assert_eq!(budget.reserved(), 90);
        drop(first);
        for task in waiting {
            task.await.unwrap();
        }
        assert_eq!(*order.lock().unwrap(), [30, 60, 80]);
        assert_eq!(budget.reserved(), 0);
        assert!(budget.state().line.is_empty());
    }

    #[tokio::test(start_paused = true)]
    async fn what_stalls_makes_room_and_what_is_whole_stays() {
        let budget = Arc::new(Budget::new(100));
        let (whole, stalled) = (budget.reserve(50).await.unwrap(), budget.reserve(50).await.unwrap());
        whole.arrived();
        let reader = tokio::spawn(async move { stalled.evicted().await });
        let started = Instant::now();
        let next = budget.reserve(40).await.unwrap();
        assert!(started.elapsed() >= STALLED);
        reader.await.unwrap();
        next.arrived();
        let started = Instant::now();
        assert_eq!(budget.reserve(60).await.err(), Some(Exhausted));
        assert!(started.elapsed() >= PATIENCE);
        // One who gave up waiting stands in nobody's way.
        assert!(budget.state().line.is_empty());
        budget.reserve(10).await.unwrap();
        drop((whole, next));
        assert_eq!(budget.reserved(), 0);
    }

    #[tokio::test(start_paused = true)]
    async fn what_moves_is_not_evicted() {
        let budget = Arc::new(Budget::new(100));
        let moving = budget.reserve(100).await.unwrap();
        let next = tokio::spawn({
            let budget = Arc::clone(&budget);
            async move { budget.reserve(1).await.err() }
        });
        let gone = async {
            loop {
                tokio::time::sleep(Duration::from_millis(100)).await;
                moving.progressed();
            }
        };
        tokio::select! {
            () = gone => {}
            () = moving.evicted() => panic!("evicted"),
            refused = next => assert_eq!(refused.unwrap(), Some(Exhausted)),
        }
    }
}
