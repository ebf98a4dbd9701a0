//! The clock: periods of the source, and cycles of the processor.
//!
//! Outside, instants are counted in periods of the clock source, which never change. Inside, all that the system clock
//! drives is counted in its cycles; CLKPR decides how many periods a cycle has, and in deep sleep there are none.
//!
//! Source: data sheet, sections *System Clock Prescaler* and *Sleep Modes*.

use serde::{Deserialize, Serialize};

/// No instant and no cycle comes after this one: at 16 MHz more than two thousand years.
pub const LATEST: u64 = 1 << 60;

/// The map from cycles to periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Clock {
    /// CLKPS: a cycle has two to the power of this many periods.
    shift: u8,
    cycle: u64,
    period: u64,
}

impl Clock {
    pub(crate) const fn new(shift: u8) -> Self {
        Self { shift, cycle: 0, period: 0 }
    }

    pub(crate) const fn shift(&self) -> u8 {
        self.shift
    }

    /// The period with which a cycle begins; the cycle is not before the last change.
    #[inline]
    pub(crate) const fn period_of(&self, cycle: u64) -> u64 {
        self.period + ((cycle - self.cycle) << self.shift)
    }

    /// The first cycle that begins at or after a period.
    #[inline]
    pub(crate) const fn cycle_from(&self, period: u64) -> u64 {
        let periods = period.saturating_sub(self.period);
        let rest = if periods & ((1 << self.shift) - 1) == 0 { 0 } else { 1 };
        self.cycle.saturating_add((periods >> self.shift) + rest)
    }

    /// Whether this is a clock that has run up to this cycle.
    pub(crate) const fn is_possible(&self, cycle: u64) -> bool {
        self.shift <= 8
            && self.cycle <= cycle
            && self.period < LATEST
            && cycle - self.cycle < LATEST >> self.shift
    }

    /// Cycles are longer or shorter from this cycle on.
    pub(crate) const fn set_shift(&mut self, cycle: u64, shift: u8) {
        self.period = self.period_of(cycle);
        self.cycle = cycle;
        self.shift = shift;
    }

    /// The clock has stood at this cycle, until this period.
    pub(crate) const fn skip_to(&mut self, cycle: u64, period: u64) {
        self.cycle = cycle;
        self.period = period;
    }
}

/// A time of the clock source for a duration in microseconds, rounded up.
pub(crate) const fn periods(clock_hz: u32, microseconds: u64) -> u64 {
    (microseconds * clock_hz as u64).div_ceil(1_000_000)
}

/// A sequence of two writes in which the second must follow within four cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Window {
    until: u64,
}

impl Window {
    const CYCLES: u64 = 4;

    pub(crate) const fn open(&mut self, now: u64) {
        self.until = now + Self::CYCLES;
    }

    pub(crate) const fn close(&mut self) {
        self.until = 0;
    }

    pub(crate) const fn is_open(self, now: u64) -> bool {
        now <= self.until && self.until != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_and_periods_agree_after_each_change() {
        let mut clock = Clock::new(0);
        assert_eq!(clock.period_of(100), 100);
        clock.set_shift(100, 3);
        assert_eq!(clock.period_of(110), 180);
        assert_eq!((clock.cycle_from(180), clock.cycle_from(181), clock.cycle_from(0)), (110, 111, 100));
        clock.skip_to(110, 1000);
        assert_eq!(clock.period_of(111), 1008);
    }
}
