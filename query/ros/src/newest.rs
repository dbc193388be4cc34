//! A place for one thing: what comes before it was taken takes the place of what waited.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Hands the newest of many things from one thread to another.
#[derive(Debug)]
pub(crate) struct Newest<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct State<T> {
    waiting: Option<T>,
    has_come: bool,
    dropped: u64,
    is_closed: bool,
}

impl<T> Newest<T> {
    /// An empty place.
    pub(crate) fn new() -> Self {
        let state = State { waiting: None, has_come: false, dropped: 0, is_closed: false };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Puts a thing there. What waited there is dropped, and counted.
    pub(crate) fn put(&self, thing: T) {
        let mut state = self.state();
        let older = state.waiting.replace(thing);
        state.dropped += u64::from(older.is_some());
        state.has_come = true;
        self.changed.notify_all();
    }

    /// Waits for a thing and takes it; `None` once the place is closed.
    pub(crate) fn take(&self) -> Option<T> {
        let waits = |state: &mut State<T>| state.waiting.is_none() && !state.is_closed;
        let waited = self.changed.wait_while(self.state(), waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.is_closed { None } else { state.waiting.take() }
    }

    /// Waits until the first thing has come or the place is closed, and says whether that took no
    /// longer than `limit`.
    pub(crate) fn has_come_within(&self, limit: Duration) -> bool {
        let waits = |state: &mut State<T>| !state.has_come && !state.is_closed;
        let waited = self.changed.wait_timeout_while(self.state(), limit, waits);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Lets whoever waits go, now and ever after.
    pub(crate) fn close(&self) {
        self.state().is_closed = true;
        self.changed.notify_all();
    }

    /// How many things were dropped for newer ones.
    pub(crate) fn dropped(&self) -> u64 {
        self.state().dropped
    }

    /// A thread that has panicked leaves a sound state: each change is a single one.
    fn state(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::thread;

    #[test]
    fn only_the_newest_is_taken_and_the_others_are_counted() {
        let place = Newest::new();
        (0..5).for_each(|number| place.put(number));
        assert_eq!((place.take(), place.dropped()), (Some(4), 4));
        place.put(5);
        assert_eq!((place.take(), place.dropped()), (Some(5), 4));
    }

    #[test]
    fn whoever_waits_is_woken_by_a_thing_and_by_the_end() {
        let place = Arc::new(Newest::new());
        let waiting = Arc::clone(&place);
        let taker = thread::spawn(move || (waiting.take(), waiting.take()));
        thread::sleep(Duration::from_millis(20));
        place.put(1);
        thread::sleep(Duration::from_millis(20));
        place.close();
        assert_eq!(taker.join().unwrap(), (Some(1), None));
    }

    #[test]
    fn whether_anything_comes_is_known_in_time() {
        let place = Newest::new();
        assert!(!place.has_come_within(Duration::from_millis(5)));
        place.put(1);
        assert_eq!(place.take(), Some(1));
        assert!(place.has_come_within(Duration::ZERO));
        let closed = Newest::<u32>::new();
        closed.close();
        assert!(closed.has_come_within(Duration::ZERO));
    }

    #[test]
    fn a_slow_taker_works_on_what_has_just_come() {
        let place = Arc::new(Newest::new());
        let waiting = Arc::clone(&place);
        let taker = thread::spawn(move || {
            std::iter::from_fn(|| {
                let number = waiting.take();
                thread::sleep(Duration::from_millis(20));
                number
            })
            .collect::<Vec<u32>>()
        });
        for number in 0..40 {
            place.put(number);
            thread::sleep(Duration::from_millis(5));
        }
        thread::sleep(Duration::from_millis(50));
        place.close();
        let taken = taker.join().unwrap();
        assert!(taken.is_sorted() && taken.last() == Some(&39), "{taken:?}");
        assert_eq!(taken.len() as u64 + place.dropped(), 40);
        assert!(place.dropped() > 10, "{taken:?}");
    }
}
