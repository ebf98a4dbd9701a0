//! Pins, and what is on them.

use serde::{Deserialize, Serialize};

use crate::checked::checked;

/// A port of eight pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Port {
    /// PB7 to PB0.
    B,
    /// PC6 to PC0.
    C,
    /// PD7 to PD0.
    D,
}

impl Port {
    /// All ports.
    pub const ALL: [Self; 3] = [Self::B, Self::C, Self::D];

    pub(crate) const fn index(self) -> usize {
        self as usize
    }
}

/// A pin of a port.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Pin {
    port: Port,
    bit: u8,
}

checked!(Pin, "a port has eight pins");

impl Pin {
    /// The pin of this number, from 0 to 7; higher numbers do not exist.
    pub const fn new(port: Port, bit: u8) -> Option<Self> {
        if bit < 8 { Some(Self { port, bit }) } else { None }
    }

    /// The port of the pin.
    pub const fn port(self) -> Port {
        self.port
    }

    /// The number of the pin in the port, from 0 to 7.
    pub const fn bit(self) -> u8 {
        self.bit
    }

    const fn is_possible(self) -> bool {
        self.bit < 8
    }

    pub(crate) const fn mask(self) -> u8 {
        1 << (self.bit & 7)
    }

    pub(crate) const fn of(port: Port, bit: u8) -> Self {
        Self { port, bit: bit & 7 }
    }
}

impl core::fmt::Debug for Pin {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "P{:?}{}", self.port, self.bit)
    }
}

/// The effect of a pin on its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Drive {
    /// An output that is low.
    Low,
    /// An output that is high.
    High,
    /// An input with its pull-up resistor.
    PullUp,
    /// An input.
    HighImpedance,
}

impl Drive {
    /// Whether it drives its wire.
    pub const fn is_output(self) -> bool {
        match self {
            Self::Low | Self::High => true,
            Self::PullUp | Self::HighImpedance => false,
        }
    }
}

/// The effect of another part on a pin's wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum External {
    /// The part pulls the wire to ground.
    Low,
    /// The part pulls the wire to the supply.
    High,
    /// The part does not drive the pin: an input reads high with its pull-up resistor, and without one it floats.
    Open,
}

/// The shape of a signal that a timer makes on a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Pwm {
    /// Periods of the clock source in which the pin is high.
    pub high: u64,
    /// Periods of the clock source until the signal repeats; never 0.
    pub period: u64,
}

impl Pwm {
    const fn is_possible(self) -> bool {
        self.high <= self.period && self.period > 0
    }
}

checked!(Pwm, "a signal is high for a part of its period");

/// The kind of report for an output of a timer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PwmReport {
    /// Each edge, as a change of the pin: for servos and tones.
    #[default]
    Edges,
    /// The shape of the signal whenever it changes, and no edges: for motors. This is much faster.
    Shape,
}
