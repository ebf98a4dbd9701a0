use std::vec;
use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::*;
use crate::error::NoRoom;

const fn format(characters: Characters, first_step: u16, last_step: u16, cluster: u8) -> Format {
    Format { characters, first_step, last_step, cluster }
}

fn encoded(format: &Format, time_ms: u32, ranges_mm: &[u32]) -> Vec<u8> {
    let mut out = vec![0xaa; format.message_len() + 3];
    let len = encode(format, time_ms, ranges_mm.iter().copied(), &mut out).unwrap();
    assert_eq!(len, format.message_len());
    assert_eq!(out[len..], [0xaa; 3], "nothing is written behind the message");
    out.truncate(len);
    out
}

/// A format of up to 400 points and that many values.
fn scan() -> impl Strategy<Value = (Format, Vec<u32>)> {
    let characters = prop_oneof![Just(Characters::Two), Just(Characters::Three)];
    (characters, 0..9600u16, 0..400u16, 0..=99u8)
        .prop_map(|(characters, first, span, cluster)| format(characters, first, first + span, cluster))
        .prop_flat_map(|format| {
            (Just(format), vec(0..=format.characters.top_mm(), format.points()..=format.points()))
        })
}

/// By hand. 1234 = 010011 010010: 0x30 + 19, 0x30 + 18 are `CB`. 5000 is more than 12 bits hold: 63, 63 are `oo`.
/// 16,000,000 = 111101 000010 010000 000000 is `m2@0`. Checksums: `99` 114 mod 64 = 50, `b`; `m2@0`
/// 271 mod 64 = 15, `?`; `CBoo` 355 mod 64 = 35, `S`.
#[test]
fn a_scan_of_two_characters_by_hand() {
    let two = format(Characters::Two, 44, 45, 0);
    let wire = b"MS0044004500000\n99b\nm2@0?\nCBooS\n\n";
    assert_eq!(encoded(&two, 16_000_000, &[1234, 5000]), wire);
    let scan = parse(wire).unwrap();
    assert_eq!((scan.time_ms, scan.format, scan.interval, scan.remaining), (16_000_000, two, 0, 0));
    assert!(scan.values().eq([1234, 4095]));
}

/// By hand. 5432 = 000001 010100 111000 is `1Dh`, sum 49 + 68 + 104 = 221 mod 64 = 29, `M`; 19 is `00C`, sum
/// with it 221 + 48 + 48 + 67 = 384 mod 64 = 0, `0`. Time 1 is `0001`, sum 193 mod 64 = 1, `1`.
#[test]
fn a_scan_of_three_characters_by_hand() {
    let wire = b"MD0100010301207\n99b\n00011\n1DhM\n\n";
    let error = ParseError::Length { expected: 41, found: 32 };
    assert_eq!(parse(wire), Err(error), "4 steps in clusters of 1 are 4 values");
    let wire = b"MD0100010302305\n99b\n00011\n1Dh00C0\n\n";
    let scan = parse(wire).unwrap();
    assert_eq!(scan.format, format(Characters::Three, 100, 103, 2));
    assert_eq!((scan.time_ms, scan.interval, scan.remaining), (1, 3, 5));
    assert!(scan.values().eq([5432, 19]));
    assert!(scan.ranges_mm().eq([Some(5432), None]));
}

/// By hand: 63 times `0` and `1` are 3073 mod 64 = 1, `1`; `Dh` 172 mod 64 = 44, a backslash.
#[test]
fn a_value_is_cut_where_a_block_is_full() {
    let format = format(Characters::Three, 0, 21, 1);
    let mut ranges = [0; 22];
    ranges[21] = 5432;
    let wire = encoded(&format, 0, &ranges);
    assert_eq!(wire[HEAD_LEN + 63..], *b"11\nDh\\\n\n");
    assert!(parse(&wire).unwrap().values().eq(ranges));
}

#[test]
fn messages_have_the_length_of_the_real_ones() {
    let len = |characters, points: u16, cluster| {
        let format = format(characters, 44, 43 + points, cluster);
        (format.points(), format.message_len())
    };
    assert_eq!(len(Characters::Three, 682, 0), (682, 2137));
    assert_eq!(len(Characters::Three, 682, 1), (682, 2137));
    assert_eq!(len(Characters::Two, 682, 1), (682, 1435));
    assert_eq!(len(Characters::Three, 682, 2), (341, 1082));
    assert_eq!(len(Characters::Three, 683, 1), (683, 2142));
    assert_eq!(len(Characters::Three, 726, 1), (726, 2275));
    assert_eq!(len(Characters::Two, 32, 1), (32, 27 + 64 + 2));
    assert_eq!(len(Characters::Two, 33, 1), (33, 27 + 64 + 2 + 2 + 2));
    assert_eq!(format(Characters::Two, 9, 8, 1).points(), 0);
    assert_eq!(format(Characters::Two, 0, u16::MAX, 0).points(), 65_536);
}

#[test]
fn too_large_a_value_saturates() {
    for characters in [Characters::Two, Characters::Three] {
        let wire = encoded(&format(characters, 0, 1, 1), u32::MAX, &[u32::MAX, characters.top_mm()]);
        let scan = parse(&wire).unwrap();
        assert!(scan.values().eq([characters.top_mm(); 2]));
        assert_eq!(scan.time_ms, 0x00ff_ffff);
    }
}

proptest! {
    #[test]
    fn a_scan_arrives_as_it_was_sent((format, ranges) in scan(), time_ms: u32) {
        let wire = encoded(&format, time_ms, &ranges);
        prop_assert_eq!(message_end(&wire), Some(wire.len()));
        let scan = parse(&wire).unwrap();
        prop_assert_eq!((scan.time_ms, scan.format), (time_ms & 0x00ff_ffff, format));
        prop_assert_eq!(scan.values().len(), ranges.len());
        prop_assert!(scan.values().eq(ranges.iter().copied()));
        prop_assert!(scan.ranges_mm().eq(ranges.iter().map(|&value| (value >= 20).then_some(value))));
    }

    #[test]
    fn one_altered_byte_behind_the_echo_is_always_found(
        (format, ranges) in scan(), at: Index, altered: u8,
    ) {
        let mut wire = encoded(&format, 0, &ranges);
        let at = ECHO_LEN + at.index(wire.len() - ECHO_LEN);
        prop_assume!(wire[at] != altered);
        wire[at] = altered;
        prop_assert!(parse(&wire).is_err());
    }

    #[test]
    fn one_altered_byte_of_the_echo_is_found_or_shown(
        (format, ranges) in scan(), at in 0..ECHO_LEN, altered in prop_oneof![any::<u8>(), b'0'..=b'9'],
    ) {
        let mut wire = encoded(&format, 0, &ranges);
        prop_assume!(wire[at] != altered);
        wire[at] = altered;
        if let Ok(scan) = parse(&wire) {
            prop_assert_ne!((scan.format, scan.interval, scan.remaining), (format, 0, 0));
        }
    }

    #[test]
    fn a_message_cut_short_or_gone_on_with_is_refused((format, ranges) in scan(), extra in 1..20usize) {
        let mut wire = encoded(&format, 0, &ranges);
        for len in 0..wire.len() {
            prop_assert!(parse(&wire[..len]).is_err());
            prop_assert_eq!(message_end(&wire[..len]), None);
        }
        let expected = wire.len();
        wire.extend(vec![b'\n'; extra]);
        prop_assert_eq!(parse(&wire), Err(ParseError::Length { expected, found: expected + extra }));
        prop_assert_eq!(message_end(&wire), Some(expected));
    }

    #[test]
    fn any_bytes_do_no_harm(bytes in vec(any::<u8>(), 0..100)) {
        let _ = parse(&bytes);
        let _ = message_end(&bytes);
    }

    #[test]
    fn altered_scans_do_no_harm(
        (format, ranges) in scan(), edits in vec((any::<Index>(), any::<u8>()), 0..5), cut: Index,
    ) {
        let mut wire = encoded(&format, 0, &ranges);
        for (at, altered) in edits {
            let at = at.index(wire.len());
            wire[at] = altered;
        }
        if let Ok(scan) = parse(&wire) {
            prop_assert_eq!(scan.values().count(), scan.format.points());
        }
        let _ = parse(&wire[..cut.index(wire.len())]);
    }

    #[test]
    fn a_short_buffer_and_a_wrong_number_of_ranges_are_refused((format, ranges) in scan(), room: Index) {
        let (needed, expected) = (format.message_len(), ranges.len());
        let mut out = vec![0; needed];
        let room = room.index(needed);
        let short = encode(&format, 0, ranges.iter().copied(), &mut out[..room]);
        prop_assert_eq!(short, Err(NoRoom { needed, room }.into()));
        let few = encode(&format, 0, ranges.iter().copied().skip(1), &mut out);
        prop_assert_eq!(few, Err(EncodeError::Count { expected, found: expected - 1 }));
        let many = encode(&format, 0, core::iter::repeat(0), &mut out);
        prop_assert_eq!(many, Err(EncodeError::Count { expected, found: expected + 1 }));
    }
}

#[test]
fn the_checksum_does_not_find_these() {
    let wire = encoded(&format(Characters::Two, 0, 1, 1), 0, &[1234, 2345]);
    let mut swapped = wire.clone();
    swapped.swap(HEAD_LEN, HEAD_LEN + 1);
    assert!(parse(&swapped).is_ok());
    let mut cancelling = wire;
    cancelling[HEAD_LEN] += 1;
    cancelling[HEAD_LEN + 1] -= 1;
    assert!(parse(&cancelling).is_ok());
}

#[test]
fn formats_that_the_echo_cannot_say_are_refused() {
    let refused = |format: Format| encode(&format, 0, core::iter::repeat(0), &mut [0; 99]).unwrap_err();
    let two = Characters::Two;
    assert_eq!(refused(format(two, 5, 4, 1)), FormatError::Steps { first: 5, last: 4 }.into());
    assert_eq!(refused(format(two, 5, 10_000, 1)), FormatError::Steps { first: 5, last: 10_000 }.into());
    assert_eq!(refused(format(two, 5, 6, 100)), FormatError::Cluster { found: 100 }.into());
}

#[test]
fn errors_carry_what_disagrees() {
    let parse = |text: &'static str| parse(text.as_bytes()).unwrap_err();
    let byte = |at, expected, found| ParseError::Byte { at, expected, found };
    assert_eq!(parse(""), ParseError::Length { expected: 26, found: 0 });
    assert_eq!(parse("MS00"), ParseError::Length { expected: 26, found: 4 });
    assert_eq!(parse("QT"), byte(0, "M", b'Q'));
    assert_eq!(parse("MX"), byte(1, "D or S", b'X'));
    assert_eq!(parse("MS00x"), byte(4, "a digit", b'x'));
    assert_eq!(parse("MS0044004500000?"), byte(15, "a line feed", b'?'));
    assert_eq!(parse("MS0045004400000\n"), FormatError::Steps { first: 45, last: 44 }.into());
    assert_eq!(parse("MS0044004500000\n00P\n\n"), ParseError::Status { found: *b"00" });
    assert_eq!(parse("MS0044004500000\n99c\n"), ParseError::Checksum { at: 18, expected: b'b', found: b'c' });
    assert_eq!(parse("MS0044004500000\n99b\nm2@0?\nCB o!\n\n"), byte(28, "a character from 0 to o", b' '));
    let text = std::format!("{}", ParseError::Status { found: *b"0A" });
    assert_eq!(text, "the status is 0A, not 99 as of a scan");
}

/// 40 values of two characters are a block of 64 characters from byte 26 on, and one of 16 from byte 26 + 64 + 2 on.
#[test]
fn an_error_in_a_later_block_says_at_which_byte_of_the_message_it_is() {
    let mut wire = encoded(&format(Characters::Two, 44, 83, 1), 0, &[1234; 40]);
    assert!(parse(&wire).is_ok());
    wire[92 + 3] = b' ';
    let error = ParseError::Byte { at: 95, expected: "a character from 0 to o", found: b' ' };
    assert_eq!(parse(&wire), Err(error));
}

#[test]
fn the_end_of_a_message_is_found_in_a_stream() {
    let stream = b"h0\n\nMS0044004500000\n99b\nm2@0?\nCBooS\n\nMS00";
    let first = message_end(stream).unwrap();
    let second = message_end(&stream[first..]).unwrap();
    assert!(parse(&stream[first..first + second]).is_ok());
    assert_eq!(message_end(&stream[first + second..]), None);
}
