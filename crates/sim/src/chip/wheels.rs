//! The pins at which a program makes the robot's wheels turn, and when it makes them turn otherwise.

use alloc::vec::Vec;

use baudbot_board::{By, Edge, Level, Net, Role, Seen, Terminal};

use super::{Attached, ChipSpec};

impl Attached {
    /// Whether it is a wheel's motor.
    const fn is_wheel(&self) -> bool {
        match self {
            Self::Motor(_) | Self::WheelServo(_) => true,
            Self::Voltage(_)
            | Self::Comparator(_)
            | Self::Control(_)
            | Self::Contact { .. }
            | Self::Wheel(_)
            | Self::Sonar { .. }
            | Self::Reflectance { .. }
            | Self::Compass { .. }
            | Self::Actuator(_)
            | Self::Board => false,
        }
    }
}

impl ChipSpec {
    /// Whether a wheel's motor turns when this wire is high.
    pub fn turns_a_wheel(&self, net: Net) -> bool {
        let turns = |terminal: Terminal| {
            let others = [Role::Direction, Role::Standby, Role::Data, Role::Clock, Role::Latch];
            !others.contains(&terminal.role)
        };
        self.of_wheels().any(|(terminal, _, other)| other == net && turns(terminal))
    }

    /// The terminals of the wheels' motors, with what they belong to and their wires.
    fn of_wheels(&self) -> impl Iterator<Item = (Terminal, Attached, Net)> {
        let wires = self.board().wiring().wires();
        let attached = wires.map(|(terminal, net)| (terminal, self.attached_to(terminal.part), net));
        attached.filter(|(_, attached, _)| attached.is_wheel())
    }
}

/// Finds by the [edges](baudbot_board::Board::edges) of a board when the program changes the signal of a wheel's motor:
/// a pin of a bridge moves, the duty or the frequency of its PWM is another one, or a pulse of a servo is longer or
/// shorter than the one before.
#[derive(Clone, Debug)]
pub struct WheelPins(Vec<WheelPin>);

#[derive(Clone, Debug)]
struct WheelPin {
    net: Net,
    is_servo: bool,
    /// The begin of a servo's pulse, and how long the last one was.
    pulse: Option<u64>,
    width_ns: Option<u64>,
}

impl WheelPins {
    /// The pins of a chip.
    pub fn new(chip: &ChipSpec) -> Self {
        // What is shifted into a register moves nothing before it is latched.
        let shifts = |terminal: Terminal| matches!(terminal.role, Role::Data | Role::Clock);
        let pin = |(terminal, attached, net): (Terminal, Attached, Net)| {
            let is_servo = matches!(attached, Attached::WheelServo(_));
            net.pin().filter(|_| !shifts(terminal)).map(|_| WheelPin {
                net,
                is_servo,
                pulse: None,
                width_ns: None,
            })
        };
        Self(chip.of_wheels().filter_map(pin).collect())
    }

    /// Takes the next edge. The wire with which the program makes a motor do otherwise from then on, if it is one.
    pub fn take(&mut self, edge: &Edge) -> Option<Net> {
        let (pin, level) = match edge.seen {
            Seen::Shape { pin, .. } => (pin, None),
            Seen::Level { pin, level, by: By::Chip } => (pin, Some(level)),
            Seen::Level { by: By::Shape | By::Character | By::Part, .. }
            | Seen::Converted { .. }
            | Seen::Sends(_)
            | Seen::Receives(_)
            | Seen::Round(_) => return None,
        };
        let found = self.0.iter_mut().find(|found| found.net == Net::Pin(pin))?;
        let changes = level.is_none_or(|level| found.moves(edge.at_ns, level == Level::High));
        changes.then_some(found.net)
    }
}

impl WheelPin {
    /// The chip has moved the pin. Returns whether the motor does otherwise from now on.
    fn moves(&mut self, at_ns: u64, high: bool) -> bool {
        if !self.is_servo {
            return true;
        }
        if high {
            self.pulse = Some(at_ns);
            return false;
        }
        let Some(width) = self.pulse.take().map(|begin| at_ns.saturating_sub(begin)) else { return false };
        self.width_ns.replace(width).is_none_or(|before| before.abs_diff(width) > PULSE_JITTER_NS)
    }
}

/// Interrupts make the pulses of a library longer and shorter by some microseconds.
const PULSE_JITTER_NS: u64 = 4_000;
