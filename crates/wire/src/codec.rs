//! The common part of the messages of all protocols.

use crate::encoding::Encoding;
use crate::layout::Layout;

/// The agreement of the two ends of a cable, without the protocol.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms<'a> {
    /// The encodings of the values.
    pub layout: Layout<'a>,
    /// The place of each of the layout's components in the protocol, by a number of its own; `None` for one that it has not.
    pub places: &'a [Option<u8>],
}

/// The schedule by which a firmware sends readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// On a schedule, or in answer to each message.
    Any,
    /// In answer to a question only.
    Asked,
    /// On a schedule of its own, once a program has opened it.
    Opened,
}

/// Bytes of a robot's answer to a command and a question before the readings come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Preface {
    /// The number of bytes that confirm the command.
    pub acknowledgement: usize,
    /// The shortest and the longest line with the positions of the wheels.
    pub positions: [usize; 2],
}

/// The sense of a message to the laptop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The message has no valid content.
    Nonsense,
    /// The confirmation of a command: a brain does not wait for it.
    Acknowledgement,
    /// No readings, but what a brain that asks waits for.
    Answer,
    /// The positions of the wheels, which become readings with the next message that has any.
    Positions([i32; 2]),
    /// The readings that the message has were noted.
    Readings,
}

/// The number and the instant that a message has of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The number of the message.
    pub sequence: u8,
    /// The instant at which it was sampled, in nanoseconds, if the message has it.
    pub sampled_at_ns: Option<u64>,
}

/// Takes the readings of a message.
pub trait Sink {
    /// A reading of the sensor in this place of the layout; without a stamp if its message has none.
    fn take(&mut self, sensor: usize, stamp: Option<Stamp>, values: impl Iterator<Item = f64>);
}

/// The readings of a message that has a value for each component of these sensors.
pub(crate) fn take_all<'a>(
    sensors: impl Iterator<Item = (usize, &'a [Encoding])>,
    mut values: impl Iterator<Item = f64>,
    sink: &mut impl Sink,
) -> Notice {
    for (sensor, components) in sensors {
        sink.take(sensor, None, values.by_ref().take(components.len()));
    }
    Notice::Readings
}
