//! Connections on which nothing is asked: each holds a place that others may wait for.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::Semaphore;
use tokio::time::{Sleep, sleep};

/// How long a connection may stay without a byte of a request where no place is free.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);
/// How often to look after that whether one is.
const LOOK: Duration = Duration::from_secs(1);

/// A stream that fails where its other end has not begun to ask and all places are taken. Between
/// requests it is as at the beginning.
#[derive(Debug)]
pub(super) struct Idle<S> {
    stream: S,
    places: Arc<Semaphore>,
    /// When to look for a free place; not set while a request comes or is worked on.
    deadline: Option<Pin<Box<Sleep>>>,
}

impl<S> Idle<S> {
    pub(super) fn new(stream: S, places: Arc<Semaphore>) -> Self {
        Self { stream, places, deadline: Some(Box::pin(sleep(PATIENCE))) }
    }

    /// An answer, or a piece of one, is not under way any more where it was written.
    fn wrote(&mut self, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        self.deadline = written.is_ready().then(|| Box::pin(sleep(PATIENCE)));
        written
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Idle<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(context, into);
        if read.is_ready() {
            self.deadline = None;
            return read;
        }
        while let Some(deadline) = &mut self.deadline {
            ready!(deadline.as_mut().poll(context));
            if self.places.available_permits() == 0 {
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
            self.deadline = Some(Box::pin(sleep(LOOK)));
        }
        Poll::Pending
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Idle<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.wrote(written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, pieces);
        self.wrote(written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::poll_fn;
    use tokio::time::{Instant, timeout};

    /// The other end, which sends and takes where it is told to.
    #[derive(Debug, Default)]
    struct Other {
        sends: bool,
        takes: bool,
    }

    impl AsyncRead for Other {
        fn poll_read(
            self: Pin<&mut Self>,
            _: &mut Context<'_>,
            into: &mut ReadBuf<'_>,
        ) -> Poll<io::Result<()>> {
            if !self.sends {
                return Poll::Pending;
            }
            into.put_slice(b"x");
            Poll::Ready(Ok(()))
        }
    }

    impl AsyncWrite for Other {
        fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
            if self.takes { Poll::Ready(Ok(bytes.len())) } else { Poll::Pending }
        }

        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }

        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    type Tested = Idle<Other>;

    async fn read(stream: &mut Tested) -> io::Result<()> {
        let mut byte = [0];
        poll_fn(|context| Pin::new(&mut *stream).poll_read(context, &mut ReadBuf::new(&mut byte))).await
    }

    /// How long a read takes until it fails; `None` where it still waits after a minute.
    async fn fails_after(stream: &mut Tested) -> Option<Duration> {
        let started = Instant::now();
        let failed = timeout(Duration::from_secs(60), read(stream)).await.ok()?;
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::TimedOut);
        Some(started.elapsed())
    }

    #[tokio::test(start_paused = true)]
    async fn only_where_no_place_is_free_who_asks_nothing_has_to_go() {
        let places = Arc::new(Semaphore::new(1));
        let mut stream = Idle::new(Other::default(), Arc::clone(&places));
        assert_eq!(fails_after(&mut stream).await, None);
        let _taken = places.try_acquire().unwrap();
        assert!(fails_after(&mut stream).await.is_some_and(|after| after <= LOOK));
        assert_eq!(fails_after(&mut Idle::new(Other::default(), Arc::clone(&places))).await, Some(PATIENCE));
    }

    #[tokio::test(start_paused = true)]
    async fn who_has_begun_to_ask_may_stay_until_the_answer_is_written() {
        let places = Arc::new(Semaphore::new(0));
        let mut stream = Idle::new(Other { sends: true, takes: false }, places);
        read(&mut stream).await.unwrap();
        stream.stream.sends = false;
        assert_eq!(fails_after(&mut stream).await, None);
        for takes in [true, false] {
            stream.stream.takes = takes;
            let written =
                poll_fn(|context| Poll::Ready(Pin::new(&mut stream).poll_write(context, b"x"))).await;
            assert_eq!(written.is_ready(), takes);
            assert_eq!(fails_after(&mut stream).await, takes.then_some(PATIENCE));
        }
    }
}
