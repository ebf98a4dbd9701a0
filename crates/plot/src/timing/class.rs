//! The classes of bars, with their colours and words.

use baudbot_sim::timeline::What;

use crate::palette::{LATE, WHITE};

/// The classes of bars, in the order of the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// A sensor is read.
    Acquire,
    /// A device measures.
    Measure,
    /// Readings are framed.
    Frame,
    /// Something waits.
    Block,
    /// Readings are on the wire.
    Up,
    /// Readings are in the adapter.
    Adapter,
    /// A message is on a cable of its own.
    Port,
    /// The brain thinks.
    Think,
    /// A command is on its way.
    Down,
    /// A device is asked, on a cable of its own.
    PortDown,
    /// A command is taken.
    Obey,
    /// The motors obey.
    Act,
    /// Something was not in time.
    Late,
    /// Something was left out.
    Missed,
    /// Bytes were lost.
    Lost,
    /// A fault of the scenario.
    Fault,
    /// A round of the main loop of a chip's program.
    Round,
    /// Short rounds of it.
    Rounds,
    /// A chip's ADC holds a voltage.
    Convert,
    /// A chip sends a character.
    Sent,
    /// A chip receives a character.
    Received,
}

impl Class {
    /// All classes, in the order of the key.
    pub const ALL: [Self; 21] = [
        Self::Acquire,
        Self::Measure,
        Self::Frame,
        Self::Block,
        Self::Up,
        Self::Adapter,
        Self::Port,
        Self::Think,
        Self::Down,
        Self::PortDown,
        Self::Obey,
        Self::Act,
        Self::Late,
        Self::Missed,
        Self::Lost,
        Self::Fault,
        Self::Round,
        Self::Rounds,
        Self::Convert,
        Self::Sent,
        Self::Received,
    ];

    /// The class of an event.
    pub fn of(what: What) -> Self {
        match what {
            What::Acquire { .. } => Self::Acquire,
            What::Measure { .. } => Self::Measure,
            What::Frame { .. } => Self::Frame,
            What::Block => Self::Block,
            What::Up { .. } => Self::Up,
            What::Adapter => Self::Adapter,
            What::Port { .. } => Self::Port,
            What::Think { .. } => Self::Think,
            What::Down { .. } => Self::Down,
            What::PortDown { .. } => Self::PortDown,
            What::Obey => Self::Obey,
            What::Act => Self::Act,
            What::Late => Self::Late,
            What::Missed { .. } => Self::Missed,
            What::Lost { .. } => Self::Lost,
            What::Fault { .. } => Self::Fault,
        }
    }

    /// Whether it stands for something that went wrong.
    pub fn is_trouble(self) -> bool {
        match self {
            Self::Late | Self::Missed | Self::Lost | Self::Fault => true,
            Self::Acquire
            | Self::Measure
            | Self::Frame
            | Self::Block
            | Self::Up
            | Self::Adapter
            | Self::Port
            | Self::Think
            | Self::Down
            | Self::PortDown
            | Self::Obey
            | Self::Act
            | Self::Round
            | Self::Rounds
            | Self::Convert
            | Self::Sent
            | Self::Received => false,
        }
    }

    /// Its words in the key.
    pub fn words(self) -> &'static str {
        match self {
            Self::Acquire => "a sensor is read",
            Self::Measure => "a device measures",
            Self::Frame => "readings are framed",
            Self::Block => "waiting",
            Self::Up => "readings on the wire",
            Self::Adapter => "in the adapter",
            Self::Port => "on a cable of its own",
            Self::Think => "the brain thinks",
            Self::Down => "a command on its way",
            Self::PortDown => "to a device, on its own cable",
            Self::Obey => "a command is taken",
            Self::Act => "the motors obey",
            Self::Late => "not in time",
            Self::Missed => "skipped",
            Self::Lost => "bytes lost",
            Self::Fault => "a fault",
            Self::Round => "a round of the main loop",
            Self::Rounds => "short rounds",
            Self::Convert => "the ADC holds a voltage",
            Self::Sent => "the program sends",
            Self::Received => "the program receives",
        }
    }

    /// Its colour.
    pub fn color(self) -> &'static str {
        match self {
            Self::Acquire => "#56b4e9",
            Self::Measure => "#b5d9ee",
            Self::Frame => "#0072b2",
            Self::Block => "#bcc3cf",
            Self::Up => "#009e73",
            Self::Adapter => "#8fcfb8",
            Self::Port => "#66b8ad",
            Self::Think => "#e69f00",
            Self::Down => "#cc79a7",
            Self::PortDown => "#e3b7cf",
            Self::Obey => "#8f4a86",
            Self::Act => "#332288",
            Self::Late => LATE,
            Self::Missed => "#882255",
            Self::Lost => "#b5651d",
            Self::Fault => "#999933",
            Self::Round => "#6a5acd",
            Self::Rounds => "#d6d0ee",
            Self::Convert => "#ddaa33",
            Self::Sent => "#117733",
            Self::Received => "#aa4499",
        }
    }

    /// The colour of text on it.
    pub fn ink(self) -> &'static str {
        match self {
            Self::Acquire
            | Self::Measure
            | Self::Block
            | Self::Adapter
            | Self::Port
            | Self::Think
            | Self::Down
            | Self::PortDown
            | Self::Rounds
            | Self::Convert => "#10151f",
            Self::Frame
            | Self::Up
            | Self::Obey
            | Self::Act
            | Self::Late
            | Self::Missed
            | Self::Lost
            | Self::Fault
            | Self::Round
            | Self::Sent
            | Self::Received => WHITE,
        }
    }
}
