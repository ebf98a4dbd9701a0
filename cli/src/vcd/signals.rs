//! The signals of a chip: what they are called, and which values they have.
//!
//! All pins of an Arduino are there, as a program may move one on which no wire is. `D9_PB1_motors_left_pwm` is a pin with
//! both of its names and what is on it; `adc0_sensors_ir_left` has the results of the ADC; `uart_sent` and `uart_received`
//! have the characters at TXD and RXD while they last. `loop` changes when a round of the program's main loop begins.

use std::io::{self, Write};

use baudbot_sim::chip::{Board, Level, Net, Role, Seen};
use baudbot_sim::model::RobotSpec;
use vcd::{IdCode, Value, Writer};

/// All signals with their values.
pub(super) struct Signals {
    wires: Vec<(Net, IdCode, Value)>,
    channels: Vec<(u8, Vector)>,
    sent: Vector,
    received: Vector,
    /// It changes when a round of the main loop begins.
    rounds: (IdCode, bool),
}

/// A number, or nothing.
#[derive(Clone, Copy)]
pub(super) struct Vector {
    code: IdCode,
    bits: u32,
    /// What stands there without a number.
    nothing: Value,
    number: Option<u16>,
}

/// A signal that has changed.
pub(super) enum Change {
    Wire(IdCode, Value),
    Vector(Vector),
}

impl Signals {
    /// Writes what there is into the header.
    pub(super) fn declare<W: Write>(writer: &mut Writer<W>, spec: &RobotSpec) -> io::Result<Self> {
        writer.add_module(&identifier(&spec.name))?;
        let board = spec.chip.as_ref().map(|chip| chip.board());
        let mut wires = Vec::new();
        for (net, name) in nets(board) {
            wires.push((net, writer.add_wire(1, &name)?, Value::Z));
        }
        let mut vector = |name: &str, bits, nothing| {
            let code = writer.add_wire(bits, name)?;
            io::Result::Ok(Vector { code, bits, nothing, number: None })
        };
        let mut channels = Vec::new();
        for channel in 0..8 {
            let on = parts(board, |net| net.adc_channel() == Some(channel));
            if !on.is_empty() {
                channels.push((channel, vector(&format!("adc{channel}{on}"), ADC_BITS, Value::X)?));
            }
        }
        let sent = vector("uart_sent", CHARACTER_BITS, Value::Z)?;
        let received = vector("uart_received", CHARACTER_BITS, Value::Z)?;
        let rounds = (writer.add_wire(1, "loop")?, false);
        writer.upscope()?;
        Ok(Self { wires, channels, sent, received, rounds })
    }

    /// Something was seen. What it changes, if it is among the signals.
    pub(super) fn take(&mut self, seen: &Seen) -> Option<Change> {
        match *seen {
            Seen::Level { pin, level, .. } => {
                let (_, code, value) = self.wires.iter_mut().find(|(net, ..)| *net == Net::Pin(pin))?;
                *value = match level {
                    Level::Low => Value::V0,
                    Level::High => Value::V1,
                    Level::Open => Value::Z,
                    Level::Short => Value::X,
                };
                Some(Change::Wire(*code, *value))
            }
            Seen::Converted { channel, result } => {
                let (_, vector) = self.channels.iter_mut().find(|(of, _)| *of == channel)?;
                Some(vector.set(Some(result)))
            }
            Seen::Sends(frame) => Some(self.sent.set(frame.map(|frame| frame.data()))),
            Seen::Receives(frame) => Some(self.received.set(frame.map(|frame| frame.data()))),
            Seen::Round => {
                let (code, level) = &mut self.rounds;
                *level = !*level;
                Some(Change::Wire(*code, (*level).into()))
            }
            // Its edges are drawn.
            Seen::Shape { .. } => None,
        }
    }

    /// Nothing is known of the wires.
    pub(super) fn forget(&mut self) {
        self.wires.iter_mut().for_each(|(_, _, value)| *value = Value::X);
    }

    pub(super) fn write_all<W: Write>(&self, writer: &mut Writer<W>) -> io::Result<()> {
        let wires = self.wires.iter().map(|&(_, code, value)| Change::Wire(code, value));
        let vectors = self.channels.iter().map(|(_, vector)| vector).chain([&self.sent, &self.received]);
        let rounds = Change::Wire(self.rounds.0, self.rounds.1.into());
        wires
            .chain([rounds])
            .chain(vectors.map(|&vector| Change::Vector(vector)))
            .try_for_each(|change| change.write(writer))
    }
}

impl Vector {
    fn set(&mut self, number: Option<u16>) -> Change {
        self.number = number;
        Change::Vector(*self)
    }
}

impl Change {
    pub(super) fn write<W: Write>(&self, writer: &mut Writer<W>) -> io::Result<()> {
        match *self {
            Self::Wire(code, value) => writer.change_scalar(code, value),
            Self::Vector(Vector { code, bits, nothing, number }) => {
                let bit = |bit| number.map_or(nothing, |number| Value::from(number >> bit & 1 == 1));
                writer.change_vector(code, (0..bits).rev().map(bit))
            }
        }
    }
}

/// The pins of an Arduino in the order of their numbers, and others that have wires, with their names.
fn nets(board: Option<&Board>) -> Vec<(Net, String)> {
    let mut nets: Vec<(Net, String)> = Vec::new();
    for number in 0..20 {
        let Some(net) = Net::arduino(number) else { continue };
        let printed =
            if number < ANALOG_0 { format!("D{number}") } else { format!("A{}", number - ANALOG_0) };
        let line = ["_rxd", "_txd"].get(usize::from(number)).copied().unwrap_or("");
        nets.push((net, format!("{printed}_{net}{line}{}", parts(board, |other| other == net))));
    }
    let wired = board.into_iter().flat_map(|board| board.wiring().wires());
    for net in wired.map(|(_, net)| net).filter(|net| net.pin().is_some()) {
        if !nets.iter().any(|(known, _)| *known == net) {
            nets.push((net, format!("{net}{}", parts(board, |other| other == net))));
        }
    }
    nets
}

/// The terminals on some wires, each with an underscore before it.
fn parts(board: Option<&Board>, is_meant: impl Fn(Net) -> bool) -> String {
    let wiring = board.map(Board::wiring);
    let terminals = wiring.into_iter().flat_map(|wiring| {
        let meant = wiring.wires().filter(|(_, net)| is_meant(*net));
        meant.map(|(terminal, _)| (wiring.name(terminal.part), terminal.role))
    });
    let name = |(part, role)| {
        let part = identifier(part);
        if role == Role::Signal { format!("_{part}") } else { format!("_{part}_{role}") }
    };
    terminals.map(name).collect()
}

/// A name without what would end it in the file, or mean something to viewers.
fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// The digital pin of an Arduino that is its analog input 0.
const ANALOG_0: u8 = 14;

/// Data sheet, chapter *Analog-to-Digital Converter*.
const ADC_BITS: u32 = 10;

/// Of longer characters the lower bits.
const CHARACTER_BITS: u32 = 8;
