//! The other end of [`crate::Service`]: pictures or descriptors are sent to a running service,
//! which answers in the words of this program.
//!
//! Over TCP a [`Client`] keeps its connections open from picture to picture, one for each thread
//! that asks at the same time.

mod address;
mod parts;
#[cfg(unix)]
mod socket;

use std::io;
use std::thread::sleep;
use std::time::{Duration, Instant};

pub use address::{Address, AddressError};
pub use parts::Parts;
use serde::Serialize;
use ureq::http::{Response, StatusCode, header};
use ureq::typestate::WithBody;
#[cfg(unix)]
use ureq::unversioned::resolver::DefaultResolver;
use ureq::{Agent, Body, Error, RequestBuilder, Timeout};

use crate::wire::parameters::{PictureParameters, SearchParameters};
use crate::wire::{Format, STATUS, Token};

/// How long a service may take for one answer.
const PATIENCE: Duration = Duration::from_secs(120);
/// For how long a picture is offered to a service that has too many already; it says itself how
/// long to wait in between.
const BUSY: Duration = Duration::from_secs(300);
/// The longest answer that is read.
const MOST_BYTES: u64 = 1 << 28;
/// A longer body waits until the service says that it wants it: a service may answer without
/// reading what it refuses, and its answer would be lost.
const LONG_BODY: usize = 1 << 20;

/// What a service says to a picture.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The exit status that the picture asks for: 0 recognised, 1 rejected, 2 an error.
    pub exit: u8,
    /// Whether it is an answer, and not the reason why there is none.
    pub is_answer: bool,
    /// In the format that was wanted.
    pub body: Vec<u8>,
}

/// Why a service does not answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// Nobody is there.
    #[error("no service answers at {address}: {source}: start one with `grasp-query serve`")]
    Unreachable {
        /// Where.
        address: Address,
        /// What the system said.
        source: io::Error,
    },
    /// The connection broke.
    #[error("the service at {address} did not answer: {reason}")]
    Broken {
        /// Where.
        address: Address,
        /// What happened.
        reason: String,
    },
    /// The service turned the request away.
    #[error("the service at {address} says: {message}")]
    Refused {
        /// Where.
        address: Address,
        /// Whether it was this picture that it did not want; others may be welcome.
        is_picture: bool,
        /// Its words.
        message: String,
    },
    /// Something else answers there.
    #[error("what answers at {address} is not a `grasp-query serve` (status {status})")]
    Foreign {
        /// Where.
        address: Address,
        /// What it answered with.
        status: u16,
    },
}

/// Connections to a service, opened when they are needed.
#[derive(Clone, Debug)]
pub struct Client {
    address: Address,
    token: Option<Token>,
    agent: Agent,
}

impl Client {
    /// A client that has not connected yet.
    pub fn new(address: Address, token: Option<Token>) -> Self {
        let config = Agent::config_builder()
            .proxy(None)
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false)
            .max_idle_connections(usize::MAX)
            .max_idle_connections_per_host(usize::MAX)
            .timeout_global(Some(PATIENCE))
            .build();
        let agent = match &address {
            #[cfg(unix)]
            Address::Unix(path) => {
                Agent::with_parts(config, socket::Socket(path.clone()), DefaultResolver::default())
            }
            _ => config.new_agent(),
        };
        Self { address, token, agent }
    }

    /// Sends a picture, again and again for five minutes where the service is busy, and waits for
    /// the answer.
    ///
    /// # Errors
    /// [`ClientError`], where there is none.
    pub fn recognise(
        &self,
        parameters: &PictureParameters,
        parts: &Parts,
        format: Format,
    ) -> Result<Answer, ClientError> {
        let send = |request| parts.send(request);
        let answer = self.ask("recognise", parameters, format.media_type(), parts.len(), send)?;
        let exit = answer.headers().get(STATUS).and_then(|exit| exit.to_str().ok()?.parse().ok());
        let is_answer = answer.status() == StatusCode::OK;
        match exit {
            Some(exit) => Ok(Answer { exit, is_answer, body: answer.into_body() }),
            None => Err(self.refused(&answer)),
        }
    }

    /// Sends descriptors, an array in NumPy's format, and waits for a line of JSON for each; as
    /// [`Self::recognise`] does where the service is busy.
    ///
    /// # Errors
    /// [`ClientError`], where there are none.
    pub fn search(&self, parameters: &SearchParameters, array: &[u8]) -> Result<Vec<u8>, ClientError> {
        let send = |request: RequestBuilder<_>| request.content_type("application/octet-stream").send(array);
        let answer = self.ask("search", parameters, "application/x-ndjson", array.len(), send)?;
        if answer.status() == StatusCode::OK { Ok(answer.into_body()) } else { Err(self.refused(&answer)) }
    }

    /// Asks again and again where the service is busy; `length` bytes are sent.
    fn ask(
        &self,
        path: &str,
        parameters: &impl Serialize,
        accept: &str,
        length: usize,
        send: impl Fn(RequestBuilder<WithBody>) -> Result<Response<Body>, Error>,
    ) -> Result<Response<Vec<u8>>, ClientError> {
        let base = match &self.address {
            Address::Http(base) => base,
            Address::Unix(_) if cfg!(unix) => "http://127.0.0.1",
            Address::Unix(_) => return Err(self.unreachable(io::ErrorKind::Unsupported.into())),
        };
        let query =
            serde_urlencoded::to_string(parameters).map_err(|error| self.broken(error.to_string()))?;
        let uri = format!("{base}/v1/{path}?{query}");
        let ask_once = || {
            let mut request = self.agent.post(&uri).header(header::ACCEPT, accept);
            if length > LONG_BODY {
                request = request.header(header::EXPECT, "100-continue");
            }
            if let Some(token) = &self.token {
                request = request.header(header::AUTHORIZATION, format!("Bearer {}", token.reveal()));
            }
            let (head, mut body) = send(request)?.into_parts();
            let body = body.with_config().limit(MOST_BYTES).read_to_vec()?;
            Ok(Response::from_parts(head, body))
        };
        let until = Instant::now() + BUSY;
        loop {
            let answer = match ask_once() {
                // A connection that was kept open may have been closed meanwhile.
                Err(Error::Io(error)) if is_broken(&error) => ask_once(),
                answer => answer,
            };
            let answer = answer.map_err(|error| self.failed(error))?;
            let wait = answer.headers().get(header::RETRY_AFTER);
            let wait = wait.and_then(|wait| wait.to_str().ok()?.parse().ok()).unwrap_or(1);
            let wait = Duration::from_secs(wait.max(1));
            let left = until.saturating_duration_since(Instant::now());
            if answer.status() != StatusCode::TOO_MANY_REQUESTS || wait > left {
                return Ok(answer);
            }
            sleep(wait);
        }
    }

    fn failed(&self, error: Error) -> ClientError {
        match error {
            Error::Timeout(Timeout::Resolve | Timeout::Connect)
            | Error::HostNotFound
            | Error::ConnectionFailed => self.unreachable(error.into_io()),
            Error::Timeout(_) => self.broken(format!("{} seconds have passed", PATIENCE.as_secs())),
            Error::Io(error) if is_broken(&error) => self.broken(error.to_string()),
            Error::Io(error) => self.unreachable(error),
            other => self.broken(other.to_string()),
        }
    }

    fn unreachable(&self, source: io::Error) -> ClientError {
        ClientError::Unreachable { address: self.address.clone(), source }
    }

    fn broken(&self, reason: String) -> ClientError {
        ClientError::Broken { address: self.address.clone(), reason }
    }

    fn refused(&self, answer: &Response<Vec<u8>>) -> ClientError {
        let (address, status) = (self.address.clone(), answer.status());
        let problem: Option<serde_json::Value> = serde_json::from_slice(answer.body()).ok();
        match problem.as_ref().and_then(|problem| problem.get("error")?.get("message")?.as_str()) {
            Some(message) => ClientError::Refused {
                address,
                is_picture: status == StatusCode::PAYLOAD_TOO_LARGE,
                message: message.to_owned(),
            },
            None => ClientError::Foreign { address, status: status.as_u16() },
        }
    }
}

/// Whether a connection broke that had been made.
fn is_broken(error: &io::Error) -> bool {
    use io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset, UnexpectedEof};
    matches!(error.kind(), BrokenPipe | ConnectionAborted | ConnectionReset | UnexpectedEof)
}
