//! Frames: where a payload begins and ends in a stream of bytes, and whether it arrived whole.
//!
//! | bytes | meaning |
//! |---|---|
//! | 1 or more | COBS code bytes: they replace the zeros, so that none is left in the frame |
//! | n | the payload, n ≤ 512 |
//! | 2 | CRC-16/IBM-3740 of the payload, least significant byte first |
//! | 1 | 0x00, the delimiter |
//!
//! The payload and its CRC are stuffed together (COBS, consistent-overhead byte stuffing, Cheshire and Baker 1999);
//! 0x00 can therefore only be a delimiter, and after any disturbance the next one sets a reader right. A frame of up
//! to 252 bytes of payload costs exactly 4 bytes more, and at most one more for each further 254 begun.
//!
//! The CRC (polynomial 0x1021, first value 0xffff, not reflected, also known as CCITT-FALSE) finds every one, two or
//! three flipped bits among payload and CRC. That is no promise about the stuffing: a flipped code byte or delimiter
//! moves zeros or joins frames, and such a frame passes by chance once in 2^16. A message of the wrong length is
//! then still refused by its parser.
//!
//! The CRC goes least significant byte first, as all else here. The other order would let a frame followed by
//! stray zeros pass, since the remainder behind a valid CRC would be zero.

use cobs::{CobsEncoder, DecodeResult, DecoderState};
use crc::{CRC_16_IBM_3740, Crc};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::buffer::Buffer;
use crate::error::NoRoom;

/// Bytes of the longest payload.
pub const MAX_PAYLOAD: usize = 512;

/// Bytes of the longest frame on the wire.
pub const MAX_FRAME: usize = encoded_len_max(MAX_PAYLOAD);

/// The byte that ends every frame and occurs nowhere in it.
pub const DELIMITER: u8 = 0x00;

/// The most bytes that a payload of `payload_len` bytes takes on the wire, the delimiter included.
pub const fn encoded_len_max(payload_len: usize) -> usize {
    let stuffed = payload_len.saturating_add(CRC_LEN);
    stuffed.saturating_add(stuffed.div_ceil(254)).saturating_add(1)
}

/// The least and the most bytes that a payload of `payload_len` bytes takes on the wire: stuffing adds one, and at most one more
/// for each 254 begun.
pub fn encoded_len(payload_len: usize) -> [usize; 2] {
    let most = encoded_len_max(payload_len);
    [most.min(payload_len + 4), most]
}

/// Writes `payload` as a frame to the front of `out` and returns the number of bytes written.
///
/// # Errors
/// If the payload is longer than [`MAX_PAYLOAD`], or `out` shorter than [`encoded_len_max`] of it.
pub fn encode(payload: &[u8], out: &mut [u8]) -> Result<usize, NoRoom> {
    if payload.len() > MAX_PAYLOAD {
        return Err(NoRoom { needed: payload.len(), room: MAX_PAYLOAD });
    }
    let no_room = NoRoom { needed: encoded_len_max(payload.len()), room: out.len() };
    if no_room.needed > no_room.room {
        return Err(no_room);
    }
    let mut encoder = CobsEncoder::new(out);
    encoder.push(payload).map_err(|_| no_room)?;
    encoder.push(&CRC.checksum(payload).to_le_bytes()).map_err(|_| no_room)?;
    let len = encoder.finalize();
    *out.get_mut(len).ok_or(no_room)? = DELIMITER;
    Ok(len + 1)
}

/// Finds frames in a stream of bytes.
///
/// After each delimiter it is as new: nothing of a frame, good or bad, affects the next.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decoder {
    /// The bytes since the last delimiter, still stuffed.
    collected: Buffer<{ MAX_FRAME - 1 }>,
    /// The number of bytes since the buffer was full.
    dropped: u32,
}

impl Decoder {
    /// Whether the next byte is the first of a frame.
    pub fn is_between_frames(&self) -> bool {
        self.collected.len() == 0 && self.dropped == 0
    }

    /// A decoder that has seen nothing.
    pub const fn new() -> Self {
        Self { collected: Buffer::new(), dropped: 0 }
    }

    /// Takes the next byte from the wire. At the end of a frame gives its payload, or says why there is none.
    ///
    /// Two delimiters in a row are no frame; a sender may put one before a frame to end whatever noise came before.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if byte != DELIMITER {
            if !self.collected.push(byte) {
                self.dropped = self.dropped.saturating_add(1);
            }
            return None;
        }
        let dropped = core::mem::take(&mut self.dropped);
        let limit = MAX_FRAME - 1;
        match self.collected.drain() {
            [] => None,
            _ if dropped > 0 => {
                Some(Err(FrameError::TooLong { limit, found: limit.saturating_add(dropped as usize) }))
            }
            frame => Some(open(frame)),
        }
    }
}

/// A reason why the bytes before a delimiter are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// More bytes than the longest frame has.
    #[error("{found} bytes without a delimiter, but a frame has at most {limit}")]
    TooLong {
        /// Bytes of the longest frame, without its delimiter.
        limit: usize,
        /// Bytes that came.
        found: usize,
    },
    /// The stuffing is broken: the delimiter came too early.
    #[error("the frame ends {missing} bytes earlier than its last COBS code byte indicates")]
    Cobs {
        /// Bytes that the last code byte promises and that did not come.
        missing: u8,
    },
    /// Fewer bytes than a CRC has.
    #[error("{found} bytes are too few for a CRC of {expected}")]
    TooShort {
        /// Bytes of the CRC.
        expected: usize,
        /// Bytes in the frame.
        found: usize,
    },
    /// The payload is not the one that was sent.
    #[error("the frame's CRC is {found:#06x}, but its payload has {expected:#06x}")]
    Crc {
        /// The CRC of the payload that arrived.
        expected: u16,
        /// The CRC that arrived.
        found: u16,
    },
}

/// Unstuffs a frame in place and checks it.
fn open(frame: &mut [u8]) -> Result<&[u8], FrameError> {
    let len = unstuff(frame)?;
    let frame = frame.get(..len).unwrap_or_default();
    let Some((payload, crc)) = frame.split_last_chunk::<CRC_LEN>() else {
        return Err(FrameError::TooShort { expected: CRC_LEN, found: len });
    };
    let (expected, found) = (CRC.checksum(payload), u16::from_le_bytes(*crc));
    if expected == found { Ok(payload) } else { Err(FrameError::Crc { expected, found }) }
}

/// Undoes the stuffing in place, which is safe as each byte written was read before. Returns the length.
fn unstuff(frame: &mut [u8]) -> Result<usize, FrameError> {
    let mut state = DecoderState::Idle;
    let mut len = 0;
    for at in 0..frame.len() {
        let Some(&byte) = frame.get(at) else { break };
        if let Ok(DecodeResult::DataContinue(byte)) = state.feed(byte)
            && let Some(place) = frame.get_mut(len)
        {
            *place = byte;
            len += 1;
        }
    }
    match state {
        DecoderState::Grab(missing) | DecoderState::GrabChain(missing) if missing > 0 => {
            Err(FrameError::Cobs { missing })
        }
        DecoderState::Idle | DecoderState::Grab(_) | DecoderState::GrabChain(_) => Ok(len),
    }
}

pub(crate) const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

const CRC_LEN: usize = 2;

/// The length of the frame of a payload that is not longer does not depend on its bytes.
pub const SHORT_PAYLOAD: usize = 252;

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    fn payload() -> impl Strategy<Value = Vec<u8>> {
        // Zeros and long runs without any are what the stuffing is about.
        prop_oneof![
            vec(any::<u8>(), 0..=MAX_PAYLOAD),
            vec(0..2u8, 0..=MAX_PAYLOAD),
            vec(1..=255u8, 240..=MAX_PAYLOAD),
        ]
    }

    fn framed(payload: &[u8]) -> Vec<u8> {
        let mut out = vec![0xaa; encoded_len_max(payload.len())];
        let len = encode(payload, &mut out).unwrap();
        out.truncate(len);
        out
    }

    fn decode_all(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Vec<u8>, FrameError>> {
        bytes.iter().filter_map(|&byte| decoder.push(byte).map(|frame| frame.map(<[u8]>::to_vec))).collect()
    }

    proptest! {
        #[test]
        fn what_goes_in_comes_out(payloads in vec(payload(), 0..4)) {
            let wire: Vec<u8> = payloads.iter().flat_map(|payload| framed(payload)).collect();
            let mut decoder = Decoder::new();
            let expected: Vec<_> = payloads.into_iter().map(Ok).collect();
            prop_assert_eq!(decode_all(&mut decoder, &wire), expected);
            prop_assert_eq!(decoder, Decoder::new());
        }

        #[test]
        fn only_the_delimiter_is_zero_and_short_frames_cost_four_bytes(payload in payload()) {
            let frame = framed(&payload);
            prop_assert_eq!(frame.iter().position(|&byte| byte == DELIMITER), Some(frame.len() - 1));
            prop_assert!(payload.len() > 252 || frame.len() == payload.len() + 4);
        }

        #[test]
        fn a_delimiter_after_any_garbage_sets_the_decoder_right(
            garbage in vec(any::<u8>(), 0..2000), payload in payload(),
        ) {
            let mut decoder = Decoder::new();
            decode_all(&mut decoder, &garbage);
            decoder.push(DELIMITER);
            prop_assert_eq!(decode_all(&mut decoder, &framed(&payload)), vec![Ok(payload)]);
        }

        #[test]
        fn garbage_costs_at_most_the_frame_that_it_touches(
            garbage in vec(1..=255u8, 1..700), payload in payload(),
        ) {
            let mut decoder = Decoder::new();
            let mut wire = garbage;
            wire.extend(framed(&payload));
            wire.extend(framed(&payload));
            prop_assert_eq!(decode_all(&mut decoder, &wire).pop(), Some(Ok(payload)));
        }

        #[test]
        fn a_flipped_bit_of_payload_or_crc_is_always_found(payload in vec(any::<u8>(), 0..100), bit in 0..8u32) {
            let frame = framed(&payload);
            for at in unstuffed_positions(&frame) {
                let mut broken = frame.clone();
                broken[at] ^= 1 << bit;
                // A byte that became zero cuts the frame in two, which is a matter of the stuffing.
                if broken[at] != DELIMITER {
                    let found = decode_all(&mut Decoder::new(), &broken);
                    prop_assert!(matches!(found[..], [Err(FrameError::Crc { .. })]), "{found:?}");
                }
            }
        }

        #[test]
        fn up_to_three_flipped_bits_below_the_stuffing_are_always_found(
            payload in vec(any::<u8>(), 0..=MAX_PAYLOAD),
            flips in vec(any::<prop::sample::Index>(), 1..=3),
        ) {
            let mut frame = payload.clone();
            frame.extend(CRC.checksum(&payload).to_le_bytes());
            for flip in flips {
                let bit = flip.index(frame.len() * 8);
                frame[bit / 8] ^= 1 << (bit % 8);
            }
            let (broken, crc) = frame.split_last_chunk::<CRC_LEN>().unwrap();
            let unchanged = broken == payload && u16::from_le_bytes(*crc) == CRC.checksum(&payload);
            let mut stuffed = vec![0; cobs::max_encoding_length(frame.len())];
            let len = cobs::encode(&frame, &mut stuffed);
            prop_assert_eq!(open(&mut stuffed[..len]).is_ok(), unchanged);
        }

        #[test]
        fn lost_bytes_never_panic(payload in payload(), at: prop::sample::Index, n in 0..20usize) {
            let mut frame = framed(&payload);
            let at = at.index(frame.len());
            frame.drain(at..(at + n).min(frame.len()));
            decode_all(&mut Decoder::new(), &frame);
        }

        #[test]
        fn a_decoder_is_saved_as_the_bytes_it_holds(bytes in vec(any::<u8>(), 0..700)) {
            let mut decoder = Decoder::new();
            decode_all(&mut decoder, &bytes);
            let held = bytes.iter().rev().take_while(|&&byte| byte != DELIMITER).count().min(MAX_FRAME - 1);
            let saved = postcard::to_allocvec(&decoder).unwrap();
            prop_assert!(saved.len() <= held + 4);
            prop_assert_eq!(&postcard::from_bytes::<Decoder>(&saved).unwrap(), &decoder);
            let text = serde_json::to_string(&decoder).unwrap();
            prop_assert_eq!(&serde_json::from_str::<Decoder>(&text).unwrap(), &decoder);
        }
    }

    /// All single flips of many frames, the stuffing and the delimiter included. A flip of the stuffing passes by
    /// chance once in 2^16, so the payloads are fixed: with these, none does.
    #[test]
    fn no_single_flip_of_these_frames_gives_another_payload() {
        let mut seed = 1u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 24) as u8
        };
        for len in 0..64 {
            let payload: Vec<u8> = (0..len).map(|_| if random() < 64 { 0 } else { random() }).collect();
            let frame = framed(&payload);
            for bit in 0..frame.len() * 8 {
                let mut wire = frame.clone();
                wire[bit / 8] ^= 1 << (bit % 8);
                wire.extend(&frame);
                wire.extend(&frame);
                let found = decode_all(&mut Decoder::new(), &wire);
                let whole = found.iter().flatten().filter(|&found| *found == payload).count();
                // A flipped delimiter takes the next frame with it.
                let expected = if bit / 8 == frame.len() - 1 { 1 } else { 2 };
                assert_eq!(whole, expected, "length {len}, bit {bit}: {found:?}");
                assert_eq!(found.iter().flatten().count(), whole, "length {len}, bit {bit}: {found:?}");
            }
        }
    }

    #[test]
    fn the_crc_is_the_catalogued_one() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29b1);
    }

    #[test]
    fn empty_frames_are_ignored() {
        assert_eq!(decode_all(&mut Decoder::new(), &[0, 0, 0]), []);
    }

    #[test]
    fn overlong_input_is_reported_once() {
        let mut wire = vec![1; 1000];
        wire.push(DELIMITER);
        wire.extend(framed(b"next"));
        assert_eq!(
            decode_all(&mut Decoder::new(), &wire),
            [Err(FrameError::TooLong { limit: 517, found: 1000 }), Ok(b"next".to_vec())]
        );
    }

    #[test]
    fn errors_carry_what_disagrees() {
        let mut decoder = Decoder::new();
        assert_eq!(decode_all(&mut decoder, &[5, 1, 0]), [Err(FrameError::Cobs { missing: 3 })]);
        assert_eq!(
            decode_all(&mut decoder, &[2, 1, 0]),
            [Err(FrameError::TooShort { expected: 2, found: 1 })]
        );
        assert_eq!(
            decode_all(&mut decoder, &[3, 1, 1, 0]),
            [Err(FrameError::Crc { expected: 0xffff, found: 0x0101 })]
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut out = [0; MAX_FRAME + 9];
        assert_eq!(encode(&[1; 513], &mut out), Err(NoRoom { needed: 513, room: 512 }));
        assert_eq!(encode(&[0; 4], &mut out[..7]), Err(NoRoom { needed: 8, room: 7 }));
        assert_eq!(encode(&[1; 512], &mut out), Ok(MAX_FRAME));
    }

    #[test]
    fn a_saved_decoder_that_holds_too_much_is_refused() {
        let text = std::format!("{{\"collected\":{:?},\"dropped\":0}}", [1; MAX_FRAME]);
        assert!(serde_json::from_str::<Decoder>(&text).is_err());
    }

    /// The positions at which the bytes of a frame are data rather than stuffing.
    fn unstuffed_positions(frame: &[u8]) -> Vec<usize> {
        let mut code_at = 0;
        (0..frame.len() - 1)
            .filter(|&at| {
                let is_code = at == code_at;
                if is_code {
                    code_at += usize::from(frame[at]);
                }
                !is_code
            })
            .collect()
    }
}
