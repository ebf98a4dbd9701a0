//! Characters as bits on a line.

use serde::{Deserialize, Serialize};

use crate::checked::checked;

/// The parity bit of a character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parity {
    /// The frame has no parity bit.
    #[default]
    None,
    /// The ones among data and parity are even in number.
    Even,
    /// The ones are odd in number.
    Odd,
}

impl Parity {
    pub(super) const fn bits(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Even | Self::Odd => 1,
        }
    }

    /// The parity bit of data.
    pub(super) const fn bit(self, data: u16) -> bool {
        let odd = data.count_ones() % 2 == 1;
        match self {
            Self::None => true,
            Self::Even => odd,
            Self::Odd => !odd,
        }
    }
}

/// A character: a start bit, data with the lowest bit first, perhaps a parity bit, one or two stop bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Frame {
    data: u16,
    data_bits: u8,
    parity: Parity,
    stop_bits: u8,
}

checked!(Frame, "a character has 5 to 9 bits of data and 1 or 2 stop bits");

impl Frame {
    /// A character. Data bits are brought into 5 to 9, stop bits into 1 to 2, and data above them is cut off.
    pub const fn new(data: u16, data_bits: u8, parity: Parity, stop_bits: u8) -> Self {
        let data_bits = if data_bits < 5 {
            5
        } else if data_bits > 9 {
            9
        } else {
            data_bits
        };
        let stop_bits = if stop_bits < 2 { 1 } else { 2 };
        Self { data: data & ((1 << data_bits) - 1), data_bits, parity, stop_bits }
    }

    /// A byte as almost everybody sends it: 8 bits, no parity, one stop bit.
    pub const fn byte(byte: u8) -> Self {
        Self::new(byte as u16, 8, Parity::None, 1)
    }

    const fn is_possible(&self) -> bool {
        5 <= self.data_bits
            && self.data_bits <= 9
            && self.data < 1 << self.data_bits
            && 1 <= self.stop_bits
            && self.stop_bits <= 2
    }

    /// The data.
    pub const fn data(&self) -> u16 {
        self.data
    }

    /// The number of data bits, from 5 to 9.
    pub const fn data_bits(&self) -> u8 {
        self.data_bits
    }

    /// The parity.
    pub const fn parity(&self) -> Parity {
        self.parity
    }

    /// The number of stop bits, 1 or 2.
    pub const fn stop_bits(&self) -> u8 {
        self.stop_bits
    }

    /// All bits, with those of start and stop.
    pub const fn bits(&self) -> u8 {
        1 + self.data_bits + self.parity.bits() + self.stop_bits
    }

    /// The level of a bit, counted from the start bit. From the stop bits on it is high.
    pub const fn level(&self, bit: u64) -> bool {
        if bit == 0 {
            false
        } else if bit <= self.data_bits as u64 {
            self.data >> (bit - 1) & 1 == 1
        } else if bit == self.data_bits as u64 + 1 {
            self.parity.bit(self.data)
        } else {
            true
        }
    }
}

/// The duration of a bit: a fraction, in periods of the clock source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct BitLength {
    periods: u32,
    bits: u32,
}

checked!(BitLength, "a bit has at least one period");

impl BitLength {
    /// A number of bits takes a number of periods; neither may be zero, and a bit has at least one period.
    pub const fn new(periods: u32, bits: u32) -> Option<Self> {
        if bits > 0 && periods >= bits { Some(Self { periods, bits }) } else { None }
    }

    /// The bit of a baud rate, by the frequency of the receiver's clock source.
    pub const fn of_baud(clock_hz: u32, baud: u32) -> Option<Self> {
        Self::new(clock_hz, baud)
    }

    const fn is_possible(self) -> bool {
        self.bits > 0 && self.periods >= self.bits
    }

    /// The bit that is on the line so many periods after the start, counted from 0.
    pub(super) const fn bit_at(self, periods: u64) -> u64 {
        (periods as u128 * self.bits as u128 / self.periods as u128) as u64
    }

    /// The period in which so many bits end.
    pub(super) const fn end_within(self, bits: u64) -> u64 {
        (bits as u128 * self.periods as u128 / self.bits as u128) as u64
    }

    /// The first period of a bit, counted from the first one of bit 0.
    pub const fn begin_of(self, bit: u64) -> u64 {
        (bit as u128 * self.periods as u128).div_ceil(self.bits as u128) as u64
    }
}
