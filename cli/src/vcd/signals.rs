//! The signals of a chip in a VCD file, and which values they have.
//!
//! The signals are named as in [`Signal`](baudbot_sim::chip::Signal). Besides, `loop` changes when a round of the
//! program's main loop begins.

use std::io::{self, Write};

use baudbot_sim::chip::{Level, Line, Seen, identifier};
use baudbot_sim::model::RobotSpec;
use vcd::{IdCode, Value, Writer};

/// All signals with their values.
pub(super) struct Signals {
    all: Vec<Variable>,
    /// The signal that changes when a round of the main loop begins.
    rounds: (IdCode, bool),
}

/// A signal in the file.
struct Variable {
    line: Line,
    code: IdCode,
    value: Shown,
}

#[derive(Clone, Copy)]
enum Shown {
    Bit(Value),
    /// A number of so many bits; the value is for what has no number.
    Number(Option<u16>, u32, Value),
}

/// A signal that has changed.
pub(super) struct Change(IdCode, Shown);

impl Signals {
    /// Writes what there is into the header.
    pub(super) fn declare<W: Write>(writer: &mut Writer<W>, spec: &RobotSpec) -> io::Result<Self> {
        writer.add_module(&identifier(&spec.name))?;
        let mut all = Vec::new();
        for signal in spec.chip.iter().flat_map(|chip| chip.signals()) {
            let (bits, value) = match signal.line {
                Line::MainLoop => continue,
                Line::Wire(_) => (1, Shown::Bit(Value::Z)),
                Line::Adc(_) => (ADC_BITS, Shown::Number(None, ADC_BITS, Value::X)),
                Line::Sent | Line::Received => {
                    (CHARACTER_BITS, Shown::Number(None, CHARACTER_BITS, Value::Z))
                }
            };
            let code = writer.add_wire(bits, &signal.identifier())?;
            all.push(Variable { line: signal.line, code, value });
        }
        let rounds = (writer.add_wire(1, "loop")?, false);
        writer.upscope()?;
        Ok(Self { all, rounds })
    }

    /// Something was seen. What it changes, if it is among the signals.
    pub(super) fn take(&mut self, seen: &Seen) -> Option<Change> {
        if matches!(seen, Seen::Round(_)) {
            self.rounds.1 = !self.rounds.1;
            return Some(self.round());
        }
        let line = Line::of(*seen)?;
        let Variable { code, value, .. } = self.all.iter_mut().find(|variable| variable.line == line)?;
        match (*seen, &mut *value) {
            (Seen::Level { level, .. }, Shown::Bit(bit)) => *bit = bit_of(level),
            (Seen::Converted { result, .. }, Shown::Number(number, ..)) => *number = Some(result),
            (Seen::Sends(frame) | Seen::Receives(frame), Shown::Number(number, ..)) => {
                *number = frame.map(|frame| frame.data());
            }
            (Seen::Level { .. } | Seen::Round(_) | Seen::Shape { .. }, Shown::Number(..))
            | (
                Seen::Converted { .. }
                | Seen::Sends(_)
                | Seen::Receives(_)
                | Seen::Round(_)
                | Seen::Shape { .. },
                Shown::Bit(_),
            ) => {}
        }
        Some(Change(*code, *value))
    }

    /// Nothing is known of the wires.
    pub(super) fn forget(&mut self) {
        for variable in &mut self.all {
            if let Shown::Bit(bit) = &mut variable.value {
                *bit = Value::X;
            }
        }
    }

    fn round(&self) -> Change {
        Change(self.rounds.0, Shown::Bit(self.rounds.1.into()))
    }

    pub(super) fn write_all<W: Write>(&self, writer: &mut Writer<W>) -> io::Result<()> {
        self.round().write(writer)?;
        self.all.iter().try_for_each(|variable| Change(variable.code, variable.value).write(writer))
    }
}

impl Change {
    pub(super) fn write<W: Write>(&self, writer: &mut Writer<W>) -> io::Result<()> {
        match self.1 {
            Shown::Bit(value) => writer.change_scalar(self.0, value),
            Shown::Number(number, bits, nothing) => {
                let bit = |bit| number.map_or(nothing, |number| Value::from(number >> bit & 1 == 1));
                writer.change_vector(self.0, (0..bits).rev().map(bit))
            }
        }
    }
}

fn bit_of(level: Level) -> Value {
    match level {
        Level::Low => Value::V0,
        Level::High => Value::V1,
        Level::Open => Value::Z,
        Level::Short => Value::X,
    }
}

/// Data sheet, chapter *Analog-to-Digital Converter*.
const ADC_BITS: u32 = 10;

/// The lower bits of longer characters are shown.
const CHARACTER_BITS: u32 = 8;
