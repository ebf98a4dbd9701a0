//! The line discipline of Linux (n_tty): what it makes of bytes on their way in and out, and when a read returns.
//!
//! Deviations: XON and XOFF are taken from the input, but do not stop the output. Marks (PARMRK) and tabs (XTABS) are not made. A read of
//! a port that is no controlling terminal sends no signals, so the characters of ISIG only vanish, as they do under Linux.

use std::collections::VecDeque;

use super::termios::Termios;

/// Linux holds 4,096 bytes in the discipline and 64 KiB before it; what comes on top is lost.
const ROOM: usize = 4096 + 65_536;

/// The answer to a read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Reading {
    /// These bytes, which may be none.
    Bytes(Vec<u8>),
    /// It waits for bytes, or until an instant.
    Waiting(Option<u64>),
    /// It would wait, and may not.
    Nothing,
}

/// A read of a program.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Request {
    /// The most bytes that it takes.
    pub(crate) room: usize,
    /// The instant of the call.
    pub(crate) began_ns: u64,
    /// The instant now.
    pub(crate) now_ns: u64,
    /// O_NONBLOCK.
    pub(crate) is_nonblocking: bool,
}

/// The bytes that have come in.
#[derive(Debug, Default)]
pub(crate) struct Input {
    /// Bytes to read. In canonical mode, whole lines.
    ready: VecDeque<u8>,
    /// The lengths of the lines among them, in canonical mode.
    lines: VecDeque<usize>,
    /// The line that is being typed, in canonical mode.
    editing: Vec<u8>,
    /// The instant of the last byte.
    pub(crate) last_ns: u64,
}

impl Input {
    /// A byte comes in. What is to be echoed is appended to `echo`.
    pub(crate) fn receive(&mut self, termios: &Termios, byte: u8, echo: &mut Vec<u8>) {
        let flag = |flag| termios.input & flag != 0;
        let byte = if flag(libc::ISTRIP) { byte & 0x7f } else { byte };
        let any = |places: &[usize]| places.iter().any(|place| termios.is_special(byte, *place));
        let is_flow = flag(libc::IXON) && any(&[libc::VSTART, libc::VSTOP]);
        let is_signal = termios.local & libc::ISIG != 0 && any(&[libc::VINTR, libc::VQUIT, libc::VSUSP]);
        if is_flow || is_signal || (byte == b'\r' && flag(libc::IGNCR)) {
            return;
        }
        let byte = match byte {
            b'\r' if flag(libc::ICRNL) => b'\n',
            b'\n' if flag(libc::INLCR) => b'\r',
            other => other,
        };
        if self.ready.len() + self.editing.len() >= ROOM {
            return;
        }
        let is_shown = if termios.is_canonical() {
            self.edit(termios, byte)
        } else {
            self.ready.push_back(byte);
            true
        };
        if is_shown
            && (termios.local & libc::ECHO != 0 || (byte == b'\n' && termios.local & libc::ECHONL != 0))
        {
            let is_control = byte < 0x20 && byte != b'\n' && byte != b'\t';
            let shown = if is_control && termios.local & libc::ECHOCTL != 0 {
                vec![b'^', byte ^ 0x40]
            } else {
                vec![byte]
            };
            echo.extend(process(termios, &shown));
        }
    }

    /// Canonical mode. Returns whether the byte is one to echo.
    fn edit(&mut self, termios: &Termios, byte: u8) -> bool {
        let is = |place| termios.is_special(byte, place);
        if is(libc::VERASE) {
            self.editing.pop();
            return false;
        }
        if is(libc::VKILL) {
            self.editing.clear();
            return false;
        }
        let is_end = is(libc::VEOF);
        if !is_end {
            self.editing.push(byte);
        }
        if is_end || byte == b'\n' || is(libc::VEOL) || is(libc::VEOL2) {
            self.lines.push_back(self.editing.len());
            self.ready.extend(self.editing.drain(..));
        }
        !is_end
    }

    /// Whether select and poll say that there is something to read.
    pub(crate) fn is_ready(&self, termios: &Termios) -> bool {
        if termios.is_canonical() {
            return !self.lines.is_empty();
        }
        let least = if termios.timeout_ns() == 0 { termios.least().max(1) } else { 1 };
        self.ready.len() >= least
    }

    /// The answer to a read, at this instant.
    pub(crate) fn read(&mut self, termios: &Termios, request: &Request) -> Reading {
        if termios.is_canonical() {
            return match self.lines.front_mut() {
                Some(length) => {
                    let taken = request.room.min(*length);
                    *length -= taken;
                    if *length == 0 {
                        self.lines.pop_front();
                    }
                    Reading::Bytes(self.ready.drain(..taken).collect())
                }
                None if request.is_nonblocking => Reading::Nothing,
                None => Reading::Waiting(None),
            };
        }
        let (there, least, timeout_ns) = (self.ready.len(), termios.least(), termios.timeout_ns());
        let enough = there >= least.clamp(1, request.room.max(1));
        let until_ns = match (least, timeout_ns) {
            _ if enough || request.room == 0 => Some(0),
            (0, 0) => Some(0),
            _ if request.is_nonblocking && there > 0 => Some(0),
            _ if request.is_nonblocking => return Reading::Nothing,
            (0, timeout_ns) => Some(request.began_ns + timeout_ns),
            (_, 0) => None,
            // The time between bytes: it runs only once there is one.
            (_, _) if there == 0 => None,
            (_, timeout_ns) => Some(request.began_ns.max(self.last_ns) + timeout_ns),
        };
        match until_ns {
            Some(until_ns) if until_ns <= request.now_ns => {
                Reading::Bytes(self.ready.drain(..there.min(request.room)).collect())
            }
            until_ns => Reading::Waiting(until_ns),
        }
    }

    /// Bytes that FIONREAD tells.
    pub(crate) fn available(&self) -> usize {
        self.ready.len()
    }

    /// Throws everything away.
    pub(crate) fn clear(&mut self) {
        self.ready.clear();
        self.lines.clear();
        self.editing.clear();
    }

    /// The program has changed between lines and bytes: what is there can be read.
    pub(crate) fn change_mode(&mut self, is_canonical: bool) {
        self.lines.clear();
        self.ready.extend(self.editing.drain(..));
        if is_canonical && !self.ready.is_empty() {
            self.lines.push_back(self.ready.len());
        }
    }
}

/// Bytes of a program as they enter the UART (OPOST).
pub(crate) fn process(termios: &Termios, bytes: &[u8]) -> Vec<u8> {
    let flag = |flag| termios.output & flag != 0;
    if !flag(libc::OPOST) {
        return bytes.to_vec();
    }
    let mut processed = Vec::with_capacity(bytes.len() + 8);
    for byte in bytes {
        match byte {
            b'\n' if flag(libc::ONLCR) => processed.extend_from_slice(b"\r\n"),
            b'\r' if flag(libc::OCRNL) => processed.push(b'\n'),
            byte => processed.push(*byte),
        }
    }
    processed
}
