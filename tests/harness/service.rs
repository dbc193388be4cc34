//! A service that a test runs, and the few words of HTTP that it takes to talk to one.

use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::program;

/// How long anything may take before a test gives up: machines that test are busy.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A running `grasp-query serve`; it is ended when this is dropped.
#[derive(Debug)]
pub struct Service {
    child: Child,
    address: String,
    /// Behind a lock, so that threads can share a service.
    lines: Mutex<Receiver<String>>,
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Response {
    /// The HTTP status.
    pub status: u16,
    /// Status line and headers.
    pub head: String,
    /// What follows.
    pub body: Vec<u8>,
}

impl Response {
    /// Reads all that the other end sends. `None` where it sends no whole answer.
    pub fn read(stream: &mut impl Read) -> Option<Self> {
        let mut answer = Vec::new();
        // A server that refuses early resets what was still under way.
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n")?;
        let head = String::from_utf8(answer[..end].to_vec()).ok()?;
        let status = head.split(' ').nth(1)?.parse().ok()?;
        Some(Self { status, head, body: answer[end + 4..].to_vec() })
    }

    /// The body as JSON.
    ///
    /// # Panics
    /// If it is none.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", self.text()))
    }

    /// The body as text.
    #[must_use]
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// The value of a header, by its name in small letters.
    #[must_use]
    pub fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
    }
}

/// A request that closes its connection.
#[must_use]
pub fn request(method: &str, path: &str, headers: &str, body: &[u8]) -> Vec<u8> {
    let length = body.len();
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n"
    );
    [head.as_bytes(), body].concat()
}

impl Service {
    /// Starts `grasp-query serve` with these arguments at a free port of this machine, and waits
    /// until it answers.
    ///
    /// # Panics
    /// If it ends before that.
    #[must_use]
    pub fn start(arguments: impl FnOnce(&mut Command)) -> Self {
        let mut command = program("grasp-query");
        command.args(["serve", "--listen", "127.0.0.1:0"]);
        arguments(&mut command);
        Self::of(&mut command)
    }

    /// Starts a command that tells on standard error where it listens.
    ///
    /// # Panics
    /// As [`Self::start`].
    #[must_use]
    pub fn of(command: &mut Command) -> Self {
        let mut child =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the service starts");
        let lines = read_lines(child.stderr.take().expect("standard error is a pipe"));
        let mut service = Self { child, address: String::new(), lines: Mutex::new(lines) };
        // A service that logs its phases says that it begins before it says where.
        let mut line = service.line();
        while line.contains("\"began\"") {
            line = service.line();
        }
        let rest = line.split("http://").nth(1).unwrap_or_else(|| panic!("no address in: {line}"));
        service.address = rest.split('/').next().unwrap_or_default().to_owned();
        service
    }

    /// HOST:PORT.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// The process's number.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The next line that the service says on standard error.
    ///
    /// # Panics
    /// If none comes.
    pub fn line(&mut self) -> String {
        let lines = self.lines.get_mut().expect("no other test panicked with it");
        lines.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("the service says nothing more"))
    }

    /// The next line that it says; `None` where it has ended and nothing is left.
    ///
    /// # Panics
    /// If none comes, and it does not end.
    pub fn next_line(&mut self) -> Option<String> {
        let lines = self.lines.get_mut().expect("no other test panicked with it");
        match lines.recv_timeout(PATIENCE) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("the service neither ends nor says anything more"),
        }
    }

    /// Connects.
    ///
    /// # Panics
    /// If nobody listens.
    #[must_use]
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).expect("the service listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket has a timeout");
        stream
    }

    /// Sends bytes and reads the answer.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn send(&self, request: &[u8]) -> Response {
        let mut stream = self.connect();
        // A server that refuses early may close before all is written.
        let _ = stream.write_all(request);
        Response::read(&mut stream).expect("an answer comes")
    }

    /// `GET`.
    #[must_use]
    pub fn get(&self, path: &str) -> Response {
        self.send(&request("GET", path, "", b""))
    }

    /// `POST` of bytes.
    #[must_use]
    pub fn post(&self, path: &str, body: &[u8]) -> Response {
        self.send(&request("POST", path, "", body))
    }

    /// A number that `/metrics` tells.
    ///
    /// # Panics
    /// If it tells none of that name.
    #[must_use]
    pub fn metric(&self, name: &str) -> f64 {
        let text = self.get("/metrics").text();
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.and_then(|value| value.parse().ok()).unwrap_or_else(|| panic!("no {name} in\n{text}"))
    }

    /// Asks until `is_so`.
    ///
    /// # Panics
    /// If that takes too long.
    pub fn wait_until(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let started = Instant::now();
        while !is_so(self) {
            assert!(started.elapsed() < PATIENCE, "waited for {what} in vain");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Sends a signal, such as `TERM`.
    ///
    /// # Panics
    /// If it cannot be sent.
    pub fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
    }

    /// Waits for the end; the exit status.
    ///
    /// # Panics
    /// If there is none.
    pub fn wait(&mut self) -> i32 {
        let started = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child can be waited for") {
                return status.code().unwrap_or(-1);
            }
            assert!(started.elapsed() < PATIENCE, "the service does not end");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        // A failed test must leave nothing running.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Read from a thread of its own, so that the service never waits to be heard.
fn read_lines(stderr: ChildStderr) -> Receiver<String> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stderr).lines().map_while(Result::ok) {
            // Where nobody listens any more, what is still said is read and forgotten.
            let _ = send.send(line);
        }
    });
    receive
}
