//! The protocol of the Khepera: lines of text, and never one that was not asked for.
//!
//! A line is a letter and decimal numbers with commas before them. Questions begin with a capital, answers with its small
//! letter.
//!
//! | to the robot | answer | meaning |
//! |---|---|---|
//! | `N` CR | `n,v0,v1,…` CR LF | readings: all `components` of the layout, in order |
//! | `D,l,r` CR | `d` CR LF | signals for the left and the right motor |
//!
//! A number is the code of a value's [`Encoding`]: of `Level` 0 to 2^bits − 1, of `Signed` and `Counter` with a `-`
//! before it if it is negative. There is no checksum, no time and no age: an altered digit is an altered value.
//!
//! The robot takes CR, LF, and both for the end of a question; an answer ends with its LF. Empty lines are passed over.
//! Whatever came before the end of a line does not matter behind it, so a disturbance costs the line that it is in, and
//! the next one too if it takes the end between the two.
//!
//! All other letters of the robot's are [commands](Command) over named [registers](Register), whose numbers no layout says.
//!
//! # Deviations
//!
//! The real robot's `N` answers with its eight infra-red sensors and nothing else; here all sensors are in it, in the order
//! of the layout. `D` has signals, which are pulses per 10 ms only of motors that are as fast at full signal.

mod lines;
mod registers;

pub use lines::{LineError, Lines};
pub use registers::{Access, Command, Gain, NOT_FOUND, PROTOCOL_ERROR, Register, Side, write_answer};

use crate::encoding::Encoding;
use crate::error::{LayoutError, NoRoom, WriteError};
use crate::frame::MAX_PAYLOAD;
use crate::layout::Layout;

/// The most characters of a line, the one that ends it not counted.
pub const MAX_LINE: usize = MAX_PAYLOAD - 1;

/// Asks for readings.
pub const POLL: [u8; 2] = *b"N\r";

/// Answers a command.
pub const ACKNOWLEDGEMENT: [u8; 3] = *b"d\r\n";

/// Whether the layout can be spoken of in lines. Owners check once, when they are configured, as they do with
/// [`Layout::check`]; after that, writing to a buffer of [`MAX_PAYLOAD`] bytes cannot fail.
///
/// # Errors
/// Names the first thing that is wrong.
pub fn check(layout: &Layout<'_>) -> Result<(), LayoutError> {
    if layout.motors.len() != MOTORS {
        return Err(LayoutError::Motors { found: layout.motors.len() });
    }
    if layout.components.iter().chain(layout.motors).any(|encoding| encoding.numbers().is_none()) {
        return Err(LayoutError::NoCode);
    }
    let needed = readings_len_max(layout);
    if needed > MAX_PAYLOAD {
        return Err(NoRoom { needed, room: MAX_PAYLOAD }.into());
    }
    Ok(())
}

/// Bytes of the longest answer with readings, its end included.
pub fn readings_len_max(layout: &Layout<'_>) -> usize {
    1 + numbers_len_max(layout.components) + ANSWER_END.len()
}

/// Bytes of the longest command, its end included.
pub fn command_len_max(layout: &Layout<'_>) -> usize {
    1 + numbers_len_max(layout.motors) + QUESTION_END.len()
}

/// The most characters of numbers in these encodings, the commas before them included; 0 of those without codes.
pub fn numbers_len_max(encodings: &[Encoding]) -> usize {
    let len = |number: i64| {
        let digits = number.unsigned_abs().checked_ilog10().unwrap_or(0) as usize + 1;
        usize::from(number < 0) + digits
    };
    let longest = |encoding: &Encoding| encoding.numbers().map_or(0, |[a, b]| len(a).max(len(b)));
    encodings.iter().map(|encoding| 1 + longest(encoding)).sum()
}

/// Writes an answer with readings to the front of `out`, one value for each of the layout's components, and returns its
/// length.
///
/// # Errors
/// If there are not as many values as components, one has no code, or `out` is too short; one of
/// [`readings_len_max`] bytes is not.
pub fn write_readings(
    layout: &Layout<'_>,
    values: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let mut line = Writer { out, len: 0 };
    line.put(b'n');
    line.numbers(layout.components, values)?;
    line.end(&ANSWER_END)
}

/// Writes a command to the front of `out`, a signal for each motor, and returns its length.
///
/// # Errors
/// As [`write_readings`]; [`command_len_max`] bytes are enough.
pub fn write_command(
    layout: &Layout<'_>,
    signals: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let mut line = Writer { out, len: 0 };
    line.put(b'D');
    line.numbers(layout.motors, signals)?;
    line.end(&QUESTION_END)
}

/// Writes what a program says that drives and wants readings, which takes two lines: a command and a poll. Returns the
/// length of both.
///
/// # Errors
/// As [`write_command`]; [`POLL`] needs its room, too.
pub fn write_exchange(
    layout: &Layout<'_>,
    signals: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let len = write_command(layout, signals, out)?;
    let mut line = Writer { out, len };
    line.end(&POLL)
}

/// A question, as the robot understands it.
#[derive(Clone, Debug, PartialEq)]
pub enum Question<'a> {
    /// Asks for readings.
    Poll,
    /// Signals for the motors.
    Command(Numbers<'a>),
    /// Sets registers, or asks for them.
    Access(Access),
}

impl<'a> Question<'a> {
    /// The meaning of a line.
    ///
    /// # Errors
    /// Says what about the line is not as the layout has it. Nothing of such a line should be used.
    pub fn parse(line: &'a [u8], layout: &Layout<'a>) -> Result<Self, LineError> {
        match line {
            [b'N', rest @ ..] => Numbers::parse(rest, &[]).map(|_| Self::Poll),
            [b'D', rest @ ..] => Numbers::parse(rest, layout.motors).map(Self::Command),
            _ => Access::parse(line).map(Self::Access),
        }
    }
}

/// An answer, as a program understands it.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer<'a> {
    /// A command was obeyed.
    Acknowledgement,
    /// The values of all components.
    Readings(Numbers<'a>),
    /// Registers, or that they were set.
    Registers(Command),
    /// The line was not understood, or not possible.
    Refusal,
}

impl<'a> Answer<'a> {
    /// The meaning of a line.
    ///
    /// # Errors
    /// As [`Question::parse`].
    pub fn parse(line: &'a [u8], layout: &Layout<'a>) -> Result<Self, LineError> {
        match line {
            [b'd', rest @ ..] => Numbers::parse(rest, &[]).map(|_| Self::Acknowledgement),
            [b'n', rest @ ..] => Numbers::parse(rest, layout.components).map(Self::Readings),
            [] => Err(LineError::Empty),
            _ if [NOT_FOUND, PROTOCOL_ERROR]
                .iter()
                .any(|said| said.strip_suffix(&ANSWER_END) == Some(line)) =>
            {
                Ok(Self::Refusal)
            }
            &[found, ref rest @ ..] => {
                let capital = Some(found.to_ascii_uppercase()).filter(|_| found.is_ascii_lowercase());
                let command = capital.and_then(Command::of).ok_or(LineError::Letter { found })?;
                command.check_answer(rest).map(|()| Self::Registers(command))
            }
        }
    }
}

/// Iterates over the values that the numbers of a line stand for; each is a code of its encoding.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers<'a> {
    encodings: &'a [Encoding],
    text: &'a [u8],
}

impl<'a> Numbers<'a> {
    /// What stands behind the letter, if it is a number for each encoding.
    fn parse(text: &'a [u8], encodings: &'a [Encoding]) -> Result<Self, LineError> {
        let expected = encodings.len();
        let mut rest = text;
        for (index, encoding) in encodings.iter().enumerate() {
            let (digits, behind) = field(rest).ok_or(LineError::Count { expected, found: index })?;
            let number = number(digits).ok_or(LineError::Number { index })?;
            encoding.value_of(number).ok_or(LineError::Range { index })?;
            rest = behind;
        }
        if !rest.is_empty() {
            return Err(LineError::Count { expected, found: expected + 1 });
        }
        Ok(Self { encodings, text })
    }
}

impl Iterator for Numbers<'_> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let (encoding, encodings) = self.encodings.split_first()?;
        let (digits, behind) = field(self.text)?;
        (self.encodings, self.text) = (encodings, behind);
        encoding.value_of(number(digits)?)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, Some(self.encodings.len()))
    }
}

/// What stands between the comma at the front of `text` and the next one, and all from that on.
fn field(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.strip_prefix(b",")?;
    text.split_at_checked(text.iter().position(|&byte| byte == b',').unwrap_or(text.len()))
}

/// A whole number of at most [`MAX_DIGITS`] digits.
fn number(text: &[u8]) -> Option<i64> {
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
struct Writer<'a> {
    out: &'a mut [u8],
    len: usize,
}

impl Writer<'_> {
    fn put(&mut self, byte: u8) {
        if let Some(free) = self.out.get_mut(self.len) {
            *free = byte;
        }
        self.len += 1;
    }

    fn numbers(
        &mut self,
        encodings: &[Encoding],
        values: impl IntoIterator<Item = f64>,
    ) -> Result<(), WriteError> {
        let (mut values, expected) = (values.into_iter(), encodings.len());
        for (index, encoding) in encodings.iter().enumerate() {
            let value = values.next().ok_or(WriteError::Count { expected, found: index })?;
            self.put(b',');
            self.number(encoding.number(value).ok_or(WriteError::NoCode { index })?);
        }
        match values.next() {
            Some(_) => Err(WriteError::Count { expected, found: expected + 1 }),
            None => Ok(()),
        }
    }

    fn number(&mut self, number: i64) {
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

    fn end(&mut self, end: &[u8]) -> Result<usize, WriteError> {
        for &byte in end {
            self.put(byte);
        }
        if self.len > self.out.len() {
            return Err(NoRoom { needed: self.len, room: self.out.len() }.into());
        }
        Ok(self.len)
    }
}

/// Left and right.
const MOTORS: usize = 2;

/// Digits of 2^32 − 1, the greatest number of any encoding.
const MAX_DIGITS: usize = 10;

const QUESTION_END: [u8; 1] = *b"\r";
const ANSWER_END: [u8; 2] = *b"\r\n";

#[cfg(test)]
mod tests;
