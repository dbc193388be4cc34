//! From the first look at the index to the last answer.

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use grasp_terminal::PHASE;
use tokio::task::JoinSet;
use tokio::time::Instant;

use crate::current::Refresh;
use crate::listen::{Connections, Listener};
use crate::router::router;
use crate::service::{Ended, Event, Service};
use crate::unusable::{IndexFault, UnusableIndex};

/// How long answers that are there may take to go out, even where the time to drain is over.
const LAST_ANSWERS: Duration = Duration::from_secs(1);

impl Service {
    /// Opens the index, and answers until `stop`; then finishes what was begun. The paths of
    /// `quiz`, where there is one, lie below `/quiz/`.
    ///
    /// # Errors
    /// Where the first index cannot be opened: what is wrong with it.
    pub async fn run(
        self: Arc<Self>,
        listeners: Vec<Listener>,
        quiz: Option<Router>,
        stop: impl Future<Output = ()>,
        report: impl Fn(Event) + Send + 'static,
    ) -> Result<Ended, Arc<UnusableIndex>> {
        let router = router(Arc::clone(&self), quiz);
        let connections = Arc::new(Connections::new());
        // Dropped, it ends them.
        let mut accepting = JoinSet::new();
        for listener in listeners {
            let (connections, router) = (Arc::clone(&connections), router.clone());
            accepting.spawn(async move { connections.accept(&listener, &router).await });
        }
        tokio::pin!(stop);
        let first = tokio::select! {
            biased;
            () = &mut stop => return Ok(Ended::Drained),
            first = self.refresh(false) => first,
        };
        let first = match first {
            Some(Refresh::Replaced(generation)) => generation,
            Some(Refresh::Failed(why)) => return Err(why),
            _ => return Err(self.current.unusable(IndexFault::Unknown)),
        };
        report(Event::Serving(first));
        let watching = tokio::spawn(Arc::clone(&self).watch(report));
        stop.await;
        let under_way = self.arriving() + self.gate.inside();
        tracing::info!(target: PHASE, state = "began", phase = "draining", under_way, "draining: {under_way} under way");
        let deadline = Instant::now() + self.settings.drain;
        let ended = self.drain(deadline).await;
        watching.abort();
        // The tasks let go of the connections.
        accepting.shutdown().await;
        // What is left are answers on their way out, and connections that lie idle and are closed.
        let time = deadline.saturating_duration_since(Instant::now()).max(LAST_ANSWERS);
        let left = match Arc::into_inner(connections) {
            Some(connections) => connections.close(time).await,
            None => 0,
        };
        Ok(if ended == Ended::Drained && left > 0 { Ended::CutShort(left) } else { ended })
    }
}
