//! What a connection's other end has to do: ask, where others wait for its place, and take what it
//! asked for. An answer that nobody reads is memory that nobody gets back.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::Semaphore;
use tokio::time::{Sleep, sleep};

/// How long a connection may stay without a whole head of a request where no place is free.
const IDLE: Duration = Duration::from_secs(5);
/// How often to look after that whether one is.
const LOOK: Duration = Duration::from_secs(1);
/// How long the other end may take less than [`LEAST_TAKEN`] of what waits to be written to it.
const UNTAKEN: Duration = Duration::from_secs(20);
/// In bytes.
const LEAST_TAKEN: usize = 64 << 10;

/// How far the request on a connection is: known to what answers it, and asked by the stream.
#[derive(Clone, Debug, Default)]
pub(super) struct Stage(Arc<AtomicU8>);

impl Stage {
    /// Its head is still to come, or what is left of the answer to the one before to go.
    const COMING: u8 = 0;
    const WORKED_ON: u8 = 1;
    /// Its answer is there, and no byte of it written.
    const ANSWERED: u8 = 2;

    /// The head is whole.
    pub(super) fn begin(&self) {
        self.0.store(Self::WORKED_ON, Ordering::Release);
    }

    /// The answer is there.
    pub(super) fn answer(&self) {
        self.0.store(Self::ANSWERED, Ordering::Release);
    }

    fn is_coming(&self) -> bool {
        self.0.load(Ordering::Acquire) == Self::COMING
    }

    /// Something was written, which need not be the answer: a client may be told to go on.
    fn write(&self) {
        let _ = self.0.compare_exchange(Self::ANSWERED, Self::COMING, Ordering::AcqRel, Ordering::Acquire);
    }
}

/// A stream that fails where its other end has not asked and all places are taken, and where what
/// is written to it is not taken. Between requests it is as at the beginning.
#[derive(Debug)]
pub(super) struct Connection<S> {
    stream: S,
    places: Arc<Semaphore>,
    stage: Stage,
    /// When to look for a free place; not set while a request is worked on or an answer waits.
    idle: Option<Pin<Box<Sleep>>>,
    /// When to give up; set from where a write waits until all is flushed, and anew after each
    /// [`LEAST_TAKEN`].
    untaken: Option<Pin<Box<Sleep>>>,
    /// How much was taken since the last flush or [`LEAST_TAKEN`], in bytes.
    taken: usize,
}

impl<S> Connection<S> {
    pub(super) fn new(stream: S, places: Arc<Semaphore>, stage: Stage) -> Self {
        Self { stream, places, stage, idle: Some(Box::pin(sleep(IDLE))), untaken: None, taken: 0 }
    }

    /// What came of a write or a flush, which may wait for [`UNTAKEN`].
    fn bounded<T>(&mut self, context: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if written.is_ready() {
            return written;
        }
        let deadline = self.untaken.get_or_insert_with(|| Box::pin(sleep(UNTAKEN)));
        deadline.as_mut().poll(context).map(|()| Err(io::ErrorKind::TimedOut.into()))
    }

    /// The other end has taken enough, or all.
    fn have_taken(&mut self) {
        (self.untaken, self.taken) = (None, 0);
    }

    /// The same of an answer, or a piece of one, which is not under way any more where it was
    /// written.
    fn wrote(
        &mut self,
        context: &mut Context<'_>,
        written: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        let written = self.bounded(context, written);
        if let Poll::Ready(Ok(bytes)) = &written {
            self.taken += bytes;
            if self.taken >= LEAST_TAKEN {
                self.have_taken();
            }
        }
        if written.is_ready() {
            self.stage.write();
        }
        self.idle = written.is_ready().then(|| Box::pin(sleep(IDLE)));
        written
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Connection<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(context, into);
        if !self.stage.is_coming() {
            self.idle = None;
        }
        if read.is_ready() {
            return read;
        }
        while let Some(deadline) = &mut self.idle {
            ready!(deadline.as_mut().poll(context));
            if self.places.available_permits() == 0 {
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
            self.idle = Some(Box::pin(sleep(LOOK)));
        }
        Poll::Pending
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Connection<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.wrote(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, pieces);
        self.wrote(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let flushed = Pin::new(&mut self.stream).poll_flush(context);
        if flushed.is_ready() {
            self.have_taken();
        }
        self.bounded(context, flushed)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let shut = Pin::new(&mut self.stream).poll_shutdown(context);
        self.bounded(context, shut)
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

    type Tested = Connection<Other>;

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

    fn connection(other: Other, places: &Arc<Semaphore>) -> (Tested, Stage) {
        let stage = Stage::default();
        (Connection::new(other, Arc::clone(places), stage.clone()), stage)
    }

    #[tokio::test(start_paused = true)]
    async fn only_where_no_place_is_free_who_asks_nothing_has_to_go() {
        let places = Arc::new(Semaphore::new(1));
        let (mut stream, _) = connection(Other::default(), &places);
        assert_eq!(fails_after(&mut stream).await, None);
        let _taken = places.try_acquire().unwrap();
        assert!(fails_after(&mut stream).await.is_some_and(|after| after <= LOOK));
        assert_eq!(fails_after(&mut connection(Other::default(), &places).0).await, Some(IDLE));
    }

    #[tokio::test(start_paused = true)]
    async fn a_part_of_a_head_is_no_request() {
        let places = Arc::new(Semaphore::new(0));
        let (mut stream, _) = connection(Other { sends: true, takes: false }, &places);
        sleep(IDLE - LOOK).await;
        read(&mut stream).await.unwrap();
        stream.stream.sends = false;
        assert_eq!(fails_after(&mut stream).await, Some(LOOK));
    }

    #[tokio::test(start_paused = true)]
    async fn who_has_asked_may_stay_until_the_answer_is_written() {
        let places = Arc::new(Semaphore::new(0));
        let (mut stream, stage) = connection(Other { sends: true, takes: true }, &places);
        let write = async |stream: &mut Tested| {
            poll_fn(|context| Poll::Ready(Pin::new(&mut *stream).poll_write(context, b"x").is_ready())).await
        };
        read(&mut stream).await.unwrap();
        stage.begin();
        stream.stream.sends = false;
        assert_eq!(fails_after(&mut stream).await, None);
        // Told to go on, it may take its time for the body.
        assert!(write(&mut stream).await);
        assert_eq!(fails_after(&mut stream).await, None);
        stage.answer();
        assert_eq!(fails_after(&mut stream).await, None);
        for takes in [true, false] {
            stream.stream.takes = takes;
            assert_eq!(write(&mut stream).await, takes);
            assert_eq!(fails_after(&mut stream).await, takes.then_some(IDLE));
        }
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_not_taken_fails_in_the_end() {
        let (mut stream, _) = connection(Other::default(), &Arc::new(Semaphore::new(1)));
        let started = Instant::now();
        let failed = poll_fn(|context| Pin::new(&mut stream).poll_write(context, b"x")).await;
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert_eq!(started.elapsed(), UNTAKEN);
    }

    #[tokio::test(start_paused = true)]
    async fn a_byte_now_and_then_is_too_little_and_a_piece_is_enough() {
        let write = async |stream: &mut Tested, bytes: &[u8]| {
            poll_fn(|context| Poll::Ready(Pin::new(&mut *stream).poll_write(context, bytes))).await
        };
        for (bytes, is_enough) in [(1, false), (LEAST_TAKEN, true)] {
            let (mut stream, _) = connection(Other::default(), &Arc::new(Semaphore::new(1)));
            assert!(write(&mut stream, b"x").await.is_pending());
            sleep(UNTAKEN / 2).await;
            stream.stream.takes = true;
            assert!(write(&mut stream, &vec![0; bytes]).await.is_ready());
            stream.stream.takes = false;
            assert!(write(&mut stream, b"x").await.is_pending());
            sleep(UNTAKEN / 2 + LOOK).await;
            let waits = write(&mut stream, b"x").await.is_pending();
            assert_eq!(waits, is_enough, "{bytes} bytes");
        }
    }
}
