//! Intel HEX: lines of `:` count address type data checksum.
//!
//! Source: Intel, *Hexadecimal Object File Format Specification*, revision A, 1988.

use alloc::string::String;

use thiserror::Error;

use super::ProgramError;
use super::image::Image;

/// A line is no record of Intel HEX.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum HexError {
    /// The line does not begin with a colon.
    #[error("a record begins with a colon")]
    NoColon,
    /// A character is no hexadecimal digit.
    #[error("column {column} is no hexadecimal digit")]
    Digit {
        /// The column, counted from 1.
        column: usize,
    },
    /// The record has an odd number of digits, or not as many as its count.
    #[error("the record has {found} digits, but its count asks for {expected}")]
    Length {
        /// Digits by the count; 10 at least.
        expected: usize,
        /// Digits there are.
        found: usize,
    },
    /// The sum of the record's bytes is not zero.
    #[error("the checksum is {found:#04x}, but the bytes give {expected:#04x}")]
    Checksum {
        /// The checksum of the bytes.
        expected: u8,
        /// In the record.
        found: u8,
    },
    /// The type of the record is none of 0 to 5, or its data has another length than the type has.
    #[error("there is no record of type {kind} with {count} bytes of data")]
    Kind {
        /// The type.
        kind: u8,
        /// The bytes of data.
        count: u8,
    },
    /// There is a record after the last one.
    #[error("a record follows the end of the file")]
    AfterEnd,
    /// The file stops without an end record.
    #[error("the end record is missing")]
    NoEnd,
}

/// Bytes of a record's data, as many as avr-objcopy writes.
const RECORD: usize = 16;
/// Bytes that a record's address reaches.
const SEGMENT: usize = 1 << 16;

/// The records of a memory from address 0 on.
pub(super) fn write(memory: &[u8]) -> String {
    let mut text = String::new();
    for (base, segment) in (0_u16..).zip(memory.chunks(SEGMENT)) {
        if base > 0 {
            write_record(&mut text, 0, 4, &base.to_be_bytes());
        }
        for (at, data) in (0_u16..).step_by(RECORD).zip(segment.chunks(RECORD)) {
            write_record(&mut text, at, 0, data);
        }
    }
    write_record(&mut text, 0, 1, &[]);
    text
}

fn write_record(text: &mut String, address: u16, kind: u8, data: &[u8]) {
    let [high, low] = address.to_be_bytes();
    let head = [u8::try_from(data.len()).unwrap_or(u8::MAX), high, low, kind];
    let sum = head.iter().chain(data).fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
    text.push(':');
    for byte in head.iter().chain(data).chain([&sum.wrapping_neg()]) {
        for digit in [byte >> 4, byte & 15] {
            text.extend(char::from_digit(digit.into(), 16).map(|digit| digit.to_ascii_uppercase()));
        }
    }
    text.push('\n');
}

/// Reads all records of a text into the flash.
pub(super) fn read(text: &[u8], flash: &mut Image) -> Result<(), ProgramError> {
    let mut base = 0;
    let mut ended = false;
    let mut last = 0;
    for (line, record) in (1..).zip(text.split(|&byte| byte == b'\n')) {
        let record = record.trim_ascii();
        if record.is_empty() {
            continue;
        }
        last = line;
        let at_line = |error| ProgramError::Hex { line, error };
        if ended {
            return Err(at_line(HexError::AfterEnd));
        }
        let record = Record::parse(record).map_err(at_line)?;
        match (record.kind, record.data()) {
            (0, data) => flash.put(base + u32::from(record.address), data)?,
            (1, []) => ended = true,
            (2, &[high, low]) => base = u32::from(u16::from_be_bytes([high, low])) << 4,
            (4, &[high, low]) => base = u32::from(u16::from_be_bytes([high, low])) << 16,
            // A start address has no use: the processor starts at its reset vector.
            (3 | 5, [_, _, _, _]) => {}
            (kind, _) => return Err(at_line(HexError::Kind { kind, count: record.count })),
        }
    }
    // A text without a single record is empty, which is an error elsewhere.
    if ended || last == 0 { Ok(()) } else { Err(ProgramError::Hex { line: last, error: HexError::NoEnd }) }
}

struct Record {
    count: u8,
    address: u16,
    kind: u8,
    bytes: [u8; 255],
}

impl Record {
    fn parse(line: &[u8]) -> Result<Self, HexError> {
        let Some(digits) = line.strip_prefix(b":") else { return Err(HexError::NoColon) };
        if let Some(bad) = digits.iter().position(|digit| !digit.is_ascii_hexdigit()) {
            return Err(HexError::Digit { column: bad + 2 });
        }
        let byte = |at: usize| (value(digits[2 * at]) << 4) | value(digits[2 * at + 1]);
        let expected = if digits.len() < 2 { 10 } else { 10 + 2 * usize::from(byte(0)) };
        if digits.len() != expected {
            return Err(HexError::Length { expected, found: digits.len() });
        }
        let count = byte(0);
        let end = 4 + usize::from(count);
        let sum = (0..end).fold(0u8, |sum, at| sum.wrapping_add(byte(at)));
        let (expected, found) = (sum.wrapping_neg(), byte(end));
        if expected != found {
            return Err(HexError::Checksum { expected, found });
        }
        let mut bytes = [0; 255];
        for (at, place) in bytes.iter_mut().take(usize::from(count)).enumerate() {
            *place = byte(4 + at);
        }
        Ok(Self { count, address: u16::from_be_bytes([byte(1), byte(2)]), kind: byte(3), bytes })
    }

    fn data(&self) -> &[u8] {
        &self.bytes[..usize::from(self.count)]
    }
}

/// The value of a hexadecimal digit.
const fn value(digit: u8) -> u8 {
    match digit {
        b'0'..=b'9' => digit - b'0',
        _ => (digit | 0x20) - b'a' + 10,
    }
}
