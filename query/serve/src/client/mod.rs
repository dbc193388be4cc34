//! The other end of [`crate::Service`]: pictures or descriptors are sent to a running service,
//! which answers in the words of this program.
//!
//! One [`Client`] is one connection that stays open from picture to picture; [`Clients`] lends them
//! to threads.

mod address;
mod form;

use std::io;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

pub use address::{Address, AddressError};
use axum::body::Bytes;
pub use form::Parts;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::client::conn::http1::{SendRequest, handshake};
use hyper::header::HeaderValue;
use hyper::{Method, Request, StatusCode, header};
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;
use tokio::runtime::Runtime;

use crate::wire::parameters::{PictureParameters, SearchParameters};
use crate::wire::{Format, STATUS, Token};

/// How long a service may take for one answer.
const PATIENCE: Duration = Duration::from_secs(120);
/// How often a picture is offered to a service that has too many already; it says itself how long
/// to wait in between.
const ATTEMPTS: u32 = 60;
/// The longest that it may make us wait.
const LONGEST_WAIT: u64 = 30;
/// The longest answer that is read.
const MOST_BYTES: usize = 1 << 28;

/// What a service says to a picture.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The exit status that the picture asks for: 0 recognised, 1 rejected, 2 an error.
    pub exit: u8,
    /// Whether it is an answer, and not the reason why there is none.
    pub is_answer: bool,
    /// In the format that was wanted.
    pub body: Bytes,
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

/// What is sent.
struct Question<'a> {
    path: &'static str,
    query: &'a str,
    kind: &'a str,
    body: &'a Bytes,
    accept: &'static str,
}

/// A connection to a service, opened when it is needed.
#[derive(Debug)]
pub struct Client {
    address: Address,
    token: Option<Token>,
    runtime: Runtime,
    open: Option<SendRequest<Full<Bytes>>>,
}

impl Client {
    /// A client that has not connected yet.
    ///
    /// # Errors
    /// Where the system has no means left for one.
    pub fn new(address: Address, token: Option<Token>) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        Ok(Self { address, token, runtime, open: None })
    }

    /// Sends a picture, again and again where the service is busy, and waits for the answer.
    ///
    /// # Errors
    /// [`ClientError`], where there is none.
    pub fn recognise(
        &mut self,
        parameters: &PictureParameters,
        parts: &Parts,
        format: Format,
    ) -> Result<Answer, ClientError> {
        let (kind, body) = parts.encode();
        let query = serde_urlencoded::to_string(parameters).map_err(|error| self.broken(error))?;
        let question = Question {
            path: "recognise",
            query: &query,
            kind: &kind,
            body: &body,
            accept: format.media_type(),
        };
        let (head, body) = self.send(&question)?;
        let exit = head.headers.get(STATUS).and_then(|exit| exit.to_str().ok()?.parse().ok());
        match exit {
            Some(exit) => Ok(Answer { exit, is_answer: head.status == StatusCode::OK, body }),
            None => Err(self.refused(head.status, &body)),
        }
    }

    /// Sends descriptors, an array in NumPy's format, and waits for a line of JSON for each.
    ///
    /// # Errors
    /// [`ClientError`], where there are none.
    pub fn search(&mut self, parameters: &SearchParameters, body: Bytes) -> Result<Bytes, ClientError> {
        let query = serde_urlencoded::to_string(parameters).map_err(|error| self.broken(error))?;
        let (kind, accept) = ("application/octet-stream", "application/x-ndjson");
        let question = Question { path: "search", query: &query, kind, body: &body, accept };
        let (head, body) = self.send(&question)?;
        if head.status == StatusCode::OK { Ok(body) } else { Err(self.refused(head.status, &body)) }
    }

    /// Asks again and again where the service is busy.
    fn send(
        &mut self,
        question: &Question<'_>,
    ) -> Result<(hyper::http::response::Parts, Bytes), ClientError> {
        let mut attempts = 0;
        loop {
            let (head, body) = self.send_once(question)?;
            attempts += 1;
            if head.status != StatusCode::TOO_MANY_REQUESTS || attempts >= ATTEMPTS {
                return Ok((head, body));
            }
            let wait =
                head.headers.get(header::RETRY_AFTER).and_then(|wait| wait.to_str().ok()?.parse().ok());
            std::thread::sleep(Duration::from_secs(wait.unwrap_or(1).min(LONGEST_WAIT)));
        }
    }

    /// One request, on the connection that is open, or on a new one where there is none or it was
    /// closed meanwhile.
    fn send_once(
        &mut self,
        question: &Question<'_>,
    ) -> Result<(hyper::http::response::Parts, Bytes), ClientError> {
        let was_open = self.open.is_some();
        match self.try_send(question) {
            Err(ClientError::Broken { .. }) if was_open => self.try_send(question),
            outcome => outcome,
        }
    }

    fn try_send(
        &mut self,
        question: &Question<'_>,
    ) -> Result<(hyper::http::response::Parts, Bytes), ClientError> {
        let Question { path, query, kind, body, accept } = *question;
        let (host, prefix) = match &self.address {
            Address::Http { authority, prefix } => (authority.as_str(), prefix.as_str()),
            Address::Unix(_) => ("localhost", ""),
        };
        let mut request = Request::builder()
            .method(Method::POST)
            .uri(format!("{prefix}/v1/{path}?{query}"))
            .header(header::HOST, host)
            .header(header::ACCEPT, accept)
            .header(header::CONTENT_TYPE, kind);
        if let Some(token) = &self.token {
            let shown = HeaderValue::from_str(&format!("Bearer {}", token.reveal()));
            let mut shown = shown.map_err(|error| self.broken(error))?;
            shown.set_sensitive(true);
            request = request.header(header::AUTHORIZATION, shown);
        }
        let request = request.body(Full::new(body.clone())).map_err(|error| self.broken(error))?;
        let (address, open) = (&self.address, self.open.take());
        let answer = self.runtime.block_on(async {
            let mut sender = match open.filter(|sender| !sender.is_closed()) {
                Some(sender) => sender,
                None => connect(address).await?,
            };
            let exchange = async {
                let response = sender.send_request(request).await.map_err(|error| error.to_string())?;
                let (head, body) = response.into_parts();
                let body =
                    Limited::new(body, MOST_BYTES).collect().await.map_err(|error| error.to_string())?;
                Ok((head, body.to_bytes()))
            };
            let broken = |reason: String| ClientError::Broken { address: address.clone(), reason };
            match tokio::time::timeout(PATIENCE, exchange).await {
                Ok(Ok(answer)) => Ok((answer, sender)),
                Ok(Err(reason)) => Err(broken(reason)),
                Err(_) => Err(broken(format!("{} seconds have passed", PATIENCE.as_secs()))),
            }
        });
        let (answer, sender) = answer?;
        self.open = Some(sender);
        Ok(answer)
    }

    fn broken(&self, error: impl ToString) -> ClientError {
        ClientError::Broken { address: self.address.clone(), reason: error.to_string() }
    }

    fn refused(&self, status: StatusCode, body: &Bytes) -> ClientError {
        let address = self.address.clone();
        let problem: Option<serde_json::Value> = serde_json::from_slice(body).ok();
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

async fn connect(address: &Address) -> Result<SendRequest<Full<Bytes>>, ClientError> {
    let unreachable = |source| ClientError::Unreachable { address: address.clone(), source };
    let opened = match address {
        Address::Http { authority, .. } => {
            let stream = TcpStream::connect(authority).await.map_err(unreachable)?;
            // A picture is sent whole: waiting to fill a packet only adds time.
            let _ = stream.set_nodelay(true);
            start(TokioIo::new(stream)).await
        }
        #[cfg(unix)]
        Address::Unix(path) => {
            let stream = tokio::net::UnixStream::connect(path).await.map_err(unreachable)?;
            start(TokioIo::new(stream)).await
        }
        #[cfg(not(unix))]
        Address::Unix(_) => return Err(unreachable(io::ErrorKind::Unsupported.into())),
    };
    opened.map_err(|error| ClientError::Broken { address: address.clone(), reason: error.to_string() })
}

async fn start<S>(stream: S) -> hyper::Result<SendRequest<Full<Bytes>>>
where
    S: hyper::rt::Read + hyper::rt::Write + Unpin + Send + 'static,
{
    let (sender, connection) = handshake(stream).await?;
    // What breaks the connection is told to the request that is under way on it.
    tokio::spawn(async move { drop(connection.await) });
    Ok(sender)
}

/// Clients of one service, as many as threads ask for at a time.
#[derive(Debug)]
pub struct Clients {
    address: Address,
    token: Option<Token>,
    idle: Mutex<Vec<Client>>,
}

impl Clients {
    /// No connection is open yet.
    pub fn new(address: Address, token: Option<Token>) -> Self {
        Self { address, token, idle: Mutex::default() }
    }

    /// Sends a picture by a client that nobody else uses.
    ///
    /// # Errors
    /// As [`Client::recognise`].
    pub fn recognise(
        &self,
        parameters: &PictureParameters,
        parts: &Parts,
        format: Format,
    ) -> Result<Answer, ClientError> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let unreachable = |source| ClientError::Unreachable { address: self.address.clone(), source };
        let mut client = match idle {
            Some(client) => client,
            None => Client::new(self.address.clone(), self.token.clone()).map_err(unreachable)?,
        };
        let answer = client.recognise(parameters, parts, format);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(client);
        answer
    }
}
