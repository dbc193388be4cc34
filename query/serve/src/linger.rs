//! Answers that are sent before the whole request has been read. Closing the connection then would
//! reset it, and most clients would lose the answer: what still comes is read and forgotten for a
//! moment.

use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::Request;
use axum::http::header;
use http_body_util::BodyExt as _;
use hyper::body::{Frame, SizeHint};

/// How long a client may take to notice that it has its answer.
const TIME: Duration = Duration::from_secs(2);
/// The most bytes that are read meanwhile.
const MOST: usize = 64 << 20;

/// A body whose rest is read and forgotten when it is dropped.
#[derive(Debug)]
pub(super) struct Linger {
    body: Body,
    is_over: bool,
}

impl Linger {
    /// Puts itself around a request's body.
    pub(super) fn around(request: Request) -> Request {
        // One who asks first whether to send the body waits for a word; the answer is that word.
        let asks_first = request.headers().contains_key(header::EXPECT);
        request.map(|body| if asks_first { body } else { Body::new(Self { body, is_over: false }) })
    }
}

impl HttpBody for Linger {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let frame = Pin::new(&mut self.body).poll_frame(context);
        self.is_over |= matches!(frame, Poll::Ready(None | Some(Err(_))));
        frame
    }

    fn is_end_stream(&self) -> bool {
        self.is_over || self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

impl Drop for Linger {
    fn drop(&mut self) {
        if self.is_end_stream() {
            return;
        }
        if let Ok(runtime) = tokio::runtime::Handle::try_current() {
            runtime.spawn(tokio::time::timeout(TIME, forget(std::mem::take(&mut self.body))));
        }
    }
}

async fn forget(mut body: Body) {
    let mut left = MOST;
    while let Some(Ok(frame)) = body.frame().await {
        let bytes = frame.data_ref().map_or(0, Bytes::len);
        match left.checked_sub(bytes) {
            Some(rest) => left = rest,
            None => return,
        }
    }
}
