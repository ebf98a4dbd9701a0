//! What a program opens: one interface to ptys and sockets.

use std::io::{self, ErrorKind};
use std::os::fd::BorrowedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::address::Place;
use crate::error::PortError;
use crate::pty::Pty;
use crate::socket::{Connection, Listener};
use crate::telnet::{Event, Telnet, escaped};
use crate::uart::{Read, Settings};

/// The program's end of a port.
#[derive(Debug)]
pub(crate) enum Medium {
    Pty {
        pty: Pty,
        open: bool,
    },
    Socket {
        listener: Listener,
        program: Option<Program>,
        /// Where each program's UART begins, if the port speaks RFC 2217.
        telnet: Option<Settings>,
    },
}

/// A program that is connected.
#[derive(Debug)]
pub(crate) struct Program {
    connection: Connection,
    telnet: Option<Telnet>,
    /// The rest of an escape that its machine has not taken.
    owed: Vec<u8>,
}

/// What has happened at the program's end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Happened {
    /// A program has opened the port, or has set DTR on it.
    Opened,
    Closed,
    /// The program sends a break, or ends it.
    Break(bool),
    PurgeReceived,
}

impl Medium {
    /// A port at a place, for a robot whose UART is set so, if it has one.
    pub(crate) fn open(place: &Place, settings: Option<&Settings>) -> Result<Self, PortError> {
        let usual = settings.copied().unwrap_or(Settings::new_8n1(9600));
        let socket = |listener, telnet| Self::Socket { listener, program: None, telnet };
        Ok(match place {
            Place::Pty(link) => Self::Pty { pty: Pty::open(link, settings)?, open: false },
            Place::Tcp(address) => socket(Listener::tcp(*address, place)?, None),
            Place::Rfc2217(address) => socket(Listener::tcp(*address, place)?, Some(usual)),
            Place::Unix(path) => socket(Listener::unix(path, place)?, None),
        })
    }

    /// What there is to be said of where it is.
    pub(crate) fn where_it_is(&self, place: &Place) -> String {
        match (self, place) {
            (Self::Pty { pty, .. }, Place::Pty(link)) => {
                format!("{} ({})", link.display(), pty.slave().display())
            }
            (Self::Socket { listener, .. }, Place::Tcp(address) | Place::Rfc2217(address)) => {
                let bound = listener.local_addr().unwrap_or(*address);
                let kind = if matches!(place, Place::Tcp(_)) { "tcp" } else { "rfc2217" };
                format!("{kind}:{bound}")
            }
            _ => place.to_string(),
        }
    }

    /// Looks whether programs have come or gone.
    pub(crate) fn look(&mut self, happened: &mut Vec<Happened>) {
        match self {
            Self::Pty { pty, open } => {
                let is_open = pty.is_open();
                if *open && !is_open {
                    pty.forget_unread();
                }
                if is_open != *open {
                    happened.push(if is_open { Happened::Opened } else { Happened::Closed });
                }
                *open = is_open;
            }
            Self::Socket { listener, program, telnet } => {
                // The next one waits until all is read that a program has left which is gone.
                while !is_gone(program.as_ref())
                    && let Some(connection) = listener.accept()
                {
                    // The cable has one end: a second program is sent away, the connection closed.
                    if program.is_none() {
                        *program =
                            Some(Program { connection, telnet: telnet.map(Telnet::new), owed: Vec::new() });
                        happened.push(Happened::Opened);
                    }
                }
            }
        }
    }

    /// Whether a program has it open.
    pub(crate) fn is_open(&self) -> bool {
        match self {
            Self::Pty { open, .. } => *open,
            Self::Socket { program, .. } => program.is_some(),
        }
    }

    /// How the program has set its UART; `None` where it cannot, so that it is as the robot's.
    pub(crate) fn settings(&self) -> Option<Settings> {
        match self {
            Self::Pty { pty, .. } => pty.settings(),
            Self::Socket { program, .. } => Some(program.as_ref()?.telnet.as_ref()?.settings()),
        }
    }

    /// The descriptors at which something may happen, and whether to wait for bytes there.
    pub(crate) fn fds(&self) -> Vec<(BorrowedFd<'_>, Role)> {
        match self {
            Self::Pty { pty, open: true } => vec![(pty.fd(), Role::Bytes)],
            Self::Pty { .. } => vec![],
            Self::Socket { listener, program, .. } => {
                let listener = (!is_gone(program.as_ref())).then(|| (listener.fd(), Role::Programs));
                let program = program.iter().map(|program| (program.connection.fd(), Role::Bytes));
                listener.into_iter().chain(program).collect()
            }
        }
    }

    /// Bytes that the program has written; as many as there is room for.
    pub(crate) fn read(&mut self, buffer: &mut [u8], happened: &mut Vec<Happened>) -> Vec<u8> {
        match self {
            Self::Pty { pty, .. } => match pty.read(buffer) {
                Ok(n) => buffer[..n].to_vec(),
                // EIO is a hang-up, which `look` finds.
                Err(_) => Vec::new(),
            },
            Self::Socket { program, .. } => {
                let Some(connected) = program else { return Vec::new() };
                match connected.connection.read(buffer) {
                    Ok(n) if n > 0 => connected.hear(&buffer[..n], happened),
                    Err(error) if is_busy(&error) => Vec::new(),
                    Ok(_) | Err(_) => {
                        *program = None;
                        happened.push(Happened::Closed);
                        Vec::new()
                    }
                }
            }
        }
    }

    /// Gives the program bytes, and says how many of them it has taken.
    pub(crate) fn write(&mut self, reads: &[Read]) -> usize {
        match self {
            Self::Pty { pty, .. } => {
                let taken = reads.iter().take_while(|read| {
                    let bytes = pty.as_read(read);
                    bytes.is_empty() || pty.write(&bytes).is_ok_and(|n| n == bytes.len())
                });
                taken.count()
            }
            Self::Socket { program, .. } => {
                let Some(program) = program else { return 0 };
                // What a program's machine does not take is lost, as at a UART that overruns.
                program.write(reads)
            }
        }
    }
}

/// What happens at a descriptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Bytes come.
    Bytes,
    /// Programs come.
    Programs,
}

/// Whether a program has closed its end, so that only what it has left is to be read.
fn is_gone(program: Option<&Program>) -> bool {
    program.is_some_and(|program| {
        let mut fds = [PollFd::from_borrowed_fd(program.connection.fd(), PollFlags::RDHUP)];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut fds, Some(&at_once)).is_ok() && !fds[0].revents().is_empty()
    })
}

impl Program {
    /// Gives the program bytes, and says how many of them have gone. An escape that was cut is completed first.
    fn write(&mut self, reads: &[Read]) -> usize {
        let mut bytes = std::mem::take(&mut self.owed);
        let owed = bytes.len();
        let mut ends = Vec::with_capacity(reads.len());
        for read in reads {
            if self.telnet.is_some() {
                bytes.extend(escaped(&[read.byte]));
            } else {
                bytes.push(read.byte);
            }
            ends.push(bytes.len());
        }
        let gone = self.connection.write(&bytes).unwrap_or(0);
        if gone < owed {
            self.owed = bytes[gone..owed].to_vec();
            return 0;
        }
        let whole = ends.iter().take_while(|end| **end <= gone).count();
        if let Some(&end) = ends.get(whole).filter(|end| **end == gone + 1 && self.telnet.is_some()) {
            let begins = whole.checked_sub(1).map_or(owed, |last| ends[last]);
            self.owed = if begins < gone { bytes[gone..end].to_vec() } else { Vec::new() };
        }
        whole
    }

    fn hear(&mut self, bytes: &[u8], happened: &mut Vec<Happened>) -> Vec<u8> {
        let Some(telnet) = &mut self.telnet else { return bytes.to_vec() };
        let heard = telnet.hear(bytes);
        // A few bytes; a program that does not take its answers has no use for them.
        drop(self.connection.write(&heard.replies));
        happened.extend(heard.events.into_iter().filter_map(|event| match event {
            Event::Dtr(true) => Some(Happened::Opened),
            Event::Dtr(false) => None,
            Event::Break(on) => Some(Happened::Break(on)),
            Event::PurgeReceived => Some(Happened::PurgeReceived),
        }));
        heard.data
    }
}

fn is_busy(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
