//! Streams: packets that come again and again, with a header and a checksum.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Packet, Signal, Version, group, listed_len};
use crate::buffer::Buffer;
use crate::encoding::Encoding;

/// The first byte of each message of a stream (libcreate, CREATE_2_HEADER).
pub const HEADER: u8 = 19;

/// Most bytes between the length and the checksum: numbers of packets and their data.
pub const MOST_STREAMED: usize = 255;

/// Time between two messages of a stream, in nanoseconds (pycreate2 waits so long for data; recalled of the specifications).
pub const STREAM_PERIOD_NS: u64 = 15_000_000;

/// Bytes of a message of a stream of these packets: header, length, numbers and data, checksum.
pub fn stream_len(version: Version, ids: &[u8]) -> usize {
    3 + ids.len() + listed_len(version, ids)
}

/// Writes a message of a stream to the front of `out`, with the value that `read` gives of each packet, and returns how
/// long it is; 0 if `out` is too short, or there is more than [`MOST_STREAMED`].
pub fn write_stream(
    version: Version,
    ids: &[u8],
    mut read: impl FnMut(Packet) -> i32,
    out: &mut [u8],
) -> usize {
    let len = stream_len(version, ids);
    let Some(out) = out.get_mut(..len).filter(|_| len - 3 <= MOST_STREAMED) else { return 0 };
    out[0] = HEADER;
    out[1] = (len - 3) as u8;
    let mut at = 2;
    for &id in ids {
        out[at] = id;
        at += 1;
        for packet in group(version, id).unwrap_or_default() {
            at += packet.put(read(*packet), &mut out[at..]);
        }
    }
    out[at] = out[..at].iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)).wrapping_neg();
    len
}

/// Finds the messages of a stream at the laptop's end. It knows how long they are, so bytes that only look like the beginning
/// of one seldom cost it one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stream {
    /// Bytes between the length and the checksum.
    len: u8,
    collected: Buffer<{ MOST_STREAMED + 3 }>,
}

/// A reason why a message of a stream is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StreamError {
    /// The bytes do not add up to 0.
    #[error("the bytes of a message add up to {found}, not to 0")]
    Sum {
        /// The sum of the bytes, modulo 256.
        found: u8,
    },
}

impl Stream {
    /// A reader of a stream of these packets that has seen nothing.
    pub fn new(version: Version, ids: &[u8]) -> Self {
        let len = (stream_len(version, ids) - 3).min(MOST_STREAMED);
        Self { len: len as u8, collected: Buffer::new() }
    }

    /// Whether this reader may have become what `other` is: of messages as long, with less than one collected.
    pub fn may_become(&self, other: &Self) -> bool {
        self.len == other.len && other.collected.used().len() < usize::from(self.len) + 3
    }

    /// Takes the next byte from the wire. Gives the numbers and data of the message that the byte ends.
    ///
    /// # Errors
    /// If the checksum of the message that ends here is wrong.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], StreamError>> {
        let expected = match self.collected.used().len() {
            0 => Some(HEADER),
            1 => Some(self.len),
            _ => None,
        };
        if expected.is_some_and(|expected| byte != expected) {
            self.collected.clear();
            if byte != HEADER {
                return None;
            }
        }
        self.collected.push(byte);
        if self.collected.used().len() < usize::from(self.len) + 3 {
            return None;
        }
        let message = &*self.collected.drain();
        match message.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) {
            0 => Some(Ok(&message[2..message.len() - 1])),
            found => Some(Err(StreamError::Sum { found })),
        }
    }
}

/// The content of a message of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload<'a> {
    /// The model of the robot.
    pub version: Version,
    /// Numbers and data, as [`Stream::push`] gives them.
    pub bytes: &'a [u8],
}

impl Payload<'_> {
    /// The value of a component that has this signal, if it is there.
    pub fn value(&self, signal: Signal, encoding: Encoding) -> Option<f64> {
        signal.value(self.packet(signal.packet)?, encoding)
    }

    /// The bits of a packet's value, if it is there.
    pub fn packet(&self, wanted: Packet) -> Option<u16> {
        let mut rest = self.bytes;
        while let [id, behind @ ..] = rest {
            rest = behind;
            for packet in group(self.version, *id)? {
                if *packet == wanted {
                    return packet.take(rest);
                }
                rest = rest.get(packet.size()..)?;
            }
        }
        None
    }
}
