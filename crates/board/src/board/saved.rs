//! Boards that are saved and loaded. What is loaded is a board that could exist, or refused: it cannot make anything panic
//! or run for ever.

use baudbot_avr::LATEST;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Board, slice_cycles};
use crate::clock::ChipClock;
use crate::wiring::Wiring;

impl Serialize for Board {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Board {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let board = Self::deserialize(deserializer)?;
        if board.is_possible() { Ok(board) } else { Err(D::Error::custom("no board can be in this state")) }
    }
}

impl Board {
    /// Whether a board that was loaded is one of this wiring, with this clock. That it is a possible board at all was
    /// checked when it was loaded.
    pub fn is_of(&self, wiring: &Wiring, clock: &ChipClock) -> bool {
        *self.wiring() == *wiring && *self.clock() == *clock
    }

    fn is_possible(&self) -> bool {
        let clock = &self.around.clock;
        clock.hz() == self.chip.supply().clock_hz
            && self.around.supply_uv() == self.chip.supply().avcc_uv
            && self.slice_cycles == slice_cycles(&self.around)
            && self.watchdog_resets == self.chip.watchdog_resets()
            // A step has been run to its end.
            && clock.cycle(self.now_ns).min(LATEST) <= self.chip.now()
            && self.around.are_possible(self.chip.now())
    }
}
