//! Conversations in words, and what holds for any bytes.

use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

use proptest::collection::vec as vec_of;
use proptest::prelude::*;

use super::*;
use crate::encoding::Encoding;
use crate::message::Sample;
use crate::{create, frame, line_image, nmea, scip, write_command, write_readings, write_values};

const LAYOUT: Layout<'static> = Layout {
    components: &[
        Encoding::Level { bits: 8, min: 0.0, max: 255.0 },
        Encoding::Counter { bits: 16 },
        Encoding::Counter { bits: 16 },
    ],
    counts: &[1, 2],
    motors: &[Encoding::Signed { bits: 8, limit: 127.0 }, Encoding::Signed { bits: 8, limit: 127.0 }],
    ages: true,
};

const NAMES: [&str; 1] = ["ir_left"];

const FRAMED: Protocol<'static> = Protocol::Framed { layout: Some(LAYOUT) };

/// An item that is kept.
#[derive(Clone, Debug, PartialEq)]
struct Kept {
    direction: Direction,
    from_ns: u64,
    to_ns: u64,
    bytes: Vec<u8>,
    text: String,
    is_understood: bool,
    age_ns: Option<u64>,
}

/// The items of bytes with their directions and instants.
fn items(protocol: Protocol<'_>, heard: impl IntoIterator<Item = Heard>) -> Vec<Kept> {
    let cable = Cable { protocol, names: &NAMES };
    let mut analyser = Analyser::new([vec![0; 4096], vec![0; 4096]]);
    let mut items = Vec::new();
    let mut keep = |item: Item<'_>| {
        let Item { direction, from_ns, to_ns, bytes, text, is_understood, age_ns } = item;
        let (bytes, text) = (bytes.to_vec(), text.to_string());
        items.push(Kept { direction, from_ns, to_ns, bytes, text, is_understood, age_ns });
    };
    heard.into_iter().for_each(|heard| analyser.push(&cable, heard, &mut keep));
    analyser.finish(&mut keep);
    items
}

/// Messages in one direction or the other, a byte a millisecond.
fn talk(said: &[(Direction, &[u8])]) -> Vec<Heard> {
    let bytes = said.iter().flat_map(|(direction, bytes)| bytes.iter().map(|&byte| (*direction, byte)));
    let instants = (0..).map(|i| i * MS);
    instants.zip(bytes).map(|(at_ns, (direction, byte))| Heard { direction, at_ns, byte }).collect()
}

fn texts(protocol: Protocol<'_>, said: &[(Direction, &[u8])]) -> Vec<String> {
    items(protocol, talk(said)).into_iter().map(|item| item.text).collect()
}

const MS: u64 = 1_000_000;

use Direction::{Down, Up};

#[test]
fn frames_are_told_with_names_values_and_ages() {
    let fresh = |sensor| match sensor {
        0 => Some(Sample { age_100us: 5, values: &[17.0] }),
        1 => Some(Sample { age_100us: 20, values: &[-2.0, 700.0] }),
        _ => None,
    };
    let mut payload = [0; frame::MAX_PAYLOAD];
    let len = write_readings(&LAYOUT, 12, 30, fresh, &mut payload).unwrap();
    let mut readings = [0; frame::MAX_FRAME];
    let readings_len = frame::encode(&payload[..len], &mut readings).unwrap();
    let len = write_command(&LAYOUT, 3, [100.0, -100.0], &mut payload).unwrap();
    let mut command = [0; frame::MAX_FRAME];
    let command_len = frame::encode(&payload[..len], &mut command).unwrap();
    let said = [(Up, &readings[..readings_len]), (Down, &command[..command_len])];
    let found = items(FRAMED, talk(&said));
    let expected =
        "readings #12, closed at 3 ms: ir_left 17 (0.5 ms old), sensor 1 -2 700 (2 ms old)".to_string();
    assert_eq!((&found[0].text, found[0].age_ns), (&expected, Some((readings_len as u64 - 1 - 3 + 2) * MS)));
    assert_eq!(found[1].text, "command #3: left 100, right -100");
    let without = texts(Protocol::Framed { layout: None }, &said);
    assert_eq!(without, ["readings #12, closed at 3 ms, 12 bytes", "command #3, 4 bytes"]);
    readings[3] ^= 1;
    let damaged = items(FRAMED, talk(&[(Up, &readings[..readings_len]), (Up, &[0])]));
    assert!(!damaged[0].is_understood && damaged[0].text.contains("CRC is"), "{damaged:?}");
    assert_eq!(damaged[1].text, "delimiter without a frame");
}

#[test]
fn bare_messages_are_told_by_their_length_and_cut_off_by_silence() {
    let protocol = Protocol::Bare { layout: LAYOUT, gap_ns: 2 * MS };
    let mut bytes = [0; 5];
    write_values(LAYOUT.components, [17.0, -2.0, 700.0], &mut bytes).unwrap();
    let mut heard = talk(&[(Up, &bytes), (Down, &[100, 156]), (Up, &bytes[..3])]);
    let at_ns = 20 * MS;
    heard.push(Heard { direction: Up, at_ns, byte: 17 });
    let found = items(protocol, heard);
    let texts: Vec<_> = found.iter().map(|item| item.text.as_str()).collect();
    let expected = [
        "readings: ir_left 17, sensor 1 -2 700",
        "command: left 100, right -100",
        "not understood (cut off by silence): 11 fe ff",
        "not understood (the beginning of a message): 11",
    ];
    assert_eq!(texts, expected);
    assert_eq!((found[2].from_ns, found[2].to_ns, found[3].from_ns), (7 * MS, 9 * MS, at_ns));
}

#[test]
fn a_kheperas_lines_are_in_the_words_of_its_manual() {
    let down = |line: &[u8]| texts(Protocol::Khepera, &[(Down, line)]).remove(0);
    for (line, text) in [
        (&b"N\r"[..], "N: ask proximity"),
        (b"D,5,-5\r", "D,5,-5: set speed 5 -5"),
        (b"A,3800,800,100\n", "A,3800,800,100: set speed PID Kp 3800 Ki 800 Kd 100"),
        (b"B\r", "B: ask software version"),
        (b"C,10,20\r", "C,10,20: go to position 10 20"),
        (b"E\r", "E: ask speed"),
        (b"F,1,2,3\r", "F,1,2,3: set position PID Kp 1 Ki 2 Kd 3"),
        (b"G,0,0\r", "G,0,0: set position counters 0 0"),
        (b"H\r", "H: ask position"),
        (b"I,3\r", "I,3: ask analog input 3"),
        (
            b"J,20,64,20,64\r",
            "J,20,64,20,64: set speed profile left speed 20 acceleration 64 right speed 20 acceleration 64",
        ),
        (b"K\r", "K: ask status of motion"),
        (b"L,0,1\r", "L,0,1: set LED 0 action 1"),
        (b"O\r", "O: ask ambient light"),
        (b"P,10,10\r", "P,10,10: set pulse width 10 10"),
        (b"R,5\r", "R,5: read extension bus address 5"),
        (b"T,1,B\r", "T,1,B: to turret 1 B"),
        (b"W,7,5\r", "W,7,5: write extension bus byte 7 address 5"),
        (b"\n", "end of line"),
        (b"D,5\r", "D,5: set speed 5 (not understood: 2 whole numbers belong there)"),
        (b"Q\r", "not understood (no command): 51 0d; Q"),
    ] {
        assert_eq!(down(line), text);
    }
    let up = |line: &[u8]| texts(Protocol::Khepera, &[(Up, line)]).remove(0);
    for (line, text) in [
        (&b"n,12,0,7\r\n"[..], "n: proximity 12 0 7"),
        (b"d\r\n", "d: speed set"),
        (b"h,100,-4\r\n", "h: position 100 -4"),
        (b"b,5.02,5.01\r\n", "b: software version 5.02 5.01"),
        (b"z,Protocol error\r\n", "z: refused, protocol error"),
        (b"Command not found\r\n", "refused, command not found"),
        (b"n,12,x\r\n", "n: proximity 12 x (not understood: no whole numbers)"),
    ] {
        assert_eq!(up(line), text);
    }
}

#[test]
fn an_e_pucks_letters_are_told_in_text_and_in_bytes() {
    let minus = u8::wrapping_neg;
    let said: [(Direction, &[u8]); 12] = [
        (Down, b"D,100,-100\r"),
        (Up, b"d\r\n"),
        (Down, b"n\r\n"),
        (Up, b"n,1,2,3,4,5,6,7,8\r\n"),
        (Down, b"b\rX\r"),
        (Up, b"b,1\r\nz,Command not found\r\n"),
        (Down, &[minus(b'D'), 0, 1, 0x9c, 0xff, minus(b'L'), 8, 1, 0]),
        (Down, &[minus(b'Q'), minus(b't'), minus(b'A'), 0]),
        (Up, &[10, 13, 0xec, 0xff, 25, 0, 0, 0x40, 0x44, 0, 0, 0, 0, 0, 0, 0, 0]),
        (Down, &[minus(b'Z'), 0, 0]),
        (Down, b"V\r"),
        (Up, b"v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n"),
    ];
    let expected = [
        "D,100,-100: set speeds",
        "d: set speeds",
        "n: proximity",
        "end of line",
        "n: proximity 1 2 3 4 5 6 7 8",
        "b: battery",
        "not understood (no command): 58 0d; X",
        "b: battery 1",
        "z: refused, command not found",
        "in bytes; D: set speeds 256 -100; L: LED 8 1",
        "in bytes; Q: steps; t: temperature; A: acceleration",
        "answer; steps 3338 -20; temperature 25; acceleration 768 0 0",
        "in bytes; not understood: a6",
        "end of letters",
        "V: version",
        "v: version Version 1.2.2 August 2008 GCtronic",
        "HW version: FFFF",
    ];
    assert_eq!(texts(Protocol::Asercom, &said), expected);
}

#[test]
fn a_line_that_is_typed_slowly_is_one_item() {
    let slowly =
        b"N\r".iter().zip([0, 5_000 * MS]).map(|(&byte, at_ns)| Heard { direction: Down, at_ns, byte });
    assert_eq!(items(Protocol::Khepera, slowly).len(), 1);
}

#[test]
fn a_creates_answers_mean_what_was_asked() {
    let two = Protocol::Create(Version::Two);
    let said: [(Direction, &[u8]); 6] = [
        (Down, &[128, 131, 142, 22, 149, 2, 7, 20]),
        (Up, &[0x3a, 0x98]),
        (Up, &[3, 0xff, 0xfe]),
        (Down, &[137, 0, 200, 0x80, 0, 137, 0, 200, 1, 0xf4, 145, 0, 100, 0xff, 0x9c]),
        (Down, &[148, 2, 29, 13]),
        (Up, &[19, 5, 29, 2, 25, 13, 0, 163]),
    ];
    let expected = [
        "start",
        "safe mode",
        "sensors: voltage",
        "query list: 2 packets: bumps wheel drops, angle",
        "answer; voltage 15000",
        "answer; bumps wheel drops 3; angle -2",
        "drive 200 mm/s straight",
        "drive 200 mm/s, radius 500 mm",
        "drive direct: right 100 mm/s, left -100 mm/s",
        "stream: 2 packets: cliff front left signal, virtual wall",
        "stream, checksum right; cliff front left signal 537; virtual wall 0",
    ];
    assert_eq!(texts(two, &said), expected);
    let broken = items(two, talk(&[said[4], (Up, &[7, 19, 5, 29, 2, 25, 13, 1, 163])]));
    assert_eq!(broken[1].text, "not understood: 07");
    assert!(broken[2].text.starts_with("stream, checksum wrong") && !broken[2].is_understood);
}

#[test]
fn a_question_that_is_not_answered_is_forgotten() {
    let two = Protocol::Create(Version::Two);
    let mut heard = talk(&[(Down, &[142, 22])]);
    let later = PATIENCE_NS + 10 * MS;
    heard.extend([142, 7].map(|byte| Heard { direction: Down, at_ns: later, byte }));
    heard.push(Heard { direction: Up, at_ns: later + MS, byte: 2 });
    assert_eq!(items(two, heard).pop().unwrap().text, "answer; bumps wheel drops 2");
}

#[test]
fn a_group_is_told_packet_by_packet_and_text_as_text() {
    let one = Protocol::Create(Version::One);
    let said: [(Direction, &[u8]); 4] =
        [(Up, b"bl-start\r\n"), (Down, &[142, 2]), (Up, &[0xff, 0, 0, 10, 0, 0]), (Down, &[164])];
    let expected = [
        "text: bl-start",
        "sensors: group 2",
        "answer; group 2; infrared omni 255; buttons 0; distance 10; angle 0",
        "not understood (no command of this robot): a4",
    ];
    assert_eq!(texts(one, &said), expected);
}

#[test]
fn every_command_of_both_creates_has_a_meaning() {
    for (version, opcodes) in [
        (Version::One, &[128..=132, 134..=145, 147..=158][..]),
        (Version::Two, &[7..=7, 128..=146, 148..=150, 162..=165, 167..=168, 173..=173]),
    ] {
        for opcode in opcodes.iter().cloned().flatten() {
            // Behind it enough zeros for any command; what is left of them is no command.
            let found =
                items(Protocol::Create(version), talk(&[(Down, &[&[opcode][..], &[0; 16]].concat())]));
            assert!(found[0].is_understood, "{version:?} {opcode}: {:?}", found[0]);
        }
    }
}

#[test]
fn a_range_finders_commands_and_scans_are_told() {
    let format =
        scip::Format { characters: scip::Characters::Three, first_step: 44, last_step: 725, cluster: 1 };
    let mut scan = vec![0; format.message_len()];
    let ranges = core::iter::repeat_n(1000, format.points());
    scip::encode(&format, 20, ranges, &mut scan).unwrap();
    let said: [(Direction, &[u8]); 7] = [
        (Down, b"BM\nGD0044072501\rMD0044072501000\nSS115200\nTM1;hi\n"),
        (Up, b"BM\n02R\n\n"),
        (Up, &scan),
        (Down, b"GD00\n"),
        (Down, b"XX\n"),
        (Up, b"GD0044072501\n10Q\n\n"),
        (Up, b"VV\n00P\nPROT:SCIP 2.0;N\nPROT:SCIP 2.0;x\n\n"),
    ];
    let found = items(Protocol::Scip, talk(&said));
    let texts: Vec<_> = found.iter().map(|item| item.text.as_str()).collect();
    let expected = [
        "BM: laser on",
        "GD0044072501: distances of steps 44 to 725",
        "MD0044072501000: measure distances of steps 44 to 725, without an end",
        "SS115200: bit rate 115200",
        "TM1;hi: time mode ask time",
        "BM: status 02 (laser was on)",
        "MD0044072501000: status 99 (scan) of steps 44 to 725, without an end, time 20 ms, 682 distances, checksums right",
        "GD00: distances (not understood: other parameters belong there)",
        "not understood (no command): 58 58 0a; XX",
        "GD0044072501: status 10 (laser off) of steps 44 to 725",
        "VV: status 00 (accepted); PROT:SCIP 2.0; PROT:SCIP 2.0 (checksum wrong)",
    ];
    assert_eq!(texts, expected);
    assert_eq!(found[6].age_ns, Some(found[6].to_ns - 20 * MS));
    scan[30] ^= 1;
    let damaged = items(Protocol::Scip, talk(&[(Up, &scan)])).remove(0);
    assert!(damaged.text.ends_with("checksum wrong of 1 line") && !damaged.is_understood, "{damaged:?}");
}

#[test]
fn sentences_are_told_with_their_positions() {
    let fix = nmea::Fix {
        time_utc_ms: 5,
        date: (1, 1, 16),
        valid: true,
        latitude_deg: 57.7,
        longitude_deg: -11.97,
        speed_m_s: 0.5,
        course_deg: 300.0,
        altitude_m: 12.5,
        satellites: 12,
        hdop: 1.0,
        pdop_vdop: None,
    };
    let mut line = [0; nmea::MAX_SENTENCE];
    let len = nmea::write_rmc(&fix, &mut line).unwrap();
    let rmc = line[..len].to_vec();
    let len = nmea::write_gga(&fix, &mut line).unwrap();
    let gga = line[..len].to_vec();
    let len = nmea::write_gsa(&fix, &[], &mut line).unwrap();
    let gsa = line[..len].to_vec();
    let found = items(Protocol::Nmea, talk(&[(Up, &rmc), (Up, &gga), (Up, &gsa), (Up, b"$GP*00\r\n")]));
    let texts: Vec<_> = found.iter().map(|item| item.text.as_str()).collect();
    let expected = [
        "RMC 00:00:00.005, 57.700000° N 11.970000° W, 0.499 m/s, course 300°",
        "GGA 00:00:00.005, 57.700000° N 11.970000° W, quality 1, satellites 12, altitude 12.5 m",
        "GSA: satellites in use and dilution of precision,A,3,,,,,,,,,,,,,,1.00,",
    ];
    assert_eq!(texts[..3], expected);
    assert_eq!(found[0].age_ns, Some((rmc.len() as u64 - 1 - 5) * MS));
    assert!(texts[3].contains("checksum is 0x00"), "{texts:?}");
}

#[test]
fn images_are_found_among_other_bytes() {
    let columns = [([255, 0, 51], 1500), ([0, 102, 255], 0)];
    let columns = columns.map(|(rgb, depth_mm)| line_image::Column { rgb, depth_mm });
    let mut image = vec![0; line_image::encoded_len(2, 3)];
    line_image::encode(7, columns.into_iter(), 3, &mut image).unwrap();
    let found = texts(Protocol::LineImage, &[(Up, b"no"), (Up, &image)]);
    assert_eq!(
        found,
        ["not understood: 6e 6f", "image #7: 2 columns, 3 rows, nearest at 1500 mm, CRC right"]
    );
    image[9] ^= 1;
    assert!(texts(Protocol::LineImage, &[(Up, &image)])[0].contains("damaged image"));
}

fn protocols() -> impl Strategy<Value = Protocol<'static>> {
    prop_oneof![
        Just(FRAMED),
        Just(Protocol::Framed { layout: None }),
        Just(Protocol::Bare { layout: LAYOUT, gap_ns: 3 * MS }),
        Just(Protocol::Asercom),
        Just(Protocol::Khepera),
        Just(Protocol::Create(Version::One)),
        Just(Protocol::Create(Version::Two)),
        Just(Protocol::Scip),
        Just(Protocol::Nmea),
        Just(Protocol::LineImage),
    ]
}

/// Any bytes, and those that protocols are made of.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        vec_of(any::<u8>(), 1..8),
        Just(b"\r\n".to_vec()),
        Just(b"\n\n".to_vec()),
        Just(b"D,5,5".to_vec()),
        Just(b"MD0044072501000\n99b\n".to_vec()),
        Just(b"$GPRMC,".to_vec()),
        Just(vec![0xa5, 0x5a, 0, 0, 1, 0, 1, 0]),
        Just(vec![148, 2, 29, 13]),
        Just(vec![142, 100, 149, 2, 7, 8]),
        Just(vec![19, 5, 29, 2, 25, 13, 0, 163]),
        Just(vec![0]),
    ];
    vec_of(part, 0..40).prop_map(|parts| parts.concat())
}

proptest! {
    #[test]
    fn every_byte_is_in_one_item_of_its_direction(
        protocol in protocols(),
        up in bytes(),
        down in bytes(),
        pauses in vec_of(prop_oneof![Just(0), 0..4 * MS, Just(20_000 * MS)], 0..1200),
        room in 1..64_usize,
    ) {
        let cable = Cable { protocol, names: &NAMES };
        let mut analyser = Analyser::new([vec![0; room], vec![0; 2 * room]]);
        let mut told = [Vec::new(), Vec::new()];
        let mut last_ns = [0; 2];
        let mut problem = None;
        let mut keep = |item: Item<'_>| {
            let side = usize::from(item.direction == Down);
            told[side].extend_from_slice(item.bytes);
            let in_order = last_ns[side] <= item.from_ns && item.from_ns <= item.to_ns;
            last_ns[side] = item.to_ns;
            if item.bytes.is_empty() || item.text.is_empty() || item.text.len() > MAX_TEXT || !in_order {
                problem = Some(std::format!("{item:?}"));
            }
        };
        let (mut at_ns, mut pauses) = (0, pauses.into_iter());
        let most = up.len().max(down.len());
        for i in 0..most {
            at_ns += pauses.next().unwrap_or(MS);
            for (direction, bytes) in [(Down, &down), (Up, &up)] {
                if let Some(&byte) = bytes.get(i) {
                    analyser.push(&cable, Heard { direction, at_ns, byte }, &mut keep);
                }
            }
        }
        analyser.wait(&cable, at_ns, &mut keep);
        analyser.finish(&mut keep);
        prop_assert_eq!(problem, None);
        prop_assert_eq!(told, [up, down]);
    }

    #[test]
    fn frames_are_understood_behind_any_bytes_and_a_delimiter(
        noise in vec_of(any::<u8>(), 0..100), signals in prop::array::uniform2(-127.0..127.0),
    ) {
        let mut payload = [0; frame::MAX_PAYLOAD];
        let len = write_command(&LAYOUT, 3, signals, &mut payload).unwrap();
        let mut command = [0; frame::MAX_FRAME];
        let len = frame::encode(&payload[..len], &mut command).unwrap();
        let said: [(Direction, &[u8]); 3] = [(Down, &noise), (Down, &[0]), (Down, &command[..len])];
        let last = items(FRAMED, talk(&said)).pop().unwrap();
        prop_assert!(last.is_understood && last.text.starts_with("command #3: left "), "{:?}", last);
    }

    #[test]
    fn a_stream_is_understood_behind_any_bytes(noise in vec_of(any::<u8>(), 0..100)) {
        let version = Version::Two;
        let mut message = [0; 16];
        let len = create::write_stream(version, &[29, 13], |_| 7, &mut message);
        let repeated = message[..len].repeat(3);
        let said: [(Direction, &[u8]); 3] = [(Down, &[148, 2, 29, 13]), (Up, &noise), (Up, &repeated)];
        let found = items(Protocol::Create(version), talk(&said));
        prop_assert!(found.iter().any(|item| item.text.starts_with("stream, checksum right")), "{:?}", found);
    }
}
