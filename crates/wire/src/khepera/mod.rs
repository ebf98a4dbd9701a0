//! The protocol of the Khepera: lines of text, and never one that was not asked for.
//!
//! A line is a letter and decimal numbers with commas before them. Questions begin with a capital, answers with its small
//! letter.
//!
//! | to the robot | answer | meaning |
//! |---|---|---|
//! | `N` CR | `n,v0,v1,…` CR LF | readings: all `components` of the layout that are no counters, in order |
//! | `H` CR | `h,l,r` CR LF | the position counters of the left and the right wheel, 32 bits |
//! | `D,l,r` CR | `d` CR LF | signals for the left and the right motor |
//!
//! The eight infra-red sensors of a real robot are all that its `N` tells. A layout with counters has two, of the wheels
//! ([`check`]). What a program of messages says that wants all readings is a [`poll`]: `H`, if there are counters, and `N`,
//! whose answer is the last.
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
//! A robot with other sensors than the real one's sends them in its `N`, too, in the order of the layout. The codes of
//! signals are pulses per 10 ms where the layout's owner has made their encoding so.

mod readings;
mod registers;

pub use crate::lines::{LineError, Lines, MAX_LINE};
pub(crate) use readings::{read, read_positions};
pub use registers::{Access, Command, Gain, NOT_FOUND, PROTOCOL_ERROR, Register, Side, write_answer};

use crate::encoding::Encoding;
use crate::error::{LayoutError, NoRoom, WriteError};
use crate::frame::MAX_PAYLOAD;
use crate::layout::Layout;
use crate::lines::{Writer, field, number};

/// Asks for what is no counter.
pub const POLL: [u8; 2] = *b"N\r";

/// Asks for all readings of the layout: for its counters first, if it has any, so that the answer to [`POLL`] is the last.
pub fn poll(layout: &Layout<'_>) -> &'static [u8] {
    if has_counters(layout) { b"H\rN\r" } else { b"N\r" }
}

/// The values of a sensor with these components in the position counters, if it is in `H`, and not in `N`.
pub fn counted(components: &[Encoding], positions: [i32; 2]) -> Option<[f64; 2]> {
    let &[left, right] = components else { return None };
    let both = is_counter(&left) && is_counter(&right);
    both.then(|| [left.quantise(positions[0].into()), right.quantise(positions[1].into())])
}

fn is_counter(encoding: &Encoding) -> bool {
    matches!(encoding, Encoding::Counter { .. })
}

fn has_counters(layout: &Layout<'_>) -> bool {
    layout.components.iter().any(is_counter)
}

/// The encodings of the answer to `N`.
fn levels<'a>(layout: &Layout<'a>) -> impl Iterator<Item = &'a Encoding> {
    layout.components.iter().filter(|encoding| !is_counter(encoding))
}

/// The number of the analog input that a sensor of this name is at, which is asked for by `I` and told by nothing else.
pub fn input_number(name: &str) -> Option<u8> {
    name.strip_prefix("ad_")?.parse().ok()
}

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
    let counters = layout.components.len() - levels(layout).count();
    let is_pair = |components: &[Encoding]| counted(components, [0; 2]).is_some();
    if counters > 0 && !(counters == 2 && layout.sensors().any(is_pair)) {
        return Err(LayoutError::Positions { found: counters });
    }
    let needed = readings_len_max(layout) + positions_len(layout)[1];
    if needed > MAX_PAYLOAD {
        return Err(NoRoom { needed, room: MAX_PAYLOAD }.into());
    }
    Ok(())
}

/// Bytes of the longest answer to `N`, its end included.
pub fn readings_len_max(layout: &Layout<'_>) -> usize {
    1 + levels(layout).copied().map(longest).sum::<usize>() + ANSWER_END.len()
}

/// Bytes of the shortest answer to `N`, its end included.
pub fn readings_len_min(layout: &Layout<'_>) -> usize {
    1 + levels(layout).count() * 2 + ANSWER_END.len()
}

/// Bytes of the shortest and of the longest answer to `H` of a layout that has counters, its end included; 0 of others.
/// Counters of fewer than 32 bits wrap in the answer as they do on the robot.
pub fn positions_len(layout: &Layout<'_>) -> [usize; 2] {
    if !has_counters(layout) {
        return [0; 2];
    }
    let counters = layout.components.iter().copied().filter(is_counter);
    let rest = 1 + ANSWER_END.len();
    [rest + 2 * 2, rest + counters.map(longest).sum::<usize>()]
}

/// Bytes of the longest command, its end included.
pub fn command_len_max(layout: &Layout<'_>) -> usize {
    1 + numbers_len_max(layout.motors) + QUESTION_END.len()
}

/// The most characters of numbers in these encodings, the commas before them included; 0 of those without codes.
pub fn numbers_len_max(encodings: &[Encoding]) -> usize {
    encodings.iter().copied().map(longest).sum()
}

/// The most characters of a number in this encoding, the comma before it included.
pub(crate) fn longest(encoding: Encoding) -> usize {
    let len = |number: i64| {
        let digits = number.unsigned_abs().checked_ilog10().unwrap_or(0) as usize + 1;
        usize::from(number < 0) + digits
    };
    1 + encoding.numbers().map_or(0, |[a, b]| len(a).max(len(b)))
}

/// Writes an answer to `N` to the front of `out`, and returns its length. `values` are those of all of the layout's
/// components, of which counters are passed over.
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

/// Writes what a program says that drives and wants readings: a command and a [`poll`]. Returns the length of both.
///
/// # Errors
/// As [`write_command`]; the poll needs its room, too.
pub fn write_exchange(
    layout: &Layout<'_>,
    signals: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let len = write_command(layout, signals, out)?;
    let mut line = Writer { out, len };
    line.end(poll(layout))
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
    /// An error if the line does not fit the layout. Nothing of such a line should be used.
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
    /// The values of all components that are no counters.
    Readings(Numbers<'a>),
    /// The position counters of the left and the right wheel.
    Positions([i32; 2]),
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
            [b'h', rest @ ..] => positions(rest).map(Self::Positions),
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

/// Iterates over the values that the numbers of a line stand for; each is a code of its encoding. Of answers to `N` counters
/// are passed over.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers<'a> {
    encodings: &'a [Encoding],
    text: &'a [u8],
}

impl<'a> Numbers<'a> {
    /// Reads the values behind the letter, a number for each encoding.
    fn parse(text: &'a [u8], encodings: &'a [Encoding]) -> Result<Self, LineError> {
        let told = || encodings.iter().filter(|encoding| !is_counter(encoding));
        let expected = told().count();
        let mut rest = text;
        for (index, encoding) in told().enumerate() {
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
        let next = self.encodings.iter().position(|encoding| !is_counter(encoding))?;
        let (digits, behind) = field(self.text)?;
        let encoding = self.encodings[next];
        (self.encodings, self.text) = (&self.encodings[next + 1..], behind);
        encoding.value_of(number(digits)?)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, Some(self.encodings.len()))
    }
}

/// The two position counters behind the letter of an answer.
fn positions(text: &[u8]) -> Result<[i32; 2], LineError> {
    let (mut rest, mut positions) = (text, [0; 2]);
    for (index, position) in positions.iter_mut().enumerate() {
        let (digits, behind) = field(rest).ok_or(LineError::Count { expected: 2, found: index })?;
        let number = number(digits).ok_or(LineError::Number { index })?;
        *position = i32::try_from(number).map_err(|_| LineError::Range { index })?;
        rest = behind;
    }
    if rest.is_empty() { Ok(positions) } else { Err(LineError::Count { expected: 2, found: 3 }) }
}

impl Writer<'_> {
    fn numbers(
        &mut self,
        encodings: &[Encoding],
        values: impl IntoIterator<Item = f64>,
    ) -> Result<(), WriteError> {
        let (mut values, expected) = (values.into_iter(), encodings.len());
        for (index, encoding) in encodings.iter().enumerate() {
            let value = values.next().ok_or(WriteError::Count { expected, found: index })?;
            if is_counter(encoding) {
                continue;
            }
            self.put(b',');
            self.number(encoding.number(value).ok_or(WriteError::NoCode { index })?);
        }
        match values.next() {
            Some(_) => Err(WriteError::Count { expected, found: expected + 1 }),
            None => Ok(()),
        }
    }
}

/// Left and right.
const MOTORS: usize = 2;

const QUESTION_END: [u8; 1] = *b"\r";
const ANSWER_END: [u8; 2] = *b"\r\n";

#[cfg(test)]
mod tests;
