//! The protocols that a robot can speak. Everything that depends on the protocol, and that both ends of the cable must know, is
//! chosen here.

use crate::asercom;
use crate::bare::BareDecoder;
use crate::codec::{Notice, Pace, Preface, Sink, Terms, take_all};
use crate::create::{self, Signal, Stream, Version, drive_direct, listed_len, stream_len, streamed};
use crate::encoding::Encoding;
use crate::error::{LayoutError, NoRoom, WriteError};
use crate::frame::{self, Decoder};
use crate::khepera;
use crate::lines::Lines;
use crate::meaning;
use crate::message;
use crate::values::{Values, write_values};

/// The form of the messages on a robot's cable.
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
    /// The letters of an e-puck, which answers only when asked. It knows no readability.
    Asercom,
}

impl Protocol {
    /// The name of the protocol, in a few words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Framed { .. } => "framed",
            Self::Bare { .. } => "bare",
            Self::Khepera => "khepera, lines of text",
            Self::Create(Version::One) => "the Open Interface of a Create 1",
            Self::Create(Version::Two) => "the Open Interface of a Create 2",
            Self::Asercom => "asercom, lines of text",
        }
    }

    /// The schedule by which readings are sent.
    #[inline]
    pub const fn pace(self) -> Pace {
        match self {
            Self::Framed { .. } | Self::Bare { .. } => Pace::Any,
            Self::Khepera | Self::Asercom => Pace::Asked,
            Self::Create(_) => Pace::Opened,
        }
    }

    /// Whether each message has all values, new or not: it knows no readability.
    #[inline]
    pub const fn repeats(self) -> bool {
        !matches!(self, Self::Framed { .. })
    }

    /// Whether its bytes are part of what a brain sees and does, so that one on board has them, too.
    #[inline]
    pub const fn is_dialogue(self) -> bool {
        !matches!(self.pace(), Pace::Any)
    }

    /// Whether the robot is still to be opened, which the [poll](Agreement::write_poll) does, if this is the number of the next message:
    /// a brain that wants nothing lets it know nonetheless that a program is there.
    #[inline]
    pub fn is_to_be_opened(self, sequence: u8) -> bool {
        self.pace() == Pace::Opened && sequence == 0
    }

    /// Whether readings can be asked for without a command.
    pub const fn has_poll(self) -> bool {
        !matches!(self, Self::Bare { .. })
    }

    /// Whether each value has the bits that the protocol gives it.
    pub const fn has_fixed_bits(self) -> bool {
        matches!(self, Self::Create(_) | Self::Asercom)
    }

    /// Whether a command can change the baud rate of the cable.
    #[inline]
    pub const fn changes_baud(self) -> bool {
        matches!(self, Self::Create(_))
    }

    /// Whether messages of readings have the sensor of this name. A Khepera's analog inputs are asked for one by one, and an e-puck has
    /// letters of their own for most.
    pub fn tells(self, sensor: &str) -> bool {
        match self {
            Self::Framed { .. } | Self::Bare { .. } | Self::Create(_) => true,
            Self::Khepera => khepera::input_number(sensor).is_none(),
            Self::Asercom => asercom::place(sensor, 0).is_some(),
        }
    }

    /// The place of this component, counted from 0, of the sensor of this name in the protocol, by a number of its own.
    pub fn place(self, sensor: &str, component: usize) -> Option<u8> {
        match self {
            Self::Framed { .. } | Self::Bare { .. } | Self::Khepera => None,
            Self::Create(version) => Signal::place(version, sensor, component),
            Self::Asercom => asercom::place(sensor, component),
        }
    }

    /// The most bytes that values in these encodings take on the wire. Of a Create the number of each packet is not counted,
    /// and two that share one are counted twice.
    pub fn values_len_max(self, encodings: &[Encoding]) -> usize {
        match self {
            Self::Framed { .. } | Self::Bare { .. } | Self::Create(_) => {
                encodings.iter().map(|encoding| encoding.len()).sum()
            }
            Self::Khepera | Self::Asercom => khepera::numbers_len_max(encodings),
        }
    }

    /// The group of packets with the most bytes that can be asked for, and how many those are; `None` if there are none.
    pub fn largest_query(self) -> Option<(u8, usize)> {
        let Self::Create(version) = self else { return None };
        let group = match version {
            Version::One => 6,
            Version::Two => 100,
        };
        Some((group, listed_len(version, &[group])))
    }

    /// The number of the next message to the robot, as far as there are numbers; `sequence` is counted on. Only the first
    /// message to a robot that has to be opened is number 0.
    pub fn count(self, sequence: &mut u8) -> u8 {
        let now = *sequence;
        match self {
            Self::Framed { .. } => *sequence = now.wrapping_add(1),
            Self::Create(_) => *sequence = now.checked_add(1).unwrap_or(1),
            Self::Bare { .. } | Self::Khepera | Self::Asercom => {}
        }
        now
    }
}

/// A protocol, and what the two ends of the cable have agreed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement<'a> {
    /// The form of the messages.
    pub protocol: Protocol,
    /// The content of the messages.
    pub terms: Terms<'a>,
}

impl Agreement<'_> {
    /// Checks that messages can be made of it. Owners check once; after that, writing to a buffer of
    /// [`MAX_FRAME`](frame::MAX_FRAME) bytes cannot run out of room.
    ///
    /// # Errors
    /// If no cable can have such encodings, or the protocol cannot carry them.
    pub fn check(&self) -> Result<(), LayoutError> {
        self.terms.layout.check()?;
        match self.protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } => Ok(()),
            Protocol::Khepera => khepera::check(&self.terms.layout),
            Protocol::Create(_) => create::check(&self.terms),
            Protocol::Asercom => asercom::check(&self.terms),
        }
    }

    /// Bytes on the wire of the shortest and of the longest message with all readings.
    pub fn readings_len(&self) -> [usize; 2] {
        let layout = &self.terms.layout;
        match self.protocol {
            Protocol::Framed { .. } => frame::encoded_len(layout.readings_len_max()),
            Protocol::Bare { .. } => [layout.bare_readings_len(); 2],
            Protocol::Khepera => [khepera::readings_len_min(layout), khepera::readings_len_max(layout)],
            Protocol::Create(version) => [stream_len(version, streamed(&self.terms).used()); 2],
            Protocol::Asercom => asercom::readings_len(&self.terms),
        }
    }

    /// Bytes on the wire of the shortest and of the longest command.
    pub fn command_len(&self) -> [usize; 2] {
        let layout = &self.terms.layout;
        match self.protocol {
            Protocol::Framed { .. } => frame::encoded_len(layout.command_len()),
            Protocol::Bare { .. } => [layout.bare_command_len(); 2],
            Protocol::Khepera => [1 + 2 * layout.motors.len() + 1, khepera::command_len_max(layout)],
            Protocol::Create(_) => [drive_direct([0.0; 2]).len(); 2],
            Protocol::Asercom => asercom::command_len(layout),
        }
    }

    /// Bytes of what comes before the readings in answer to a command and a question.
    pub fn preface(&self) -> Preface {
        match self.protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Create(_) => Preface::default(),
            Protocol::Khepera => Preface {
                acknowledgement: khepera::ACKNOWLEDGEMENT.len(),
                positions: khepera::positions_len(&self.terms.layout),
            },
            Protocol::Asercom => Preface {
                acknowledgement: khepera::ACKNOWLEDGEMENT.len(),
                positions: asercom::positions_len(&self.terms),
            },
        }
    }

    /// The bytes behind a command that asks for readings, too; none where each command does.
    pub fn question(&self) -> &'static [u8] {
        match self.protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Create(_) => &[],
            Protocol::Khepera => khepera::poll(&self.terms.layout),
            Protocol::Asercom => asercom::question(&self.terms),
        }
    }

    /// Writes a command with a signal for each motor and actuator, and what it needs before and behind it: a robot that has to
    /// be opened is opened by command 0, and one that answers only when asked is asked. Returns the length.
    ///
    /// # Errors
    /// If there are not as many signals as the layout says, or `out` is too short.
    pub fn write_command(
        &self,
        sequence: u8,
        signals: impl IntoIterator<Item = f64>,
        out: &mut [u8],
    ) -> Result<usize, WriteError> {
        let layout = &self.terms.layout;
        match self.protocol {
            Protocol::Framed { .. } => {
                let mut payload = [0; frame::MAX_PAYLOAD];
                let len = message::write_command(layout, sequence, signals, &mut payload)?;
                Ok(frame::encode(&payload[..len], out)?)
            }
            Protocol::Bare { .. } => write_values(layout.motors, signals, out),
            Protocol::Khepera => khepera::write_exchange(layout, signals, out),
            Protocol::Asercom => asercom::write_exchange(&self.terms, signals, out),
            Protocol::Create(_) => {
                let mut signals = signals.into_iter();
                let mut next = |found| signals.next().ok_or(WriteError::Count { expected: 2, found });
                let drive = drive_direct([next(0)?, next(1)?]);
                let no_room = NoRoom { needed: frame::MAX_PAYLOAD, room: out.len() };
                let opening = if sequence > 0 { Some(0) } else { create::write_opening(&self.terms, out) };
                let at = opening.ok_or(no_room)?;
                out.get_mut(at..at + drive.len()).ok_or(no_room)?.copy_from_slice(&drive);
                Ok(at + drive.len())
            }
        }
    }

    /// Writes the next question for readings, and returns how long it is; `None` if the protocol has none, or `out` is
    /// too short. What has to be opened is opened.
    pub fn write_poll(&self, sequence: &mut u8, out: &mut [u8]) -> Option<usize> {
        let sequence = self.protocol.count(sequence);
        match self.protocol {
            Protocol::Framed { .. } => frame::encode(&message::poll(sequence), out).ok(),
            Protocol::Bare { .. } => None,
            Protocol::Khepera | Protocol::Asercom => {
                let question = self.question();
                out.get_mut(..question.len())?.copy_from_slice(question);
                Some(question.len())
            }
            Protocol::Create(_) => create::write_opening(&self.terms, out),
        }
    }

    /// The finder of messages of readings among the bytes that come to the laptop.
    ///
    /// # Errors
    /// If they are too long.
    pub fn uplink(&self) -> Result<Uplink, NoRoom> {
        Ok(match self.protocol {
            Protocol::Framed { .. } => Uplink::Framed(Decoder::new()),
            Protocol::Bare { gap_ns } => {
                Uplink::Bare(BareDecoder::new(self.terms.layout.bare_readings_len(), gap_ns)?)
            }
            Protocol::Khepera | Protocol::Asercom => Uplink::Lines(Lines::of_answers()),
            Protocol::Create(version) => Uplink::Stream(Stream::new(version, streamed(&self.terms).used())),
        })
    }

    /// Reads a message that came to the laptop at this instant, and gives its readings to `sink`.
    pub fn read(&self, payload: &[u8], at_ns: u64, sink: &mut impl Sink) -> Notice {
        let layout = &self.terms.layout;
        match self.protocol {
            Protocol::Framed { .. } => message::read(layout, payload, at_ns, sink),
            // The decoder gives a payload only when it is whole, so there is a value for every component.
            Protocol::Bare { .. } => {
                take_all(layout.sensors().enumerate(), Values::new(layout.components, payload), sink)
            }
            Protocol::Khepera => khepera::read(layout, payload, sink),
            Protocol::Create(version) => create::read(version, &self.terms, payload, sink),
            Protocol::Asercom => asercom::read(&self.terms, payload, sink),
        }
    }

    /// Gives positions, which came before readings, to `sink` as the readings that they are.
    pub fn read_positions(&self, positions: [i32; 2], sink: &mut impl Sink) {
        match self.protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } | Protocol::Create(_) => {}
            Protocol::Khepera => khepera::read_positions(&self.terms.layout, positions, sink),
            Protocol::Asercom => asercom::read_positions(&self.terms, positions, sink),
        }
    }
}

impl<'a> Agreement<'a> {
    /// The protocol for an [analyser](meaning::Analyser) of the cable.
    pub const fn meaning(&self) -> meaning::Protocol<'a> {
        let layout = self.terms.layout;
        match self.protocol {
            Protocol::Framed { .. } => meaning::Protocol::Framed { layout: Some(layout) },
            Protocol::Bare { gap_ns } => meaning::Protocol::Bare { layout, gap_ns },
            Protocol::Khepera => meaning::Protocol::Khepera,
            Protocol::Create(version) => meaning::Protocol::Create(version),
            Protocol::Asercom => meaning::Protocol::Asercom,
        }
    }
}

/// Finds messages among the bytes that come to the laptop.
#[derive(Clone, Debug)]
pub enum Uplink {
    /// Frames.
    Framed(Decoder),
    /// Messages of one length.
    Bare(BareDecoder),
    /// Lines of text.
    Lines(Lines),
    /// Messages of a Create's stream.
    Stream(Stream),
}

impl Uplink {
    /// Takes the next byte and the instant at which it came. Gives the message that it ends, if that is whole.
    pub fn push(&mut self, byte: u8, at_ns: u64) -> Option<&[u8]> {
        match self {
            Self::Framed(framed) => framed.push(byte)?.ok(),
            Self::Bare(bare) => bare.push(byte, at_ns),
            Self::Lines(lines) => lines.push(byte)?.ok(),
            Self::Stream(stream) => stream.push(byte)?.ok(),
        }
    }
}
