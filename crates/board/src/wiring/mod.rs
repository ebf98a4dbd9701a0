//! The terminals of parts on each pin.

mod builder;
mod error;
mod net;

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_avr::Pin;
use serde::{Deserialize, Serialize};

pub use builder::Builder;
pub use error::WiringError;
pub use net::Net;

use crate::parts::Kind;
use crate::physics::PartId;
use crate::role::{Port, Role};

/// A terminal of a part of a wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Terminal {
    /// The part.
    pub part: PartId,
    /// The role of the terminal.
    pub role: Role,
}

/// Parts, and the wires from their terminals to the chip. It was checked when it was built: each terminal is connected, and no
/// wire has two drivers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "builder::Loaded")]
pub struct Wiring {
    parts: Vec<Placed>,
    wires: Vec<(Terminal, Net)>,
}

/// A part in a wiring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    name: String,
    kind: Kind,
}

impl Placed {
    /// The part's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The kind of the part.
    pub const fn kind(&self) -> &Kind {
        &self.kind
    }
}

impl Wiring {
    /// A description that is checked when it is complete.
    pub fn builder() -> Builder {
        Builder::default()
    }

    /// The parts, in the order in which they were given.
    pub fn parts(&self) -> impl Iterator<Item = (PartId, &Placed)> {
        (0..).map(PartId).zip(&self.parts)
    }

    /// The part of a name.
    pub fn part(&self, name: &str) -> Option<PartId> {
        self.parts().find(|(_, placed)| placed.name == name).map(|(id, _)| id)
    }

    /// The name of a part; empty if another wiring's part is meant.
    pub fn name(&self, part: PartId) -> &str {
        self.parts.get(part.index()).map_or("", Placed::name)
    }

    /// All wires: a terminal, and what it is connected to.
    pub fn wires(&self) -> impl Iterator<Item = (Terminal, Net)> {
        self.wires.iter().copied()
    }

    /// The name of a terminal: that of its part, and behind a dot its own if the part has several.
    pub fn terminal_name(&self, terminal: Terminal) -> String {
        let name = self.name(terminal.part);
        match self.parts.get(terminal.part.index()) {
            Some(placed) if placed.kind.terminals().len() > 1 => format!("{name}.{}", terminal.role),
            Some(_) | None => name.to_string(),
        }
    }

    /// The net that a terminal is connected to.
    pub fn net(&self, terminal: Terminal) -> Option<Net> {
        self.wires().find(|(other, _)| *other == terminal).map(|(_, net)| net)
    }

    /// The terminals on a pin that react to the chip's output there. Drivers are among them: a sensor on one pin is
    /// triggered by it.
    pub(crate) fn on(&self, pin: Pin) -> impl Iterator<Item = Terminal> {
        self.wires().filter(move |(_, net)| net.pin() == Some(pin)).map(|(terminal, _)| terminal)
    }

    /// The voltage on a channel of the ADC.
    pub(crate) fn voltage_on(&self, channel: u8) -> Option<PartId> {
        let measured = |&(terminal, net): &(Terminal, Net)| {
            net.adc_channel() == Some(channel) && self.port(terminal) == Some(Port::Analog)
        };
        self.wires().find(measured).map(|(terminal, _)| terminal.part)
    }

    /// The part with this address on the I²C bus.
    pub(crate) fn at_bus_address(&self, address: u8) -> Option<PartId> {
        self.parts().find(|(_, placed)| placed.kind.bus_address() == Some(address)).map(|(id, _)| id)
    }

    /// The part that drives a pin, or gives it a voltage.
    pub(crate) fn driver(&self, pin: Pin) -> Option<PartId> {
        let drives = |terminal: &Terminal| matches!(self.port(*terminal), Some(Port::Drives | Port::Analog));
        self.on(pin).find(drives).map(|terminal| terminal.part)
    }

    /// Whether the shape of a timer's signal is enough for all terminals of a pin.
    pub(crate) fn takes_shapes(&self, pin: Pin) -> bool {
        let mut listeners =
            self.on(pin).filter_map(|terminal| self.parts.get(terminal.part.index())).peekable();
        listeners.peek().is_some() && listeners.all(|placed| placed.kind.takes_shapes())
    }

    fn port(&self, terminal: Terminal) -> Option<Port> {
        self.parts.get(terminal.part.index()).map(|placed| placed.kind.port(terminal.role))
    }
}

#[cfg(test)]
mod tests;
