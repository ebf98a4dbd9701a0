//! Reads scans.

use thiserror::Error;

use super::{
    BLOCK_LEN, Characters, ECHO_LEN, FIRST_CHARACTER, Format, FormatError, HEAD_LEN, LAST_CHARACTER,
    LEAST_RANGE_MM, LINE_END_LEN, LINE_FEED, STATUS_LEN, STATUS_SCAN, TIME_LEN, value,
};

/// A scan as it arrived. All its characters and checksums are sound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scan<'a> {
    /// The range finder's clock when the scan began, in milliseconds; wraps after 2^24 ms, which is 4.66 hours.
    pub time_ms: u32,
    /// The contents of the scan.
    pub format: Format,
    /// The number of scans left out between two that are sent, 0 to 9.
    pub interval: u8,
    /// The number of scans that still come, 0 to 99. 0 also if they come without an end.
    pub remaining: u8,
    /// The blocks with their checksums and line feeds.
    blocks: &'a [u8],
}

impl<'a> Scan<'a> {
    /// The values as they were sent, [`Format::points`] of them, from the first step on.
    pub fn values(&self) -> impl ExactSizeIterator<Item = u32> + Clone + use<'a> {
        let (blocks, count) = (self.blocks, self.format.characters.count());
        (0..self.format.points()).map(move |point| {
            let characters = (point * count..).take(count);
            characters.fold(0, |value, at| {
                let character = blocks.get(at + at / BLOCK_LEN * LINE_END_LEN).copied();
                value << 6 | u32::from(character.unwrap_or(FIRST_CHARACTER).wrapping_sub(FIRST_CHARACTER))
            })
        })
    }

    /// The ranges in millimetres, `None` where there was no measurement.
    pub fn ranges_mm(&self) -> impl ExactSizeIterator<Item = Option<u32>> + Clone + use<'a> {
        self.values().map(|value| (value >= LEAST_RANGE_MM).then_some(value))
    }
}

/// A reason why bytes are not a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ParseError {
    /// The message is too short, or continues behind its end.
    #[error("the message has {found} bytes, but its head makes it {expected}")]
    Length {
        /// Bytes that a message with this head has, or, of a cut head, at least has.
        expected: usize,
        /// Bytes in the message.
        found: usize,
    },
    /// A byte that cannot be in its place.
    #[error("byte {at} is {found:#04x}, where {expected} should be")]
    Byte {
        /// The index of the byte, counted from 0.
        at: usize,
        /// The expected content.
        expected: &'static str,
        /// The actual content.
        found: u8,
    },
    /// A line is not the one that was sent.
    #[error("the checksum in byte {at} is {found:#04x}, but its line has {expected:#04x}")]
    Checksum {
        /// The index of the byte, counted from 0.
        at: usize,
        /// The checksum of the line that arrived.
        expected: u8,
        /// The checksum that arrived.
        found: u8,
    },
    /// The echo has an impossible format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A sound message, but no scan: status 00 confirms a request, and most others are errors.
    #[error("the status is {}, not 99 as of a scan", .found.escape_ascii())]
    Status {
        /// The two characters of the status.
        found: [u8; 2],
    },
}

/// Reads one whole message, from the `M` to the second line feed in a row.
///
/// # Errors
/// An error if the bytes are not a scan. Nothing of such a message should be used.
pub fn parse(message: &[u8]) -> Result<Scan<'_>, ParseError> {
    let number = |at, len| digits(message, at, len);
    let format = Format {
        characters: characters(message)?,
        first_step: number(2, 4)?,
        last_step: number(6, 4)?,
        cluster: number(10, 2)? as u8,
    };
    let (interval, remaining) = (number(12, 1)? as u8, number(13, 2)? as u8);
    format.check()?;
    line_feed(message, ECHO_LEN - 1)?;
    let status = line(message, ECHO_LEN)?;
    if status != STATUS_SCAN {
        return Err(ParseError::Status { found: *status });
    }
    let time_ms = value(line::<TIME_LEN>(message, ECHO_LEN + STATUS_LEN)?);
    let (expected, found) = (format.message_len(), message.len());
    if expected != found {
        return Err(ParseError::Length { expected, found });
    }
    let blocks = message.get(HEAD_LEN..expected - 1).unwrap_or_default();
    for (index, block) in blocks.chunks(BLOCK_LEN + LINE_END_LEN).enumerate() {
        check_line(block, HEAD_LEN + index * (BLOCK_LEN + LINE_END_LEN))?;
    }
    line_feed(message, expected - 1)?;
    Ok(Scan { time_ms, format, interval, remaining, blocks })
}

fn byte(message: &[u8], at: usize) -> Result<u8, ParseError> {
    let short = ParseError::Length { expected: HEAD_LEN.max(at + 1), found: message.len() };
    message.get(at).copied().ok_or(short)
}

fn characters(message: &[u8]) -> Result<Characters, ParseError> {
    match (byte(message, 0)?, byte(message, 1)?) {
        (b'M', b'D') => Ok(Characters::Three),
        (b'M', b'S') => Ok(Characters::Two),
        (b'M', found) => Err(ParseError::Byte { at: 1, expected: "D or S", found }),
        (found, _) => Err(ParseError::Byte { at: 0, expected: "M", found }),
    }
}

/// The number in `len` decimal digits, at most 4.
fn digits(message: &[u8], from: usize, len: usize) -> Result<u16, ParseError> {
    (from..from + len).try_fold(0, |number, at| match byte(message, at)? {
        digit @ b'0'..=b'9' => Ok(number * 10 + u16::from(digit - b'0')),
        found => Err(ParseError::Byte { at, expected: "a digit", found }),
    })
}

fn line_feed(message: &[u8], at: usize) -> Result<(), ParseError> {
    match byte(message, at)? {
        LINE_FEED => Ok(()),
        found => Err(ParseError::Byte { at, expected: "a line feed", found }),
    }
}

/// The `N` characters of a line whose checksum and line feed are as they should be.
fn line<const N: usize>(message: &[u8], at: usize) -> Result<&[u8; N], ParseError> {
    let short = ParseError::Length { expected: HEAD_LEN, found: message.len() };
    let line = message.get(at..at + N + LINE_END_LEN).ok_or(short)?;
    check_line(line, at)?;
    line.first_chunk().ok_or(short)
}

/// Checks the characters, the checksum and the line feed of `line`, which begins at byte `from`.
fn check_line(line: &[u8], from: usize) -> Result<(), ParseError> {
    let short = ParseError::Length { expected: from + LINE_END_LEN, found: from + line.len() };
    let (characters, &[sum, end]) = line.split_last_chunk::<LINE_END_LEN>().ok_or(short)?;
    for (at, &found) in (from..).zip(characters) {
        if !(FIRST_CHARACTER..=LAST_CHARACTER).contains(&found) {
            return Err(ParseError::Byte { at, expected: "a character from 0 to o", found });
        }
    }
    let at = from + characters.len();
    let expected = checksum(characters);
    if sum != expected {
        return Err(ParseError::Checksum { at, expected, found: sum });
    }
    if end != LINE_FEED {
        return Err(ParseError::Byte { at: at + 1, expected: "a line feed", found: end });
    }
    Ok(())
}

fn checksum(characters: &[u8]) -> u8 {
    FIRST_CHARACTER + (characters.iter().fold(0u8, |sum, &character| sum.wrapping_add(character)) & 0x3f)
}

/// The status of a whole message of any kind, from its echo to the second line feed in a row: that of the device's own
/// [answers](super::device), too. `None` if it has none whose checksum is right.
pub fn status(message: &[u8]) -> Option<[u8; 2]> {
    let mut lines = message.split(|&byte| byte == LINE_FEED);
    lines.next()?;
    let &[first, second, sum] = lines.next()? else { return None };
    (sum == checksum(&[first, second])).then_some([first, second])
}
