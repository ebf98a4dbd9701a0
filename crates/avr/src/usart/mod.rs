//! USART0 in its asynchronous modes.
//!
//! The baud-rate generator ticks every UBRR + 1 cycles; a bit has 16 ticks, or 8 with U2X. The transmitter begins a character
//! with a tick. The receiver samples its line with the ticks.
//!
//! Source: data sheet, chapter *USART0*.
//!
//! # Deviations
//!
//! Synchronous modes are refused by a warning. The pin TXD stays high while a character is sent: the board gets the
//! whole character instead, see [`Sent`]. The data sheet does not state how long an idle transmitter waits before a
//! start bit; here it waits for the next tick.

mod frame;
mod line;
mod receiver;

use serde::{Deserialize, Serialize};

pub use frame::{BitLength, Frame, Parity};
pub use line::LineError;

use line::{Incoming, Line};
use receiver::{Format, Receiver};

use crate::clock::Clock;

/// A character on its way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sent {
    /// The frame on its way.
    pub frame: Frame,
    /// The instant at which its start bit begins, in periods of the clock source.
    pub start: u64,
    /// The duration of each of its bits, in periods of the clock source.
    pub bit: u64,
}

impl Sent {
    /// The instant at which its last stop bit ends, in periods of the clock source.
    pub const fn end(&self) -> u64 {
        self.start + self.bit * self.frame.bits() as u64
    }
}

/// A register of the USART.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    ControlA,
    ControlB,
    ControlC,
    Baud,
    BaudHigh,
    Data,
}

pub(crate) const RECEIVED: u8 = 1 << 7;
pub(crate) const SENT: u8 = 1 << 6;
pub(crate) const EMPTY: u8 = 1 << 5;
const FRAME_ERROR: u8 = 1 << 4;
const OVERRUN: u8 = 1 << 3;
const PARITY_ERROR: u8 = 1 << 2;
const DOUBLE_SPEED: u8 = 1 << 1;
const MULTI_PROCESSOR: u8 = 1;
const RECEIVER_ON: u8 = 1 << 4;
const TRANSMITTER_ON: u8 = 1 << 3;
const NINE_BITS: u8 = 1 << 2;

/// The USART with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Usart {
    double_speed: bool,
    multi_processor: bool,
    control_b: u8,
    control_c: u8,
    baud: u16,
    /// A cycle with a tick of the baud-rate generator.
    zero: u64,
    /// The transmit buffer, which the program has written.
    buffer: Option<u16>,
    /// The instant at which the character in the buffer begins, if the shift register is idle.
    begin: u64,
    /// The instant at which the character in the shift register ends.
    end: Option<u64>,
    sent: bool,
    receiver: Receiver,
    line: Line,
}

impl Usart {
    pub(crate) const fn new(now: u64) -> Self {
        Self {
            double_speed: false,
            multi_processor: false,
            control_b: 0,
            control_c: 0x06,
            baud: 0,
            zero: now,
            buffer: None,
            begin: u64::MAX,
            end: None,
            sent: false,
            receiver: Receiver::new(),
            line: Line::new(),
        }
    }

    /// Resets the registers; what is on the line stays.
    pub(crate) fn reset(&mut self, now: u64) {
        let line = core::mem::replace(&mut self.line, Line::new());
        *self = Self { line, ..Self::new(now) };
    }

    /// Whether this USART can exist at a cycle.
    pub(crate) fn is_possible(&self, now: u64) -> bool {
        self.zero <= now && self.receiver.is_possible(now) && self.line.is_possible()
    }

    /// RXC, TXC and UDRE where they are set and their interrupts enabled.
    pub(crate) fn requests(&self) -> u8 {
        self.status() & self.control_b & (RECEIVED | SENT | EMPTY)
    }

    /// The interrupt of TXC has been taken.
    pub(crate) fn acknowledge_sent(&mut self) {
        self.sent = false;
    }

    /// A character was lost, and the program has not read on yet.
    pub(crate) fn has_overrun(&self) -> bool {
        self.receiver.status() & OVERRUN != 0
    }

    pub(crate) const fn receiver_on(&self) -> bool {
        self.control_b & RECEIVER_ON != 0
    }

    /// Whether the pin TXD belongs to the USART: also until the last character is over.
    pub(crate) const fn transmitter_on(&self) -> bool {
        self.control_b & TRANSMITTER_ON != 0 || self.end.is_some()
    }

    /// UMSEL asks for a synchronous mode.
    pub(crate) const fn is_synchronous(&self) -> bool {
        self.control_c & 0xC0 != 0
    }

    /// Puts a character on the receiver's line.
    pub(crate) fn put(
        &mut self,
        now: u64,
        frame: Frame,
        start: u64,
        bit: BitLength,
    ) -> Result<(), LineError> {
        self.line.put(now, Incoming { frame, start, bit })
    }

    /// The level at the pin RXD has changed at this cycle.
    pub(crate) fn set_pin(&mut self, now: u64, level: bool) {
        self.line.pin = level;
        self.receiver.look_from(now);
    }

    /// The clock runs in another way from this cycle on.
    pub(crate) fn clock_changed(&mut self, now: u64) {
        self.receiver.look_from(now);
    }

    /// The next cycle at which something happens.
    pub(crate) fn next_event(&self, clock: &Clock) -> u64 {
        let sending = self.end.unwrap_or(self.begin);
        if self.receiver_on() {
            sending.min(self.receiver.next_event(&self.line, clock, self.zero, self.divisor()))
        } else {
            sending
        }
    }

    /// Does what happens at this cycle; a character that begins is returned.
    pub(crate) fn event(&mut self, now: u64, clock: &Clock) -> Option<Sent> {
        if self.receiver_on() {
            let format = Format {
                data_bits: self.data_bits(),
                parity: self.parity(),
                addresses_only: self.multi_processor,
            };
            let samples = if self.double_speed { 8 } else { 16 };
            let generator = (self.zero, self.divisor());
            self.receiver.event(now, &mut self.line, clock, generator, samples, format);
        }
        if self.end == Some(now) {
            self.end = None;
            match self.buffer {
                Some(_) => self.begin = now,
                None => self.sent = true,
            }
        }
        if self.begin != now {
            return None;
        }
        self.begin = u64::MAX;
        let data = self.buffer.take()?;
        let frame = Frame::new(data, self.data_bits(), self.parity(), self.stop_bits());
        let bit = self.bit_cycles();
        self.end = Some(now + bit * u64::from(frame.bits()));
        Some(Sent { frame, start: clock.period_of(now), bit: bit << clock.shift() })
    }

    /// Reads a register; reading data takes the character away.
    pub(crate) fn read(&mut self, register: Register) -> u8 {
        match register {
            Register::ControlA => self.status(),
            Register::ControlB => self.control_b & !2 | self.receiver.ninth_bit() << 1,
            Register::ControlC => self.control_c,
            Register::Baud => self.baud.to_le_bytes()[0],
            Register::BaudHigh => self.baud.to_le_bytes()[1],
            Register::Data => self.receiver.take(),
        }
    }

    /// Writes a register.
    pub(crate) fn write(&mut self, register: Register, value: u8, now: u64) {
        match register {
            Register::ControlA => {
                self.double_speed = value & DOUBLE_SPEED != 0;
                self.multi_processor = value & MULTI_PROCESSOR != 0;
                if value & SENT != 0 {
                    self.sent = false;
                }
            }
            Register::ControlB => self.write_control_b(value, now),
            Register::ControlC => self.control_c = value,
            Register::Baud => {
                self.baud = u16::from_le_bytes([value, self.baud.to_le_bytes()[1]]);
                self.zero = now;
            }
            Register::BaudHigh => self.baud = u16::from_le_bytes([self.baud.to_le_bytes()[0], value & 0x0F]),
            Register::Data => self.write_data(value, now),
        }
    }

    fn write_control_b(&mut self, value: u8, now: u64) {
        let on = !self.receiver_on() && value & RECEIVER_ON != 0;
        self.control_b = value & !2;
        if !self.receiver_on() {
            self.receiver = Receiver::new();
        } else if on {
            self.receiver.start(now);
        }
        if value & TRANSMITTER_ON == 0 && self.end.is_none() {
            self.buffer = None;
            self.begin = u64::MAX;
        }
    }

    fn write_data(&mut self, value: u8, now: u64) {
        // A byte that is written while the buffer is full is ignored.
        if self.control_b & TRANSMITTER_ON == 0 || self.buffer.is_some() {
            return;
        }
        self.buffer = Some(u16::from(value) | u16::from(self.control_b & 1) << 8);
        if self.end.is_none() {
            self.begin = receiver::tick_from(now, self.zero, self.divisor());
        }
    }

    fn status(&self) -> u8 {
        let mut status = self.receiver.status();
        for (set, bit) in [
            (self.sent, SENT),
            (self.buffer.is_none(), EMPTY),
            (self.double_speed, DOUBLE_SPEED),
            (self.multi_processor, MULTI_PROCESSOR),
        ] {
            status |= if set { bit } else { 0 };
        }
        status
    }

    /// Cycles from one tick of the baud-rate generator to the next.
    const fn divisor(&self) -> u64 {
        self.baud as u64 + 1
    }

    const fn bit_cycles(&self) -> u64 {
        self.divisor() * if self.double_speed { 8 } else { 16 }
    }

    const fn data_bits(&self) -> u8 {
        match (self.control_b & NINE_BITS != 0, self.control_c >> 1 & 3) {
            (true, 3) => 9,
            (_, size) => 5 + size,
        }
    }

    const fn stop_bits(&self) -> u8 {
        1 + (self.control_c >> 3 & 1)
    }

    const fn parity(&self) -> Parity {
        match self.control_c >> 4 & 3 {
            2 => Parity::Even,
            3 => Parity::Odd,
            _ => Parity::None,
        }
    }
}

#[cfg(test)]
mod tests;
