//! The receiver's line: the level at the pin RXD, and characters that the embedder puts on it.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::frame::{BitLength, Frame};
use crate::clock::LATEST;

/// Characters that can be on the line or on their way.
const ROOM: usize = 16;

/// A character cannot be put on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LineError {
    /// There is no room, as too many characters are on the line and before it.
    #[error("{ROOM} characters are on the line, and no more have room")]
    Full,
    /// The character would begin after the last instant of all.
    #[error("no character can begin at {start}: the last instant is {LATEST}")]
    Late {
        /// The instant at which it should begin.
        start: u64,
    },
    /// The character would begin before the one in front of it has ended, or in the past.
    #[error("a character cannot begin at {start}: before {free} the line is not free")]
    Occupied {
        /// The instant at which it should begin.
        start: u64,
        /// The instant from which on the line is free.
        free: u64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Incoming {
    pub(super) frame: Frame,
    pub(super) start: u64,
    pub(super) bit: BitLength,
}

impl Incoming {
    fn end(&self) -> u64 {
        self.start + self.bit.begin_of(u64::from(self.frame.bits()))
    }

    /// The period in which it ends.
    fn last_period(&self) -> u64 {
        self.start + self.bit.end_within(u64::from(self.frame.bits()))
    }
}

/// A line with characters in the order of time. It is low if the pin is low or a character is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Line {
    pub(super) pin: bool,
    incoming: ArrayVec<Incoming, ROOM>,
}

impl Line {
    pub(super) const fn new() -> Self {
        Self { pin: true, incoming: ArrayVec::new_const() }
    }

    /// Whether all characters are some that could have been put here.
    pub(super) fn is_possible(&self) -> bool {
        self.incoming.iter().all(|one| one.start < LATEST)
    }

    /// Puts a character behind the others. `now` and its start are periods of the clock source.
    pub(super) fn put(&mut self, now: u64, incoming: Incoming) -> Result<(), LineError> {
        self.forget_before(now);
        // Within the last period of a stop bit the next start bit may begin: the sender's bits need not end with a period.
        let free = self.incoming.last().map_or(0, Incoming::last_period).max(now);
        if incoming.start < free {
            return Err(LineError::Occupied { start: incoming.start, free });
        }
        if incoming.start >= LATEST {
            return Err(LineError::Late { start: incoming.start });
        }
        self.incoming.try_push(incoming).map_err(|_| LineError::Full)
    }

    /// Forgets characters that are over by this period.
    pub(super) fn forget_before(&mut self, period: u64) {
        let over = self.incoming.iter().take_while(|one| one.end() <= period).count();
        self.incoming.drain(..over);
    }

    /// The level in a period.
    pub(super) fn level(&self, period: u64) -> bool {
        let Some(one) = self.at(period) else { return self.pin };
        self.pin && one.frame.level(one.bit.bit_at(period - one.start))
    }

    /// The next period in which the level may differ from that in this one, as long as the pin stays as it is.
    pub(super) fn next_change(&self, period: u64) -> Option<u64> {
        if !self.pin {
            return None;
        }
        match self.at(period) {
            Some(one) => Some(one.start + one.bit.begin_of(one.bit.bit_at(period - one.start) + 1)),
            None => self.incoming.iter().map(|one| one.start).find(|&start| start > period),
        }
    }

    fn at(&self, period: u64) -> Option<&Incoming> {
        self.incoming.iter().find(|one| one.start <= period && period < one.end())
    }
}
