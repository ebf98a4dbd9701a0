//! A program that is connected to a port's socket.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::os::fd::BorrowedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::happened::Happened;
use crate::socket::Connection;
use crate::telnet::{Event, Telnet};
use baudbot_board::far_end::{Read, Settings};

/// A program that is connected.
#[derive(Debug)]
pub(crate) struct Program {
    connection: Connection,
    telnet: Option<Telnet>,
    /// The bytes that are sent before anything else: answers, and the rest of an escape that its machine has not taken.
    owed: Vec<u8>,
    /// The bytes of the program that the cable has no room for yet.
    unsent: VecDeque<u8>,
    /// The program has closed its end: nothing more comes.
    has_ended: bool,
}

/// The room for a program's data while the cable is busy, so that commands behind it come through, as in a terminal
/// server. A program that sends more waits.
const MOST_UNSENT: usize = 64 << 10;

/// Most bytes of answers that a program has not taken; one that takes none has no use for more.
const MOST_OWED: usize = 64 << 10;

impl Program {
    /// A program at this connection, whose UART begins so if it speaks RFC 2217.
    pub(crate) fn new(connection: Connection, settings: Option<Settings>) -> Self {
        let telnet = settings.map(Telnet::new);
        Self { connection, telnet, owed: Vec::new(), unsent: VecDeque::new(), has_ended: false }
    }

    /// The program's settings of its UART, if it can set it.
    pub(crate) fn settings(&self) -> Option<Settings> {
        self.telnet.as_ref().map(Telnet::settings)
    }

    /// The descriptor to wait at for its bytes, if any of them are to be taken now.
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

    /// The program's bytes, as far as there is room for them. Commands are obeyed whether there is room or not.
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
        self.unsent.extend(heard.data);
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

    /// Gives it bytes, and returns how many of them it gets. What its machine does not take is lost, as at a UART that
    /// overruns.
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

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::os::unix::net::UnixStream;

    use super::*;

    /// A program's end, and what the port has of it.
    fn connected(telnet: bool) -> (UnixStream, Program) {
        let (theirs, ours) = UnixStream::pair().unwrap();
        ours.set_nonblocking(true).unwrap();
        (theirs, Program::new(Connection::Unix(ours), telnet.then(|| Settings::new_8n1(9600))))
    }

    fn read(program: &mut Program, room: usize) -> (Vec<u8>, Vec<Happened>) {
        let mut happened = Vec::new();
        (program.read(&mut [0; 512], room, &mut happened), happened)
    }

    const DTR_OFF: [u8; 7] = [255, 250, 44, 5, 9, 255, 240];
    const DTR_ON: [u8; 7] = [255, 250, 44, 5, 8, 255, 240];
    const PURGE_SENT: [u8; 7] = [255, 250, 44, 12, 2, 255, 240];

    #[test]
    fn commands_are_obeyed_although_the_cable_has_no_room_for_the_data_before_them() {
        let (mut theirs, mut program) = connected(true);
        theirs.write_all(&[7; 10_000]).unwrap();
        theirs.write_all(&DTR_OFF).unwrap();
        theirs.write_all(&DTR_ON).unwrap();
        assert_eq!(read(&mut program, 0), (vec![], vec![Happened::Opened]));
        let mut answers = [0; 14];
        theirs.read_exact(&mut answers).unwrap();
        assert_eq!((answers[3..5].to_vec(), answers[10..12].to_vec()), (vec![105, 9], vec![105, 8]));
        assert_eq!(read(&mut program, 3), (vec![7; 3], vec![]), "the data wait for room");
    }

    #[test]
    fn data_that_wait_are_thrown_away_when_the_program_wants_that() {
        let (mut theirs, mut program) = connected(true);
        theirs.write_all(&[7; 1000]).unwrap();
        theirs.write_all(&PURGE_SENT).unwrap();
        theirs.write_all(b"N").unwrap();
        assert_eq!(read(&mut program, 10), (b"N".to_vec(), vec![Happened::PurgeSent]));
    }

    #[test]
    fn a_program_that_sends_without_an_end_waits() {
        for (telnet, most) in [(true, MOST_UNSENT), (false, 0)] {
            let (mut theirs, mut program) = connected(telnet);
            theirs.set_nonblocking(true).unwrap();
            let mut sent = 0;
            while let Ok(n) = theirs.write(&[7; 4096]) {
                sent += n;
                read(&mut program, 0);
            }
            assert!(program.unsent.len() <= most && sent < 10 << 20, "{sent}");
            assert!(program.fd(false).is_none(), "nothing is read before there is room");
        }
    }

    #[test]
    fn what_a_program_has_left_is_taken_before_it_is_over() {
        let (mut theirs, mut program) = connected(true);
        theirs.write_all(b"D,0,0\r").unwrap();
        drop(theirs);
        assert_eq!(read(&mut program, 2).0, b"D,");
        assert!(program.is_gone() && program.has_left() && !program.is_over());
        assert_eq!(read(&mut program, 100).0, b"0,0\r");
        assert!(program.is_over());
    }

    #[test]
    fn an_escape_that_was_cut_is_completed_first() {
        let (mut theirs, mut program) = connected(true);
        let byte = |byte| Read { byte, at_ns: 0, error: None };
        let mut taken = 0;
        // Until the program's machine takes no more, perhaps half an escape.
        for _ in 0..10_000 {
            taken += program.write(&[byte(255); 101]);
        }
        let mut received = vec![0; 2 * taken];
        theirs.set_nonblocking(true).unwrap();
        let mut found = 0;
        while found < received.len() {
            match theirs.read(&mut received[found..]) {
                Ok(n) => found += n,
                // Owed bytes go first.
                Err(_) => drop(program.write(&[])),
            }
        }
        assert!(received.iter().all(|byte| *byte == 255) && taken < 1_010_000, "{taken}");
        assert_eq!(program.write(&[byte(1)]), 1);
        assert_eq!(theirs.read(&mut received).unwrap(), 1);
    }
}
