//! The meaning of the bytes of one cable: what a protocol analyser shows that listens to both directions.
//!
//! An [`Analyser`] takes each byte with its instant and cuts both streams into [`Item`]s: a question, an answer, a frame. Each
//! byte is in exactly one item, and the items of a direction, one behind the other, are its bytes again. What fits nothing is an
//! item as well, with its bytes in hexadecimal digits, and so is a message that silence cuts off.
//!
//! | protocol | an item | it ends |
//! |---|---|---|
//! | [`Protocol::Framed`] | a frame | with its delimiter |
//! | [`Protocol::Bare`] | a message | with its last byte |
//! | [`Protocol::Khepera`] | a line | with CR or LF of a question, with LF of an answer |
//! | [`Protocol::Asercom`] | a line; binary letters; their answer | with CR or LF of a question, with LF of an answer; with 0; with its last byte |
//! | [`Protocol::Create`] | a command; an answer, a message of a stream | with its last byte, which an answer's question says |
//! | [`Protocol::Scip`] | a command; a message | with its line; with two line feeds in a row |
//! | [`Protocol::Nmea`] | a sentence | with its line feed |
//! | [`Protocol::LineImage`] | an image | with its last byte |
//!
//! An analyser is no receiver. It knows no more than what was on the cable, so it can be wrong where a device knows more: a
//! Create that is switched off does not answer, and the answer to the next question is then taken for that of the first, until
//! [`PATIENCE_NS`] is over.
//!
//! # Example
//!
//! ```
//! use baudbot_wire::meaning::{Analyser, Cable, Direction, Heard, Protocol};
//!
//! let cable = Cable { protocol: Protocol::Khepera, names: &[] };
//! let mut analyser = Analyser::new([[0; 512]; 2]);
//! let mut texts = Vec::new();
//! for (at_ns, &byte) in (0..).step_by(1_000_000).zip(b"D,5,5\r") {
//!     let heard = Heard { direction: Direction::Down, at_ns, byte };
//!     analyser.push(&cable, heard, &mut |item| texts.push(item.text.to_owned()));
//! }
//! assert_eq!(texts, ["D,5,5: set speed 5 5"]);
//! ```

mod asercom;
mod bare;
mod commands;
mod create;
mod framed;
mod half;
mod image;
mod khepera;
mod nmea;
mod packets;
mod scip;
mod scip_words;
#[cfg(test)]
mod tests;
mod text;

use core::fmt::{Display, Write};

pub use self::create::PATIENCE_NS;
pub use self::text::{MAX_TEXT, Text};

use self::asercom::Letters;
use self::create::Conversation;
use self::half::Half;
use self::text::Hex;
use crate::create::Version;
use crate::frame::DELIMITER;
use crate::layout::Layout;

/// The direction of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// The direction from the robot or the device to the laptop.
    Up,
    /// The direction from the laptop to the robot or the device.
    Down,
}

/// The protocol of a cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Protocol<'a> {
    /// Frames with a CRC.
    Framed {
        /// The content of the messages; without it only their kinds are known.
        layout: Option<Layout<'a>>,
    },
    /// Values and nothing else.
    Bare {
        /// The content of the messages.
        layout: Layout<'a>,
        /// The longest pause within a message, in nanoseconds.
        gap_ns: u64,
    },
    /// Lines of a Khepera.
    Khepera,
    /// The Open Interface of a Create.
    Create(Version),
    /// Letters of an e-puck.
    Asercom,
    /// SCIP 2.0 of a laser range finder.
    Scip,
    /// Sentences of a satellite receiver.
    Nmea,
    /// Images of a line camera.
    LineImage,
}

impl Protocol<'_> {
    /// A message is cut off by a pause that is longer than this, in nanoseconds. Lines may be typed by hand.
    pub const fn silence_ns(&self) -> u64 {
        match self {
            Self::Bare { gap_ns, .. } => *gap_ns,
            Self::Framed { .. } | Self::Create(_) | Self::LineImage => 1_000_000_000,
            Self::Khepera | Self::Asercom | Self::Scip | Self::Nmea => 10_000_000_000,
        }
    }
}

/// A cable, as far as its two ends have agreed on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cable<'a> {
    /// The cable's protocol.
    pub protocol: Protocol<'a>,
    /// The names of the layout's sensors, in its order. One that is missing goes by its number.
    pub names: &'a [&'a str],
}

/// A byte on a cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// The direction.
    pub direction: Direction,
    /// The instant at which it is at the end of its way, in nanoseconds. Instants of a direction do not go back.
    pub at_ns: u64,
    /// The byte.
    pub byte: u8,
}

/// A part of what is said on a cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item<'a> {
    /// The direction.
    pub direction: Direction,
    /// The instant of its first byte, in nanoseconds.
    pub from_ns: u64,
    /// The instant of its last byte, in nanoseconds.
    pub to_ns: u64,
    /// The bytes of the item, at least one.
    pub bytes: &'a [u8],
    /// The meaning, in the words of the protocol; at most [`MAX_TEXT`] bytes.
    pub text: &'a str,
    /// Whether the bytes are a whole and sound message of the protocol.
    pub is_understood: bool,
    /// The age of its oldest reading when the last byte came, in nanoseconds; `None` if it has no reading or its
    /// protocol has no ages.
    pub age_ns: Option<u64>,
}

/// Cuts the bytes of a cable into items. `B` is memory for the message that is under way in each direction: what is
/// longer is reported in parts that are not understood.
#[derive(Clone, Debug)]
pub struct Analyser<B> {
    up: Half<B>,
    down: Half<B>,
    interface: Conversation,
    /// The letters that an e-puck is to answer in bytes.
    letters: Letters,
}

/// The bound that the last byte makes for the bytes in hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cut {
    /// The bytes may be the beginning of a message.
    Wait,
    /// The last byte begins something else: those before it belong to nothing.
    Before,
    /// The bytes are an item.
    After,
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Analyser<B> {
    /// An analyser that has received nothing, with memory for a message up and one down.
    pub fn new([up, down]: [B; 2]) -> Self {
        let (interface, letters) = (Conversation::default(), Letters::default());
        Self { up: Half::new(up), down: Half::new(down), interface, letters }
    }

    /// Takes the next byte of the cable, and calls `each` for every item that ends with it or before it.
    pub fn push(&mut self, cable: &Cable<'_>, heard: Heard, each: &mut impl FnMut(Item<'_>)) {
        let Heard { direction, at_ns, byte } = heard;
        self.end_silent(cable, direction, at_ns, each);
        if self.half(direction).is_full() {
            self.end(direction, "part of a message that is too long", each);
        }
        self.half(direction).push(byte, at_ns);
        match self.cut(cable, heard) {
            Cut::Wait => {}
            Cut::After => self.tell(cable, direction, each),
            Cut::Before => {
                self.half(direction).tell_all_but_last(direction, each);
                if self.cut(cable, heard) == Cut::After {
                    self.tell(cable, direction, each);
                }
            }
        }
    }

    /// Reports the messages that silence has cut off by `now_ns` nanoseconds: `each` is called for each.
    pub fn wait(&mut self, cable: &Cable<'_>, now_ns: u64, each: &mut impl FnMut(Item<'_>)) {
        for direction in [Direction::Up, Direction::Down] {
            self.end_silent(cable, direction, now_ns, each);
        }
    }

    /// Nothing more comes: `each` is called for what is held.
    pub fn finish(&mut self, each: &mut impl FnMut(Item<'_>)) {
        for direction in [Direction::Up, Direction::Down] {
            self.end(direction, "the beginning of a message", each);
        }
    }

    fn end_silent(
        &mut self,
        cable: &Cable<'_>,
        direction: Direction,
        now_ns: u64,
        each: &mut impl FnMut(Item<'_>),
    ) {
        if self.half(direction).is_silent(now_ns, cable.protocol.silence_ns()) {
            self.end(direction, "cut off by silence", each);
        }
    }

    /// The bytes in hand are no whole message.
    fn end(&mut self, direction: Direction, why: &str, each: &mut impl FnMut(Item<'_>)) {
        self.half(direction).tell(direction, |bytes, _| Meaning::not_understood(bytes, why), each);
        if direction == Direction::Down {
            self.interface.forget_command();
        }
    }

    fn half(&mut self, direction: Direction) -> &mut Half<B> {
        match direction {
            Direction::Up => &mut self.up,
            Direction::Down => &mut self.down,
        }
    }

    /// The bound that the newest byte makes.
    fn cut(&mut self, cable: &Cable<'_>, heard: Heard) -> Cut {
        let half = match heard.direction {
            Direction::Up => &self.up,
            Direction::Down => &self.down,
        };
        let bytes = half.bytes();
        match (cable.protocol, heard.direction) {
            (Protocol::Framed { .. }, _) => ends_with(bytes, &[DELIMITER]),
            (Protocol::Bare { layout, .. }, direction) => bare::cut(&layout, direction, bytes),
            (Protocol::Khepera | Protocol::Scip, Direction::Down) => match heard.byte {
                b'\r' | b'\n' => Cut::After,
                _ => Cut::Wait,
            },
            (Protocol::Khepera, Direction::Up) | (Protocol::Nmea, _) => ends_with(bytes, b"\n"),
            (Protocol::Scip, Direction::Up) => ends_with(bytes, b"\n\n"),
            (Protocol::Create(version), Direction::Up) => {
                self.interface.cut_answer(version, heard.at_ns, bytes)
            }
            (Protocol::Create(version), Direction::Down) => self.interface.cut_command(version, heard.byte),
            (Protocol::Asercom, Direction::Up) => self.letters.cut_answer(bytes),
            (Protocol::Asercom, Direction::Down) => self.letters.cut_command(bytes),
            (Protocol::LineImage, _) => image::cut(bytes, half.room()),
        }
    }

    /// The bytes in hand are an item.
    fn tell(&mut self, cable: &Cable<'_>, direction: Direction, each: &mut impl FnMut(Item<'_>)) {
        let Self { up, down, interface, letters } = self;
        let half = match direction {
            Direction::Up => up,
            Direction::Down => down,
        };
        let read = |bytes: &[u8], at_ns| match (cable.protocol, direction) {
            (Protocol::Framed { layout }, _) => framed::read(layout.as_ref(), cable.names, at_ns, bytes),
            (Protocol::Bare { layout, .. }, _) => bare::read(&layout, cable.names, direction, bytes),
            (Protocol::Khepera, Direction::Up) => khepera::read_answer(bytes),
            (Protocol::Khepera, Direction::Down) => khepera::read_question(bytes),
            (Protocol::Create(version), Direction::Up) => interface.read_answer(version, bytes),
            (Protocol::Create(version), Direction::Down) => interface.read_command(version, at_ns, bytes),
            (Protocol::Asercom, Direction::Up) => letters.read_answer(bytes),
            (Protocol::Asercom, Direction::Down) => asercom::read_command(bytes),
            (Protocol::Scip, Direction::Up) => scip::read_answer(at_ns, bytes),
            (Protocol::Scip, Direction::Down) => scip::read_command(bytes),
            (Protocol::Nmea, _) => nmea::read(at_ns, bytes),
            (Protocol::LineImage, _) => image::read(bytes),
        };
        half.tell(direction, read, each);
    }
}

/// The meaning of an item's bytes.
struct Meaning {
    text: Text,
    is_understood: bool,
    age_ns: Option<u64>,
}

impl Meaning {
    /// A `Meaning` of a sound message without readings.
    fn of(text: impl Display) -> Self {
        let mut meaning = Self { text: Text::new(), is_understood: true, age_ns: None };
        meaning.add(text);
        meaning
    }

    /// The meaning of bytes that fit nothing, for this reason if there is one.
    fn not_understood(bytes: &[u8], why: &str) -> Self {
        let (open, close) = if why.is_empty() { ("", "") } else { (" (", ")") };
        let text = format_args!("not understood{open}{why}{close}: {}", Hex(bytes));
        Self { is_understood: false, ..Self::of(text) }
    }

    /// Writes more of the text.
    fn add(&mut self, text: impl Display) {
        // Text that does not fit is cut, and that is no error.
        let _ = write!(self.text, "{text}");
    }
}

/// A message that ends with these bytes.
fn ends_with(bytes: &[u8], end: &[u8]) -> Cut {
    if bytes.ends_with(end) { Cut::After } else { Cut::Wait }
}
