//! Writes scans.

use thiserror::Error;

use super::{BLOCK_LEN, FIRST_CHARACTER, Format, FormatError, LINE_FEED, STATUS_SCAN, TIME_LEN, value};
use crate::error::NoRoom;

/// A scan could not be written. The buffer's contents are unspecified then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// The buffer is too short.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// The format is not possible.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// There are not as many ranges as the format says.
    #[error("the format has {expected} values, but {found} were given")]
    Count {
        /// Values in the format.
        expected: usize,
        /// Values given. Of too many, one is counted.
        found: usize,
    },
}

/// Writes a scan to the front of `out` and returns its length, [`Format::message_len`].
///
/// Of `time_ms` the low 24 bits are sent: it wraps after 4.66 hours. A range above
/// [`Characters::top_mm`](super::Characters::top_mm) is sent as that. One below
/// [`LEAST_RANGE_MM`](super::LEAST_RANGE_MM) arrives as no measurement. The echo says that the scans come one after
/// the other without an end: scan interval 0, 0 scans remain.
///
/// # Errors
/// If the format is not possible, `out` too short, or there are not as many ranges as [`Format::points`].
pub fn encode(
    format: &Format,
    time_ms: u32,
    ranges_mm: impl Iterator<Item = u32>,
    out: &mut [u8],
) -> Result<usize, EncodeError> {
    format.check()?;
    let no_room = NoRoom { needed: format.message_len(), room: out.len() };
    let mut writer =
        Writer { out: out.get_mut(..no_room.needed).ok_or(no_room)?, len: 0, sum: 0, line_len: 0 };
    writer.echo(format);
    writer.code(value(STATUS_SCAN), STATUS_SCAN.len());
    writer.end_line();
    writer.code(time_ms, TIME_LEN);
    writer.end_line();
    let expected = format.points();
    let mut found = 0;
    for range_mm in ranges_mm.take(expected + 1) {
        writer.code(range_mm.min(format.characters.top_mm()), format.characters.count());
        found += 1;
    }
    if found != expected {
        return Err(EncodeError::Count { expected, found });
    }
    if writer.line_len > 0 {
        writer.end_line();
    }
    writer.put(LINE_FEED);
    Ok(writer.len)
}

/// Writes lines. What is beyond the end of `out` is dropped: the caller has made room for all that counts.
struct Writer<'a> {
    out: &'a mut [u8],
    len: usize,
    /// The sum of the line's characters.
    sum: u8,
    /// Characters in the line so far.
    line_len: usize,
}

impl Writer<'_> {
    fn put(&mut self, byte: u8) {
        if let Some(place) = self.out.get_mut(self.len) {
            *place = byte;
            self.len += 1;
        }
    }

    fn echo(&mut self, format: &Format) {
        self.put(b'M');
        self.put(format.characters.letter());
        self.digits(format.first_step, 1000);
        self.digits(format.last_step, 1000);
        self.digits(u16::from(format.cluster), 10);
        self.digits(0, 1);
        self.digits(0, 10);
        self.put(LINE_FEED);
    }

    /// Writes as many decimal digits as `place`, a power of ten, has.
    fn digits(&mut self, number: u16, mut place: u16) {
        while place > 0 {
            self.put(b'0' + (number / place % 10) as u8);
            place /= 10;
        }
    }

    /// The low 6 · `count` bits of `number` as characters, in blocks.
    fn code(&mut self, number: u32, count: usize) {
        for place in (0..count).rev() {
            let character = FIRST_CHARACTER + (number >> (6 * place) & 0x3f) as u8;
            self.put(character);
            self.sum = self.sum.wrapping_add(character);
            self.line_len += 1;
            if self.line_len == BLOCK_LEN {
                self.end_line();
            }
        }
    }

    fn end_line(&mut self) {
        self.put(FIRST_CHARACTER + (self.sum & 0x3f));
        self.put(LINE_FEED);
        self.sum = 0;
        self.line_len = 0;
    }
}
