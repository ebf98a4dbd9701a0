//! Chips that are saved and loaded. What is loaded is a chip that could exist, or refused: it cannot make anything panic.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Chip, State};
use crate::clock::LATEST;
use crate::timer::Which;

impl Serialize for Chip {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Chip {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut chip = Self::deserialize(deserializer)?;
        if !chip.has_memories() || !chip.has_possible_times() || !chip.has_possible_peripherals() {
            return Err(D::Error::custom("no chip can be in this state"));
        }
        // The values set here follow from other fields.
        chip.watch_timers();
        chip.schedule();
        if chip.next_event < chip.cycle {
            return Err(D::Error::custom("an event of the chip is over"));
        }
        Ok(chip)
    }
}

impl Chip {
    fn has_memories(&self) -> bool {
        let properties = self.part.properties();
        self.sram.len() == usize::from(properties.sram_bytes)
            && self.flash.words().len() == self.part.flash_words() as usize
            && self.pc_mask == self.part.flash_words() - 1
            && self.pc <= self.pc_mask
            && self.return_bytes == properties.return_bytes
            && self.eeprom.fits(properties.eeprom_bytes)
            && self.programming.fits(properties.page_words)
    }

    fn has_possible_times(&self) -> bool {
        let held = match self.state {
            State::Held(until) => (self.now_if_possible()..LATEST).contains(&until),
            State::Awake | State::Asleep(_) => true,
        };
        self.cycle < LATEST && self.clock.is_possible(self.cycle) && self.now() < LATEST && held
    }

    fn has_possible_peripherals(&self) -> bool {
        self.limit == 0
            && self.supply.clock_hz > 0
            && self.watchdog.is_possible(self.supply.clock_hz, self.end_of_reset())
            && [Which::T0, Which::T1, Which::T2]
                .into_iter()
                .zip(&self.timers)
                .all(|(which, timer)| timer.is_possible(which as usize, self.timer_time(which, self.cycle)))
            && self.usart.is_possible(self.cycle)
            && self.adc.is_possible(self.cycle)
            && self.twi.is_possible()
    }

    /// The instant until which the processor is held in reset; if it is not, the present instant.
    fn end_of_reset(&self) -> u64 {
        match self.state {
            State::Held(until) => until,
            State::Awake | State::Asleep(_) => self.now(),
        }
    }

    /// The present instant, or the last of all if the clock is none.
    fn now_if_possible(&self) -> u64 {
        if self.clock.is_possible(self.cycle) && self.cycle < LATEST { self.now() } else { LATEST }
    }
}
