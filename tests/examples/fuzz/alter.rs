//! The alterations of inputs.

use crate::chance::Chance;

/// Another input: `input` with some changes, words among them that this format knows, and parts of `other`.
pub(crate) fn altered(input: &[u8], other: &[u8], words: &[&[u8]], chance: &mut Chance) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=chance.below(4) {
        alter(&mut bytes, other, words, chance);
    }
    bytes.truncate(MAX_INPUT);
    bytes
}

fn alter(bytes: &mut Vec<u8>, other: &[u8], words: &[&[u8]], chance: &mut Chance) {
    if bytes.is_empty() {
        bytes.push(chance.next() as u8);
    }
    let at = chance.below(bytes.len());
    // Short parts more often than long ones.
    let longest = 1 << chance.below(8);
    let until = (at + 1 + chance.below(longest)).min(bytes.len());
    match chance.below(10) {
        0..3 => bytes[at] ^= 1 << chance.below(8),
        3 => bytes[at] = *chance.one(&[0, 1, 0x7f, 0x80, 0xfe, 0xff, b'\n', b'"', b'-', b'9']),
        4 => drop(bytes.drain(at..until)),
        5 => {
            let part = bytes[at..until].to_vec();
            let to = chance.below(bytes.len());
            drop(bytes.splice(to..to, part));
        }
        6 if !other.is_empty() => {
            let from = chance.below(other.len());
            let part = &other[from..(from + until - at).min(other.len())];
            drop(bytes.splice(at..until, part.iter().copied()));
        }
        // A number of some bytes, as large as can be or nearly.
        7 => {
            let number =
                *chance.one(&[0, 1, u64::MAX, u64::MAX / 2, 1 << 32, 0xffff_ffff, 0x7fff_ffff, 0xffff]);
            let width = (*chance.one(&[1, 2, 4, 8])).min(bytes.len() - at);
            bytes[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
        }
        8 if !words.is_empty() => {
            let word = *chance.one(words);
            let end = if chance.below(2) == 0 { at } else { until };
            drop(bytes.splice(at..end, word.iter().copied()));
        }
        _ => bytes[at] = chance.next() as u8,
    }
}

/// Longer inputs only take longer.
const MAX_INPUT: usize = 1 << 17;
