//! A frame of a line camera, which has a colour and a depth for each column, or of a camera.
//!
//! | offset | bytes | meaning |
//! |---|---|---|
//! | 0 | 2 | 0xa5 0x5a, where a message begins |
//! | 2 | 2 | sequence number, wrapping: a gap is a lost frame |
//! | 4 | 2 | columns |
//! | 6 | 2 | rows |
//! | 8 | 3 · rows · columns | red, green and blue of each pixel, row by row |
//! | | 2 · columns | depth of each column in millimetres, 0 if nothing is within range |
//! | | 2 | CRC-16/IBM-3740 of all between the first two bytes and here |
//!
//! Multi-byte numbers are sent least significant byte first.
//!
//! A line camera sees a world whose walls are vertical, without floor or ceiling: within a column every pixel has the
//! same colour and the same depth. All rows are therefore alike. They are sent nevertheless, as a camera does that
//! does not know it, and cost the time that they cost there; the depth is sent once. A camera sends its image in the
//! same form; it measures no depths, so that all of them are 0.
//!
//! The CRC finds whatever is altered within any 16 bits in a row, so every single altered byte. The two sync bytes may
//! occur inside a message, too: a receiver that begins in the middle of one may take such a place for a beginning,
//! which the CRC then refuses.

use thiserror::Error;

use crate::error::NoRoom;
use crate::frame::CRC;

/// The pixel that the camera sees in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// The colour: red, green and blue, each 0 to 255.
    pub rgb: [u8; 3],
    /// Depth in millimetres, 0 if nothing is within range.
    pub depth_mm: u16,
}

/// The number of bytes of a message; `usize::MAX` if that is beyond this machine.
pub const fn encoded_len(columns: u16, rows: u16) -> usize {
    let column_len = 3 * rows as u64 + 2;
    let len = HEADER_LEN as u64 + columns as u64 * column_len + CRC_LEN as u64;
    if len > usize::MAX as u64 { usize::MAX } else { len as usize }
}

/// A frame could not be written. The buffer's contents are unspecified then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// The buffer is too short.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// More columns than the header can say.
    #[error("a frame has at most {limit} columns, but more were given")]
    Columns {
        /// The most columns of a frame.
        limit: usize,
    },
}

/// Writes a frame of `rows` rows, all alike, to the front of `out` and returns its length, [`encoded_len`].
///
/// # Errors
/// If there are more than 65,535 columns, or `out` is too short.
pub fn encode(
    sequence: u16,
    columns: impl Iterator<Item = Column> + Clone,
    rows: u16,
    out: &mut [u8],
) -> Result<usize, EncodeError> {
    let limit = usize::from(u16::MAX);
    let count =
        u16::try_from(columns.clone().take(limit + 1).count()).or(Err(EncodeError::Columns { limit }))?;
    Ok(frame(sequence, (count, rows), out, |pixels, depths| {
        // Of no columns there are no rows to copy, but a chunk must not be empty.
        let mut copies = pixels.chunks_exact_mut((3 * usize::from(count)).max(1));
        if let Some(first) = copies.next() {
            for (to, column) in first.as_chunks_mut().0.iter_mut().zip(columns.clone()) {
                *to = column.rgb;
            }
            copies.for_each(|row| row.copy_from_slice(first));
        }
        for (to, column) in depths.as_chunks_mut().0.iter_mut().zip(columns) {
            *to = column.depth_mm.to_le_bytes();
        }
    })?)
}

/// Writes the frame of a camera that measures no depths: all its pixels, row by row from the top, each from left to right, in red,
/// green and blue. What `pixels` lacks is black.
///
/// # Errors
/// If `out` is too short.
pub fn encode_pixels(
    sequence: u16,
    (columns, rows): (u16, u16),
    pixels: impl Iterator<Item = [u8; 3]>,
    out: &mut [u8],
) -> Result<usize, NoRoom> {
    frame(sequence, (columns, rows), out, |room, depths| {
        room.fill(0);
        room.as_chunks_mut().0.iter_mut().zip(pixels).for_each(|(to, pixel)| *to = pixel);
        depths.fill(0);
    })
}

/// Writes a frame, whose pixels and depths `fill` writes.
fn frame(
    sequence: u16,
    (columns, rows): (u16, u16),
    out: &mut [u8],
    fill: impl FnOnce(&mut [u8], &mut [u8]),
) -> Result<usize, NoRoom> {
    let no_room = NoRoom { needed: encoded_len(columns, rows), room: out.len() };
    let out = out.get_mut(..no_room.needed).ok_or(no_room)?;
    let (header, rest) = out.split_first_chunk_mut::<HEADER_LEN>().ok_or(no_room)?;
    let ([s0, s1], [c0, c1], [r0, r1]) = (sequence.to_le_bytes(), columns.to_le_bytes(), rows.to_le_bytes());
    *header = [SYNC[0], SYNC[1], s0, s1, c0, c1, r0, r1];
    let pixels_len = 3 * usize::from(columns) * usize::from(rows);
    let (pixels, rest) = rest.split_at_mut_checked(pixels_len).ok_or(no_room)?;
    let depths = rest.get_mut(..2 * usize::from(columns)).ok_or(no_room)?;
    fill(pixels, depths);
    let (message, crc) = out.split_last_chunk_mut().ok_or(no_room)?;
    *crc = CRC.checksum(message.get(SYNC.len()..).unwrap_or_default()).to_le_bytes();
    Ok(no_room.needed)
}

/// A frame as it arrived whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineImage<'a> {
    /// The number of the camera's frame; wraps after 65,535.
    pub sequence: u16,
    /// The number of columns.
    pub columns: u16,
    /// The number of rows. They are alike if a line camera sent them.
    pub rows: u16,
    /// The pixels, row by row.
    pixels: &'a [[u8; 3]],
    depths: &'a [[u8; 2]],
}

impl<'a> LineImage<'a> {
    /// Red, green and blue of each pixel of a row, counted from 0; `None` if there is no such row.
    pub fn row(&self, row: u16) -> Option<&'a [[u8; 3]]> {
        let columns = usize::from(self.columns);
        let from = usize::from(row) * columns;
        (row < self.rows).then(|| self.pixels.get(from..from + columns))?
    }

    /// Depth of each column in millimetres, 0 where nothing is within range.
    pub fn depths_mm(&self) -> impl ExactSizeIterator<Item = u16> + Clone + use<'a> {
        self.depths.iter().map(|&depth| u16::from_le_bytes(depth))
    }

    /// The columns, with the colours of the first row. None if there is no row.
    pub fn columns(&self) -> impl ExactSizeIterator<Item = Column> + Clone + use<'a> {
        let first = self.row(0).unwrap_or_default().iter();
        first.zip(self.depths_mm()).map(|(&rgb, depth_mm)| Column { rgb, depth_mm })
    }
}

/// A reason why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ParseError {
    /// The first bytes are not those of a message.
    #[error("no message begins here; the next may begin {skip} bytes on")]
    Sync {
        /// Bytes to be thrown away until the sync bytes come, or might come if more bytes were there; at least 1.
        skip: usize,
    },
    /// The message is too short, or continues behind its end.
    #[error("the message has {found} bytes, but its header makes it {expected}")]
    Length {
        /// Bytes that a message with this header has, or, of a cut header, at least has.
        expected: usize,
        /// Bytes in the message.
        found: usize,
    },
    /// The message is not the one that was sent.
    #[error("the message's CRC is {found:#06x}, but its content has {expected:#06x}")]
    Crc {
        /// The CRC of the content that arrived.
        expected: u16,
        /// The CRC that arrived.
        found: u16,
    },
}

/// The number of bytes of the message that begins at the front of `received`, or `None` if its header is not complete
/// yet.
///
/// The header has no checksum of its own. A receiver that knows the camera's columns and rows compares the length with
/// [`encoded_len`] of them, and skips a byte if it is another; one that does not must at least have an upper bound, or
/// an altered header makes it wait for up to 12.9 GB.
///
/// # Errors
/// [`ParseError::Sync`] if no message begins there. It says how many bytes to throw away before trying again.
pub fn message_len(received: &[u8]) -> Result<Option<usize>, ParseError> {
    if received.iter().zip(SYNC).any(|(&found, expected)| found != expected) {
        // A lone first sync byte at the end may have its second one still to come.
        let begins =
            |at: &usize| received.get(*at..).is_some_and(|rest| rest.iter().zip(SYNC).all(|(a, b)| *a == b));
        return Err(ParseError::Sync { skip: (1..received.len()).find(begins).unwrap_or(received.len()) });
    }
    let header = received.first_chunk::<HEADER_LEN>();
    Ok(header
        .map(|&[.., c0, c1, r0, r1]| encoded_len(u16::from_le_bytes([c0, c1]), u16::from_le_bytes([r0, r1]))))
}

/// Reads one whole message.
///
/// # Errors
/// An error if the bytes are not a frame. Nothing of such a message should be used.
pub fn parse(message: &[u8]) -> Result<LineImage<'_>, ParseError> {
    let no_header = ParseError::Length { expected: encoded_len(0, 0), found: message.len() };
    let expected = message_len(message)?.ok_or(no_header)?;
    let wrong_length = ParseError::Length { expected, found: message.len() };
    if expected != message.len() {
        return Err(wrong_length);
    }
    let (content, crc) = message.split_last_chunk::<CRC_LEN>().ok_or(wrong_length)?;
    let (header, body) = content.split_first_chunk::<HEADER_LEN>().ok_or(wrong_length)?;
    let (sound, found) =
        (CRC.checksum(content.get(SYNC.len()..).unwrap_or_default()), u16::from_le_bytes(*crc));
    if sound != found {
        return Err(ParseError::Crc { expected: sound, found });
    }
    let [_, _, s0, s1, c0, c1, r0, r1] = *header;
    let [sequence, columns, rows] = [[s0, s1], [c0, c1], [r0, r1]].map(u16::from_le_bytes);
    let pixels_len = 3 * usize::from(columns) * usize::from(rows);
    let (pixels, depths) = body.split_at_checked(pixels_len).ok_or(wrong_length)?;
    Ok(LineImage { sequence, columns, rows, pixels: pixels.as_chunks().0, depths: depths.as_chunks().0 })
}

const SYNC: [u8; 2] = [0xa5, 0x5a];
/// Bytes before the first pixel.
pub const HEADER_LEN: usize = 8;
const CRC_LEN: usize = 2;

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::Index;

    use super::*;

    fn column(rgb: [u8; 3], depth_mm: u16) -> Column {
        Column { rgb, depth_mm }
    }

    fn encoded(sequence: u16, columns: &[Column], rows: u16) -> Vec<u8> {
        let expected = encoded_len(columns.len() as u16, rows);
        let mut out = vec![0xaa; expected + 3];
        assert_eq!(encode(sequence, columns.iter().copied(), rows, &mut out), Ok(expected));
        assert_eq!(out[expected..], [0xaa; 3], "nothing is written behind the message");
        out.truncate(expected);
        out
    }

    fn columns() -> impl Strategy<Value = Vec<Column>> {
        vec(any::<([u8; 3], u16)>().prop_map(|(rgb, depth_mm)| column(rgb, depth_mm)), 0..40)
    }

    /// The frame was computed by hand; the CRC is that of crates/wire/frames.py.
    #[test]
    fn a_frame_by_hand() {
        let wire = [
            0xa5, 0x5a, // sync
            0x02, 0x01, 0x02, 0x00, 0x02, 0x00, // sequence 258, 2 columns, 2 rows
            255, 128, 0, 1, 2, 3, // the upper row
            255, 128, 0, 1, 2, 3, // the lower row
            0xe8, 0x03, 0x00, 0x00, // 1000 mm, nothing
            0xd7, 0xaa,
        ];
        let columns = [column([255, 128, 0], 1000), column([1, 2, 3], 0)];
        assert_eq!(encoded(258, &columns, 2), wire);
        let image = parse(&wire).unwrap();
        assert_eq!((image.sequence, image.columns, image.rows), (258, 2, 2));
        assert!(image.columns().eq(columns));
        assert!(image.depths_mm().eq([1000, 0]));
        assert_eq!(image.row(0), Some(&[[255, 128, 0], [1, 2, 3]][..]));
        assert_eq!((image.row(1), image.row(2)), (image.row(0), None));
    }

    #[test]
    fn lengths() {
        assert_eq!(encoded_len(0, 0), 10);
        assert_eq!(encoded_len(64, 1), 8 + 64 * 3 + 64 * 2 + 2);
        assert_eq!(encoded_len(160, 120), 8 + 57_600 + 320 + 2);
        assert_eq!(encoded_len(u16::MAX, u16::MAX) as u64, 12_884_639_755);
    }

    proptest! {
        #[test]
        fn a_frame_arrives_as_it_was_sent(sequence: u16, columns in columns(), rows in 0..9u16) {
            let wire = encoded(sequence, &columns, rows);
            for len in 0..HEADER_LEN {
                prop_assert_eq!(message_len(&wire[..len]), Ok(None));
            }
            prop_assert_eq!(message_len(&wire[..HEADER_LEN]), Ok(Some(wire.len())));
            let image = parse(&wire).unwrap();
            prop_assert_eq!((image.sequence, image.rows), (sequence, rows));
            prop_assert!(image.depths_mm().eq(columns.iter().map(|column| column.depth_mm)));
            let colours: Vec<_> = columns.iter().map(|column| column.rgb).collect();
            for row in 0..rows {
                prop_assert_eq!(image.row(row), Some(&colours[..]));
            }
            prop_assert_eq!(image.row(rows), None);
            let seen = if rows == 0 { vec![] } else { columns };
            prop_assert!(image.columns().eq(seen));
        }

        #[test]
        fn one_altered_byte_is_always_found(
            sequence: u16, columns in columns(), rows in 0..5u16, at: Index, altered: u8,
        ) {
            let mut wire = encoded(sequence, &columns, rows);
            let at = at.index(wire.len());
            prop_assume!(wire[at] != altered);
            wire[at] = altered;
            prop_assert!(parse(&wire).is_err());
        }

        #[test]
        fn a_message_cut_short_or_gone_on_with_is_refused(
            columns in columns(), rows in 0..5u16, extra in 1..20usize,
        ) {
            let mut wire = encoded(0, &columns, rows);
            for len in 0..wire.len() {
                let refused = matches!(parse(&wire[..len]), Err(ParseError::Length { found, .. }) if found == len);
                prop_assert!(refused);
            }
            let expected = wire.len();
            wire.extend(vec![0; extra]);
            prop_assert_eq!(parse(&wire), Err(ParseError::Length { expected, found: expected + extra }));
        }

        #[test]
        fn a_short_buffer_is_refused(columns in columns(), rows in 0..5u16, room: Index) {
            let needed = encoded_len(columns.len() as u16, rows);
            let room = room.index(needed);
            let written = encode(0, columns.iter().copied(), rows, &mut vec![0; room]);
            prop_assert_eq!(written, Err(NoRoom { needed, room }.into()));
        }

        #[test]
        fn any_bytes_do_no_harm(mut bytes in vec(any::<u8>(), 0..100), begins: bool) {
            if begins {
                bytes.splice(..0, SYNC);
            }
            let _ = parse(&bytes);
            let _ = message_len(&bytes);
        }

        #[test]
        fn a_receiver_finds_the_frame_behind_any_garbage(
            garbage in vec(prop_oneof![any::<u8>(), Just(SYNC[0]), Just(SYNC[1])], 0..60), columns in columns(),
        ) {
            let expected = encoded(7, &columns, 1);
            let mut stream = garbage;
            stream.extend(&expected);
            let mut rest = &stream[..];
            let found = loop {
                match message_len(rest) {
                    Err(ParseError::Sync { skip }) => rest = &rest[skip..],
                    Ok(Some(len)) if len == expected.len() && parse(&rest[..len.min(rest.len())]).is_ok() => {
                        break &rest[..len];
                    }
                    Ok(Some(_)) => rest = &rest[1..],
                    other => panic!("{other:?}"),
                }
            };
            prop_assert_eq!(found, &expected[..]);
        }
    }

    #[test]
    fn what_does_not_begin_a_message_is_skipped() {
        let skip = |bytes: &[u8]| message_len(bytes).unwrap_err();
        assert_eq!(skip(&[0]), ParseError::Sync { skip: 1 });
        assert_eq!(skip(&[0xa5, 0xa5, 0x5a]), ParseError::Sync { skip: 1 });
        assert_eq!(skip(&[0, 1, 0xa5]), ParseError::Sync { skip: 2 });
        assert_eq!(skip(&[0, 0xa5, 1, 0x5a]), ParseError::Sync { skip: 4 });
        assert_eq!((message_len(&[]), message_len(&[0xa5])), (Ok(None), Ok(None)));
    }

    #[test]
    fn errors_carry_what_disagrees() {
        assert_eq!(parse(&[]), Err(ParseError::Length { expected: 10, found: 0 }));
        assert_eq!(parse(b"RIFF"), Err(ParseError::Sync { skip: 4 }));
        let mut wire = encoded(0, &[], 0);
        let crc = CRC.checksum(&[0; 6]);
        assert_eq!(wire[8..], crc.to_le_bytes());
        wire[8] ^= 1;
        assert_eq!(parse(&wire), Err(ParseError::Crc { expected: crc, found: crc ^ 1 }));
    }

    #[test]
    fn more_columns_than_the_header_can_say_are_refused() {
        let endless = core::iter::repeat(column([0; 3], 0));
        assert_eq!(encode(0, endless, 1, &mut [0; 99]), Err(EncodeError::Columns { limit: 65_535 }));
    }
}
