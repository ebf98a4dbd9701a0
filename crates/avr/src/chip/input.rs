//! Levels, characters and voltages that come from outside.

use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Chip;
use crate::board::Board;
use crate::pin::{External, Pin};
use crate::usart::{BitLength, Frame, LineError};

/// Changes of pins that can be waiting.
const ROOM: usize = 64;

/// A change of a pin cannot be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum InputError {
    /// There is no room, as too many changes are waiting.
    #[error("{ROOM} changes of pins are waiting, and no more have room")]
    Full,
    /// The instant is over.
    #[error("a pin cannot change at {at}, as it is {now} already")]
    Past {
        /// The instant at which it should change.
        at: u64,
        /// The present instant.
        now: u64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Change {
    at: u64,
    pin: Pin,
    external: External,
}

/// Changes of pins in the order of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Inputs {
    /// The last one comes first.
    waiting: ArrayVec<Change, ROOM>,
}

impl Inputs {
    pub(super) fn next_due(&self) -> u64 {
        self.waiting.last().map_or(u64::MAX, |change| change.at)
    }

    pub(super) fn take_due(&mut self, period: u64) -> Option<(Pin, External)> {
        if self.next_due() > period {
            return None;
        }
        self.waiting.pop().map(|change| (change.pin, change.external))
    }

    fn put(&mut self, change: Change) -> Result<(), InputError> {
        let place = self.waiting.iter().rposition(|other| other.at > change.at).map_or(0, |later| later + 1);
        self.waiting.try_insert(place, change).map_err(|_| InputError::Full)
    }
}

impl Chip {
    /// Another part does this to a pin from an instant on, which must not be over. Changes at one instant are taken in the
    /// order in which they were given.
    ///
    /// # Errors
    ///
    /// The instant is over, or too many changes are waiting.
    pub fn set_pin(&mut self, pin: Pin, external: External, at: u64) -> Result<(), InputError> {
        let now = self.now();
        if at < now {
            return Err(InputError::Past { at, now });
        }
        self.inputs.put(Change { at, pin, external })?;
        self.schedule();
        Ok(())
    }

    /// A character comes in at RXD: its start bit begins at this instant, which must not be over.
    ///
    /// The receiver samples its bits as it would those of a wire, so that a clock that is too fast or too slow gives wrong
    /// bits and frame errors. The pin itself does not move.
    ///
    /// # Errors
    ///
    /// The line is not free then, or too many characters are on their way.
    pub fn receive(&mut self, frame: Frame, start: u64, bit: BitLength) -> Result<(), LineError> {
        self.usart.put(self.now(), frame, start, bit)?;
        self.schedule();
        Ok(())
    }

    /// A master on the SPI bus has selected this chip and exchanges a byte with it. None: the program has not made it a
    /// slave.
    pub fn exchange_spi(&mut self, byte: u8) -> Option<u8> {
        self.spi.exchange(byte)
    }

    /// Voltages have changed now: the comparator compares them.
    pub fn analog_changed<B: Board>(&mut self, board: &mut B) {
        self.compare(board);
        self.check_trigger(self.cycle);
        self.schedule();
    }
}
