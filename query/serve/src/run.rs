//! From the first look at the index to the last answer.

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use grasp_terminal::PHASE;

use crate::current::Refresh;
use crate::listen::{Connections, Listener};
use crate::router::router;
use crate::service::{Ended, Event, Service};
use crate::unusable::{IndexFault, UnusableIndex};

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
        let accepting: Vec<_> = listeners
            .into_iter()
            .map(|listener| {
                let (connections, router) = (Arc::clone(&connections), router.clone());
                tokio::spawn(async move { connections.accept(&listener, &router).await })
            })
            .collect();
        let first = match self.refresh(false).await {
            Some(Refresh::Replaced(generation)) => generation,
            Some(Refresh::Failed(why)) => return Err(why),
            _ => return Err(self.current.unusable(IndexFault::Unknown)),
        };
        report(Event::Serving(first));
        let watching = tokio::spawn(Arc::clone(&self).watch(report));
        stop.await;
        let under_way = self.arriving() + self.gate.inside();
        tracing::info!(target: PHASE, state = "began", phase = "draining", under_way, "draining: {under_way} under way");
        let ended = self.drain().await;
        watching.abort();
        for task in accepting {
            task.abort();
            // The task lets go of the connections.
            let _ = task.await;
        }
        if let Some(connections) = Arc::into_inner(connections) {
            // What is left are answers on their way out and connections that lie idle.
            let _ = tokio::time::timeout(Duration::from_secs(1), connections.close()).await;
        }
        Ok(ended)
    }
}
