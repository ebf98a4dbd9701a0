//! Lines that a person types, until Ctrl-C.

use std::io;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::signals::Stop;
use crate::text;

/// The result of a prompt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Typed {
    /// A line, without blanks around it.
    Line(String),
    /// Ctrl-D, or the end of a file.
    End,
    /// The input ended by Ctrl-C.
    Stopped,
}

/// Asks for a line. On a terminal the line ends with Enter; of a pipe no byte too many is read.
pub(super) fn ask(prompt: &str, stop: &Stop) -> io::Result<Typed> {
    text::prompt(prompt);
    let stdin = io::stdin();
    let mut line = Vec::new();
    loop {
        if stop.is_wanted() {
            return Ok(Typed::Stopped);
        }
        let interval = Timespec { tv_sec: 0, tv_nsec: INTERVAL.as_nanos() as _ };
        match poll(&mut [PollFd::new(&stdin, PollFlags::IN)], Some(&interval)) {
            Ok(0) | Err(Errno::INTR) => continue,
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let mut byte = [0];
        match rustix::io::read(&stdin, &mut byte) {
            Ok(0) if line.is_empty() => return Ok(Typed::End),
            Ok(1) if byte[0] != b'\n' => line.push(byte[0]),
            Ok(_) => return Ok(Typed::Line(String::from_utf8_lossy(&line).trim().to_owned())),
            Err(Errno::INTR | Errno::AGAIN) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// The time for which Ctrl-C may go unheard.
const INTERVAL: Duration = Duration::from_millis(100);
