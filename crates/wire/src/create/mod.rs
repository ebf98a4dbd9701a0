//! The Open Interface (OI) of the iRobot Create: single bytes that name a command, the bytes of its data behind them, and
//! packets of sensor data for those who ask.
//!
//! | to the robot | answer | meaning |
//! |---|---|---|
//! | `128` | none | Start: the interface is on, in the mode Passive |
//! | `131`, `132` | none | Safe and Full: the actuators obey |
//! | `145` right left | none | speeds of the wheels, in mm/s, of 16 bits, the high byte first |
//! | `142` id | the packet's data | asks for a packet or a group of packets once |
//! | `148` n ids | `19` n (id data)… sum, every 15 ms | asks for a stream |
//!
//! [`Commands`] finds commands in a stream of bytes, and [`Command`] says what they mean. [`Packet`] names what can be asked
//! for: the interface's registers. [`Stream`] reads a stream at the laptop's end, [`Signal`] says which sensor of ours is in
//! which packet. There is no checksum but that of a stream, no time and no age: an altered byte is an altered command.
//!
//! Sources. Opcodes, their data, the lengths of packets and groups, and bits are those of pycreate2 0.8.0 (OI.py, packets.py),
//! AutonomyLab/libcreate (types.h, data.cpp, serial_stream.cpp) and the tables of commands in iRobot's "Create Open Interface"
//! (of the first Create, read in excerpts). What else is said of the Create 2 is recalled of iRobot's "Create 2 Open Interface
//! Specification based on the Roomba 600"; `docs/reference/robots/create.md` has each of them with its source.
//!
//! # Deviations
//!
//! An opcode that the robot has not is passed over, and so is each byte behind it up to the next one that is an opcode;
//! the behaviour of the real one is not published. Lists of packets may name groups.

mod commands;
mod drive;
mod packets;
mod signals;
mod stream;
mod streamed;

pub use commands::{BAUDS, Command, Commands, MAX_COMMAND, MOST_NOTES, Mode};
pub use drive::{FULL_MM_S, drive_direct, mm_s, wheels_mm_s};
pub use packets::{Packet, group, listed_len};
pub use signals::Signal;
pub use stream::{
    HEADER, MOST_STREAMED, Payload, STREAM_PERIOD_NS, Stream, StreamError, stream_len, write_stream,
};
pub(crate) use streamed::{check, read, streamed, write_opening};

use serde::{Deserialize, Serialize};

/// The model of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Version {
    /// The Create of 2007: 57,600 baud, packets 0 to 42.
    One,
    /// The Create 2 of 2014, a Roomba 600: 115,200 baud, packets 0 to 58 and four groups from 100 on.
    Two,
}

impl Version {
    /// The number of the version: 1 or 2.
    pub const fn number(self) -> u8 {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }

    /// The robot of this number.
    pub const fn of(number: u32) -> Option<Self> {
        match number {
            1 => Some(Self::One),
            2 => Some(Self::Two),
            _ => None,
        }
    }

    /// The number of songs that it keeps: 16, or 5 of a Create 2 (recalled; pycreate2 uses four).
    pub const fn songs(self) -> u8 {
        match self {
            Self::One => 16,
            Self::Two => 5,
        }
    }
}

#[cfg(test)]
mod tests;
