//! The contents of a chunk, unpacked and compared with its checksum.

#[cfg(feature = "lz4")]
use std::io::Read;

use super::record::{Chunk, HEAD, Record, head, parse};
use crate::error::Packing;

/// The reason why nothing of a chunk is used.
pub(super) enum Unusable {
    /// The chunk differs from what was written.
    Damaged,
    /// The chunk is packed in a way of MCAP's that is not read here.
    Packed(Packing),
}

/// Unpacks a chunk's records. Memory grows with what comes out, whatever length the chunk claims.
pub(super) fn unpack(chunk: &Chunk<'_>, out: &mut Vec<u8>) -> Result<(), Unusable> {
    out.clear();
    let packed = chunk.data.len() as u64;
    let most = match chunk.compression {
        b"" => packed,
        b"lz4" => packed.saturating_mul(MOST_OF_A_BYTE),
        b"zstd" => return Err(Unusable::Packed(Packing::Zstd)),
        _ => return Err(Unusable::Damaged),
    };
    if chunk.size > most {
        return Err(Unusable::Damaged);
    }
    if chunk.compression.is_empty() {
        out.extend(chunk.data);
    } else {
        unpack_lz4(chunk, out)?;
    }
    let is_it = out.len() as u64 == chunk.size
        && (chunk.checksum == 0 || chunk.checksum == crc32fast::hash(out))
        && is_sound(out);
    if is_it { Ok(()) } else { Err(Unusable::Damaged) }
}

#[cfg(feature = "lz4")]
fn unpack_lz4(chunk: &Chunk<'_>, out: &mut Vec<u8>) -> Result<(), Unusable> {
    // One frame: of frames in which nothing is, a file could have one every few bytes, and each costs a decoder.
    let frame = lz4::Decoder::new(chunk.data).map_err(|_| Unusable::Damaged)?;
    frame.take(chunk.size).read_to_end(out).map_err(|_| Unusable::Damaged)?;
    Ok(())
}

#[cfg(not(feature = "lz4"))]
fn unpack_lz4(_: &Chunk<'_>, _: &mut Vec<u8>) -> Result<(), Unusable> {
    Err(Unusable::Packed(Packing::Lz4))
}

/// The record that begins at this place of a chunk, and where the next one does.
pub(super) fn record(chunk: &[u8], at: usize) -> Option<(Record<'_>, usize)> {
    let bytes = chunk.get(at..)?;
    let (kind, length) = head(bytes)?;
    let body = bytes[HEAD..].get(..usize::try_from(length).ok()?)?;
    Some((parse(kind, body)?, at + HEAD + body.len()))
}

/// Whether it is records one after the other, such as may be in a chunk.
fn is_sound(chunk: &[u8]) -> bool {
    let mut at = 0;
    while at < chunk.len() {
        at = match record(chunk, at) {
            Some((Record::Channel { .. } | Record::Message { .. } | Record::Other, next)) => next,
            Some((
                Record::Chunk(_) | Record::DataEnd { .. } | Record::Footer { .. } | Record::Statistics(_),
                _,
            ))
            | None => return false,
        };
    }
    true
}

/// No byte of LZ4 stands for more bytes than that.
const MOST_OF_A_BYTE: u64 = 255;
