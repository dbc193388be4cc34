//! Connections: accepted up to a bound, each with a time for its requests' heads, and drained when
//! the program ends.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
#[cfg(unix)]
use tokio::net::UnixListener;
use tokio::sync::Semaphore;

use super::connection::{Connection, Stage};

/// How long a connection may take to send a request's head, and how long it may lie idle between
/// requests; less where no place is free ([`Connection`]).
const HEAD_TIME: Duration = Duration::from_secs(30);
/// The most bytes of a request's head, and of what is read ahead of it.
const MOST_HEAD: usize = 64 * 1024;
/// Connections at a time; more wait to be accepted.
const MOST_CONNECTIONS: usize = 512;
/// How long to wait where the system cannot accept, as when the process has too many files open.
const PAUSE: Duration = Duration::from_millis(100);

/// Where requests come from.
#[derive(Debug)]
pub enum Listener {
    /// The network, or this machine's own.
    Tcp(TcpListener),
    /// A file.
    #[cfg(unix)]
    Unix(UnixListener),
}

trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}
impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

impl Listener {
    async fn accept(&self) -> io::Result<Pin<Box<dyn Stream>>> {
        match self {
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept().await?;
                // Answers are sent whole: waiting to fill a packet only adds time.
                let _ = stream.set_nodelay(true);
                Ok(Box::pin(stream))
            }
            #[cfg(unix)]
            Self::Unix(listener) => Ok(Box::pin(listener.accept().await?.0)),
        }
    }
}

/// Whether an error says that a connection was given up before it was accepted: others go on.
fn is_of_one_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

/// Connections that are open.
#[derive(Debug)]
pub(super) struct Connections {
    open: GracefulShutdown,
    places: Arc<Semaphore>,
}

impl Connections {
    pub(super) fn new() -> Self {
        Self { open: GracefulShutdown::new(), places: Arc::new(Semaphore::new(MOST_CONNECTIONS)) }
    }

    /// Accepts connections and answers on them by `router`, for as long as this future lives.
    pub(super) async fn accept(&self, listener: &Listener, router: &Router) {
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME).max_buf_size(MOST_HEAD);
        let mut is_failing = false;
        loop {
            // The semaphore is never closed.
            let Ok(place) = Arc::clone(&self.places).acquire_owned().await else { return };
            let stream = match listener.accept().await {
                Ok(stream) => stream,
                Err(error) if is_of_one_connection(&error) => continue,
                Err(error) => {
                    if !std::mem::replace(&mut is_failing, true) {
                        tracing::warn!("no connection can be accepted: {error}");
                    }
                    tokio::time::sleep(PAUSE).await;
                    continue;
                }
            };
            is_failing = false;
            let stage = Stage::default();
            let stream = Connection::new(stream, Arc::clone(&self.places), stage.clone());
            let router = TowerToHyperService::new(router.clone());
            let service = service_fn(move |request| {
                stage.begin();
                let (answer, stage) = (router.call(request), stage.clone());
                async move {
                    let answer = answer.await;
                    stage.answer();
                    answer
                }
            });
            let connection = self.open.watch(builder.serve_connection(TokioIo::new(stream), service));
            tokio::spawn(async move {
                let _held = place;
                // A connection that breaks is its other end's affair.
                let _ = connection.await;
            });
        }
    }

    /// Lets connections end after the request that they are in.
    /// Returns how many were left after `time`.
    pub(super) async fn close(self, time: Duration) -> usize {
        match tokio::time::timeout(time, self.open.shutdown()).await {
            Ok(()) => 0,
            Err(_) => MOST_CONNECTIONS - self.places.available_permits(),
        }
    }
}
