//! The medium that a program opens: one interface to ptys and sockets.

use std::os::fd::BorrowedFd;
use std::path::Path;

use baudbot_fields::endpoint::Endpoint;

use crate::error::PortError;
use crate::happened::Happened;
use crate::hold::Hold;
use crate::program::Program;
use crate::pty::Pty;
use crate::socket::Listener;
use baudbot_access::peer::Reach;
use baudbot_board::far_end::{Read, Settings};

/// The program's end of a port.
#[derive(Debug)]
pub(crate) enum Medium {
    Pty {
        pty: Pty,
        used: Used,
    },
    Socket {
        listener: Listener,
        program: Option<Program>,
        /// The first settings of each program's UART, if the port speaks RFC 2217.
        telnet: Option<Settings>,
    },
}

/// Whether a program has a pty open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Used {
    Closed,
    Open,
    /// The program has closed the port, and there may be bytes that it has written.
    Left,
}

impl Medium {
    /// A port at a place, for a robot whose UART is set so, if it has one.
    pub(crate) fn open(
        place: &Endpoint,
        reach: Reach,
        settings: Option<&Settings>,
    ) -> Result<Self, PortError> {
        let usual = settings.copied().unwrap_or(Settings::new_8n1(9600));
        let socket = |listener, telnet| Self::Socket { listener, program: None, telnet };
        Ok(match place {
            Endpoint::Pty(link) => {
                Self::Pty { pty: Pty::open(Path::new(link), settings)?, used: Used::Closed }
            }
            Endpoint::Tcp(address) => socket(Listener::tcp(*address, reach, place)?, None),
            Endpoint::Rfc2217(address) => socket(Listener::tcp(*address, reach, place)?, Some(usual)),
            Endpoint::Unix(path) => socket(Listener::unix(Path::new(path), place)?, None),
        })
    }

    /// A description of its place.
    pub(crate) fn where_it_is(&self, place: &Endpoint) -> String {
        match (self, place) {
            (Self::Pty { pty, .. }, _) => format!("{} ({})", pty.link().display(), pty.slave().display()),
            (Self::Socket { listener, .. }, Endpoint::Tcp(address)) => {
                Endpoint::Tcp(listener.local_addr().unwrap_or(*address)).to_string()
            }
            (Self::Socket { listener, .. }, Endpoint::Rfc2217(address)) => {
                Endpoint::Rfc2217(listener.local_addr().unwrap_or(*address)).to_string()
            }
            (Self::Socket { .. }, Endpoint::Unix(_) | Endpoint::Pty(_)) => place.to_string(),
        }
    }

    /// Checks whether programs have come or gone.
    pub(crate) fn look(&mut self, hold: &Hold, happened: &mut Vec<Happened>) {
        match self {
            Self::Pty { pty, used } => *used = look_at_pty(pty, *used, hold, happened),
            Self::Socket { listener, program, telnet } => {
                // The next one waits until all is read that a program has left which is gone.
                while !program.as_ref().is_some_and(Program::is_gone)
                    && let Some(connection) = listener.accept()
                {
                    // The cable has one end: a second program is sent away, the connection closed.
                    if program.is_none() && hold.take() {
                        *program = Some(Program::new(connection, *telnet));
                        happened.push(Happened::Opened);
                    } else if program.is_none() {
                        happened.push(Happened::Refused);
                    }
                }
            }
        }
    }

    /// Whether a program has the port open.
    pub(crate) fn is_open(&self) -> bool {
        match self {
            Self::Pty { used, .. } => *used == Used::Open,
            Self::Socket { program, .. } => program.is_some(),
        }
    }

    /// The program's settings of its UART; `None` if it cannot set it, so that it is as the robot's.
    pub(crate) fn settings(&self) -> Option<Settings> {
        match self {
            Self::Pty { pty, .. } => pty.settings(),
            Self::Socket { program, .. } => program.as_ref()?.settings(),
        }
    }

    /// The descriptors at which something may happen that is to be seen to now: bytes, if there is room for them, and
    /// programs that come.
    pub(crate) fn fds(&self, has_room: bool) -> Vec<BorrowedFd<'_>> {
        match self {
            Self::Pty { pty, used: Used::Open } => has_room.then(|| pty.fd()).into_iter().collect(),
            Self::Pty { pty, used: Used::Closed | Used::Left } => pty.watch_fd().into_iter().collect(),
            Self::Socket { listener, program, .. } => {
                let is_gone = program.as_ref().is_some_and(Program::is_gone);
                let program = program.as_ref().and_then(|program| program.fd(has_room));
                (!is_gone).then(|| listener.fd()).into_iter().chain(program).collect()
            }
        }
    }

    /// Whether only looking shows that a program has come.
    pub(crate) fn is_looked_at(&self) -> bool {
        match self {
            Self::Pty { pty, used } => *used != Used::Open && pty.watch_fd().is_none(),
            Self::Socket { .. } => false,
        }
    }

    /// Whether there is something to read that no descriptor shows.
    pub(crate) fn has_left(&self) -> bool {
        match self {
            Self::Pty { used, .. } => *used == Used::Left,
            Self::Socket { program, .. } => program.as_ref().is_some_and(Program::has_left),
        }
    }

    /// Bytes that the program has written; as many as there is room for. What has happened comes before them.
    pub(crate) fn read(
        &mut self,
        buffer: &mut [u8],
        room: usize,
        hold: &Hold,
        happened: &mut Vec<Happened>,
    ) -> Vec<u8> {
        match self {
            Self::Pty { pty, used } => {
                if room == 0 || *used == Used::Closed && hold.is_elsewhere() {
                    return Vec::new();
                }
                // EIO is a hang-up, which `look` finds.
                let wanted = room.min(buffer.len());
                let bytes = pty.read(&mut buffer[..wanted]).map_or(&[][..], |n| &buffer[..n]);
                if bytes.is_empty() && *used == Used::Left {
                    *used = Used::Closed;
                    hold.let_go();
                } else if !bytes.is_empty() && *used == Used::Closed && hold.take() {
                    // The port was opened after the last check.
                    pty.was_opened();
                    happened.push(Happened::Opened);
                    *used = Used::Open;
                }
                bytes.to_vec()
            }
            Self::Socket { program, .. } => {
                let Some(connected) = program else { return Vec::new() };
                let bytes = connected.read(buffer, room, happened);
                if bytes.is_empty() && connected.is_over() {
                    *program = None;
                    hold.let_go();
                    happened.push(Happened::Closed);
                }
                bytes
            }
        }
    }

    /// Gives the program bytes, and returns how many of them it has taken.
    pub(crate) fn write(&mut self, reads: &[Read]) -> usize {
        match self {
            Self::Pty { pty, .. } => {
                let taken = reads.iter().take_while(|read| {
                    let bytes = pty.as_read(read);
                    bytes.is_empty() || pty.write(&bytes).is_ok_and(|n| n == bytes.len())
                });
                taken.count()
            }
            Self::Socket { program, .. } => program.as_mut().map_or(0, |program| program.write(reads)),
        }
    }
}

fn look_at_pty(pty: &mut Pty, used: Used, hold: &Hold, happened: &mut Vec<Happened>) -> Used {
    let was_opened = pty.was_opened();
    match (used, pty.is_open()) {
        (Used::Open, true) => Used::Open,
        (Used::Open, false) => {
            happened.push(Happened::Closed);
            if pty.forget_unread() {
                happened.extend([Happened::Opened, Happened::Closed]);
            }
            Used::Left
        }
        (Used::Closed | Used::Left, false) if was_opened && hold.take() => {
            happened.extend([Happened::Opened, Happened::Closed]);
            pty.forget_unread();
            Used::Left
        }
        (Used::Closed | Used::Left, false) => used,
        (Used::Closed | Used::Left, true) if hold.take() => {
            happened.push(Happened::Opened);
            Used::Open
        }
        (Used::Closed | Used::Left, true) => {
            // The pty stays as it is if there is no other: the program receives nothing, and its bytes are not read.
            if pty.hang_up().is_ok() {
                happened.push(Happened::Refused);
            }
            Used::Closed
        }
    }
}
