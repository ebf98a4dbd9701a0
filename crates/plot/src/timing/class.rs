//! The classes of bars, and the table of what is shown of each.

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

/// The appearance of a class in diagrams and tables.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// The word for the class in tables for other programs.
    pub name: &'static str,
    /// The words for the class in the key.
    pub words: &'static str,
    /// The colour of the style.
    pub color: &'static str,
    /// The colour of text on it.
    pub ink: &'static str,
    /// Whether its bars have no duration.
    pub is_mark: bool,
    /// Whether it stands for something that went wrong.
    pub is_trouble: bool,
}

impl Class {
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

    /// The row of the class in the table.
    pub const fn style(self) -> Style {
        match self {
            Self::Acquire => bar("acquire", "a sensor is read", "#56b4e9", DARK),
            Self::Measure => bar("measure", "a device measures", "#b5d9ee", DARK),
            Self::Frame => bar("frame", "readings are framed", "#0072b2", WHITE),
            Self::Block => bar("block", "waiting", "#bcc3cf", DARK),
            Self::Up => bar("up", "readings on the wire", "#009e73", WHITE),
            Self::Adapter => bar("adapter", "in the adapter", "#8fcfb8", DARK),
            Self::Port => bar("port", "on a cable of its own", "#66b8ad", DARK),
            Self::Think => bar("think", "the brain thinks", "#e69f00", DARK),
            Self::Down => bar("down", "a command on its way", "#cc79a7", DARK),
            Self::PortDown => bar("port_down", "to a device, on its own cable", "#e3b7cf", DARK),
            Self::Obey => bar("obey", "a command is taken", "#8f4a86", WHITE),
            Self::Act => bar("act", "the motors obey", "#332288", WHITE).mark(),
            Self::Late => bar("late", "not in time", LATE, WHITE).mark().trouble(),
            Self::Missed => bar("missed", "skipped", "#882255", WHITE).mark().trouble(),
            Self::Lost => bar("lost", "bytes lost", "#b5651d", WHITE).mark().trouble(),
            Self::Fault => bar("fault", "a fault", "#999933", WHITE).trouble(),
            Self::Round => bar("round", "a round of the main loop", "#6a5acd", WHITE),
            Self::Rounds => bar("rounds", "short rounds", "#d6d0ee", DARK),
            Self::Convert => bar("convert", "the ADC holds a voltage", "#ddaa33", DARK).mark(),
            Self::Sent => bar("sent", "the program sends", "#117733", WHITE),
            Self::Received => bar("received", "the program receives", "#aa4499", WHITE),
        }
    }
}

const fn bar(name: &'static str, words: &'static str, color: &'static str, ink: &'static str) -> Style {
    Style { name, words, color, ink, is_mark: false, is_trouble: false }
}

impl Style {
    const fn mark(self) -> Self {
        Self { is_mark: true, ..self }
    }

    const fn trouble(self) -> Self {
        Self { is_trouble: true, ..self }
    }
}

/// The colour of text on pale bars.
const DARK: &str = "#10151f";
