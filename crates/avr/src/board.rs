//! The interface to what is around a chip.

use serde::{Deserialize, Serialize};

use crate::pin::{Drive, Pin, Pwm};
use crate::rounds::Round;
use crate::timer::Which;
use crate::usart::Sent;

/// The surroundings of a chip. All instants are periods of its clock source since it was made.
///
/// Each function has a default: nothing is connected.
pub trait Board {
    /// A pin drives its wire in another way from this instant on. All begin as [`Drive::HighImpedance`].
    fn pin_changed(&mut self, pin: Pin, drive: Drive, at: u64) {
        let _ = (pin, drive, at);
    }

    /// The signal that a timer makes on a pin has another shape, or the timer has released it (None). Only pins that
    /// are set to [`PwmReport::Shape`](crate::pin::PwmReport::Shape) are reported.
    fn pwm_changed(&mut self, pin: Pin, pwm: Option<Pwm>, at: u64) {
        let _ = (pin, pwm, at);
    }

    /// The voltage at an input of the ADC or the comparator, in microvolts.
    fn analog_microvolts(&mut self, input: AnalogInput, at: u64) -> u32 {
        let _ = (input, at);
        0
    }

    /// The ADC has measured one of ADC0 to ADC7 and will have this result, from 0 to 1023, at the end of its conversion.
    fn converted(&mut self, channel: u8, result: u16, at: u64) {
        let _ = (channel, result, at);
    }

    /// The USART has begun to send a character, which will be over after all its bits.
    fn character_sent(&mut self, sent: &Sent) {
        let _ = sent;
    }

    /// The SPI master has sent a byte; the answer is what came in meanwhile.
    fn spi_transfer(&mut self, byte: u8, at: u64) -> u8 {
        let _ = (byte, at);
        0xFF
    }

    /// The TWI master has sent a start condition and an address; the answer is whether a slave acknowledges.
    fn twi_address(&mut self, address: u8, direction: Direction, at: u64) -> bool {
        let _ = (address, direction, at);
        false
    }

    /// The TWI master has sent a byte; the answer is whether the slave acknowledges.
    fn twi_write(&mut self, byte: u8, at: u64) -> bool {
        let _ = (byte, at);
        false
    }

    /// The TWI master reads a byte, and acknowledges it unless it is the last one.
    fn twi_read(&mut self, last: bool, at: u64) -> u8 {
        let _ = (last, at);
        0xFF
    }

    /// The TWI master has sent a stop condition.
    fn twi_stop(&mut self, at: u64) {
        let _ = at;
    }

    /// A round of the program's main loop begins and the one before it is over, if
    /// [they are watched](crate::Chip::watch_rounds). Those that are passed over come together, each with its instant.
    fn round_begins(&mut self, at: u64, last: Round) {
        let _ = (at, last);
    }

    /// The program does something that it hardly means, or that is not simulated.
    fn warn(&mut self, warning: Warning, at: u64) {
        let _ = (warning, at);
    }
}

/// A board with nothing on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bare;

impl Board for Bare {}

/// A voltage that comes from outside or depends on the surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AnalogInput {
    /// ADC0 to ADC7.
    Channel(u8),
    /// The temperature sensor: about 314 mV at 25 °C, 1 mV for each degree.
    Temperature,
    /// AIN0, the positive input of the comparator.
    Positive,
    /// AIN1, its negative input.
    Negative,
}

/// The direction of bytes on a TWI bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// The byte goes from the master.
    Write,
    /// The byte goes to the master.
    Read,
}

/// An act of a program that is hardly meant, or is not simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Warning {
    /// A word that is no instruction was executed; it did nothing. This and [`BeyondMemory`](Self::BeyondMemory) are
    /// reported a hundred times at most between two resets.
    IllegalInstruction {
        /// The instruction's word address.
        pc: u32,
        /// The word.
        word: u16,
    },
    /// Data beyond the memory were read (as 0) or written (to nowhere).
    BeyondMemory {
        /// Word address of the instruction behind.
        pc: u32,
        /// The data address.
        address: u16,
    },
    /// The stack has grown below the mark of [`Chip::watch_stack`](crate::Chip::watch_stack). Said once.
    StackLow {
        /// The stack pointer.
        sp: u16,
        /// The mark.
        mark: u16,
    },
    /// An input pin was read that nothing drives and that has no pull-up; it read as 0. Reported once for each pin
    /// between two resets, and only if the program looked at that pin alone: by `SBIS` or `SBIC`, or by an instruction
    /// that takes one bit of a port behind the one that read the port. A program that reads several pins at once may
    /// ignore this one.
    FloatingInput {
        /// The pin.
        pin: Pin,
    },
    /// A pin is driven low by one side and high by the other.
    Contention {
        /// The pin.
        pin: Pin,
    },
    /// The program switched something on that is not simulated.
    Unsupported(Unsupported),
    /// A character of the USART's receiver was lost.
    Overrun,
}

/// A feature of the chip that is not simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unsupported {
    /// Timer 2 with a crystal of its own (AS2), on a chip whose clock source takes the crystal's pins.
    AsynchronousTimer,
    /// A synchronous mode of the USART (UMSEL).
    SynchronousUsart,
    /// A reserved mode of a timer.
    ReservedTimerMode(Which),
    /// A reserved input or reference of the ADC.
    ReservedAdcInput,
}

impl core::fmt::Display for Unsupported {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::AsynchronousTimer => "timer 2 with a crystal of its own, whose pins the chip's clock takes",
            Self::SynchronousUsart => "a synchronous mode of the USART",
            Self::ReservedTimerMode(_) => "a reserved mode of a timer",
            Self::ReservedAdcInput => "a reserved input or reference of the ADC",
        })
    }
}

/// The clock source and the supply of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Supply {
    /// The frequency of the clock source, in hertz; at least 1.
    pub clock_hz: u32,
    /// The voltage at AVCC, in microvolts.
    pub avcc_uv: u32,
    /// The voltage at AREF, in microvolts.
    pub aref_uv: u32,
}

impl Supply {
    /// A crystal of 16 MHz, and 5 V at AVCC and AREF.
    pub const ARDUINO: Self = Self { clock_hz: 16_000_000, avcc_uv: 5_000_000, aref_uv: 5_000_000 };
}

/// A pin that has a function of its own.
pub(crate) mod special {
    use crate::pin::{Pin, Port};
    use crate::timer::Which;

    pub(crate) const RXD: Pin = Pin::of(Port::D, 0);
    pub(crate) const TXD: Pin = Pin::of(Port::D, 1);
    pub(crate) const INT: [Pin; 2] = [Pin::of(Port::D, 2), Pin::of(Port::D, 3)];
    pub(crate) const T0: Pin = Pin::of(Port::D, 4);
    pub(crate) const T1: Pin = Pin::of(Port::D, 5);
    pub(crate) const ICP1: Pin = Pin::of(Port::B, 0);
    pub(crate) const SS: Pin = Pin::of(Port::B, 2);
    pub(crate) const MOSI: Pin = Pin::of(Port::B, 3);
    pub(crate) const MISO: Pin = Pin::of(Port::B, 4);
    pub(crate) const SCK: Pin = Pin::of(Port::B, 5);
    pub(crate) const SDA: Pin = Pin::of(Port::C, 4);
    pub(crate) const SCL: Pin = Pin::of(Port::C, 5);

    /// OCnA and OCnB.
    pub(crate) const fn outputs(timer: Which) -> [Pin; 2] {
        match timer {
            Which::T0 => [Pin::of(Port::D, 6), Pin::of(Port::D, 5)],
            Which::T1 => [Pin::of(Port::B, 1), Pin::of(Port::B, 2)],
            Which::T2 => [Pin::of(Port::B, 3), Pin::of(Port::D, 3)],
        }
    }
}
