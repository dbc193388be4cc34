//! HTTP over a Unix socket.

use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;

use ureq::Error;
use ureq::unversioned::transport::{
    Buffers, ConnectionDetails, Connector, LazyBuffers, NextTimeout, Transport,
};

/// Connects to a socket in the file system, whatever host a URI names.
#[derive(Debug)]
pub(super) struct Socket(pub(super) PathBuf);

/// A connection.
#[derive(Debug)]
pub(super) struct Open {
    stream: UnixStream,
    buffers: LazyBuffers,
}

impl Connector for Socket {
    type Out = Open;

    fn connect(&self, details: &ConnectionDetails<'_>, _: Option<()>) -> Result<Option<Open>, Error> {
        let [input, output] = [details.config.input_buffer_size(), details.config.output_buffer_size()];
        let stream = UnixStream::connect(&self.0)?;
        Ok(Some(Open { stream, buffers: LazyBuffers::new(input, output) }))
    }
}

impl Transport for Open {
    fn buffers(&mut self) -> &mut dyn Buffers {
        &mut self.buffers
    }

    fn transmit_output(&mut self, amount: usize, timeout: NextTimeout) -> Result<(), Error> {
        self.stream.set_write_timeout(timeout.not_zero().map(|time| *time))?;
        let output = self.buffers.output().get(..amount).unwrap_or_default();
        self.stream.write_all(output).map_err(|error| or_timeout(error, timeout))
    }

    fn await_input(&mut self, timeout: NextTimeout) -> Result<bool, Error> {
        self.stream.set_read_timeout(timeout.not_zero().map(|time| *time))?;
        let amount = self.stream.read(self.buffers.input_append_buf());
        let amount = amount.map_err(|error| or_timeout(error, timeout))?;
        self.buffers.input_appended(amount);
        Ok(amount > 0)
    }

    /// A connection within this machine costs little: each request has its own.
    fn is_open(&mut self) -> bool {
        false
    }
}

/// A socket says `WouldBlock` where its time is over.
fn or_timeout(error: io::Error, timeout: NextTimeout) -> Error {
    match error.kind() {
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => Error::Timeout(timeout.reason),
        _ => Error::Io(error),
    }
}
