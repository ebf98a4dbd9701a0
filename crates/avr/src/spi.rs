//! SPI as a master, and as a slave whose bytes are exchanged whole.
//!
//! Source: data sheet, chapter *SPI – Serial Peripheral Interface*.
//!
//! # Deviations
//!
//! A byte is handed over as a whole when it is complete; the pins SCK and MOSI do not move meanwhile.

use serde::{Deserialize, Serialize};

/// A register of the SPI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Control,
    Status,
    Data,
}

const INTERRUPT: u8 = 1 << 7;
const ENABLE: u8 = 1 << 6;
const MASTER: u8 = 1 << 4;
const DONE: u8 = 1 << 7;
const COLLISION: u8 = 1 << 6;
const DOUBLE_SPEED: u8 = 1;

/// The SPI with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spi {
    control: u8,
    status: u8,
    received: u8,
    sending: u8,
    end: Option<u64>,
    /// SPSR was read while SPIF or WCOL was set: the next access to SPDR clears them.
    seen: bool,
}

impl Spi {
    pub(crate) const fn new() -> Self {
        Self { control: 0, status: 0, received: 0, sending: 0, end: None, seen: false }
    }

    pub(crate) const fn requests(&self) -> bool {
        self.control & INTERRUPT != 0 && self.status & DONE != 0
    }

    pub(crate) fn acknowledge(&mut self) {
        self.status &= !DONE;
    }

    pub(crate) const fn is_enabled(&self) -> bool {
        self.control & ENABLE != 0
    }

    pub(crate) const fn is_master(&self) -> bool {
        self.control & MASTER != 0
    }

    pub(crate) fn next_event(&self) -> u64 {
        self.end.unwrap_or(u64::MAX)
    }

    /// The byte whose transfer is over at this cycle.
    pub(crate) fn event(&mut self, now: u64) -> Option<u8> {
        if self.end != Some(now) {
            return None;
        }
        self.end = None;
        Some(self.sending)
    }

    /// Takes the byte that came in during the transfer.
    pub(crate) fn receive(&mut self, byte: u8) {
        self.received = byte;
        self.status |= DONE;
    }

    /// The exchange as a slave: another master has sent a byte, and gets what SPDR held. None: this is no slave.
    pub(crate) fn exchange(&mut self, byte: u8) -> Option<u8> {
        if !self.is_enabled() || self.is_master() {
            return None;
        }
        let answer = self.sending;
        // The shift register is sent next, unless the program writes.
        self.sending = byte;
        self.receive(byte);
        Some(answer)
    }

    /// SS is low: another master is there.
    pub(crate) fn lose_mastership(&mut self) {
        self.control &= !MASTER;
        self.status |= DONE;
    }

    pub(crate) fn read(&mut self, register: Register) -> u8 {
        match register {
            Register::Control => self.control,
            Register::Status => {
                self.seen = self.status & (DONE | COLLISION) != 0;
                self.status
            }
            Register::Data => {
                self.clear_seen();
                self.received
            }
        }
    }

    pub(crate) fn write(&mut self, register: Register, value: u8, now: u64) {
        match register {
            Register::Control => self.control = value,
            Register::Status => self.status = self.status & !DOUBLE_SPEED | value & DOUBLE_SPEED,
            Register::Data => {
                self.clear_seen();
                if self.end.is_some() {
                    self.status |= COLLISION;
                    return;
                }
                self.sending = value;
                if self.is_enabled() && self.is_master() {
                    self.end = Some(now + 8 * self.clock());
                }
            }
        }
    }

    fn clear_seen(&mut self) {
        if core::mem::take(&mut self.seen) {
            self.status &= DOUBLE_SPEED;
        }
    }

    /// Cycles in one of SCK.
    const fn clock(&self) -> u64 {
        let full = [4, 16, 64, 128][(self.control & 3) as usize];
        if self.status & DOUBLE_SPEED == 0 { full } else { full / 2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_takes_eight_cycles_of_each_clock() {
        for (rate, double, clock) in
            [(0, 0, 4), (1, 0, 16), (2, 0, 64), (3, 0, 128), (0, 1, 2), (1, 1, 8), (2, 1, 32), (3, 1, 64)]
        {
            let mut spi = Spi::new();
            spi.write(Register::Control, ENABLE | MASTER | rate, 0);
            spi.write(Register::Status, double, 0);
            spi.write(Register::Data, 0xA5, 100);
            assert_eq!(spi.next_event(), 100 + 8 * clock);
        }
    }

    #[test]
    fn the_flag_is_cleared_by_reading_the_status_and_then_the_data() {
        let mut spi = Spi::new();
        spi.write(Register::Control, ENABLE | MASTER, 0);
        spi.write(Register::Data, 0xA5, 0);
        assert_eq!(spi.event(32), Some(0xA5));
        spi.receive(0x5A);
        assert_eq!(spi.read(Register::Data), 0x5A);
        assert_eq!(spi.read(Register::Status), DONE);
        assert_eq!(spi.read(Register::Data), 0x5A);
        assert_eq!(spi.read(Register::Status), 0);
    }

    #[test]
    fn a_write_during_a_transfer_is_a_collision() {
        let mut spi = Spi::new();
        spi.write(Register::Control, ENABLE | MASTER, 0);
        spi.write(Register::Data, 1, 0);
        spi.write(Register::Data, 2, 5);
        assert_eq!(spi.read(Register::Status), COLLISION);
        assert_eq!(spi.event(32), Some(1));
    }
}
