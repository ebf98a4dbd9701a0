//! Numbers one after the other, each in its own encoding: the inside of every message.

use crate::encoding::Encoding;
use crate::error::{NoRoom, WriteError};
use crate::layout::total_len;

/// Writes `values`, each in its encoding, to the front of `out` and returns the number of bytes written.
///
/// # Errors
/// If there are not as many values as encodings, or `out` is too short.
pub fn write_values(
    encodings: &[Encoding],
    values: impl IntoIterator<Item = f64>,
    out: &mut [u8],
) -> Result<usize, WriteError> {
    let mut values = values.into_iter();
    let mut at = 0;
    for (found, encoding) in encodings.iter().enumerate() {
        let value = values.next().ok_or(WriteError::Count { expected: encodings.len(), found })?;
        match encoding.put(value, out.get_mut(at..).unwrap_or_default()) {
            0 => return Err(NoRoom { needed: total_len(encodings), room: out.len() }.into()),
            len => at += len,
        }
    }
    match values.next() {
        Some(_) => Err(WriteError::Count { expected: encodings.len(), found: encodings.len() + 1 }),
        None => Ok(at),
    }
}

/// Iterates over numbers that were sent one after the other. Ends early if the bytes do.
#[derive(Clone, Debug, PartialEq)]
pub struct Values<'a> {
    encodings: &'a [Encoding],
    bytes: &'a [u8],
}

impl<'a> Values<'a> {
    /// The values that are in `bytes`. Bytes behind the last value are ignored.
    pub const fn new(encodings: &'a [Encoding], bytes: &'a [u8]) -> Self {
        Self { encodings, bytes }
    }
}

impl Iterator for Values<'_> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let (encoding, encodings) = self.encodings.split_first()?;
        let value = encoding.take(self.bytes)?;
        self.encodings = encodings;
        self.bytes = self.bytes.get(encoding.len()..)?;
        Some(value)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, Some(self.encodings.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: [Encoding; 2] = [Encoding::Counter { bits: 8 }, Encoding::Counter { bits: 16 }];

    #[test]
    fn values_come_back() {
        let mut bytes = [0; 3];
        assert_eq!(write_values(&TWO, [-1.0, 300.0], &mut bytes), Ok(3));
        assert_eq!(bytes, [0xff, 0x2c, 0x01]);
        assert!(Values::new(&TWO, &bytes).eq([-1.0, 300.0]));
        assert!(Values::new(&TWO, &bytes[..2]).eq([-1.0]));
    }

    #[test]
    fn a_wrong_number_of_values_is_refused() {
        let mut bytes = [0; 8];
        assert_eq!(write_values(&TWO, [0.0], &mut bytes), Err(WriteError::Count { expected: 2, found: 1 }));
        assert_eq!(
            write_values(&TWO, [0.0; 9], &mut bytes),
            Err(WriteError::Count { expected: 2, found: 3 })
        );
        assert_eq!(write_values(&TWO, [0.0; 2], &mut bytes[..2]), Err(NoRoom { needed: 3, room: 2 }.into()));
    }
}
