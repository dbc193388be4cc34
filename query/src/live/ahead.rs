//! Frames, read on a thread of their own.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::source::{EncodedFrame, Source, SourceError};

/// Frames that wait to be taken, where none may be left out.
const AHEAD: usize = 2;
/// How often a flag is looked at while no frame comes.
const LOOK: Duration = Duration::from_millis(50);

/// What becomes of frames that come faster than they are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// None is left out: the source waits.
    All,
    /// The newest is kept, and those before it are dropped, as a camera's have to be.
    Newest,
}

/// A frame.
#[derive(Debug)]
pub struct Frame {
    /// Its number in the source, from 0; those that were dropped are counted.
    pub number: u64,
    /// The encoded picture, or why there is none.
    pub given: Result<EncodedFrame, SourceError>,
}

/// A source that is read ahead.
#[derive(Debug)]
pub struct Ahead {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    frames: VecDeque<Frame>,
    dropped: u64,
    has_ended: bool,
    /// It ended by a panic.
    has_panicked: bool,
    /// Nobody takes frames any more.
    is_closed: bool,
}

impl Shared {
    /// A panic while the lock was held leaves nothing half done.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Ahead {
    /// Begins to read.
    ///
    /// # Errors
    /// Where no thread can be started.
    pub fn start(source: Source, keep: Keep) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let its = Arc::clone(&shared);
        thread::Builder::new().name("frames".into()).spawn(move || read(source, keep, &its))?;
        Ok(Self { shared })
    }

    /// The next frame; `None` after the last, and once `stop` is set.
    pub fn next_frame(&self, stop: &AtomicBool) -> Option<Frame> {
        let mut state = self.shared.lock();
        loop {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            if let Some(frame) = state.frames.pop_front() {
                self.shared.changed.notify_all();
                return Some(frame);
            }
            if state.has_ended {
                // What is no end must not pass for one.
                assert!(!state.has_panicked, "the thread that reads frames panicked");
                return None;
            }
            let waited = self.shared.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// How many frames were dropped so far.
    pub fn dropped(&self) -> u64 {
        self.shared.lock().dropped
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.changed.notify_all();
    }
}

/// Says that no frame comes any more, however the reading ended.
struct EndOnDrop<'a>(&'a Shared);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        (state.has_ended, state.has_panicked) = (true, thread::panicking());
        drop(state);
        self.0.changed.notify_all();
    }
}

/// Reads to the end.
fn read(mut source: Source, keep: Keep, shared: &Shared) {
    let _end = EndOnDrop(shared);
    let mut number = 0;
    while let Some(given) = source.next_frame() {
        let mut state = shared.lock();
        while keep == Keep::All && state.frames.len() >= AHEAD && !state.is_closed {
            state = shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.is_closed {
            return;
        }
        // What went wrong is told, however much comes behind it.
        if keep == Keep::Newest {
            let before = state.frames.len();
            state.frames.retain(|frame| frame.given.is_err());
            state.dropped += (before - state.frames.len()) as u64;
        }
        state.frames.push_back(Frame { number, given });
        number += 1;
        shared.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of so many one-pixel pictures, each of another grey.
    fn stream(folder: &tempfile::TempDir, count: u8) -> Source {
        let path = folder.path().join("stream");
        let frames: Vec<u8> =
            (0..count).flat_map(|grey| [b"P5 1 1 255\n".as_slice(), &[grey]].concat()).collect();
        std::fs::write(&path, frames).unwrap();
        Source::streams(vec![path])
    }

    fn grey(frame: &Frame) -> u64 {
        u64::from(*frame.given.as_ref().unwrap().bytes.last().unwrap())
    }

    #[test]
    fn every_frame_comes_in_order_however_slowly_they_are_taken() {
        let folder = tempfile::tempdir().unwrap();
        let ahead = Ahead::start(stream(&folder, 20), Keep::All).unwrap();
        let never = AtomicBool::new(false);
        let frames: Vec<Frame> = std::iter::from_fn(|| {
            thread::sleep(Duration::from_millis(2));
            ahead.next_frame(&never)
        })
        .collect();
        assert!(frames.iter().zip(0..).all(|(frame, at)| frame.number == at && grey(frame) == at));
        assert_eq!((frames.len(), ahead.dropped()), (20, 0));
    }

    #[test]
    fn of_what_cannot_wait_the_newest_is_taken_and_the_rest_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let ahead = Ahead::start(stream(&folder, 20), Keep::Newest).unwrap();
        let never = AtomicBool::new(false);
        while !ahead.shared.lock().has_ended {
            thread::yield_now();
        }
        let last = ahead.next_frame(&never).unwrap();
        assert_eq!((last.number, grey(&last), ahead.dropped()), (19, 19, 19));
        assert!(ahead.next_frame(&never).is_none());
    }

    #[test]
    fn a_flag_ends_the_wait() {
        let folder = tempfile::tempdir().unwrap();
        let ahead = Ahead::start(stream(&folder, 2), Keep::All).unwrap();
        assert!(ahead.next_frame(&AtomicBool::new(true)).is_none());
    }
}
