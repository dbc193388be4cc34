//! When a program that serves is asked to end.

use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ready when the program is asked to end, and whether that was by Ctrl-C. Listens from now on: a
/// signal must not be lost while the server starts. Where `reload` is given, SIGHUP calls it.
#[cfg(unix)]
pub(super) fn signals(
    reload: Option<impl Fn()>,
) -> anyhow::Result<(impl Future<Output = ()>, Arc<AtomicBool>)> {
    use anyhow::Context as _;
    use tokio::signal::unix::{SignalKind, signal};
    let mut interrupt = signal(SignalKind::interrupt()).context("cannot listen for Ctrl-C")?;
    let mut terminate = signal(SignalKind::terminate()).context("cannot listen for the end")?;
    let hangup = reload.map(|reload| anyhow::Ok((signal(SignalKind::hangup())?, reload)));
    let mut hangup = hangup.transpose().context("cannot listen for SIGHUP")?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let by_ctrl_c = Arc::clone(&interrupted);
    let asked = async move {
        loop {
            let hung_up = async {
                match &mut hangup {
                    Some((hangup, _)) => hangup.recv().await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                _ = interrupt.recv() => break by_ctrl_c.store(true, Ordering::SeqCst),
                _ = terminate.recv() => break,
                _ = hung_up => {}
            }
            if let Some((_, reload)) = &hangup {
                reload();
            }
        }
    };
    Ok((asked, interrupted))
}

/// Ready when the program is asked to end, which is by Ctrl-C.
#[cfg(not(unix))]
pub(super) fn signals(_: Option<impl Fn()>) -> anyhow::Result<(impl Future<Output = ()>, Arc<AtomicBool>)> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let by_ctrl_c = Arc::clone(&interrupted);
    let asked = async move {
        // Where Ctrl-C cannot be listened for, the system ends the program itself.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending().await
        }
        by_ctrl_c.store(true, Ordering::SeqCst);
    };
    Ok((asked, interrupted))
}
