//! Timer 2 with a crystal of its own: it counts in cycles of the crystal, of which there are 32,768 in a second, and goes on
//! where the system clock stands. The other timers, and timer 2 without its crystal, count in cycles of the system clock.
//!
//! Source: data sheet, section *Asynchronous Operation of Timer/Counter2*, table *Active Clock Domains and Wake-up Sources*.
//!
//! # Deviations
//!
//! The pins of the crystal are free only with the internal oscillator as the clock source. Registers are written at once, so
//! that the flags that a register is busy never show in ASSR, and what they hold survives a change of AS2. The crystal runs as
//! soon as it is chosen.

use super::{Chip, State};
use crate::system::Sleep;
use crate::timer::Which;

const CRYSTAL_HZ: u128 = 32_768;

impl Chip {
    /// AS2, on a chip whose pins for the crystal are free.
    #[inline]
    pub(super) const fn has_crystal(&self) -> bool {
        self.system.is_asynchronous() && self.fuses.clocks_internally()
    }

    /// A cycle, as a timer counts it.
    pub(super) const fn timer_time(&self, which: Which, cycle: u64) -> u64 {
        if matches!(which, Which::T2) && self.has_crystal() {
            (self.clock.period_of(cycle) as u128 * CRYSTAL_HZ / self.supply.clock_hz as u128) as u64
        } else {
            cycle
        }
    }

    /// The cycle of a timer's next event, unless it has its own crystal.
    pub(super) fn timer_event(&self, which: Which) -> u64 {
        let own = which == Which::T2 && self.has_crystal();
        if own { u64::MAX } else { self.timers[which as usize].next_event() }
    }

    /// The next event of a timer with its own crystal, in periods of the clock source.
    pub(super) fn crystal_event(&self) -> u64 {
        let event = self.timers[Which::T2 as usize].next_event();
        if !self.has_crystal() || event == u64::MAX {
            return u64::MAX;
        }
        let period = (u128::from(event) * u128::from(self.supply.clock_hz)).div_ceil(CRYSTAL_HZ);
        u64::try_from(period).unwrap_or(u64::MAX)
    }

    /// Whether the sleep has stopped timer 2 with its crystal.
    pub(super) fn stops_crystal(&self) -> bool {
        matches!(self.state, State::Asleep(Sleep::PowerDown | Sleep::Standby))
    }

    /// Periods of the clock source in a cycle that a timer counts, as a fraction.
    pub(super) fn timer_periods(&self, which: Which, cycles: u64) -> u64 {
        if which == Which::T2 && self.has_crystal() {
            u64::try_from(u128::from(cycles) * u128::from(self.supply.clock_hz) / CRYSTAL_HZ)
                .unwrap_or(u64::MAX)
        } else {
            cycles << self.clock.shift()
        }
    }
}
