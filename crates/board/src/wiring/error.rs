//! The errors of a wiring.

use alloc::string::String;
use alloc::vec::Vec;

use thiserror::Error;

use crate::role::Role;
use crate::wiring::Net;

/// A description is no wiring.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum WiringError {
    /// There is no such pin.
    #[error(
        "`{terminal}` is on `{pin}`, which is no pin: there are 0 to 19, A0 to A7, PB0 to PD7, GND and VCC"
    )]
    UnknownPin {
        /// The terminal, as it was written.
        terminal: String,
        /// The pin, as it was written.
        pin: String,
    },
    /// There is no such part.
    #[error("pin {pin}: `{text}` names no part; there are: {}", known.join(", "))]
    UnknownPart {
        /// The pin, as it was written.
        pin: String,
        /// The terminal, as it was written.
        text: String,
        /// The parts that there are.
        known: Vec<String>,
    },
    /// The part has no such terminal, or has several and none is named.
    #[error("pin {pin}: `{text}` names no terminal of `{part}`; it has: {}", Names(known))]
    UnknownTerminal {
        /// The pin, as it was written.
        pin: String,
        /// The terminal, as it was written.
        text: String,
        /// The part.
        part: String,
        /// The terminals that it has.
        known: &'static [Role],
    },
    /// Two parts have one name.
    #[error("two parts are named `{part}`")]
    SameName {
        /// The name.
        part: String,
    },
    /// A terminal is on two pins.
    #[error("`{part}.{terminal}` is on {first} and on {second}")]
    ConnectedTwice {
        /// The part.
        part: String,
        /// The terminal.
        terminal: Role,
        /// The terminal's first connection.
        first: Net,
        /// The terminal's second connection.
        second: Net,
    },
    /// Two terminals would drive one wire.
    #[error("`{part}.{terminal}` and `{other}.{other_terminal}` both drive {pin}")]
    TwoOutputs {
        /// The pin.
        pin: Net,
        /// The part that was there first.
        part: String,
        /// The first part's terminal.
        terminal: Role,
        /// The other part.
        other: String,
        /// The other part's terminal.
        other_terminal: Role,
    },
    /// A voltage is on a pin that the ADC cannot measure.
    #[error("`{part}.{terminal}` is a voltage, and {pin} has no ADC: A0 to A7 have")]
    NoAdc {
        /// The part.
        part: String,
        /// The terminal.
        terminal: Role,
        /// The pin.
        pin: Net,
    },
    /// A digital signal is on a wire that is no pin of a port.
    #[error("`{part}.{terminal}` is a digital signal, and {pin} is no digital pin")]
    NotDigital {
        /// The part.
        part: String,
        /// The terminal.
        terminal: Role,
        /// The pin.
        pin: Net,
    },
    /// A terminal of the I²C bus is on another pin.
    #[error("`{part}.{terminal}` is on {pin}, and the chip's is on {wanted}")]
    NotTheBus {
        /// The part.
        part: String,
        /// The terminal.
        terminal: Role,
        /// The pin.
        pin: Net,
        /// The pin of the bus.
        wanted: Net,
    },
    /// Two parts on the I²C bus have one address.
    #[error("`{part}` and `{other}` both have the address {address:#04x}")]
    SameAddress {
        /// The part that was there first.
        part: String,
        /// The other part.
        other: String,
        /// The address, 7 bits.
        address: u8,
    },
    /// A terminal is not connected.
    #[error("`{part}.{terminal}` is not connected")]
    Open {
        /// The part.
        part: String,
        /// The terminal.
        terminal: Role,
    },
    /// A wiring was loaded with a wire at a terminal or to a pin that no board has.
    #[error("wire {wire} has a terminal or a pin that does not exist")]
    Impossible {
        /// The wire's place among the wires, from 0.
        wire: usize,
    },
    /// There are more parts than numbers for them.
    #[error("there are more than 65535 parts")]
    TooMany,
}

/// Terminals with commas between them.
struct Names<'a>(&'a [Role]);

impl core::fmt::Display for Names<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (at, role) in self.0.iter().enumerate() {
            let comma = if at == 0 { "" } else { ", " };
            write!(f, "{comma}{role}")?;
        }
        Ok(())
    }
}
