//! A program that is connected to a port's socket.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::os::fd::BorrowedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::medium::Happened;
use crate::socket::Connection;
use crate::telnet::{Event, Telnet};
use crate::uart::{Read, Settings};

/// A program that is connected.
#[derive(Debug)]
pub(crate) struct Program {
    connection: Connection,
    telnet: Option<Telnet>,
    /// What is to be sent before anything else: answers, and the rest of an escape that its machine has not taken.
    owed: Vec<u8>,
    /// What the program has sent that the cable has no room for yet.
    unsent: VecDeque<u8>,
    /// It has closed its end: nothing more comes.
    has_ended: bool,
}

/// What a terminal server keeps of a program's data while the cable is busy, so that commands behind it come through. A program
/// that sends more waits.
const MOST_UNSENT: usize = 64 << 10;

/// Most bytes of answers that a program has not taken; one that takes none has no use for more.
const MOST_OWED: usize = 64 << 10;

impl Program {
    /// A program at this connection, whose UART begins so if it speaks RFC 2217.
    pub(crate) fn new(connection: Connection, settings: Option<Settings>) -> Self {
        let telnet = settings.map(Telnet::new);
        Self { connection, telnet, owed: Vec::new(), unsent: VecDeque::new(), has_ended: false }
    }

    /// How it has set its UART, if it can.
    pub(crate) fn settings(&self) -> Option<Settings> {
        self.telnet.as_ref().map(Telnet::settings)
    }

    /// Where to wait for what it sends, if any of that is to be taken now.
    pub(crate) fn fd(&self, has_room: bool) -> Option<BorrowedFd<'_>> {
        let is_wanted = if self.telnet.is_some() { self.unsent.len() < MOST_UNSENT } else { has_room };
        (is_wanted && !self.has_ended).then(|| self.connection.fd())
    }

    /// Whether it has closed its end, so that only what it has left is to be read.
    pub(crate) fn is_gone(&self) -> bool {
        let mut fds = [PollFd::from_borrowed_fd(self.connection.fd(), PollFlags::RDHUP)];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        self.has_ended || poll(&mut fds, Some(&at_once)).is_ok() && !fds[0].revents().is_empty()
    }

    /// Whether something is to be done for it as soon as the cable has room.
    pub(crate) fn has_left(&self) -> bool {
        self.has_ended || !self.unsent.is_empty()
    }

    /// Whether it is gone, and all is taken that it has sent.
    pub(crate) fn is_over(&self) -> bool {
        self.has_ended && self.unsent.is_empty()
    }

    /// What it has sent, as far as there is room for. Commands are obeyed whether there is room or not.
    pub(crate) fn read(&mut self, buffer: &mut [u8], room: usize, happened: &mut Vec<Happened>) -> Vec<u8> {
        let most = if self.telnet.is_some() { MOST_UNSENT } else { room };
        while !self.has_ended && self.unsent.len() < most {
            let wanted = buffer.len().min(most - self.unsent.len());
            match self.connection.read(&mut buffer[..wanted]) {
                Ok(n) if n > 0 => self.hear(&buffer[..n], happened),
                Err(error) if is_busy(&error) => break,
                Ok(_) | Err(_) => self.has_ended = true,
            }
        }
        let taken = room.min(self.unsent.len());
        self.unsent.drain(..taken).collect()
    }

    fn hear(&mut self, bytes: &[u8], happened: &mut Vec<Happened>) {
        let Some(telnet) = &mut self.telnet else { return self.unsent.extend(bytes) };
        let heard = telnet.hear(bytes);
        self.unsent.extend(heard.data);
        for event in heard.events {
            happened.extend(match event {
                Event::Dtr(true) => Some(Happened::Opened),
                Event::Dtr(false) => None,
                Event::Break(on) => Some(Happened::Break(on)),
                Event::PurgeReceived => Some(Happened::PurgeReceived),
                Event::PurgeSent => {
                    self.unsent.clear();
                    Some(Happened::PurgeSent)
                }
            });
        }
        if self.owed.len() < MOST_OWED {
            self.owed.extend(heard.replies);
        }
        self.pay();
    }

    /// Sends what is owed, as far as its machine takes it.
    fn pay(&mut self) {
        if !self.owed.is_empty() {
            let gone = self.connection.write(&self.owed).unwrap_or(0);
            self.owed.drain(..gone);
        }
    }

    /// Gives it bytes, and says how many of them it gets. What its machine does not take is lost, as at a UART that overruns.
    pub(crate) fn write(&mut self, reads: &[Read]) -> usize {
        self.pay();
        if !self.owed.is_empty() {
            return 0;
        }
        let (mut bytes, mut ends) = (Vec::with_capacity(reads.len()), Vec::with_capacity(reads.len()));
        for read in reads {
            match &self.telnet {
                Some(telnet) => bytes.extend(telnet.told(read)),
                None => bytes.push(read.byte),
            }
            ends.push(bytes.len());
        }
        let gone = self.connection.write(&bytes).unwrap_or(0);
        let whole = ends.partition_point(|end| *end <= gone);
        let begins = whole.checked_sub(1).map_or(0, |last| ends[last]);
        if let Some(&end) = ends.get(whole).filter(|_| begins < gone) {
            self.owed = bytes[gone..end].to_vec();
            return whole + 1;
        }
        whole
    }
}

fn is_busy(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
