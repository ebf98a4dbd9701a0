//! The bare format: values and nothing else.
//!
//! Wahde 2016, §3.2.1, counts a message as one byte for each sensor and motor. Taken at its word that is a protocol
//! without header, mask or checksum: to the brain go all sensors' components in order, to the robot all motor
//! signals in order, each in its encoding.
//!
//! | direction | bytes | length |
//! |---|---|---|
//! | to the brain | all `components` of the layout | [`Layout::bare_readings_len`](crate::Layout::bare_readings_len) |
//! | to the robot | all `motors` of the layout | [`Layout::bare_command_len`](crate::Layout::bare_command_len) |
//!
//! It is written with [`write_values`](crate::write_values) and read with [`Values`](crate::Values). What it saves
//! in bytes it loses in safety: an altered byte is an altered value, and after a lost byte every value is read in
//! its neighbour's place until the wire is silent. A number sent as `Float64` may be NaN or infinite.

use serde::{Deserialize, Serialize};

use crate::buffer::Buffer;
use crate::error::NoRoom;
use crate::frame::MAX_PAYLOAD;

/// Cuts a stream of bytes into messages of a fixed length. Silence is the only mark that such a protocol has: a
/// pause within a message means that bytes were lost, and what came before it is discarded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BareDecoder {
    collected: Buffer<MAX_PAYLOAD>,
    length: usize,
    gap_ns: u64,
    last_ns: u64,
    discarded: u64,
}

impl BareDecoder {
    /// A decoder of messages of `length` bytes, in which more than `gap_ns` nanoseconds from one byte to the next are
    /// a pause. A length of 0 gives no messages.
    ///
    /// # Errors
    /// If `length` is more than [`MAX_PAYLOAD`].
    pub const fn new(length: usize, gap_ns: u64) -> Result<Self, NoRoom> {
        if length > MAX_PAYLOAD {
            return Err(NoRoom { needed: length, room: MAX_PAYLOAD });
        }
        Ok(Self { collected: Buffer::new(), length, gap_ns, last_ns: 0, discarded: 0 })
    }

    /// Takes the next byte from the wire and the instant at which it came, in nanoseconds; instants must not go
    /// back. Gives the message that the byte completes.
    pub fn push(&mut self, byte: u8, at_ns: u64) -> Option<&[u8]> {
        if self.length == 0 {
            return None;
        }
        if self.collected.len() > 0 && at_ns.saturating_sub(self.last_ns) > self.gap_ns {
            self.collected.clear();
            self.discarded = self.discarded.saturating_add(1);
        }
        self.last_ns = at_ns;
        self.collected.push(byte);
        (self.collected.len() >= self.length).then(|| &*self.collected.drain())
    }

    /// Whether this decoder may have become what `other` is: of messages as long and pauses as long, and with less than a
    /// message collected.
    pub fn may_become(&self, other: &Self) -> bool {
        let is_same = self.length == other.length && self.gap_ns == other.gap_ns;
        is_same && other.collected.len() < other.length.max(1)
    }

    /// The number of incomplete messages that have been discarded.
    pub const fn discarded(&self) -> u64 {
        self.discarded
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    const GAP_NS: u64 = 1_000;

    #[test]
    fn a_decoder_becomes_only_one_of_the_same_messages_with_less_than_one_collected() {
        let own = BareDecoder::new(3, GAP_NS).unwrap();
        let mut later = own.clone();
        assert!(own.may_become(&later));
        assert!(later.push(1, 0).is_none() && later.push(2, 0).is_none());
        assert!(own.may_become(&later));
        assert!(!own.may_become(&BareDecoder::new(4, GAP_NS).unwrap()));
        assert!(!own.may_become(&BareDecoder::new(3, 2 * GAP_NS).unwrap()));
        later.collected.push(3);
        assert!(!own.may_become(&later), "a whole message is collected");
    }

    proptest! {
        #[test]
        fn a_steady_stream_is_cut_into_messages(length in 1..20usize, bytes in vec(any::<u8>(), 0..200)) {
            let mut decoder = BareDecoder::new(length, GAP_NS).unwrap();
            let messages: Vec<_> = (0..)
                .zip(&bytes)
                .filter_map(|(i, &byte)| decoder.push(byte, i * GAP_NS).map(<[u8]>::to_vec))
                .collect();
            prop_assert!(bytes.chunks_exact(length).eq(messages.iter().map(Vec::as_slice)));
            prop_assert_eq!(decoder.discarded(), 0);
        }

        #[test]
        fn silence_sets_the_decoder_right(
            noise in vec(any::<u8>(), 0..100), message in vec(any::<u8>(), 1..20),
        ) {
            let mut decoder = BareDecoder::new(message.len(), GAP_NS).unwrap();
            for &byte in &noise {
                decoder.push(byte, 0);
            }
            let (&last, rest) = message.split_last().unwrap();
            for &byte in rest {
                prop_assert_eq!(decoder.push(byte, GAP_NS + 1), None);
            }
            prop_assert_eq!(decoder.push(last, GAP_NS + 1), Some(&message[..]));
            prop_assert_eq!(decoder.discarded(), u64::from(noise.len() % message.len() > 0));
        }

        #[test]
        fn a_decoder_survives_being_saved(bytes in vec(any::<u8>(), 0..50)) {
            let mut decoder = BareDecoder::new(20, GAP_NS).unwrap();
            for &byte in &bytes {
                decoder.push(byte, 5);
            }
            let saved = postcard::to_allocvec(&decoder).unwrap();
            prop_assert_eq!(postcard::from_bytes::<BareDecoder>(&saved).unwrap(), decoder);
        }
    }

    #[test]
    fn impossible_lengths() {
        assert_eq!(BareDecoder::new(513, GAP_NS), Err(NoRoom { needed: 513, room: 512 }));
        assert_eq!(BareDecoder::new(0, GAP_NS).unwrap().push(1, 0), None);
    }
}
