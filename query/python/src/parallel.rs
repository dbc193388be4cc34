//! Work in parts, each on a thread of its own that ends with the call.
//!
//! A pool of threads that outlived a call would be lost in a forked process, which would then wait
//! for it for ever; starting a thread takes some microseconds.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use pyo3::prelude::*;

use crate::error::parameter;
use crate::number::Integer;

/// The most threads that can be asked for.
const MOST: usize = 1024;

/// As many threads as are asked for, or as the machine has cores.
pub(crate) fn threads(wanted: Option<Integer>) -> PyResult<usize> {
    let Some(wanted) = wanted else {
        return Ok(thread::available_parallelism().map_or(1, Into::into));
    };
    let threads = wanted.get().filter(|threads| (1..=MOST).contains(threads));
    threads.ok_or_else(|| {
        parameter(format!("threads is {wanted}: 1 to {MOST} are possible, or None for one a core"))
    })
}

/// How many of `count` each thread has: as many as the others, but at least `least`, where there are
/// so many.
pub(crate) fn share(count: usize, threads: usize, least: usize) -> usize {
    let parts = threads.min(count / least.max(1)).max(1);
    count.div_ceil(parts).max(1)
}

/// The results of `work` for each of `items`, in their order; each thread takes the next that
/// nobody has taken.
pub(crate) fn each<I: Sync, T: Send>(items: &[I], threads: usize, work: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let workers: Vec<()> = vec![(); threads.min(items.len()).max(1)];
    let done = on_threads(&workers, |()| {
        let mut done = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(at) else { return done };
            done.push((at, work(item)));
        }
    });
    let mut done: Vec<(usize, T)> = done.into_iter().flatten().collect();
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, result)| result).collect()
}

/// `work` for each of `items`, the first on the calling thread and each other on its own, or on the
/// calling one where the system has no more.
pub(crate) fn on_threads<I: Sync, T: Send>(items: &[I], work: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let work = &work;
    let Some((first, others)) = items.split_first() else { return Vec::new() };
    thread::scope(|scope| {
        let started: Vec<_> = others
            .iter()
            .map(|item| (item, thread::Builder::new().spawn_scoped(scope, move || work(item))))
            .collect();
        let mut results = vec![work(first)];
        for (item, thread) in started {
            results.push(match thread.map(thread::ScopedJoinHandle::join) {
                Ok(Ok(result)) => result,
                Ok(Err(panic)) => std::panic::resume_unwind(panic),
                Err(_) => work(item),
            });
        }
        results
    })
}
