//! The checksum at the end of each line: a CRC-64 of the line, and of the identity of the journal. So no line of
//! another journal passes for one of this.

use std::io;

use crc::{CRC_64_XZ, Crc};
use serde::Serialize;

use crate::run_record::{Row, Written};

/// The means to make and check the checksums of a journal's lines.
#[derive(Clone, Debug, Default)]
pub(super) struct Seal {
    /// The text with which each checksum begins.
    of: String,
}

impl Seal {
    /// A `Seal` for lines of a journal of this.
    pub(super) fn new(of: String) -> Self {
        Self { of }
    }

    /// An object as a line of JSON, whose last member is the checksum.
    pub(super) fn line(&self, object: &impl Serialize) -> io::Result<Vec<u8>> {
        let mut line = serde_json::to_vec(object)?;
        // All that is written has members.
        line.pop();
        let sum = self.sum(&line);
        line.extend(format!("{BEFORE}{sum:0DIGITS$x}{BEHIND}").bytes());
        Ok(line)
    }

    /// The object of a line as JSON without its checksum, and that; `None` if they do not match.
    pub(super) fn open(&self, line: &[u8]) -> Option<(Vec<u8>, u64)> {
        let (object, end) = line.split_at_checked(line.len().checked_sub(END)?)?;
        let sum = self.sum(object);
        let matches = end == format!("{BEFORE}{sum:0DIGITS$x}{BEHIND}").as_bytes();
        matches.then(|| ([object, b"}"].concat(), sum))
    }

    /// The row of a line, with its checksum; `None` if the line is damaged.
    pub(super) fn row(&self, line: &[u8]) -> Option<(Row, u64)> {
        let (object, sum) = self.open(line)?;
        Some((serde_json::from_slice::<Written>(&object).ok()?.row()?, sum))
    }

    fn sum(&self, object: &[u8]) -> u64 {
        let mut digest = CRC.digest();
        digest.update(self.of.as_bytes());
        digest.update(object);
        digest.finalize()
    }
}

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// The text before and behind the digits.
const BEFORE: &str = ",\"crc64\":\"";
const BEHIND: &str = "\"}\n";
const DIGITS: usize = 16;
const END: usize = BEFORE.len() + DIGITS + BEHIND.len();
