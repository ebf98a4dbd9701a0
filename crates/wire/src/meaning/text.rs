//! Texts of bounded length, without allocation.

use core::fmt::{self, Display, Write};

/// The most bytes of the text of an item.
pub const MAX_TEXT: usize = 640;

/// A text of at most [`MAX_TEXT`] bytes. Of a longer one the end is left out, and `…` stands for it.
#[derive(Clone)]
pub struct Text {
    bytes: [u8; MAX_TEXT],
    len: usize,
    is_cut: bool,
}

impl Text {
    /// An empty one.
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_TEXT], len: 0, is_cut: false }
    }

    /// The text so far.
    pub fn as_str(&self) -> &str {
        // Only whole characters are written.
        core::str::from_utf8(self.bytes.get(..self.len).unwrap_or_default()).unwrap_or_default()
    }

    /// Writes a character, if `room` bytes are left behind it.
    fn put(&mut self, character: char, room: usize) -> bool {
        let len = character.len_utf8();
        let fits = self.len + len + room <= MAX_TEXT;
        if fits && let Some(free) = self.bytes.get_mut(self.len..self.len + len) {
            character.encode_utf8(free);
            self.len += len;
        }
        fits
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            if self.is_cut {
                break;
            }
            if !self.put(character, CUT.len_utf8()) {
                self.is_cut = true;
                self.put(CUT, 0);
            }
        }
        Ok(())
    }
}

const CUT: char = '…';

/// Bytes in hexadecimal digits; of many the first.
pub(super) struct Hex<'a>(pub(super) &'a [u8]);

impl Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, byte) in self.0.iter().take(MOST_HEX).enumerate() {
            let space = if i > 0 { " " } else { "" };
            write!(f, "{space}{byte:02x}")?;
        }
        match self.0.len().saturating_sub(MOST_HEX) {
            0 => Ok(()),
            rest => write!(f, " and {rest} more"),
        }
    }
}

const MOST_HEX: usize = 32;

/// Bytes as text; those that no printable character is, as `\x..`.
pub(super) struct Ascii<'a>(pub(super) &'a [u8]);

impl Display for Ascii<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&byte| match byte {
            b' '..=b'~' => f.write_char(byte.into()),
            _ => write!(f, "\\x{byte:02x}"),
        })
    }
}

/// A value with at most four decimals.
pub(super) struct Value(pub(super) f64);

impl Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        if !(-1e9..1e9).contains(&value) {
            return write!(f, "{value:e}");
        }
        let units = crate::encoding::round(value * 1e4);
        let (sign, units) = (if units < 0 { "-" } else { "" }, units.unsigned_abs());
        let (whole, mut fraction, mut width) = (units / 10_000, units % 10_000, 4);
        if fraction == 0 {
            return write!(f, "{sign}{whole}");
        }
        while fraction % 10 == 0 {
            (fraction, width) = (fraction / 10, width - 1);
        }
        write!(f, "{sign}{whole}.{fraction:0width$}")
    }
}

/// Nanoseconds in milliseconds, to a tenth of a microsecond.
pub(super) fn ms(ns: u64) -> Value {
    Value(ns as f64 * 1e-6)
}

/// A thing that is counted, with an `s` of more than one.
pub(super) struct Count(pub(super) usize, pub(super) &'static str);

impl Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(count, thing) = *self;
        write!(f, "{count} {thing}{}", if count == 1 { "" } else { "s" })
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_text_that_is_too_long_ends_with_dots_and_whole_characters() {
        let mut text = Text::new();
        for _ in 0..MAX_TEXT {
            text.write_str("µ").unwrap();
        }
        assert!(text.as_str().ends_with("µ…") && text.as_str().len() <= MAX_TEXT, "{text:?}");
    }

    #[test]
    fn values_have_no_more_digits_than_they_need() {
        let texts = [0.0, -0.00001, 0.5, -12.3456, 700.0, 1e9, 0.00005].map(|value| Value(value).to_string());
        assert_eq!(texts, ["0", "0", "0.5", "-12.3456", "700", "1e9", "0.0001"]);
        assert_eq!([f64::NAN, f64::INFINITY].map(|value| Value(value).to_string()), ["NaN", "inf"]);
    }

    #[test]
    fn of_many_bytes_the_first_are_told() {
        assert_eq!(Hex(&[0, 255]).to_string(), "00 ff");
        assert!(Hex(&[1; 40]).to_string().ends_with(" 01 and 8 more"));
    }
}
