//! Who does what: the world's thread whatever is to be done, and somebody with a letter what does not take long.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::{Host, Next};
use crate::letter::{Activity, Letter, Order};
use crate::recording::Recorder;

/// What is to be done about a world after a visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// There is more to do, and the world's thread should do it.
    Thread,
    /// Nothing before a letter comes, or before this instant.
    Wait(Option<Instant>),
    /// It is over.
    Over,
}

impl Host {
    /// The world's thread does one thing.
    pub(crate) fn work(&mut self, letters: impl FnMut() -> Option<Letter>) -> Then {
        if let Some(recorder) = &mut self.recorder {
            recorder.wait_for_disk();
        }
        if let Some(letter) = self.heavy.take() {
            self.open(letter);
        }
        self.open_all(letters);
        if let Some(why) = self.over.take() {
            self.end_recording();
            self.sessions.close_all(&why);
            return Then::Over;
        }
        let now = Instant::now();
        self.running.set(self.activity() == Activity::Running, now);
        match self.next(now) {
            Next::Begin => self.begin(now),
            Next::Finish => self.finish_with(now, &[]),
            Next::FinishAhead(_) => self.finish_ahead(now),
            Next::End => self.end(),
            Next::Watchdog => self.bite(),
            Next::Replay => self.replay(now),
            Next::Wait(until) => {
                self.alarm = until;
                return Then::Wait(until);
            }
        }
        Then::Thread
    }

    /// Somebody with letters does what does not take long, so that the world's thread need not be woken.
    pub(crate) fn visit(&mut self, mut letters: impl FnMut() -> Option<Letter>) -> Then {
        let mut begun = None;
        loop {
            if self.heavy.is_some() {
                return Then::Thread;
            }
            // Nobody else on the network waits for a disk, or for a long state to be read.
            for _ in 0..MAX_LETTERS_AT_ONCE {
                match letters() {
                    Some(letter) if self.is_heavy(&letter) => {
                        self.heavy = Some(letter);
                        return Then::Thread;
                    }
                    Some(letter) => self.open(letter),
                    None => break,
                }
            }
            let now = Instant::now();
            let patient = now - *begun.get_or_insert(now) < VISIT;
            if self.over.is_some() {
                return Then::Thread;
            }
            self.running.set(self.activity() == Activity::Running, now);
            let next = self.next(now);
            match next {
                // The thread sleeps, and not too long.
                Next::Wait(None) => return Then::Wait(None),
                Next::Wait(Some(until)) if self.alarm.is_some_and(|alarm| alarm <= until) => {
                    return Then::Wait(Some(until));
                }
                Next::Begin if self.is_quick() && patient => self.begin(now),
                Next::Finish if self.is_quick() => self.finish_with(now, &[]),
                // The Turn has to go out first, and if ticks are short the answer is here before one could be done.
                Next::FinishAhead(until)
                    if self.tick_takes < Some(WORTH_GOING_AHEAD)
                        && self.alarm.is_some_and(|alarm| alarm <= until) =>
                {
                    return Then::Wait(Some(until));
                }
                Next::Begin
                | Next::Finish
                | Next::FinishAhead(_)
                | Next::End
                | Next::Watchdog
                | Next::Replay
                | Next::Wait(Some(_)) => return Then::Thread,
            }
        }
    }

    /// Whether a tick takes less than to wake a thread for it. Who looks at the world may take any time.
    fn is_quick(&self) -> bool {
        let waits = self.pace.watchdog().is_some();
        let limit = QUICK / self.neighbours.load(Ordering::Relaxed).max(1);
        waits
            && self.on_tick.is_none()
            && !self.recorder.as_ref().is_some_and(Recorder::is_stuck)
            && self.tick_takes.is_some_and(|takes| takes < limit)
    }

    /// Whether to do what is asked may take long.
    fn is_heavy(&self, letter: &Letter) -> bool {
        let Letter::Order(order, _) = letter else { return false };
        match order {
            Order::Record(_) | Order::StopRecording(_) | Order::Seek { .. } => true,
            Order::Reset | Order::Restore { .. } | Order::Delete => self.recorder.is_some(),
            _ => false,
        }
    }

    /// Opens letters, but not so many that a flood of them would hold up the clock.
    fn open_all(&mut self, mut letters: impl FnMut() -> Option<Letter>) {
        for _ in 0..MAX_LETTERS_AT_ONCE {
            let Some(letter) = letters() else { break };
            self.open(letter);
        }
    }
}

const MAX_LETTERS_AT_ONCE: usize = 100;

/// How long a visitor stays before the world's thread takes over; other connections wait meanwhile.
const VISIT: Duration = Duration::from_micros(500);

/// Ticks that take less are done by visitors; of several worlds on a server, those that take their share of it. All
/// visitors from the network are on one thread, and long ticks are better done on several.
const QUICK: Duration = Duration::from_micros(500);

/// A tick that takes less is not worth to wake the world's thread so that it goes ahead of its brains.
const WORTH_GOING_AHEAD: Duration = Duration::from_micros(20);
