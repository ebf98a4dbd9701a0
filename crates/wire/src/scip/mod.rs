//! Scans of a laser range finder: the messages `MD` and `MS` of SCIP 2.0, as Hokuyo's URG-04LX streams them.
//!
//! Everything is printable ASCII but the line feeds (LF, 0x0a). A number of 6 bits is one character, 0x30 + number;
//! longer ones are several, the most significant first.
//!
//! | bytes | meaning |
//! |---|---|
//! | 2 | `MD`: 3 characters a value (18 bits); `MS`: 2 characters (12 bits) |
//! | 4, 4, 2, 1, 2 | decimal digits: first step, last step, cluster, scan interval, scans that remain (0: no end) |
//! | 1 | LF |
//! | 4 | status `99`, its checksum `b`, LF |
//! | 6 | time stamp in milliseconds, 24 bits in 4 characters, its checksum, LF |
//! | n·c + 2⌈n·c/64⌉ | n values of c characters in blocks of 64, the last shorter; each with its checksum and LF |
//! | 1 | LF |
//!
//! That is 27 + n·c + 2⌈n·c/64⌉ bytes. A value is a range in whole millimetres; one below [`LEAST_RANGE_MM`] is an
//! error code. Values are cut wherever a block is full.
//!
//! # What the checksum finds
//!
//! The checksum of a line is the sum of its characters' codes, its low 6 bits, plus 0x30. The 64 characters that may
//! occur differ modulo 64, and any other is refused, so one altered byte of a line with a checksum is always found.
//! Not found are characters in another order and alterations whose sum is a multiple of 64: of two altered characters
//! one pair in 63. The echo in the first line has no checksum: compare it with the request.

pub mod device;
mod parse;
mod write;

use thiserror::Error;

pub use parse::{ParseError, Scan, parse, status};
pub use write::{EncodeError, encode};

/// Values below this, in millimetres, are error codes: there was no measurement.
pub const LEAST_RANGE_MM: u32 = 20;

/// The number of characters of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Characters {
    /// `MS`: 12 bits, at most 4095 mm.
    Two,
    /// `MD`: 18 bits, at most 262,143 mm.
    Three,
}

impl Characters {
    /// Characters of a value, so bytes on the wire.
    pub const fn count(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }

    /// The largest value, in millimetres.
    pub const fn top_mm(self) -> u32 {
        (1 << (6 * self.count())) - 1
    }

    const fn letter(self) -> u8 {
        match self {
            Self::Two => b'S',
            Self::Three => b'D',
        }
    }
}

/// The contents of a scan; the echo at the head of each message describes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Characters of each value.
    pub characters: Characters,
    /// The direction of the first value, 0 to 9999, counted counter-clockwise from where the device begins.
    pub first_step: u16,
    /// The last direction, included, `first_step` to 9999.
    pub last_step: u16,
    /// The number of neighbouring steps that give one value, the least of theirs, 0 to 99; 0 means 1.
    pub cluster: u8,
}

impl Format {
    /// The number of values of a scan. The last cluster may be of fewer steps.
    pub const fn points(&self) -> usize {
        if self.last_step < self.first_step {
            return 0;
        }
        let cluster = if self.cluster == 0 { 1 } else { self.cluster as usize };
        ((self.last_step - self.first_step) as usize + 1).div_ceil(cluster)
    }

    /// The number of bytes of a scan.
    pub const fn message_len(&self) -> usize {
        let characters = self.points() * self.characters.count();
        HEAD_LEN + characters + LINE_END_LEN * characters.div_ceil(BLOCK_LEN) + 1
    }

    /// The number of bytes of a command that asks for the newest scan (`GD` or `GS`), its end included.
    pub const QUESTION_LEN: usize = 13;

    /// The number of bytes of the answer to such a command: those of a scan, without the interval and the number of
    /// scans.
    pub const fn answer_len(&self) -> usize {
        self.message_len() - 3
    }

    /// Whether the echo can say it.
    ///
    /// # Errors
    /// Names what it cannot say.
    pub const fn check(&self) -> Result<(), FormatError> {
        let Self { first_step: first, last_step: last, cluster, .. } = *self;
        if first > last || last > 9999 {
            Err(FormatError::Steps { first, last })
        } else if cluster > 99 {
            Err(FormatError::Cluster { found: cluster })
        } else {
            Ok(())
        }
    }
}

/// A [`Format`] is none that the protocol knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FormatError {
    /// There is no such range of steps.
    #[error("the steps must go up and end at 9999 or before, but go from {first} to {last}")]
    Steps {
        /// The first step.
        first: u16,
        /// The last step.
        last: u16,
    },
    /// The cluster has more than two digits.
    #[error("a cluster has at most 99 steps, not {found}")]
    Cluster {
        /// Steps of the cluster.
        found: u8,
    },
}

/// The end of the first message in `stream`: its number of bytes, or `None` if its end has not come yet.
///
/// Every message of the protocol, also one with another status, ends with the first two line feeds in a row. After a
/// disturbance the remainder of the message goes with them, and the next one is whole.
pub fn message_end(stream: &[u8]) -> Option<usize> {
    let at = stream.windows(2).position(|pair| pair == [LINE_FEED; 2])?;
    Some(at + 2)
}

/// The number that characters stand for, 6 bits each.
pub(crate) fn value(characters: &[u8]) -> u32 {
    characters
        .iter()
        .fold(0, |value, character| value << 6 | u32::from(character.wrapping_sub(FIRST_CHARACTER)))
}

pub(crate) const LINE_FEED: u8 = b'\n';
/// The character of 0, and what each character is more than its number.
pub(crate) const FIRST_CHARACTER: u8 = b'0';
/// The character of 63.
const LAST_CHARACTER: u8 = b'o';
const STATUS_SCAN: &[u8; 2] = b"99";
/// Characters of a whole block.
pub(crate) const BLOCK_LEN: usize = 64;
/// Characters of the time stamp.
pub(crate) const TIME_LEN: usize = 4;
/// Bytes of the checksum and the line feed.
const LINE_END_LEN: usize = 2;
const ECHO_LEN: usize = 16;
const STATUS_LEN: usize = STATUS_SCAN.len() + LINE_END_LEN;
/// Bytes before the first block.
const HEAD_LEN: usize = ECHO_LEN + STATUS_LEN + TIME_LEN + LINE_END_LEN;

#[cfg(test)]
mod tests;
