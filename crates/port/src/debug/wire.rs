//! The connection to a debugger.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use gdbstub::conn::Connection;

/// A socket on which each answer goes out as a whole.
pub(crate) struct Wire {
    stream: TcpStream,
    out: Vec<u8>,
}

impl Wire {
    pub(crate) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(STUCK))?;
        Ok(Self { stream, out: Vec::new() })
    }

    /// Bytes that have come, or that come within a tenth of a second; none if none do.
    pub(crate) fn wait(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        received(self.stream.read(bytes))
    }

    /// Bytes that have come.
    pub(crate) fn poll(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_nonblocking(true)?;
        let read = received(self.stream.read(bytes));
        self.stream.set_nonblocking(false)?;
        read
    }
}

fn received(read: io::Result<usize>) -> io::Result<usize> {
    match read {
        Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
            ) =>
        {
            Ok(0)
        }
        read => read,
    }
}

impl Connection for Wire {
    type Error = io::Error;

    fn write(&mut self, byte: u8) -> io::Result<()> {
        self.out.push(byte);
        Ok(())
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.extend_from_slice(bytes);
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.out.is_empty() {
            return Ok(());
        }
        Write::write_all(&mut self.stream, &self.out)?;
        self.out.clear();
        Ok(())
    }
}

/// The time for which a look at the connection waits.
const PATIENCE: Duration = Duration::from_millis(100);

/// A debugger that takes nothing for so long is gone.
const STUCK: Duration = Duration::from_secs(10);
