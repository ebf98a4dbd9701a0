//! Firmware: what the microcontroller says on its wire, and how it is understood at the laptop's end.

use alloc::vec::Vec;

use baudbot_wire::khepera::Lines;
use baudbot_wire::{BareDecoder, Encoding, Layout};
use serde::{Deserialize, Serialize};

use crate::link::{LEAST_BAUD, Uart};
use crate::schedule::Schedule;
use crate::time::{SECOND_NS, SimTime};

/// A program of the microcontroller, one of a closed set.
#[derive(Clone, Debug, PartialEq)]
pub struct Firmware {
    /// The form of its messages.
    pub protocol: Protocol,
    /// When it sends readings.
    pub mode: Mode,
    pub(crate) fields: Fields,
}

/// The form of the messages on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Our own frames, with sequence number, time and checksum.
    Framed {
        /// Whether each reading carries its age.
        ages: bool,
    },
    /// The notes' bare bytes (§3.2.1): one value after the other and nothing else. It knows no readability,
    /// so every value that arrives counts as readable.
    Bare {
        /// Silence after which a part of a message is given up, in nanoseconds.
        gap_ns: u64,
    },
    /// The lines of text of a Khepera, which answers only when asked. It knows no readability either.
    Khepera,
}

/// When readings are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// On a schedule of the microcontroller's.
    Stream(Schedule),
    /// In answer to a command, and to a poll in the framed protocol; in that of the Khepera in answer to a poll
    /// alone. Those that come while an answer waits to be sent share it.
    Poll,
}

/// What the two ends have agreed on: how each sensor's components and each motor's signal are encoded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fields {
    components: Vec<Encoding>,
    counts: Vec<u8>,
    motors: Vec<Encoding>,
    ages: bool,
}

impl Firmware {
    /// A firmware that sends `sensors`' components and takes signals for two motors and the other actuators. Those of a
    /// sensor with more components than a message can count, 255, are in none: a brain on board gets them without.
    pub fn new(protocol: Protocol, mode: Mode, sensors: &[&[Encoding]], motors: Vec<Encoding>) -> Self {
        let counted =
            |sensor: &&[Encoding]| if sensor.len() > usize::from(u8::MAX) { 0 } else { sensor.len() };
        let sensors: Vec<_> = sensors.iter().map(|sensor| &sensor[..counted(sensor)]).collect();
        let fields = Fields {
            components: sensors.concat(),
            counts: sensors.iter().map(|components| components.len() as u8).collect(),
            motors,
            ages: matches!(protocol, Protocol::Framed { ages: true }),
        };
        Self { protocol, mode, fields }
    }

    /// The layout that encodes and decodes this firmware's messages.
    pub fn layout(&self) -> Layout<'_> {
        let Fields { components, counts, motors, ages } = &self.fields;
        Layout { components, counts, motors, ages: *ages }
    }

    /// The least baud rate of a cable on which its messages are told apart: a bare one ends when there is silence for
    /// longer than a character takes.
    pub(crate) fn least_baud(&self, uart: &Uart) -> u64 {
        let Protocol::Bare { gap_ns } = self.protocol else { return LEAST_BAUD };
        let bits_ns = u64::from(uart.bits_per_character) * SECOND_NS;
        let character_ns = gap_ns.saturating_sub(uart.adapter.hold_ns() + 1).max(1);
        bits_ns.div_ceil(character_ns).max(LEAST_BAUD)
    }

    /// How one motor signal is encoded.
    pub fn motor_encoding(&self) -> Encoding {
        self.fields.motors[0]
    }

    pub(crate) fn reading_decoder(&self) -> Decoder {
        self.decoder(self.layout().bare_readings_len(), Lines::of_answers())
    }

    pub(crate) fn command_decoder(&self) -> Decoder {
        self.decoder(self.layout().bare_command_len(), Lines::of_questions())
    }

    fn decoder(&self, bare_len: usize, lines: Lines) -> Decoder {
        match self.protocol {
            Protocol::Framed { .. } => Decoder::Framed(baudbot_wire::Decoder::new()),
            Protocol::Bare { gap_ns } => {
                let decoder = BareDecoder::new(bare_len, gap_ns);
                Decoder::Bare(decoder.expect("scenario files refuse messages that are too long"))
            }
            Protocol::Khepera => Decoder::Khepera { lines, owed: Owed::default() },
        }
    }
}

/// Finds messages in a stream of bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Decoder {
    Framed(baudbot_wire::Decoder),
    Bare(BareDecoder),
    /// At the robot's end with what it owes in answer to the lines that came.
    Khepera {
        lines: Lines,
        owed: Owed,
    },
}

/// Answers that a robot owes which has one for each kind of question. What is asked for again while the answer waits
/// is answered once.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Owed {
    pub(crate) acknowledgement: bool,
    pub(crate) readings: bool,
}

/// What a byte completed.
pub(crate) enum Found<'a> {
    Nothing,
    Payload(&'a [u8]),
    BadFrame,
}

impl Decoder {
    pub(crate) fn push(&mut self, byte: u8, at: SimTime) -> Found<'_> {
        match self {
            Self::Bare(bare) => bare.push(byte, at.as_ns()).map_or(Found::Nothing, Found::Payload),
            Self::Framed(framed) => match framed.push(byte) {
                None => Found::Nothing,
                Some(Ok(payload)) => Found::Payload(payload),
                Some(Err(_)) => Found::BadFrame,
            },
            Self::Khepera { lines, .. } => match lines.push(byte) {
                None => Found::Nothing,
                Some(Ok(line)) => Found::Payload(line),
                Some(Err(_)) => Found::BadFrame,
            },
        }
    }

    /// Whether this decoder may have become what `other` is.
    pub(crate) fn may_become(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Framed(_), Self::Framed(_)) => true,
            (Self::Bare(own), Self::Bare(other)) => own.may_become(other),
            (Self::Khepera { lines: own, .. }, Self::Khepera { lines: other, .. }) => own.may_become(other),
            (Self::Framed(_) | Self::Bare(_) | Self::Khepera { .. }, _) => false,
        }
    }

    /// A message that was understood asks for readings, or else to have its obeying acknowledged. Where every answer
    /// is readings there is nothing to remember.
    pub(crate) fn owe(&mut self, readings: bool) {
        if let Self::Khepera { owed, .. } = self {
            owed.readings |= readings;
            owed.acknowledgement |= !readings;
        }
    }

    /// What is owed, which is answered now.
    pub(crate) fn settle(&mut self) -> Owed {
        match self {
            Self::Framed(_) | Self::Bare(_) => Owed::default(),
            Self::Khepera { owed, .. } => core::mem::take(owed),
        }
    }

    /// Messages that silence cut short so far.
    pub(crate) fn cut_short(&self) -> u64 {
        match self {
            Self::Framed(_) | Self::Khepera { .. } => 0,
            Self::Bare(bare) => bare.discarded(),
        }
    }
}
