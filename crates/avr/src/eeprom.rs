//! The EEPROM.
//!
//! A write must follow EEMPE within four cycles, takes 3.4 ms (erase and write) or 1.8 ms (one of them), and stops the
//! processor for two cycles; a read stops it for four.
//!
//! Source: data sheet, section *EEPROM Data Memory*, table *EEPROM Mode Bits*.

use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::clock::{Window, periods};

/// A register of the EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Control,
    Data,
    Address,
    AddressHigh,
}

const READ: u8 = 1 << 0;
const WRITE: u8 = 1 << 1;
const MASTER_WRITE: u8 = 1 << 2;
const INTERRUPT: u8 = 1 << 3;
const READ_CYCLES: u64 = 4;
const WRITE_CYCLES: u64 = 2;

/// The EEPROM with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Eeprom {
    bytes: Vec<u8>,
    address: u16,
    data: u8,
    /// EEPM and EERIE.
    control: u8,
    window: Window,
    /// The instant at which the write is over, in periods of the clock source.
    busy_until: Option<u64>,
}

impl Eeprom {
    pub(crate) fn new(len: u16, content: &[u8]) -> Self {
        let mut bytes = vec![0xFF; usize::from(len)];
        for (byte, &given) in bytes.iter_mut().zip(content) {
            *byte = given;
        }
        Self { bytes, address: 0, data: 0, control: 0, window: Window::default(), busy_until: None }
    }

    /// Registers return to their values after a reset. A write that goes on is finished.
    pub(crate) fn reset(&mut self) {
        (self.address, self.data, self.control) = (0, 0, 0);
        self.window = Window::default();
    }

    /// Whether this is an EEPROM of so many bytes.
    pub(crate) fn fits(&self, len: u16) -> bool {
        self.bytes.len() == usize::from(len) && self.address < len
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// The interrupt is requested as long as there is no write.
    pub(crate) const fn requests(&self) -> bool {
        self.control & INTERRUPT != 0 && self.busy_until.is_none()
    }

    /// The instant at which the write is over, in periods of the clock source.
    pub(crate) fn next_event(&self) -> u64 {
        self.busy_until.unwrap_or(u64::MAX)
    }

    pub(crate) fn event(&mut self, period: u64) {
        if self.busy_until.is_some_and(|until| until <= period) {
            self.busy_until = None;
        }
    }

    pub(crate) fn read(&self, register: Register, now: u64) -> u8 {
        match register {
            Register::Control => {
                let writing = if self.busy_until.is_some() { WRITE } else { 0 };
                self.control | writing | if self.window.is_open(now) { MASTER_WRITE } else { 0 }
            }
            Register::Data => self.data,
            Register::Address => self.address.to_le_bytes()[0],
            Register::AddressHigh => self.address.to_le_bytes()[1],
        }
    }

    /// Writes a register; the answer is how many cycles the processor stands still.
    pub(crate) fn write(
        &mut self,
        register: Register,
        value: u8,
        now: u64,
        period: u64,
        clock_hz: u32,
    ) -> u64 {
        let [low, high] = self.address.to_le_bytes();
        let last = u16::try_from(self.bytes.len() - 1).unwrap_or(u16::MAX);
        match register {
            Register::Control => return self.write_control(value, now, period, clock_hz),
            Register::Data => self.data = value,
            Register::Address => self.address = u16::from_le_bytes([value, high]) & last,
            Register::AddressHigh => self.address = u16::from_le_bytes([low, value]) & last,
        }
        0
    }

    fn write_control(&mut self, value: u8, now: u64, period: u64, clock_hz: u32) -> u64 {
        let busy = self.busy_until.is_some();
        let mode = if busy { self.control & 0x30 } else { value & 0x30 };
        self.control = value & INTERRUPT | mode;
        if value & WRITE != 0 && self.window.is_open(now) && !busy {
            self.window.close();
            self.busy_until = Some(period + periods(clock_hz, self.store()));
            return WRITE_CYCLES;
        }
        if value & MASTER_WRITE != 0 {
            self.window.open(now);
        }
        if value & READ != 0 && !busy {
            self.data = self.bytes[usize::from(self.address)];
            return READ_CYCLES;
        }
        0
    }

    /// Changes the byte; the answer is how many microseconds that takes.
    fn store(&mut self) -> u64 {
        let byte = &mut self.bytes[usize::from(self.address)];
        match self.control >> 4 & 3 {
            1 => *byte = 0xFF,
            2 => *byte &= self.data,
            _ => {
                *byte = self.data;
                return 3400;
            }
        }
        1800
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HZ: u32 = 16_000_000;

    fn write(eeprom: &mut Eeprom, value: u8, now: u64) -> u64 {
        eeprom.write(Register::Control, value, now, now, HZ)
    }

    #[test]
    fn a_write_within_four_cycles_of_eempe_takes_3_4_ms_and_stops_the_processor_for_two_cycles() {
        let mut eeprom = Eeprom::new(1024, &[]);
        eeprom.write(Register::Address, 0x05, 0, 0, HZ);
        eeprom.write(Register::AddressHigh, 0x01, 0, 0, HZ);
        eeprom.write(Register::Data, 0x42, 0, 0, HZ);
        assert_eq!(write(&mut eeprom, MASTER_WRITE, 10), 0);
        assert_eq!(write(&mut eeprom, MASTER_WRITE | WRITE, 14), 2);
        assert_eq!(eeprom.next_event(), 14 + 54_400);
        assert_eq!(eeprom.read(Register::Control, 20), WRITE);
        eeprom.event(14 + 54_400);
        assert_eq!(eeprom.read(Register::Control, 60_000), 0);
        assert_eq!(eeprom.bytes()[0x105], 0x42);
        assert_eq!(write(&mut eeprom, READ, 60_000), 4);
        assert_eq!(eeprom.read(Register::Data, 60_004), 0x42);
    }

    #[test]
    fn a_write_five_cycles_after_eempe_does_nothing() {
        let mut eeprom = Eeprom::new(1024, &[1]);
        write(&mut eeprom, MASTER_WRITE, 10);
        assert_eq!(write(&mut eeprom, WRITE, 15), 0);
        assert_eq!(eeprom.next_event(), u64::MAX);
        assert_eq!(eeprom.bytes()[0], 1);
    }

    #[test]
    fn erasing_sets_and_writing_only_clears_bits_each_in_1_8_ms() {
        let mut eeprom = Eeprom::new(1024, &[0x0F, 0x0F]);
        eeprom.write(Register::Data, 0x3C, 0, 0, HZ);
        write(&mut eeprom, 0x20 | MASTER_WRITE, 0);
        write(&mut eeprom, 0x20 | WRITE, 2);
        assert_eq!((eeprom.bytes()[0], eeprom.next_event()), (0x0C, 2 + 28_800));
        eeprom.event(28_802);
        write(&mut eeprom, 0x10 | MASTER_WRITE, 30_000);
        write(&mut eeprom, 0x10 | WRITE, 30_002);
        assert_eq!(eeprom.bytes()[0], 0xFF);
    }
}
