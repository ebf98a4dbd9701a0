//! The thread of a port: it gives bytes to the program at their instants, and takes what the program writes as fast as the cable
//! does.

use std::collections::VecDeque;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tokio::sync::mpsc::UnboundedSender;

use crate::cable::{CHUNK, Cable};
use crate::clock::{Clock, now_unix_ns};
use crate::happened::Happened;
use crate::hold::Hold;
use crate::medium::Medium;
use crate::report::Report;
use baudbot_board::far_end::{Read, Settings};

/// An order to the thread.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Order {
    /// Bytes that arrive at the laptop in a tick.
    Bytes {
        /// The relation of simulated time to the wall clock.
        clock: Clock,
        /// The baud rate of the robot's UART, if it has one.
        baud: Option<u32>,
        /// Bytes, and their instants of simulated time.
        bytes: Vec<(u64, u8)>,
    },
    /// The port is to be closed.
    Close,
}

/// A report of the thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Told {
    Opened,
    Closed,
    /// A program was sent away, as that of another port has the cable.
    Refused,
    /// Bytes for the robot.
    Bytes(Vec<u8>),
}

/// The state of a port in its thread.
pub(crate) struct Driver {
    pub(crate) medium: Medium,
    /// The cable, which other ports may have, too.
    pub(crate) hold: Hold,
    pub(crate) cable: Cable,
    pub(crate) step_ns: u64,
    pub(crate) orders: Receiver<Order>,
    /// Something is to be read there when an order has come.
    pub(crate) wake: OwnedFd,
    /// The number of the port, and the channel for its reports.
    pub(crate) told: (usize, UnboundedSender<(usize, Told)>),
    /// None before the first Turn.
    pub(crate) clock: Option<Clock>,
    /// The bytes that are still to be given to the program.
    pub(crate) waiting: VecDeque<Read>,
    /// The bytes that the program's UART has still to send before the robot's end may get them.
    pub(crate) sending: VecDeque<Read>,
    pub(crate) report: Report,
    /// The number of reported bytes that the server has not been sent yet.
    pub(crate) held: Arc<AtomicUsize>,
    /// Since when the program sends a break, by simulated time.
    pub(crate) break_since_ns: Option<u64>,
}

/// Most bytes that wait for their instants: more than any cable brings in a tick.
const MOST_WAITING: usize = 16 << 20;

/// Most bytes of a program that wait for a world that stands still, as in a driver's buffer. The program then blocks.
const MOST_HELD: usize = 4096;

/// The room in the driver of a world's laptop, unless the scenario has another number (`laptop_buffer_bytes`).
const DRIVER_BYTES: usize = 4096;

/// The interval at which it is checked whether a program has opened a pty.
const LOOKS_NS: u64 = 2_000_000;

impl Driver {
    /// Serves until the port is closed. Gives what it has done.
    pub(crate) fn serve(mut self) -> Report {
        let mut buffer = vec![0; CHUNK];
        while self.take_orders() {
            self.look();
            self.give();
            self.take(&mut buffer);
            self.listen_on();
            self.send();
            self.wait();
        }
        self.report
    }

    fn settings(&self) -> Option<Settings> {
        self.medium.settings()
    }

    /// Simulated time. A world that stands still, so that no Turn comes, is not ahead of its last one by more than its window.
    fn now_ns(&self) -> u64 {
        let latest = |clock: Clock| clock.sim_ns + self.window_ns();
        self.clock.map_or(0, |clock| clock.sim_ns(now_unix_ns()).min(latest(clock)))
    }

    /// The world's time has gone back, by a reset or a restored state: what was on its way belongs to another run.
    fn forget(&mut self) {
        self.waiting.clear();
        self.sending.clear();
        self.break_since_ns = None;
        self.cable.forget();
    }

    /// `false` if the port is to be closed.
    fn take_orders(&mut self) -> bool {
        let _ = rustix::io::read(&self.wake, &mut [0; 8]);
        loop {
            match self.orders.try_recv() {
                Ok(Order::Bytes { clock, baud, bytes }) => {
                    if self.clock.is_some_and(|last| clock.sim_ns < last.sim_ns) {
                        self.forget();
                    }
                    self.clock = Some(clock);
                    self.cable.set_baud(baud);
                    let program = self.settings();
                    self.cable.up(program, &bytes, &mut self.waiting);
                    while self.waiting.len() > MOST_WAITING {
                        self.waiting.pop_front();
                        self.report.overrun += 1;
                    }
                }
                Ok(Order::Close) | Err(TryRecvError::Disconnected) => return false,
                Err(TryRecvError::Empty) => return true,
            }
        }
    }

    fn look(&mut self) {
        let mut happened = Vec::new();
        self.medium.look(&self.hold, &mut happened);
        self.handle(happened);
    }

    fn handle(&mut self, happened: Vec<Happened>) {
        for what in happened {
            match what {
                Happened::Opened => {
                    self.report.opened += 1;
                    self.tell(Told::Opened);
                }
                Happened::Closed => {
                    self.break_since_ns = None;
                    self.tell(Told::Closed);
                }
                Happened::Refused => self.tell(Told::Refused),
                Happened::Break(true) => self.break_since_ns = Some(self.now_ns()),
                Happened::Break(false) => self.end_break(),
                // Bytes that have not arrived yet are still on the cable.
                Happened::PurgeReceived => {
                    let now = self.now_ns();
                    self.waiting.retain(|read| read.at_ns > now);
                }
                Happened::PurgeSent => {
                    self.sending.clear();
                    self.cable.forget_sent();
                }
            }
        }
    }

    fn end_break(&mut self) {
        let Some(since) = self.break_since_ns.take() else { return };
        let now = self.now_ns();
        self.cable.send_break(since, now.saturating_sub(since), &mut self.sending);
    }

    fn tell(&self, told: Told) {
        // The receiver is gone only when the port is to be closed.
        drop(self.told.1.send((self.told.0, told)));
    }

    /// Sends the robot what the program's UART has sent by now. A world that is late is not sent what was written after the end of
    /// the tick that it is in: it would be on the cable too early.
    fn send(&mut self) {
        let now = self.clock.map_or(0, |clock| self.now_ns().min(clock.sim_ns + self.step_ns));
        let count = self.sending.partition_point(|read| read.at_ns <= now);
        if count == 0 {
            return;
        }
        let reads: Vec<Read> = self.sending.drain(..count).collect();
        self.report.taken += count as u64;
        self.held.fetch_add(count, Ordering::Relaxed);
        self.report.line_errors += reads.iter().filter(|read| read.error.is_some()).count() as u64;
        self.tell(Told::Bytes(reads.iter().map(|read| read.byte).collect()));
    }

    /// Gives the program what is due.
    fn give(&mut self) {
        let now = now_unix_ns();
        let due = |read: &Read| self.clock.is_none_or(|clock| clock.unix_ns(read.at_ns) <= now);
        let count = self.waiting.iter().take_while(|read| due(read)).count();
        if count == 0 {
            return;
        }
        let reads: Vec<Read> = self.waiting.drain(..count).collect();
        if !self.medium.is_open() {
            self.report.unheard += count as u64;
            return;
        }
        let taken = self.medium.write(&reads);
        self.report.overrun += (count - taken) as u64;
        for read in &reads[..taken] {
            let due_ns = self.clock.map_or(now, |clock| clock.unix_ns(read.at_ns));
            self.report.note(1, Duration::from_nanos(now_unix_ns().saturating_sub(due_ns)));
            self.report.line_errors += u64::from(read.error.is_some());
        }
    }

    /// Takes what the program has written, as far as the cable has room.
    fn take(&mut self, buffer: &mut [u8]) {
        let (room, mut happened) = (self.room(), Vec::new());
        let bytes = self.medium.read(buffer, room, &self.hold, &mut happened);
        self.handle(happened);
        let (program, now) = (self.settings(), self.now_ns());
        self.cable.down(program, now, &bytes, &mut self.sending);
    }

    /// Reads on although there is no sender any more.
    fn listen_on(&mut self) {
        if self.cable.is_listening() {
            let now = self.now_ns();
            self.cable.idle(now, &mut self.waiting, &mut self.sending);
        }
    }

    /// The number of bytes that may be taken from the program. Bytes that the world may not have carried since its
    /// last Turn are in its laptop's driver, which refuses more than it can hold.
    fn room(&self) -> usize {
        let on_cable = self.cable.room(self.settings(), self.now_ns(), self.window_ns());
        let in_driver = self.clock.map_or(0, |clock| self.cable.unsent(clock.sim_ns));
        let held = self.held.load(Ordering::Relaxed) + self.sending.len();
        on_cable.min(MOST_HELD.saturating_sub(held)).min(DRIVER_BYTES.saturating_sub(in_driver))
    }

    /// Bytes that are written are sent when the tick is over; so that the line is never idle, two ticks are kept filled.
    fn window_ns(&self) -> u64 {
        2 * self.step_ns
    }

    /// Waits until there is something to do.
    fn wait(&self) {
        let now = now_unix_ns();
        let has_room = self.room() > 0;
        let until = self.next_ns(now, has_room);
        let mut fds: Vec<_> = self.medium.fds(has_room);
        fds.push(self.wake.as_fd());
        let mut fds: Vec<_> = fds.into_iter().map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN)).collect();
        let left_ns = until.saturating_sub(now);
        let left =
            Timespec { tv_sec: (left_ns / 1_000_000_000) as i64, tv_nsec: (left_ns % 1_000_000_000) as i64 };
        // A signal ends the wait early, which does no harm.
        let _ = poll(&mut fds, Some(&left));
    }

    /// The instant at which there is something to do next, if nothing happens before, in nanoseconds since 1970.
    fn next_ns(&self, now: u64, has_room: bool) -> u64 {
        let mut until = now + LONGEST_WAIT_NS;
        if let Some(read) = self.waiting.front() {
            until = until.min(self.clock.map_or(now, |clock| clock.unix_ns(read.at_ns)));
        }
        if let Some((clock, read)) = self.clock.zip(self.sending.front()) {
            until = until.min(in_time(clock.unix_ns(read.at_ns), now));
        }
        // The thread is woken when the server has taken what is held.
        let is_held = self.held.load(Ordering::Relaxed) >= MOST_HELD;
        if let Some(clock) = self.clock.filter(|_| !has_room && !is_held) {
            let at = self.cable.has_room_ns(self.settings(), self.window_ns());
            until = until.min(in_time(clock.unix_ns(at), now));
        }
        if has_room && self.medium.has_left() {
            until = now;
        }
        if self.medium.is_looked_at() || self.cable.is_listening() {
            until = until.min(now + LOOKS_NS);
        }
        until
    }
}

/// An instant, or a while from now on if it has passed: in a world that stands it comes only when that goes on.
fn in_time(at: u64, now: u64) -> u64 {
    if at > now { at } else { now + LOOKS_NS }
}

/// The longest time without a look at anything, in nanoseconds.
const LONGEST_WAIT_NS: u64 = 100_000_000;
