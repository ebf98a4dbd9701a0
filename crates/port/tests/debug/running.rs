//! A board that runs in a thread of its own, under a debugger.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use baudbot_access::peer::Reach;
use baudbot_avr::{Chip, Fuses, Part, Program, Supply};
use baudbot_board::{Board, ChipClock, Physics, Wiring};
use baudbot_port::debug::GdbServer;
use baudbot_sim::chip::Probe;

/// A board that is given a millisecond after the other.
pub(crate) struct Running {
    pub(crate) address: SocketAddr,
    milliseconds: Arc<AtomicU64>,
    is_over: Arc<AtomicBool>,
    gives_up: Arc<AtomicBool>,
    thread: Option<JoinHandle<Board>>,
}

/// Nothing is around the board.
pub(crate) struct Nothing;

impl Physics for Nothing {}

pub(crate) fn board(words: &[u16]) -> Board {
    let part = Part::Atmega328P;
    let program = Program::from_words(part, words).unwrap();
    let chip = Chip::new(&program, Fuses::external_clock(part), Supply::ARDUINO);
    let wiring = Wiring::builder().build().unwrap();
    Board::new(chip, ChipClock::exact(16_000_000).unwrap(), wiring).unwrap()
}

impl Running {
    pub(crate) fn start(words: &[u16]) -> Self {
        let gives_up = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&gives_up);
        let server = GdbServer::listen(0, Reach::OwnUser, move || asked.load(Ordering::SeqCst)).unwrap();
        let address = server.address();
        let (milliseconds, is_over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (done, over, mut board) = (Arc::clone(&milliseconds), Arc::clone(&is_over), board(words));
        let thread = thread::spawn(move || {
            while !over.load(Ordering::SeqCst) {
                let next = done.load(Ordering::SeqCst) + 1;
                server.run(&mut board, next * 1_000_000, &mut Nothing);
                done.store(next, Ordering::SeqCst);
            }
            board
        });
        Self { address, milliseconds, is_over, gives_up, thread: Some(thread) }
    }

    /// The number of milliseconds that are over.
    pub(crate) fn now_ms(&self) -> u64 {
        self.milliseconds.load(Ordering::SeqCst)
    }

    /// Waits until time has gone on.
    pub(crate) fn goes_on(&self) {
        let (from, begun) = (self.now_ms(), Instant::now());
        while self.now_ms() < from + 10 {
            assert!(begun.elapsed() < Duration::from_secs(20), "the board stands at {from} ms");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Checks that no time passes.
    pub(crate) fn stands(&self) {
        let from = self.now_ms();
        thread::sleep(Duration::from_millis(150));
        assert_eq!(self.now_ms(), from);
    }

    /// The program is to end, as by a signal.
    pub(crate) fn give_up(&self) {
        self.gives_up.store(true, Ordering::SeqCst);
    }

    /// Ends with the next millisecond.
    pub(crate) fn end(mut self) -> Board {
        self.is_over.store(true, Ordering::SeqCst);
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.gives_up.store(true, Ordering::SeqCst);
        self.is_over.store(true, Ordering::SeqCst);
    }
}
