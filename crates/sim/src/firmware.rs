//! Firmware: what the microcontroller says on its wire, and how it is understood at the laptop's end.

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_wire::create::{self, Opening, Signal, Stream, Version};
use baudbot_wire::khepera::{self, Lines};
use baudbot_wire::{BareDecoder, Encoding, Layout, frame, write_command, write_values};

pub(crate) use crate::decoder::{Decoder, Found};
use crate::heap::elements;
use crate::link::{Command, LEAST_BAUD, Uart};
use crate::open_interface::OpenInterface;
pub(crate) use crate::registers::{Owed, Refusal, Registers, Say};
use crate::schedule::Schedule;
use crate::time::SECOND_NS;

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
    /// The Open Interface of an iRobot Create. It streams what it is asked to stream, new or not.
    Create(Version),
}

impl Protocol {
    /// Whether each message has all values, new or not: it knows no readability.
    pub const fn repeats(self) -> bool {
        match self {
            Self::Bare { .. } | Self::Khepera | Self::Create(_) => true,
            Self::Framed { .. } => false,
        }
    }

    /// Whether its bytes are part of what a brain sees and does, so that one on board has them, too.
    pub const fn is_dialogue(self) -> bool {
        match self {
            Self::Khepera | Self::Create(_) => true,
            Self::Framed { .. } | Self::Bare { .. } => false,
        }
    }
}

/// When readings are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// On a schedule of the microcontroller's; of a Create, while there is a stream.
    Stream(Schedule),
    /// In answer to a command, and to a poll in the framed protocol; in that of the Khepera in answer to a poll
    /// alone. Those that come while an answer waits to be sent share it.
    Poll,
}

/// The agreement of the two ends: the encoding of each sensor's components and of each motor's signal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fields {
    components: Vec<Encoding>,
    counts: Vec<u8>,
    motors: Vec<Encoding>,
    ages: bool,
    /// The place of each component in a Create's packets.
    signals: Vec<Option<Signal>>,
    /// The packets that tell them.
    packets: Vec<u8>,
}

impl Firmware {
    /// A firmware that sends the components of `sensors`, each with its name, and takes signals for two motors and the other actuators. Those of a
    /// sensor with more components than a message can count, 255, are in none: a brain on board gets them without. Nor are
    /// those of a Khepera's analog inputs, which are asked for one by one.
    pub fn new(
        protocol: Protocol,
        mode: Mode,
        sensors: &[(&str, &[Encoding])],
        motors: Vec<Encoding>,
    ) -> Self {
        let is_input = |name: &str| protocol == Protocol::Khepera && khepera::input_number(name).is_some();
        let counted = |&(name, sensor): &(&str, &'_ [Encoding])| {
            if sensor.len() > usize::from(u8::MAX) || is_input(name) { 0 } else { sensor.len() }
        };
        let encodings: Vec<_> = sensors.iter().map(|sensor| &sensor.1[..counted(sensor)]).collect();
        let (signals, packets) = match protocol {
            Protocol::Create(version) => told(version, sensors),
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Khepera => (Vec::new(), Vec::new()),
        };
        let fields = Fields {
            components: encodings.concat(),
            counts: encodings.iter().map(|components| components.len() as u8).collect(),
            motors,
            ages: matches!(protocol, Protocol::Framed { ages: true }),
            signals,
            packets,
        };
        Self { protocol, mode, fields }
    }

    /// The layout that encodes and decodes this firmware's messages.
    pub fn layout(&self) -> Layout<'_> {
        let Fields { components, counts, motors, ages, .. } = &self.fields;
        Layout { components, counts, motors, ages: *ages }
    }

    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        let Fields { components, counts, motors, signals, packets, .. } = &self.fields;
        elements(components) + elements(counts) + elements(motors) + elements(signals) + elements(packets)
    }

    /// The place of each of the layout's components in a Create's packets; none of other firmwares.
    pub fn signals(&self) -> &[Option<Signal>] {
        &self.fields.signals
    }

    /// The packets of the stream that a brain of messages asks a Create for; none of other firmwares.
    pub fn packets(&self) -> &[u8] {
        &self.fields.packets
    }

    /// Bytes on the wire of the longest message with all readings.
    pub fn readings_len_max(&self) -> usize {
        let layout = self.layout();
        match self.protocol {
            Protocol::Framed { .. } => frame::encoded_len_max(layout.readings_len_max()),
            Protocol::Bare { .. } => layout.bare_readings_len(),
            Protocol::Khepera => khepera::readings_len_max(&layout),
            Protocol::Create(version) => create::stream_len(version, self.packets()),
        }
    }

    /// Bytes on the wire of the longest command.
    pub fn command_len_max(&self) -> usize {
        let layout = self.layout();
        match self.protocol {
            Protocol::Framed { .. } => frame::encoded_len_max(layout.command_len()),
            Protocol::Bare { .. } => layout.bare_command_len(),
            Protocol::Khepera => khepera::command_len_max(&layout),
            Protocol::Create(_) => create::drive_direct([0.0; 2]).len(),
        }
    }

    /// The most bytes that the values of a sensor with these encodings take on the wire. Of a Create the number of each packet
    /// is not counted, and two that share one are counted twice.
    pub fn values_len_max(&self, encodings: &[Encoding]) -> usize {
        match self.protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Create(_) => {
                encodings.iter().map(|encoding| encoding.len()).sum()
            }
            Protocol::Khepera => khepera::numbers_len_max(encodings),
        }
    }

    /// The least baud rate of a cable on which its messages are told apart: a bare one ends when there is silence for
    /// longer than a character takes.
    pub(crate) fn least_baud(&self, uart: &Uart) -> u64 {
        let Protocol::Bare { gap_ns } = self.protocol else { return LEAST_BAUD };
        let bits_ns = u64::from(uart.bits_per_character) * SECOND_NS;
        let character_ns = gap_ns.saturating_sub(uart.adapter.hold_ns() + 1).max(1);
        bits_ns.div_ceil(character_ns).max(LEAST_BAUD)
    }

    /// The bytes of a command, in `out`; none if it has not a signal for each actuator.
    pub(crate) fn command<'a>(&self, command: &Command, out: &'a mut [u8; frame::MAX_FRAME]) -> &'a [u8] {
        let layout = self.layout();
        let signals =
            [command.wheels.left, command.wheels.right].into_iter().chain(command.others.iter().copied());
        let len = match self.protocol {
            Protocol::Bare { .. } => write_values(layout.motors, signals, out).unwrap_or(0),
            Protocol::Khepera => khepera::write_exchange(&layout, signals, out).unwrap_or(0),
            Protocol::Create(_) => {
                let crate::drive::Wheels { left, right } = command.wheels;
                self.write_drive(command.sequence, [left, right], out)
            }
            Protocol::Framed { .. } => {
                let mut payload = [0; frame::MAX_PAYLOAD];
                let len = write_command(&layout, command.sequence, signals, &mut payload);
                len.map_or(0, |len| frame::encode(&payload[..len], out).unwrap_or(0))
            }
        };
        &out[..len]
    }

    /// Writes the first bytes to a Create into `out`.
    pub fn write_opening(&self, out: &mut [u8]) -> usize {
        Opening { ids: self.packets() }.write(out)
    }

    /// The bytes of a Create's command: behind an opening, if it is the first one.
    pub fn write_drive(&self, sequence: u8, signals: [f64; 2], out: &mut [u8]) -> usize {
        let at = if sequence == 0 { self.write_opening(out) } else { 0 };
        let drive = create::drive_direct(signals);
        out[at..at + drive.len()].copy_from_slice(&drive);
        at + drive.len()
    }

    /// The encoding of one motor signal.
    pub fn motor_encoding(&self) -> Encoding {
        self.fields.motors[0]
    }

    pub(crate) fn reading_decoder(&self) -> Decoder {
        if let Protocol::Create(version) = self.protocol {
            return Decoder::Stream(Stream::new(version, self.packets()));
        }
        if self.protocol == Protocol::Khepera {
            return Decoder::KheperaAnswers { lines: Lines::of_answers(), positions: None };
        }
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
            Protocol::Khepera => Decoder::Khepera { lines: Lines::of_questions(), owed: Owed::default() },
            Protocol::Create(version) => Decoder::OpenInterface(Box::new(OpenInterface::new(version))),
        }
    }
}

/// The places of these sensors' components, and the packets that have them. Of a sensor of which a part is not told,
/// nothing is.
fn told(version: Version, sensors: &[(&str, &[Encoding])]) -> (Vec<Option<Signal>>, Vec<u8>) {
    let mut signals = Vec::new();
    for (name, encodings) in sensors {
        let own: Vec<_> = (0..encodings.len()).map(|i| Signal::of(version, name, i)).collect();
        let whole = own.iter().all(Option::is_some);
        signals.extend(own.into_iter().map(|signal| signal.filter(|_| whole)));
    }
    let mut packets = [0; create::MOST_STREAMED];
    let count = create::told(&signals, &mut packets);
    (signals, packets[..count].to_vec())
}
