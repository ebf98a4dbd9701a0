//! The file that a program holds as the descriptor of a port: the end of a pipe of ours, which has a byte in it while there is something to read.
//! So the kernel's own select, poll and epoll answer for it, and every rule about descriptors (dup, fork, exec, O_NONBLOCK, locks)
//! holds by itself. Reads, writes and controls of it never reach the kernel.

use std::io::{self, PipeReader, PipeWriter, Read, Write, pipe};
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};

/// The pipe.
#[derive(Debug)]
pub(crate) struct Flag {
    reader: PipeReader,
    writer: PipeWriter,
    is_up: bool,
    name: PathBuf,
}

impl Flag {
    /// A pipe with nothing in it.
    pub(crate) fn new() -> io::Result<Self> {
        let (reader, writer) = pipe()?;
        let name = std::fs::read_link(format!("/proc/self/fd/{}", reader.as_raw_fd()))?;
        Ok(Self { reader, writer, is_up: false, name })
    }

    /// The text by which /proc shows a descriptor of it.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// The path by which another process of this user opens it.
    pub(crate) fn path(&self) -> String {
        format!("/proc/{}/fd/{}", std::process::id(), self.reader.as_raw_fd())
    }

    /// Puts a byte in, or takes it out. A pipe of which both ends are ours neither breaks nor fills.
    pub(crate) fn set(&mut self, is_up: bool) {
        if self.is_up != is_up {
            self.is_up = is_up;
            let _ = if is_up { self.writer.write(&[0]) } else { self.reader.read(&mut [0]) };
        }
    }

    /// Bytes have come on top of others: who waits for edges (EPOLLET) gets one.
    pub(crate) fn poke(&mut self) {
        if self.is_up {
            self.set(false);
            self.set(true);
        }
    }
}
