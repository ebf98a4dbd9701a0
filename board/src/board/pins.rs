//! What chip and parts do to each pin.

use baudbot_avr::{Drive, External, Pin, Port};
use serde::{Deserialize, Serialize};

const PINS: usize = 24;

/// A pin's two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Sides {
    pub(crate) chip: Drive,
    /// As it was handed to the chip, perhaps ahead of time.
    pub(crate) part: External,
}

/// All pins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pins {
    sides: [Sides; PINS],
}

impl Pins {
    pub(crate) const fn new() -> Self {
        Self { sides: [Sides { chip: Drive::HighImpedance, part: External::Open }; PINS] }
    }

    pub(crate) const fn of(&mut self, pin: Pin) -> &mut Sides {
        let port = match pin.port() {
            Port::B => 0,
            Port::C => 1,
            Port::D => 2,
        };
        &mut self.sides[port * 8 + (pin.bit() & 7) as usize]
    }
}

impl Sides {
    /// Whether the wire is high, as its digital signals have it; None: nothing drives it.
    pub(crate) const fn level(self) -> Option<bool> {
        match (self.chip, self.part) {
            (Drive::Low, _) => Some(false),
            (Drive::High, _) => Some(true),
            (Drive::PullUp | Drive::HighImpedance, External::Low) => Some(false),
            (Drive::PullUp | Drive::HighImpedance, External::High) => Some(true),
            (Drive::PullUp, External::Open) => Some(true),
            (Drive::HighImpedance, External::Open) => None,
        }
    }
}
