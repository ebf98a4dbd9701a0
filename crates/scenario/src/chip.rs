//! The way from a microcontroller's program and the table of its pins to a [`ChipSpec`].
//!
//! A pin has what is connected to it: `A0 = "sensors.ir_left"`, or a list of such, or a table with options. What is connected
//! is a terminal of a part; which part it is follows from what it belongs to and from the terminals that are used of it.

mod options;
mod parts;
mod program;

use alloc::format;
use alloc::string::ToString;
use alloc::sync::Arc;

use baudbot_avr::Fuses;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::actuator::Actuator;
use baudbot_sim::chip::ChipSpec;
use baudbot_sim::link::Link;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::Sensor;

use super::{controls, raw};
use parts::Wires;

type Result<T> = core::result::Result<T, FieldError>;

/// The parts of a robot that its chip's pins may be connected to, and its cable.
pub(super) struct Parts<'a> {
    pub(super) sensors: &'a [Sensor],
    pub(super) motors: &'a Motors,
    pub(super) actuators: &'a [Actuator],
    pub(super) link: &'a Link,
}

/// The chip, if it has a program. Its pins are checked in any case.
pub(super) fn chip(path: &Path, raw: &raw::Robot, robot: &Parts<'_>) -> Result<Option<Arc<ChipSpec>>> {
    let at = path.field("pins");
    let connections = raw.pins.connections(&at);
    let Wires { wiring, attached, controls } = parts::wires(&at, &connections, robot)?;
    let controls = controls::controls(&path.field("operations"), &raw.operations, controls)?;
    let (at, microcontroller) = (path.field("microcontroller"), &raw.microcontroller);
    let fuses = program::fuses(&at, microcontroller)?;
    for (at, pin, _) in &connections {
        program::check_pin(at, pin, fuses)?;
    }
    let part = program::part(&at, microcontroller)?;
    let clock = program::clock(&at, microcontroller)?;
    let protocol = raw.firmware.protocol(microcontroller);
    let Some(given) = &microcontroller.program else {
        let problem =
            "is for a microcontroller with a `program`, whose bytes only other programs of yours understand";
        let own = protocol == raw::Protocol::Own;
        return if own { Err(path.field("firmware").field("protocol").error(problem)) } else { Ok(None) };
    };
    speaks(path, robot.link, protocol)?;
    let program = program::program(&at, given, part)?;
    // A clock that starts at once, and address 0: what a programmer leaves that writes a sketch without a boot loader.
    let fuses = fuses.unwrap_or_else(|| Fuses::external_clock(part));
    let is_opaque = protocol == raw::Protocol::Own;
    let chip = ChipSpec::new(&program, (fuses, clock), wiring, attached, is_opaque);
    let chip = chip.map_err(|error| at.error(error.to_string()))?;
    Ok(Some(Arc::new(chip.with_controls(controls))))
}

/// A chip's UART needs a cable with a baud rate, and its bytes are its program's.
fn speaks(path: &Path, link: &Link, protocol: raw::Protocol) -> Result<()> {
    let at = path.field("link");
    let Link::Uart(uart) = link else {
        let problem = "must be a serial cable (kind = \"uart\", or preset = \"uart-9600\") for a microcontroller with a \
                       program: what comes to its UART has a baud rate";
        return Err(at.error(problem));
    };
    if uart.turnaround_ns.is_some() {
        let problem = "must be false: a microcontroller with a program has no half-duplex cable yet";
        return Err(at.field("half_duplex").error(problem));
    }
    if uart.bits_per_character < 10 {
        let problem = format!(
            "must be 10 (8N1) or 11 (8N2) for a microcontroller with a program, whose UART has start and stop bits; is {}",
            uart.bits_per_character
        );
        return Err(at.field("bits_per_character").error(problem));
    }
    let problem = "is a protocol of the modelled firmware; with a program of your own take \"own\", or \"framed\" or \
                   \"bare\" if your program speaks these";
    path.field("firmware").refuse("protocol", protocol.is_dialogue(), problem)
}
