//! The effects of chip and parts on each pin.

use baudbot_avr::{Drive, External, Pin, Port};
use serde::{Deserialize, Serialize};

const PINS: usize = 24;

/// A pin's two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Sides {
    pub(crate) chip: Drive,
    /// The part's output as it was handed to the chip, perhaps ahead of time.
    pub(crate) part: External,
}

/// All pins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pins {
    sides: [Sides; PINS],
    /// Pins that chip and part drive against each other; a bit for each.
    shorts: u32,
}

impl Pins {
    pub(crate) const fn new() -> Self {
        Self { sides: [Sides { chip: Drive::HighImpedance, part: External::Open }; PINS], shorts: 0 }
    }

    /// Whether these are pins that exist. The edges of a pin with a timer's signal are not reported, so that the chip's
    /// own pins may differ from the last report.
    pub(crate) const fn is_possible(&self) -> bool {
        self.shorts < 1 << PINS
    }

    pub(crate) const fn of(&mut self, pin: Pin) -> &mut Sides {
        &mut self.sides[place(pin)]
    }

    /// Notes that this pin is shorted.
    pub(crate) const fn note_short(&mut self, pin: Pin) {
        self.shorts |= 1 << place(pin);
    }

    /// Pins that are shorted now and were not before. Chip and parts must be at one instant.
    pub(crate) fn new_shorts(&mut self) -> impl Iterator<Item = Pin> + use<> {
        let shorted = |(at, sides): (usize, &Sides)| u32::from(sides.is_short()) << at;
        let shorts = self.sides.iter().enumerate().map(shorted).fold(0, |all, one| all | one);
        let new = shorts & !core::mem::replace(&mut self.shorts, shorts);
        let pins = Port::ALL.into_iter().flat_map(|port| (0..8).filter_map(move |bit| Pin::new(port, bit)));
        pins.filter(move |pin| new >> place(*pin) & 1 == 1)
    }
}

const fn place(pin: Pin) -> usize {
    let port = match pin.port() {
        Port::B => 0,
        Port::C => 1,
        Port::D => 2,
    };
    port * 8 + (pin.bit() & 7) as usize
}

impl Sides {
    pub(crate) const fn is_short(self) -> bool {
        matches!((self.chip, self.part), (Drive::Low, External::High) | (Drive::High, External::Low))
    }

    /// Whether the wire is high by its digital signals; None: nothing drives it.
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
