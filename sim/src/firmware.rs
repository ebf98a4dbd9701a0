//! Firmware: what the microcontroller says on its wire, and how it is understood at the laptop's end.

use alloc::vec::Vec;

use baudbot_wire::{BareDecoder, Encoding, Layout};
use serde::{Deserialize, Serialize};

use crate::schedule::Schedule;
use crate::time::SimTime;

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
}

/// When readings are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// On a schedule of the microcontroller's.
    Stream(Schedule),
    /// In answer to a command, and to a poll in the framed protocol. Those that come while an answer waits to
    /// be sent share it.
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
    /// A firmware that sends `sensors`' components and takes signals for two motors and the other actuators.
    pub fn new(protocol: Protocol, mode: Mode, sensors: &[&[Encoding]], motors: Vec<Encoding>) -> Self {
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

    /// How one motor signal is encoded.
    pub fn motor_encoding(&self) -> Encoding {
        self.fields.motors[0]
    }

    pub(crate) fn reading_decoder(&self) -> Decoder {
        self.decoder(self.layout().bare_readings_len())
    }

    pub(crate) fn command_decoder(&self) -> Decoder {
        self.decoder(self.layout().bare_command_len())
    }

    fn decoder(&self, bare_len: usize) -> Decoder {
        match self.protocol {
            Protocol::Framed { .. } => Decoder::Framed(baudbot_wire::Decoder::new()),
            Protocol::Bare { gap_ns } => {
                let decoder = BareDecoder::new(bare_len, gap_ns);
                Decoder::Bare(decoder.expect("scenario files refuse messages that are too long"))
            }
        }
    }
}

/// Finds messages in a stream of bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Decoder {
    Framed(baudbot_wire::Decoder),
    Bare(BareDecoder),
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
        }
    }

    /// Messages that silence cut short so far.
    pub(crate) fn cut_short(&self) -> u64 {
        match self {
            Self::Framed(_) => 0,
            Self::Bare(bare) => bare.discarded(),
        }
    }
}
