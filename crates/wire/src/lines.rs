//! The bounds of lines in a stream of bytes.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::buffer::Buffer;
use crate::error::{NoRoom, WriteError};
use crate::frame::MAX_PAYLOAD;

/// The most characters of a line, the one that ends it not counted.
pub const MAX_LINE: usize = MAX_PAYLOAD - 1;

/// Digits of 2^32 − 1, the greatest number of any encoding.
pub(crate) const MAX_DIGITS: usize = 10;

/// Finds lines in a stream of bytes. Behind the end of a line it is as new.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lines {
    ends: Ends,
    /// The bytes since the last end of a line.
    collected: Buffer<MAX_LINE>,
    /// The number of bytes since the buffer was full.
    dropped: u32,
}

impl Lines {
    /// A reader of questions that has seen nothing. A carriage return ends them, or a line feed, or both.
    pub const fn of_questions() -> Self {
        Self { ends: Ends::Either, collected: Buffer::new(), dropped: 0 }
    }

    /// A reader of answers that has seen nothing. A line feed ends them, and not the carriage return before it: an
    /// answer is not there before its last byte is.
    pub const fn of_answers() -> Self {
        Self { ends: Ends::Feed, collected: Buffer::new(), dropped: 0 }
    }

    /// Whether this reader may have become what `other` is: of lines that end alike.
    pub fn may_become(&self, other: &Self) -> bool {
        self.ends == other.ends
    }

    /// Takes the next byte from the wire. Gives the line that the byte ends, without its end, if there is anything in it.
    ///
    /// # Errors
    /// If the line that ends here was longer than [`MAX_LINE`].
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], LineError>> {
        if byte != b'\n' && (byte != b'\r' || self.ends == Ends::Feed) {
            if !self.collected.push(byte) {
                self.dropped = self.dropped.saturating_add(1);
            }
            return None;
        }
        let line = &*self.collected.drain();
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        match core::mem::take(&mut self.dropped) {
            0 if line.is_empty() => None,
            0 => Some(Ok(line)),
            dropped => {
                let found = MAX_LINE.saturating_add(dropped as usize);
                Some(Err(LineError::TooLong { limit: MAX_LINE, found }))
            }
        }
    }
}

/// The end of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Ends {
    Either,
    Feed,
}

/// The text between the comma at the front of `text` and the next one, and the rest from that on.
pub(crate) fn field(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.strip_prefix(b",")?;
    text.split_at_checked(text.iter().position(|&byte| byte == b',').unwrap_or(text.len()))
}

/// A whole number of at most [`MAX_DIGITS`] digits.
pub(crate) fn number(text: &[u8]) -> Option<i64> {
    let (sign, digits) = text.strip_prefix(b"-").map_or((1, text), |digits| (-1, digits));
    if digits.is_empty() || digits.len() > MAX_DIGITS {
        return None;
    }
    let mut number = 0;
    for byte in digits {
        if !byte.is_ascii_digit() {
            return None;
        }
        number = 10 * number + i64::from(byte - b'0');
    }
    Some(sign * number)
}

/// A line that is being written. What does not fit is only counted.
pub(crate) struct Writer<'a> {
    pub(crate) out: &'a mut [u8],
    pub(crate) len: usize,
}

impl Writer<'_> {
    pub(crate) fn put(&mut self, byte: u8) {
        if let Some(free) = self.out.get_mut(self.len) {
            *free = byte;
        }
        self.len += 1;
    }

    pub(crate) fn number(&mut self, number: i64) {
        if number < 0 {
            self.put(b'-');
        }
        let rest = number.unsigned_abs();
        let mut unit = 10_u64.pow(rest.checked_ilog10().unwrap_or(0));
        while unit > 0 {
            self.put(b'0' + (rest / unit % 10) as u8);
            unit /= 10;
        }
    }

    pub(crate) fn end(&mut self, end: &[u8]) -> Result<usize, WriteError> {
        for &byte in end {
            self.put(byte);
        }
        if self.len > self.out.len() {
            return Err(NoRoom { needed: self.len, room: self.out.len() }.into());
        }
        Ok(self.len)
    }
}

/// A reason why a line is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LineError {
    /// More characters than any line has.
    #[error("a line of {found} characters, but the longest has {limit}")]
    TooLong {
        /// The most that there may be.
        limit: usize,
        /// The number of values in the line.
        found: usize,
    },
    /// The line is empty.
    #[error("an empty line")]
    Empty,
    /// No line of this direction begins like this.
    #[error("there is no line that begins with {found:#04x}")]
    Letter {
        /// The first byte.
        found: u8,
    },
    /// Too few or too many numbers, or no comma where one should be.
    #[error("the layout has {expected} numbers in this line, but there are {found}")]
    Count {
        /// Numbers that the line should have.
        expected: usize,
        /// Numbers that it has. Of too many, one is counted.
        found: usize,
    },
    /// A number is none.
    #[error("number {index} is not a whole number of at most {MAX_DIGITS} digits")]
    Number {
        /// The index of the value, counted from 0.
        index: usize,
    },
    /// A number is no code of its encoding.
    #[error("number {index} is beyond its encoding")]
    Range {
        /// The index of the value, counted from 0.
        index: usize,
    },
}
