//! Instants of a chip in cycles of its clock source, and in nanoseconds.
//!
//! A clock source of nominally f hertz that is off by d parts in 10⁹ makes f (10⁹ + d) / 10⁹ cycles in a second. Both
//! numbers are integers, so that an instant is an exact fraction; it is rounded once, and no rounded spans are added.

use baudbot_avr::usart::BitLength;
use serde::{Deserialize, Serialize};
use thiserror::Error;

const BILLION: u128 = 1_000_000_000;
/// An RC oscillator that was not calibrated is off by 10 %: data sheet of the ATmega328P, section *Calibrated Internal RC
/// Oscillator Accuracy*.
const LARGEST_DEVIATION_PPB: i32 = 100_000_000;
/// A bit's length is rounded to this fraction of a cycle.
const BIT_FRACTION: u128 = 1024;

/// The clock source of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Numbers")]
pub struct ChipClock {
    hz: u32,
    deviation_ppb: i32,
}

/// A clock source as it is loaded.
#[derive(Deserialize)]
struct Numbers {
    hz: u32,
    deviation_ppb: i32,
}

impl TryFrom<Numbers> for ChipClock {
    type Error = ClockError;

    fn try_from(numbers: Numbers) -> Result<Self, ClockError> {
        Self::exact(numbers.hz)?.with_ppb(numbers.deviation_ppb.into())
    }
}

/// No clock source is like that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ClockError {
    /// The clock source stands.
    #[error("a clock of 0 Hz stands still")]
    Stands,
    /// The clock is off by more than any oscillator of such a chip.
    #[error("a clock that is off by {ppb} ppb is beyond ±{LARGEST_DEVIATION_PPB} ppb")]
    Deviation {
        /// The deviation, in parts in 10⁹.
        ppb: i64,
    },
}

impl ChipClock {
    /// A clock source of exactly this frequency, in hertz.
    ///
    /// # Errors
    ///
    /// A frequency of zero.
    pub const fn exact(hz: u32) -> Result<Self, ClockError> {
        if hz == 0 { Err(ClockError::Stands) } else { Ok(Self { hz, deviation_ppb: 0 }) }
    }

    /// The same with a deviation in parts per million; above 0 it is too fast.
    ///
    /// # Errors
    ///
    /// More than ±100 000 ppm.
    pub const fn with_ppm(self, ppm: i32) -> Result<Self, ClockError> {
        self.with_ppb(ppm as i64 * 1000)
    }

    /// The same with a deviation in parts in 10⁹; above 0 it is too fast.
    ///
    /// # Errors
    ///
    /// More than ±100 000 000 ppb.
    pub const fn with_ppb(self, ppb: i64) -> Result<Self, ClockError> {
        if ppb.unsigned_abs() > LARGEST_DEVIATION_PPB as u64 {
            return Err(ClockError::Deviation { ppb });
        }
        Ok(Self { hz: self.hz, deviation_ppb: ppb as i32 })
    }

    /// The nominal frequency, in hertz.
    pub const fn hz(self) -> u32 {
        self.hz
    }

    /// The deviation, in parts in 10⁹.
    pub const fn deviation_ppb(self) -> i32 {
        self.deviation_ppb
    }

    /// The frequency with its deviation, in hertz.
    pub fn frequency(self) -> f64 {
        self.cycles_in_a_billion_seconds() as f64 / BILLION as f64
    }

    /// The instant of a cycle, in nanoseconds since cycle 0, rounded down. `u64::MAX` if it is beyond.
    pub const fn ns(self, cycle: u64) -> u64 {
        saturate(cycle as u128 * BILLION * BILLION / self.cycles_in_a_billion_seconds())
    }

    /// The first cycle that is not before an instant, given in nanoseconds. `u64::MAX` if it is beyond.
    pub const fn cycle(self, ns: u64) -> u64 {
        saturate((ns as u128 * self.cycles_in_a_billion_seconds()).div_ceil(BILLION * BILLION))
    }

    /// The duration of a bit at the chip, if the other end sends at exactly this rate. None: shorter than a cycle, or
    /// longer than four million of them.
    pub fn bit_of(self, baud: u32) -> Option<BitLength> {
        let cycles =
            (self.cycles_in_a_billion_seconds() * BIT_FRACTION).checked_div(BILLION * u128::from(baud))?;
        BitLength::new(u32::try_from(cycles).ok()?, BIT_FRACTION as u32)
    }

    const fn cycles_in_a_billion_seconds(self) -> u128 {
        self.hz as u128 * (BILLION as i64 + self.deviation_ppb as i64) as u128
    }
}

const fn saturate(value: u128) -> u64 {
    if value > u64::MAX as u128 { u64::MAX } else { value as u64 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn clock(hz: u32, ppm: i32) -> ChipClock {
        ChipClock::exact(hz).and_then(|clock| clock.with_ppm(ppm)).unwrap()
    }

    #[test]
    fn instants_are_exact_fractions_rounded_down() {
        assert_eq!([1, 2, 16].map(|cycle| clock(16_000_000, 0).ns(cycle)), [62, 125, 1000]);
        assert_eq!([1, 8].map(|cycle| clock(8_000_000, 0).ns(cycle)), [125, 1000]);
        // 14.7456 MHz: 9216 cycles are 625 µs.
        assert_eq!([1, 9216, 9217].map(|cycle| clock(14_745_600, 0).ns(cycle)), [67, 625_000, 625_067]);
    }

    #[test]
    fn a_deviation_is_not_lost_in_a_year() {
        let year = 365 * 86_400 * 16_000_000;
        assert_eq!(clock(16_000_000, 0).ns(year), 31_536_000_000_000_000);
        assert_eq!(clock(16_000_000, 25).ns(year / 1_000_000 * 1_000_025), 31_536_000_000_000_000);
        assert_eq!(clock(16_000_000, -50).ns(year / 1_000_000 * 999_950), 31_536_000_000_000_000);
    }

    #[test]
    fn a_clock_that_stands_or_is_off_by_more_than_a_tenth_is_refused() {
        assert_eq!(ChipClock::exact(0), Err(ClockError::Stands));
        let error = ChipClock::exact(1).unwrap().with_ppm(100_001);
        assert_eq!(error, Err(ClockError::Deviation { ppb: 100_001_000 }));
    }

    #[test]
    fn a_bit_at_9600_baud_has_1666_and_two_thirds_cycles() {
        let bit = clock(16_000_000, 0).bit_of(9600).unwrap();
        assert_eq!(Some(bit), BitLength::new(1_706_666, 1024));
        assert_eq!(clock(16_000_000, 0).bit_of(0), None);
        assert_eq!(clock(16_000_000, 0).bit_of(32_000_000), None);
    }

    proptest! {
        #[test]
        fn a_cycle_is_the_first_that_is_not_before_its_instant(
            hz in prop::sample::select(&[16_000_000, 8_000_000, 14_745_600, 1, 20_000_000][..]),
            ppm in -100_000..=100_000,
            ns in 0..=u64::MAX / 64,
        ) {
            let clock = clock(hz, ppm);
            let cycle = clock.cycle(ns);
            prop_assert!(clock.ns(cycle) >= ns);
            prop_assert!(cycle == 0 || clock.ns(cycle - 1) < ns);
        }

        #[test]
        fn cycles_longer_than_a_nanosecond_return_and_stay_in_order(
            hz in prop::sample::select(&[16_000_000, 8_000_000, 14_745_600][..]),
            ppm in -100_000..=100_000,
            cycle in 0..u64::MAX / 1024,
        ) {
            let clock = clock(hz, ppm);
            prop_assert_eq!(clock.cycle(clock.ns(cycle)), cycle);
            prop_assert!(clock.ns(cycle) < clock.ns(cycle + 1));
        }
    }
}
