//! The analog-to-digital converter.
//!
//! Its clock is the system clock divided by 2 to 128, counted from the moment it is enabled. A conversion begins with a cycle
//! of this clock and takes 13 of them, with the sample after 1.5; the first one takes 25, with the sample after 13.5; one that
//! is triggered takes 13.5, with the sample after 2, and the trigger is three cycles of the system clock before that.
//!
//! The result is the input's voltage times 1024 over the reference's, rounded down, 1023 at most.
//!
//! Source: data sheet, chapter *Analog-to-Digital Converter*, table *ADC Conversion Time*.

use serde::{Deserialize, Serialize};

use crate::board::{AnalogInput, Supply};

/// A register of the ADC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Multiplexer,
    ControlA,
    ControlB,
    Low,
    High,
}

const ENABLE: u8 = 1 << 7;
const START: u8 = 1 << 6;
const AUTO_TRIGGER: u8 = 1 << 5;
const DONE: u8 = 1 << 4;
const INTERRUPT: u8 = 1 << 3;
const LEFT: u8 = 1 << 5;
/// The comparator may use the multiplexer (ACME).
const COMPARATOR: u8 = 1 << 6;
const BANDGAP_UV: u32 = 1_100_000;
const SYNCHRONISER_CYCLES: u64 = 3;

/// An event that can start conversions: ADTS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trigger {
    FreeRunning,
    Comparator,
    ExternalInterrupt0,
    Timer0CompareA,
    Timer0Overflow,
    Timer1CompareB,
    Timer1Overflow,
    Timer1Capture,
}

/// A source of the voltage that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    Outside(AnalogInput),
    Inside(u32),
    Reserved,
}

/// A step of a conversion that falls on an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    Nothing,
    /// The input is held now: the ADC wants its voltage.
    Sample,
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Conversion {
    /// The cycle of the sample, until it is taken.
    sample: u64,
    end: u64,
    /// The multiplexer as it was when the conversion began.
    multiplexer: u8,
    result: u16,
}

/// The ADC with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Adc {
    multiplexer: u8,
    control_a: u8,
    control_b: u8,
    result: u16,
    /// A result that came between the reads of ADCL and ADCH is lost.
    locked: bool,
    /// A cycle with which a cycle of the ADC's clock begins.
    zero: u64,
    /// The next conversion is the first since the ADC was enabled.
    first: bool,
    conversion: Option<Conversion>,
    /// The flag that triggers, as it was last seen.
    trigger: bool,
    off: bool,
}

impl Adc {
    pub(crate) const fn new(now: u64) -> Self {
        Self {
            multiplexer: 0,
            control_a: 0,
            control_b: 0,
            result: 0,
            locked: false,
            zero: now,
            first: true,
            conversion: None,
            trigger: false,
            off: false,
        }
    }

    /// Whether this ADC can exist at a cycle.
    pub(crate) const fn is_possible(&self, now: u64) -> bool {
        self.zero <= now + SYNCHRONISER_CYCLES
    }

    /// Power reduction.
    pub(crate) fn set_off(&mut self, off: bool) {
        self.off = off;
    }

    pub(crate) const fn requests(&self) -> bool {
        self.control_a & DONE != 0 && self.control_a & INTERRUPT != 0
    }

    pub(crate) fn acknowledge(&mut self) {
        self.control_a &= !DONE;
    }

    pub(crate) fn next_event(&self) -> u64 {
        match &self.conversion {
            Some(_) if self.off => u64::MAX,
            Some(conversion) => conversion.sample.min(conversion.end),
            None => u64::MAX,
        }
    }

    /// The event that starts conversions; none without ADATE.
    pub(crate) const fn trigger(&self) -> Option<Trigger> {
        if self.control_a & (ENABLE | AUTO_TRIGGER) != ENABLE | AUTO_TRIGGER {
            return None;
        }
        Some(match self.control_b & 7 {
            0 => Trigger::FreeRunning,
            1 => Trigger::Comparator,
            2 => Trigger::ExternalInterrupt0,
            3 => Trigger::Timer0CompareA,
            4 => Trigger::Timer0Overflow,
            5 => Trigger::Timer1CompareB,
            6 => Trigger::Timer1Overflow,
            _ => Trigger::Timer1Capture,
        })
    }

    /// The input that the comparator takes instead of AIN1, if it may.
    pub(crate) const fn lent_channel(&self) -> Option<u8> {
        if self.control_b & COMPARATOR != 0 && self.control_a & ENABLE == 0 {
            Some(self.multiplexer & 7)
        } else {
            None
        }
    }

    /// Notes the flag that triggers: a conversion begins when it rises.
    pub(crate) fn see_trigger(&mut self, now: u64, flag: bool) {
        let before = core::mem::replace(&mut self.trigger, flag);
        if flag && !before && self.conversion.is_none() {
            self.zero = now + SYNCHRONISER_CYCLES;
            let clock = self.clock();
            let (sample, end) = if self.first { (27, 50) } else { (4, 27) };
            self.begin(self.zero + sample * clock / 2, self.zero + end * clock / 2);
        }
    }

    /// In ADC noise reduction a conversion begins with the sleep.
    pub(crate) fn sleep(&mut self, now: u64) {
        if self.control_a & ENABLE != 0 {
            self.start(now);
        }
    }

    pub(crate) fn event(&mut self, now: u64) -> Event {
        let Some(conversion) = self.conversion.as_mut().filter(|_| !self.off) else { return Event::Nothing };
        if conversion.sample == now {
            conversion.sample = u64::MAX;
            return Event::Sample;
        }
        if conversion.end != now {
            return Event::Nothing;
        }
        if !self.locked {
            self.result = conversion.result;
        }
        self.control_a |= DONE;
        self.conversion = None;
        if self.trigger() == Some(Trigger::FreeRunning) {
            let clock = self.clock();
            self.begin(now + 3 * clock / 2, now + 13 * clock);
        } else {
            self.control_a &= !START;
        }
        Event::Done
    }

    /// The input of the conversion that is going on.
    pub(crate) fn input(&self) -> Input {
        match self.conversion.map_or(0, |conversion| conversion.multiplexer) & 0x0F {
            channel @ 0..=7 => Input::Outside(AnalogInput::Channel(channel)),
            8 => Input::Outside(AnalogInput::Temperature),
            14 => Input::Inside(BANDGAP_UV),
            15 => Input::Inside(0),
            _ => Input::Reserved,
        }
    }

    /// Gives the voltage that was asked for; the answer is the result of the conversion.
    pub(crate) fn sample(&mut self, microvolts: u32, supply: &Supply) -> Option<u16> {
        let conversion = self.conversion.as_mut()?;
        let reference = match conversion.multiplexer >> 6 {
            0 => supply.aref_uv,
            1 => supply.avcc_uv,
            _ => BANDGAP_UV,
        };
        let result = u64::from(microvolts) * 1024 / u64::from(reference.max(1));
        conversion.result = u16::try_from(result).map_or(1023, |result| result.min(1023));
        Some(conversion.result)
    }

    /// REFS = 2 is reserved.
    pub(crate) fn has_reserved_reference(&self) -> bool {
        self.conversion.is_some_and(|conversion| conversion.multiplexer >> 6 == 2)
    }

    pub(crate) fn read(&mut self, register: Register) -> u8 {
        let left = self.multiplexer & LEFT != 0;
        let [low, high] = if left { self.result << 6 } else { self.result }.to_le_bytes();
        match register {
            Register::Multiplexer => self.multiplexer,
            Register::ControlA => self.control_a,
            Register::ControlB => self.control_b,
            Register::Low => {
                self.locked = true;
                low
            }
            Register::High => {
                self.locked = false;
                high
            }
        }
    }

    pub(crate) fn write(&mut self, register: Register, value: u8, now: u64) {
        match register {
            Register::Multiplexer => self.multiplexer = value & 0xEF,
            Register::ControlA => self.write_control_a(value, now),
            Register::ControlB => self.control_b = value & 0x47,
            Register::Low | Register::High => {}
        }
    }

    fn write_control_a(&mut self, value: u8, now: u64) {
        let before = self.control_a;
        let done = before & DONE & !value;
        // A conversion cannot be stopped by a zero.
        let going = if self.conversion.is_some() { before & START } else { 0 };
        self.control_a = value & !(DONE | START) | done | going;
        if value & ENABLE == 0 {
            self.control_a &= !START;
            self.conversion = None;
            self.first = true;
            return;
        }
        if before & ENABLE == 0 {
            self.zero = now;
        }
        if value & START != 0 {
            self.start(now);
        }
    }

    fn start(&mut self, now: u64) {
        if self.conversion.is_some() || self.off {
            return;
        }
        let clock = self.clock();
        let begin = self.zero + now.saturating_sub(self.zero).div_ceil(clock) * clock;
        let (sample, end) = if self.first { (27, 25) } else { (3, 13) };
        self.begin(begin + sample * clock / 2, begin + end * clock);
    }

    fn begin(&mut self, sample: u64, end: u64) {
        self.first = false;
        self.control_a |= START;
        self.conversion = Some(Conversion { sample, end, multiplexer: self.multiplexer, result: 0 });
    }

    /// Cycles of the system clock in a cycle of the ADC's.
    const fn clock(&self) -> u64 {
        match self.control_a & 7 {
            0 => 2,
            select => 1 << select,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUPPLY: Supply = Supply { clock_hz: 16_000_000, avcc_uv: 5_000_000, aref_uv: 4_096_000 };
    const DIVIDE_BY_128: u8 = 7;

    /// Cycles from one instant to the sample and to the end of the conversion.
    fn measured(adc: &mut Adc, from: u64, microvolts: u32) -> (u64, u64) {
        let sample = adc.next_event();
        assert_eq!(adc.event(sample), Event::Sample);
        adc.sample(microvolts, &SUPPLY);
        let end = adc.next_event();
        assert_eq!(adc.event(end), Event::Done);
        (sample - from, end - from)
    }

    #[test]
    fn the_first_conversion_takes_25_clocks_and_the_others_13() {
        let mut adc = Adc::new(0);
        adc.write(Register::ControlA, ENABLE | START | DIVIDE_BY_128, 1000);
        assert_eq!(measured(&mut adc, 1000, 0), (1728, 3200));
        adc.write(Register::ControlA, ENABLE | START | DONE | DIVIDE_BY_128, 4200);
        assert_eq!(measured(&mut adc, 4200, 0), (192, 1664));
    }

    #[test]
    fn a_conversion_waits_for_the_next_cycle_of_the_adcs_clock() {
        let mut adc = Adc::new(0);
        adc.write(Register::ControlA, ENABLE | DIVIDE_BY_128, 1000);
        adc.write(Register::ControlA, ENABLE | START | DIVIDE_BY_128, 1001);
        assert_eq!(measured(&mut adc, 1128, 0), (1728, 3200));
    }

    #[test]
    fn free_running_conversions_follow_each_other_without_a_gap() {
        let mut adc = Adc::new(0);
        adc.write(Register::ControlA, ENABLE | START | AUTO_TRIGGER | 2, 0);
        assert_eq!(measured(&mut adc, 0, 0), (54, 100));
        assert_eq!(measured(&mut adc, 100, 0), (6, 52));
        assert_eq!(measured(&mut adc, 152, 0), (6, 52));
        assert_ne!(adc.read(Register::ControlA) & START, 0);
    }

    #[test]
    fn a_triggered_conversion_samples_after_two_clocks_and_three_cycles() {
        let mut adc = Adc::new(0);
        adc.write(Register::ControlA, ENABLE | START | 7, 0);
        measured(&mut adc, 0, 0);
        adc.write(Register::ControlB, 4, 0);
        adc.write(Register::ControlA, ENABLE | AUTO_TRIGGER | 7, 5000);
        adc.see_trigger(5000, false);
        adc.see_trigger(5001, true);
        adc.see_trigger(5002, true);
        assert_eq!(measured(&mut adc, 5001, 0), (3 + 256, 3 + 1728));
    }

    #[test]
    fn results_are_fractions_of_the_reference_that_was_chosen() {
        for (multiplexer, microvolts, result) in [
            (0x40, 2_500_000, 512),
            (0x40, 4_999_999, 1023),
            (0x40, 9_000_000, 1023),
            (0x00, 4_000, 1),
            (0xC0, 550_000, 512),
        ] {
            let mut adc = Adc::new(0);
            adc.write(Register::Multiplexer, multiplexer, 0);
            adc.write(Register::ControlA, ENABLE | START, 0);
            measured(&mut adc, 0, microvolts);
            let low = adc.read(Register::Low);
            assert_eq!(
                u16::from_le_bytes([low, adc.read(Register::High)]),
                result,
                "{multiplexer:#x} {microvolts}"
            );
        }
    }

    #[test]
    fn a_left_adjusted_result_has_its_upper_eight_bits_in_adch() {
        let mut adc = Adc::new(0);
        adc.write(Register::Multiplexer, 0x60, 0);
        adc.write(Register::ControlA, ENABLE | START, 0);
        measured(&mut adc, 0, 2_500_000);
        assert_eq!((adc.read(Register::Low), adc.read(Register::High)), (0, 0x80));
    }

    #[test]
    fn a_result_between_the_reads_of_its_halves_is_lost() {
        let mut adc = Adc::new(0);
        adc.write(Register::Multiplexer, 0x40, 0);
        adc.write(Register::ControlA, ENABLE | START | AUTO_TRIGGER, 0);
        measured(&mut adc, 0, 1_000_000);
        let low = adc.read(Register::Low);
        measured(&mut adc, 0, 4_000_000);
        assert_eq!(u16::from_le_bytes([low, adc.read(Register::High)]), 204);
    }
}
