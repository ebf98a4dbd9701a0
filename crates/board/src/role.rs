//! Terminals of parts, and what they do to their wires.

use serde::{Deserialize, Serialize};

/// A terminal of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// The only signal of a part: `signal`.
    Signal,
    /// The first channel of an encoder: `a`.
    A,
    /// The second channel of an encoder: `b`.
    B,
    /// The start of a measurement: `trigger`.
    Trigger,
    /// The pulse that is as long as the echo: `echo`.
    Echo,
    /// The duty of a motor: `pwm`.
    Pwm,
    /// The direction of a motor: `direction`.
    Direction,
    /// The first input of an H-bridge: `in1`.
    In1,
    /// The second input of an H-bridge: `in2`.
    In2,
    /// The enable input of an H-bridge: `enable`.
    Enable,
    /// Low puts an H-bridge to sleep: `standby`.
    Standby,
    /// Data of the I²C bus: `sda`.
    Sda,
    /// The clock of the I²C bus: `scl`.
    Scl,
    /// The data of a shift register: `data`.
    Data,
    /// The clock of a shift register: `clock`.
    Clock,
    /// A rise hands what was shifted in to the outputs: `latch`.
    Latch,
}

/// The effect of a terminal on its wire, or its demand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Port {
    /// The pin is measured by the ADC.
    Analog,
    /// The part drives the wire.
    Drives,
    /// The part is driven by the chip.
    Listens,
    /// The pin belongs to the I²C bus.
    Bus,
}

impl Role {
    /// The name after the dot.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Signal => "signal",
            Self::A => "a",
            Self::B => "b",
            Self::Trigger => "trigger",
            Self::Echo => "echo",
            Self::Pwm => "pwm",
            Self::Direction => "direction",
            Self::In1 => "in1",
            Self::In2 => "in2",
            Self::Enable => "enable",
            Self::Standby => "standby",
            Self::Sda => "sda",
            Self::Scl => "scl",
            Self::Data => "data",
            Self::Clock => "clock",
            Self::Latch => "latch",
        }
    }
}

impl core::fmt::Display for Role {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}
