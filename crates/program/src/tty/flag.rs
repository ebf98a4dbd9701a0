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
    wanted: bool,
    is_changed: bool,
    name: PathBuf,
}

impl Flag {
    /// A pipe with nothing in it.
    pub(crate) fn new() -> io::Result<Self> {
        let (reader, writer) = pipe()?;
        let name = std::fs::read_link(format!("/proc/self/fd/{}", reader.as_raw_fd()))?;
        Ok(Self { reader, writer, is_up: false, wanted: false, is_changed: false, name })
    }

    /// The text by which /proc shows a descriptor of it.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// The path by which another process of this user opens it.
    pub(crate) fn path(&self) -> String {
        format!("/proc/{}/fd/{}", std::process::id(), self.reader.as_raw_fd())
    }

    /// It is to have a byte in it, or not.
    pub(crate) fn set(&mut self, is_up: bool) {
        self.is_changed |= self.wanted != is_up;
        self.wanted = is_up;
    }

    /// Bytes have come on top of others: who waits for edges (EPOLLET) gets one.
    pub(crate) fn poke(&mut self) {
        self.is_changed = true;
    }

    /// Puts a byte in, or takes it out, before the kernel looks at it. A pipe of which both ends are ours neither breaks nor fills.
    pub(crate) fn show(&mut self) {
        if std::mem::take(&mut self.is_changed) {
            if self.is_up {
                let _ = self.reader.read(&mut [0]);
            }
            if self.wanted {
                let _ = self.writer.write(&[0]);
            }
            self.is_up = self.wanted;
        }
    }
}
