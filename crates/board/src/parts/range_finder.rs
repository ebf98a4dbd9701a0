//! An ultrasonic range finder on the I²C bus: Devantech SRF02.
//!
//! Source: Devantech, *SRF02 Ultrasonic range finder, Technical Specification, I2C Mode*: its registers, its commands 0x50
//! to 0x52 and the 65 ms that ranging takes, in which it does not answer.
//!
//! # Deviations
//!
//! The commands of fake ranging, of a burst without ranging, and of a change of the address do nothing.

use baudbot_avr::Direction;
use serde::{Deserialize, Serialize};

use super::Instant;

/// SRF02.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RangeFinder {
    /// The address of the range finder on the bus, 7 bits: 0x70 (0xE0 in its data sheet) to 0x7F.
    pub address: u8,
}

impl RangeFinder {
    /// The range finder with the address that the maker sets.
    pub const SRF02: Self = Self { address: 0x70 };
}

const RANGING_NS: u64 = 65_000_000;
const SOFTWARE_REVISION: u8 = 6;
/// Register 1 reads so.
const UNUSED: u8 = 0x80;
/// The shortest range is about 15 cm.
const AUTOTUNE_MINIMUM_CM: u16 = 15;
const NS_PER_US: u64 = 1000;
/// The time of sound there and back: 58 µs for a centimetre, 148 µs for an inch.
const NS_PER_CM: u64 = 58_000;
const NS_PER_INCH: u64 = 148_000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    pointer: u8,
    names_register: bool,
    /// The last range, in the unit of its command; 0 if there was no echo.
    range: u16,
    /// The cycle until which it does not answer.
    busy_until: u64,
}

impl State {
    pub(crate) fn address(&mut self, direction: Direction, at: u64) -> bool {
        self.names_register = direction == Direction::Write;
        at >= self.busy_until
    }

    pub(crate) fn write(&mut self, byte: u8, at: Instant<'_>, echo_ns: impl FnOnce(u64) -> Option<u64>) {
        if core::mem::take(&mut self.names_register) {
            self.pointer = byte;
            return;
        }
        let unit_ns = match byte {
            0x50 => NS_PER_INCH,
            0x51 => NS_PER_CM,
            0x52 => NS_PER_US,
            _ => return,
        };
        if self.pointer == 0 {
            let echo_ns = echo_ns(at.ns()).filter(|&echo_ns| echo_ns <= RANGING_NS);
            self.range = u16::try_from(echo_ns.unwrap_or(0) / unit_ns).unwrap_or(u16::MAX);
            self.busy_until = at.after(RANGING_NS);
        }
    }

    pub(crate) fn read(&mut self) -> u8 {
        let register = self.pointer;
        self.pointer = self.pointer.wrapping_add(1);
        match register {
            0 => SOFTWARE_REVISION,
            1 => UNUSED,
            2 | 3 => self.range.to_be_bytes()[usize::from(register - 2)],
            4 | 5 => AUTOTUNE_MINIMUM_CM.to_be_bytes()[usize::from(register - 4)],
            _ => 0xFF,
        }
    }
}
