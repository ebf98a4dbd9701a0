//! The watchdog timer, by its own oscillator of 128 kHz.
//!
//! Source: data sheet, section *Watchdog Timer*. All instants are periods of the clock source, as the watchdog runs in each
//! sleep mode and does not know the system clock's prescaler.

use serde::{Deserialize, Serialize};

use crate::clock::Window;

const FLAG: u8 = 1 << 7;
const INTERRUPT: u8 = 1 << 6;
const CHANGE: u8 = 1 << 4;
const RESET: u8 = 1 << 3;
/// WDP3 and WDP2:0.
const PRESCALER: u8 = 0x27;
const OSCILLATOR_HZ: u64 = 128_000;
const SHORTEST_TIMEOUT: u64 = 2048;

/// The consequence of the end of the watchdog's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bite {
    Nothing,
    Interrupt,
    Reset,
}

/// The watchdog with its register.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Watchdog {
    control: u8,
    window: Window,
    /// WDTON.
    always_on: bool,
    clock_hz: u32,
    /// Since when it counts.
    started: u64,
    deadline: u64,
}

impl Watchdog {
    /// The state after a reset that ends with this period; `has_bitten` is WDRF, which keeps the watchdog on. Before,
    /// its oscillator times the start of the clock.
    pub(crate) fn new(clock_hz: u32, always_on: bool, has_bitten: bool, period: u64) -> Self {
        let control = if always_on || has_bitten { RESET } else { 0 };
        let mut watchdog =
            Self { control, window: Window::default(), always_on, clock_hz, started: 0, deadline: 0 };
        watchdog.restart(period);
        watchdog
    }

    /// Whether this watchdog can exist at a period.
    pub(crate) const fn is_possible(&self, clock_hz: u32, period: u64) -> bool {
        self.clock_hz == clock_hz
            && self.started <= period
            && self.deadline < 1 << 62
            && self.next_event() >= period
    }

    pub(crate) const fn requests(&self) -> bool {
        self.control & (FLAG | INTERRUPT) == FLAG | INTERRUPT
    }

    /// The interrupt has been taken. If a reset may follow, the interrupt is off from now on.
    pub(crate) fn acknowledge(&mut self) {
        self.control &= !FLAG;
        if self.control & RESET != 0 {
            self.control &= !INTERRUPT;
        }
    }

    /// `WDR`: the time begins again.
    pub(crate) fn restart(&mut self, period: u64) {
        self.started = period;
        self.deadline = period + self.timeout();
    }

    pub(crate) const fn next_event(&self) -> u64 {
        if self.control & (INTERRUPT | RESET) == 0 { u64::MAX } else { self.deadline }
    }

    pub(crate) fn event(&mut self, period: u64) -> Bite {
        if self.next_event() > period {
            return Bite::Nothing;
        }
        self.restart(self.deadline);
        if self.control & INTERRUPT != 0 && !self.always_on {
            self.control |= FLAG;
            Bite::Interrupt
        } else {
            Bite::Reset
        }
    }

    pub(crate) const fn read(&self, now: u64) -> u8 {
        self.control | if self.window.is_open(now) { CHANGE } else { 0 }
    }

    /// Writes WDTCSR at a cycle and its period. WDRF in MCUSR keeps WDE set.
    pub(crate) fn write(&mut self, value: u8, now: u64, period: u64, has_bitten: bool) {
        let mut control = self.control & (PRESCALER | RESET | FLAG & !value) | value & INTERRUPT;
        if self.window.is_open(now) {
            control = control & !(PRESCALER | RESET) | value & (PRESCALER | RESET);
            self.window.close();
        }
        control |= value & RESET;
        if value & (CHANGE | RESET) == CHANGE | RESET {
            self.window.open(now);
        }
        if has_bitten || self.always_on {
            control |= RESET;
        }
        let was_off = self.next_event() == u64::MAX;
        self.control = control;
        if was_off {
            self.restart(period);
        }
        // Another prescaler is another bit of the same counter.
        self.deadline = (self.started + self.timeout()).max(period);
    }

    /// Periods of the clock source until the watchdog bites.
    fn timeout(&self) -> u64 {
        let prescaler = (self.control & 7) | (self.control >> 2 & 8);
        (SHORTEST_TIMEOUT << prescaler.min(9)) * u64::from(self.clock_hz) / OSCILLATOR_HZ
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watchdog() -> Watchdog {
        Watchdog::new(16_000_000, false, false, 0)
    }

    #[test]
    fn each_prescaler_doubles_16_ms() {
        for prescaler in 0..=9u8 {
            let mut watchdog = watchdog();
            let bits = prescaler & 7 | (prescaler & 8) << 2;
            watchdog.write(CHANGE | RESET, 10, 10, false);
            watchdog.write(RESET | bits, 12, 12, false);
            assert_eq!(watchdog.next_event() - 10, 256_000 << prescaler);
        }
    }

    #[test]
    fn the_prescaler_stays_without_the_timed_sequence_or_after_four_cycles() {
        let mut watchdog = watchdog();
        watchdog.write(RESET | 7, 10, 10, false);
        assert_eq!(watchdog.read(11), RESET);
        watchdog.write(CHANGE | RESET, 20, 20, false);
        assert_eq!(watchdog.read(24), RESET | CHANGE);
        watchdog.write(7, 25, 25, false);
        assert_eq!(watchdog.read(26), RESET);
        watchdog.write(CHANGE | RESET, 30, 30, false);
        watchdog.write(7, 34, 34, false);
        assert_eq!(watchdog.read(35), 7);
    }

    #[test]
    fn interrupt_and_reset_mode_interrupts_once_and_resets_then() {
        let mut watchdog = watchdog();
        watchdog.write(INTERRUPT | RESET, 0, 0, false);
        assert_eq!(watchdog.event(256_000), Bite::Interrupt);
        assert!(watchdog.requests());
        watchdog.acknowledge();
        assert_eq!(watchdog.event(511_999), Bite::Nothing);
        assert_eq!(watchdog.event(512_000), Bite::Reset);
    }

    #[test]
    fn it_cannot_be_switched_off_after_it_has_bitten_or_with_wdton() {
        for (always_on, has_bitten) in [(true, false), (false, true)] {
            let mut watchdog = Watchdog::new(16_000_000, always_on, has_bitten, 0);
            watchdog.write(CHANGE | RESET, 10, 10, has_bitten);
            watchdog.write(0, 12, 12, has_bitten);
            assert_ne!(watchdog.next_event(), u64::MAX);
        }
    }
}
