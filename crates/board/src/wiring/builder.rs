//! The way from a description to a wiring.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_avr::{Pin, Port as ChipPort};
use serde::Deserialize;

use super::{Net, Placed, Terminal, Wiring, WiringError};
use crate::parts::Kind;
use crate::role::{Port, Role};

/// A wiring that is not checked yet. Parts and wires come in any order.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    parts: Vec<Placed>,
    wires: Vec<(String, String)>,
}

impl Builder {
    /// Another part. Its name may have dots in it, as `motors.left`.
    #[must_use]
    pub fn part(mut self, name: impl Into<String>, kind: Kind) -> Self {
        self.parts.push(Placed { name: name.into(), kind });
        self
    }

    /// A wire from a pin (see [`Net::by_name`]) to a terminal: `motors.left.pwm`, or the name alone of a part with one
    /// terminal.
    #[must_use]
    pub fn connect(mut self, pin: impl Into<String>, terminal: impl Into<String>) -> Self {
        self.wires.push((pin.into(), terminal.into()));
        self
    }

    /// Checks the whole.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong; see [`WiringError`].
    pub fn build(self) -> Result<Wiring, WiringError> {
        let Self { parts, wires } = self;
        u16::try_from(parts.len()).map_err(|_| WiringError::TooMany)?;
        let mut wiring = Wiring { parts, wires: Vec::with_capacity(wires.len()) };
        check_names(&wiring)?;
        for (pin, text) in &wires {
            let net = Net::by_name(pin)
                .ok_or_else(|| WiringError::UnknownPin { terminal: text.clone(), pin: pin.clone() })?;
            let terminal = find_terminal(&wiring, pin, text)?;
            check_wire(&wiring, terminal, net)?;
            wiring.wires.push((terminal, net));
        }
        check_complete(&wiring)?;
        check_addresses(&wiring)?;
        Ok(wiring)
    }
}

/// A wiring as it is loaded.
#[derive(Deserialize)]
pub(super) struct Loaded {
    parts: Vec<Placed>,
    wires: Vec<(Terminal, Net)>,
}

impl TryFrom<Loaded> for Wiring {
    type Error = WiringError;

    fn try_from(Loaded { parts, wires }: Loaded) -> Result<Self, WiringError> {
        u16::try_from(parts.len()).map_err(|_| WiringError::TooMany)?;
        let mut wiring = Self { parts, wires: Vec::with_capacity(wires.len()) };
        check_names(&wiring)?;
        for (terminal, net) in wires {
            let placed = wiring.parts.get(terminal.part.index());
            let known = placed.is_some_and(|placed| placed.kind.terminals().contains(&terminal.role));
            if !known || !net.is_possible() {
                return Err(WiringError::Impossible { wire: wiring.wires.len() });
            }
            check_wire(&wiring, terminal, net)?;
            wiring.wires.push((terminal, net));
        }
        check_complete(&wiring)?;
        check_addresses(&wiring)?;
        Ok(wiring)
    }
}

fn check_names(wiring: &Wiring) -> Result<(), WiringError> {
    for (id, placed) in wiring.parts() {
        if wiring.part(&placed.name) != Some(id) {
            return Err(WiringError::SameName { part: placed.name.clone() });
        }
    }
    Ok(())
}

/// The terminal that a text names.
fn find_terminal(wiring: &Wiring, pin: &str, text: &str) -> Result<Terminal, WiringError> {
    let (part, role) = match (wiring.part(text), text.rsplit_once('.')) {
        (Some(part), _) => (part, None),
        (None, Some((name, role))) => {
            (wiring.part(name).ok_or_else(|| unknown_part(wiring, pin, text))?, Some(role))
        }
        (None, None) => return Err(unknown_part(wiring, pin, text)),
    };
    let known = wiring.parts[part.index()].kind.terminals();
    let found = match role {
        Some(role) => known.iter().find(|known| known.name() == role),
        None => known.first().filter(|_| known.len() == 1),
    };
    match found {
        Some(&role) => Ok(Terminal { part, role }),
        None => Err(WiringError::UnknownTerminal {
            pin: pin.to_string(),
            text: text.to_string(),
            part: wiring.name(part).to_string(),
            known,
        }),
    }
}

fn unknown_part(wiring: &Wiring, pin: &str, text: &str) -> WiringError {
    let known = wiring.parts.iter().map(|placed| placed.name.clone()).collect();
    WiringError::UnknownPart { pin: pin.to_string(), text: text.to_string(), known }
}

/// Whether a wire can be added to those that are there.
fn check_wire(wiring: &Wiring, terminal: Terminal, net: Net) -> Result<(), WiringError> {
    let part = || wiring.name(terminal.part).to_string();
    let role = terminal.role;
    if let Some(first) = wiring.net(terminal) {
        return Err(WiringError::ConnectedTwice { part: part(), terminal: role, first, second: net });
    }
    match wiring.port(terminal) {
        Some(Port::Analog) if net.adc_channel().is_none() => {
            Err(WiringError::NoAdc { part: part(), terminal: role, pin: net })
        }
        Some(Port::Drives) if net.pin().is_none() => {
            Err(WiringError::NotDigital { part: part(), terminal: role, pin: net })
        }
        Some(Port::Listens) if matches!(net, Net::AnalogOnly(_)) => {
            Err(WiringError::NotDigital { part: part(), terminal: role, pin: net })
        }
        Some(Port::Bus) if net != bus(role) => {
            Err(WiringError::NotTheBus { part: part(), terminal: role, pin: net, wanted: bus(role) })
        }
        Some(Port::Analog | Port::Drives) => check_drivers(wiring, terminal, net),
        Some(Port::Listens | Port::Bus) | None => Ok(()),
    }
}

/// PC4 and PC5: data sheet, section *Alternate Functions of Port C*.
fn bus(role: Role) -> Net {
    let bit = if role == Role::Sda { 4 } else { 5 };
    Pin::new(ChipPort::C, bit).map_or(Net::Ground, Net::Pin)
}

fn check_drivers(wiring: &Wiring, terminal: Terminal, net: Net) -> Result<(), WiringError> {
    let drives =
        |other: Terminal| matches!(wiring.port(other), Some(Port::Drives | Port::Analog | Port::Bus));
    match wiring.wires().find(|&(other, there)| there == net && drives(other)) {
        None => Ok(()),
        Some((first, _)) => Err(WiringError::TwoOutputs {
            pin: net,
            part: wiring.name(first.part).to_string(),
            terminal: first.role,
            other: wiring.name(terminal.part).to_string(),
            other_terminal: terminal.role,
        }),
    }
}

fn check_complete(wiring: &Wiring) -> Result<(), WiringError> {
    for (part, placed) in wiring.parts() {
        for &role in placed.kind.terminals() {
            if wiring.net(Terminal { part, role }).is_none() {
                return Err(WiringError::Open { part: placed.name.clone(), terminal: role });
            }
        }
    }
    Ok(())
}

fn check_addresses(wiring: &Wiring) -> Result<(), WiringError> {
    for (id, placed) in wiring.parts() {
        let Some(address) = placed.kind.bus_address() else { continue };
        let first = wiring.parts().find(|(_, other)| other.kind.bus_address() == Some(address));
        if let Some((_, first)) = first.filter(|(first, _)| *first != id) {
            return Err(WiringError::SameAddress {
                part: first.name.clone(),
                other: placed.name.clone(),
                address,
            });
        }
    }
    Ok(())
}
