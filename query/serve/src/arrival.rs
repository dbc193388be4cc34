//! The body of a request, from its first byte to its last, in one buffer that is returned to the
//! system when it is dropped.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody as _};
use axum::http::StatusCode;
use http_body_util::BodyExt as _;
use memmap2::{MmapMut, MmapOptions};
use tokio::time::Instant;

use super::budget::{Budget, Reservation};
use super::problem::Problem;

/// Bodies up to this many bytes lie on the heap. Larger ones are pages of their own: an allocator
/// never gives its peak back.
const ON_HEAP: usize = 16 << 10;
/// Bodies up to this many bytes wait for no room: the bound on connections is theirs as well.
const UNRESERVED: usize = 256 << 10;
/// What a body must bring at least within [`STALLED`], its end excepted.
const PROGRESS: usize = 4 << 10;
/// How long a body may bring less than [`PROGRESS`].
const STALLED: Duration = Duration::from_secs(5);

/// Reads a body of at most `most` bytes. One of more than [`UNRESERVED`] counts whole against
/// `budget` until its bytes are dropped.
pub(super) async fn read(mut body: Body, most: usize, budget: &Arc<Budget>) -> Result<Bytes, Problem> {
    let declared = body.size_hint().exact().map(|length| usize::try_from(length).unwrap_or(usize::MAX));
    if declared.is_some_and(|length| length > most) {
        return Err(too_large(most));
    }
    let mut buffer = Buffer::with_room(declared.unwrap_or(0), budget).await?;
    let (mut mark, mut since) = (0, Instant::now());
    loop {
        let frame = tokio::select! {
            biased;
            () = buffer.evicted() => return Err(evicted()),
            frame = tokio::time::timeout_at(since + STALLED, body.frame()) => {
                frame.map_err(|_| Problem::stalled(PROGRESS, STALLED))?
            }
        };
        let Some(frame) = frame else { break };
        let frame = frame.map_err(|_| {
            Problem::bad_request("the request ends before its body does, or is no HTTP: send it again")
        })?;
        let Some(bytes) = frame.data_ref() else { continue };
        let length = buffer.length + bytes.len();
        if length > most {
            return Err(too_large(most));
        }
        if length > buffer.room() {
            // Of unknown length: a size at which it waits for no room, and then at once the largest
            // that it may have.
            let room = if length <= UNRESERVED { UNRESERVED.min(most) } else { most };
            buffer = buffer.moved(room, budget).await?;
            since = Instant::now();
        }
        buffer.put(bytes);
        if length - mark >= PROGRESS {
            (mark, since) = (length, Instant::now());
            buffer.progressed();
        }
    }
    buffer.arrived();
    Ok(Bytes::from_owner(buffer))
}

fn too_large(most: usize) -> Problem {
    let message = format!(
        "the request is larger than the {most} bytes that the service reads: shrink the picture, or ask for less at once"
    );
    Problem::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", message)
}

fn evicted() -> Problem {
    let message = "the request stopped coming while others waited for its memory: send it again, faster";
    Problem::new(StatusCode::TOO_MANY_REQUESTS, "busy", message)
}

/// Where a body is put together.
#[derive(Debug)]
struct Buffer {
    pages: Pages,
    length: usize,
    reservation: Option<Reservation>,
}

#[derive(Debug)]
enum Pages {
    Heap(Vec<u8>),
    /// Of zeros, which take no memory before they are written.
    Mapped(MmapMut),
}

impl Buffer {
    /// An empty buffer for `bytes`, as soon as there is room for it.
    async fn with_room(bytes: usize, budget: &Arc<Budget>) -> Result<Self, Problem> {
        let reservation = match bytes > UNRESERVED {
            true => Some(budget.reserve(bytes).await.map_err(|_| Problem::busy())?),
            false => None,
        };
        let pages = match bytes > ON_HEAP {
            true => Pages::Mapped(map(bytes).map_err(|_| Problem::busy())?),
            false => Pages::Heap(vec![0; ON_HEAP]),
        };
        Ok(Self { pages, length: 0, reservation })
    }

    /// This buffer's bytes in one with more room.
    async fn moved(self, bytes: usize, budget: &Arc<Budget>) -> Result<Self, Problem> {
        let mut larger = Self::with_room(bytes, budget).await?;
        larger.put(self.as_ref());
        Ok(larger)
    }

    fn room(&self) -> usize {
        match &self.pages {
            Pages::Heap(pages) => pages.len(),
            Pages::Mapped(pages) => pages.len(),
        }
    }

    /// Adds bytes for which there is room.
    fn put(&mut self, bytes: &[u8]) {
        let pages: &mut [u8] = match &mut self.pages {
            Pages::Heap(pages) => pages,
            Pages::Mapped(pages) => pages,
        };
        let end = self.length + bytes.len();
        if let Some(place) = pages.get_mut(self.length..end) {
            place.copy_from_slice(bytes);
            self.length = end;
        }
    }

    fn progressed(&self) {
        if let Some(reservation) = &self.reservation {
            reservation.progressed();
        }
    }

    fn arrived(&self) {
        if let Some(reservation) = &self.reservation {
            reservation.arrived();
        }
    }

    async fn evicted(&self) {
        match &self.reservation {
            Some(reservation) => reservation.evicted().await,
            None => std::future::pending().await,
        }
    }
}

impl AsRef<[u8]> for Buffer {
    fn as_ref(&self) -> &[u8] {
        let pages: &[u8] = match &self.pages {
            Pages::Heap(pages) => pages,
            Pages::Mapped(pages) => pages,
        };
        pages.get(..self.length).unwrap_or_default()
    }
}

fn map(bytes: usize) -> io::Result<MmapMut> {
    MmapOptions::new().len(bytes).no_reserve_swap().map_anon()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::pin::Pin;
    use std::task::{Context, Poll};

    use hyper::body::Frame;

    /// A body of unknown length that comes in pieces, and then does not end where it `hangs`.
    struct Pieces {
        pieces: std::vec::IntoIter<Bytes>,
        hangs: bool,
    }

    impl axum::body::HttpBody for Pieces {
        type Data = Bytes;
        type Error = std::convert::Infallible;

        fn poll_frame(
            mut self: Pin<&mut Self>,
            _: &mut Context<'_>,
        ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
            match self.pieces.next() {
                None if self.hangs => Poll::Pending,
                piece => Poll::Ready(piece.map(|piece| Ok(Frame::data(piece)))),
            }
        }
    }

    fn in_pieces(bytes: &[u8], hangs: bool) -> Body {
        let pieces: Vec<Bytes> = bytes.chunks(5000).map(Bytes::copy_from_slice).collect();
        Body::new(Pieces { pieces: pieces.into_iter(), hangs })
    }

    #[tokio::test(start_paused = true)]
    async fn what_comes_is_what_was_sent_whatever_its_size_and_all_room_is_returned() {
        let most = 1 << 20;
        let budget = Arc::new(Budget::new(2 * most));
        let noise: Vec<u8> = (0..=most).map(|at| (at * 31 % 251) as u8).collect();
        for length in [0, 1, ON_HEAP, ON_HEAP + 1, UNRESERVED, UNRESERVED + 1, most] {
            let sent = &noise[..length];
            let declared = read(Body::from(sent.to_vec()), most, &budget).await.unwrap();
            let unknown = read(in_pieces(sent, false), most, &budget).await.unwrap();
            assert!(declared == sent && unknown == sent, "{length}");
            assert_eq!(budget.reserved() > 0, length > UNRESERVED, "{length}");
            let part = declared.slice(..length / 2);
            drop((declared, unknown));
            drop(part);
            assert_eq!(budget.reserved(), 0);
        }
        for body in [Body::from(noise.clone()), in_pieces(&noise, false)] {
            assert_eq!(read(body, most, &budget).await.unwrap_err().status, StatusCode::PAYLOAD_TOO_LARGE);
        }
        let refused = read(in_pieces(&noise[..most / 2], true), most, &budget).await.unwrap_err();
        assert_eq!(refused.status, StatusCode::REQUEST_TIMEOUT);
        insta::assert_snapshot!(refused.message(), @"the request stopped coming: at least 4096 bytes of it have to come in each 5 s, or its end; send it again, without a pause");
        assert_eq!(budget.reserved(), 0);
    }
}
