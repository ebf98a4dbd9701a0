//! Bytes on a wire: each protocol's decoder and parser, as they come and with a sound frame around them.

use std::num::NonZeroU32;

use baudbot_wire::meaning::{Analyser, Cable, Direction, Heard, Item, Protocol};
use baudbot_wire::{
    BareDecoder, Decoder, Encoding, Layout, Message, Values, asercom, create, frame, khepera, line_image,
    nmea, scip,
};

use super::{Target, outcome};

const LAYOUT: Layout<'static> = Layout {
    components: &[
        Encoding::Level { bits: 8, min: 0.0, max: 255.0 },
        Encoding::Level { bits: 12, min: 0.0, max: 5.0 },
        Encoding::Counter { bits: 16 },
        Encoding::Counter { bits: 16 },
        Encoding::Float64,
    ],
    counts: &[1, 1, 2, 1],
    motors: &[Encoding::Signed { bits: 8, limit: 1.0 }, Encoding::Float64],
    ages: true,
};

/// The layout of a Khepera: its lines have whole numbers only.
const LINES: Layout<'static> = Layout {
    components: &[Encoding::Level { bits: 10, min: 0.0, max: 1023.0 }, Encoding::Counter { bits: 16 }],
    counts: &[1, 1],
    motors: &[Encoding::Signed { bits: 8, limit: 1.0 }, Encoding::Signed { bits: 8, limit: 1.0 }],
    ages: false,
};

/// The protocols.
pub(super) const NAMES: [&str; 10] =
    ["frames", "framed", "bare", "khepera", "create", "scip-device", "scip", "nmea", "line-image", "meaning"];

pub(super) fn targets() -> Vec<Target> {
    let (mut payload, mut framed) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
    let fresh = |_: usize| None;
    let n = baudbot_wire::write_readings(&LAYOUT, 3, 400, fresh, &mut payload).unwrap_or(0);
    let readings = payload[..n].to_vec();
    let n = baudbot_wire::message::write_command(&LAYOUT, 3, [0.5, -0.5], &mut payload).unwrap_or(0);
    let command = payload[..n].to_vec();
    let n = frame::encode(&command, &mut framed).unwrap_or(0);
    let frames = vec![framed[..n].to_vec(), framed[..n].repeat(3)];
    vec![
        target("frames", "COBS frames with a CRC", frames, &[b"\x00", b"\xff"], frames_of),
        target("framed", "messages in frames", vec![readings, command.clone()], &[], message),
        target("bare", "the notes' bare bytes", vec![vec![7; 24]], &[], bare),
        target(
            "khepera",
            "a Khepera's lines",
            vec![
                b"D,5,-5\r\nN\r\n".to_vec(),
                b"n,12,400\r\n".to_vec(),
                b"C,900,-900\rJ,20,64,20,64\rK\rT,1,B\r".to_vec(),
                b"k,1,1,0,1,1,0\r\nb,5.02,5.01\r\nz,Protocol error\r\n".to_vec(),
            ],
            LINE_WORDS,
            lines,
        ),
        create_target(),
        asercom_target(),
        scip_device_target(),
        target("scip", "a laser's scans", vec![scan()], &[b"\n\n", b"MD", b"99b"], scans),
        target(
            "nmea",
            "a satellite receiver's sentences",
            vec![sentence()],
            &[b"$GP", b",,", b"*"],
            sentences,
        ),
        target("line-image", "a line camera's images", vec![image()], &[], images),
        meaning_target(),
    ]
}

fn target(
    name: &'static str,
    what: &'static str,
    seeds: Vec<Vec<u8>>,
    words: &'static [&'static [u8]],
    run: fn(&[u8]) -> u64,
) -> Target {
    Target { name, what, seeds, words, run: Box::new(run) }
}

/// The first byte chooses the protocol; each of the others the direction and the time of the one behind it.
fn meaning_target() -> Target {
    let talk = |protocol: u8, bytes: &[u8]| {
        let all = bytes.iter().flat_map(|&byte| [2, byte]);
        std::iter::once(protocol).chain(all).collect::<Vec<u8>>()
    };
    let seeds = vec![
        talk(3, b"D,5,-5\rN\r"),
        talk(5, &[148, 2, 29, 13, 142, 100]),
        talk(6, &scan()),
        talk(7, &sentence()),
        talk(8, &image()),
        talk(9, b"D,5,-5\rN\r\xb2\xaf\0"),
    ];
    target("meaning", "both directions of a cable, in words", seeds, &[], meaning)
}

fn meaning(bytes: &[u8]) -> u64 {
    let Some((&first, bytes)) = bytes.split_first() else { return 0 };
    let protocol = match first % 10 {
        0 => Protocol::Framed { layout: Some(LAYOUT) },
        1 => Protocol::Framed { layout: None },
        2 => Protocol::Bare { layout: LAYOUT, gap_ns: 1_000_000 },
        3 => Protocol::Khepera,
        4 => Protocol::Create(create::Version::One),
        5 => Protocol::Create(create::Version::Two),
        6 => Protocol::Scip,
        7 => Protocol::Nmea,
        8 => Protocol::LineImage,
        _ => Protocol::Asercom,
    };
    let cable = Cable { protocol, names: &["ir"] };
    let mut analyser = Analyser::new([vec![0; 700], vec![0; 70]]);
    let (mut at_ns, mut told, mut words) = (0, 0, String::new());
    let mut each = |item: Item<'_>| {
        assert!(!item.text.is_empty() && item.from_ns <= item.to_ns, "{item:?}");
        told += item.bytes.len();
        words += item.text.split([' ', ',', ':']).next().unwrap_or_default();
    };
    let pairs = bytes.as_chunks::<2>().0;
    for &[how, byte] in pairs {
        let direction = if how & 1 == 0 { Direction::Up } else { Direction::Down };
        at_ns += 1_u64 << (how >> 1 & 31);
        analyser.push(&cable, Heard { direction, at_ns, byte }, &mut each);
    }
    analyser.finish(&mut each);
    assert_eq!(told, pairs.len(), "each byte is in one item");
    outcome(&words)
}

const LINE_WORDS: &[&[u8]] = &[b"\r\n", b",-", b"D,", b"n,", b"G,", b"L,", b"P,", b"h,", b"99999999999"];

fn frames_of(bytes: &[u8]) -> u64 {
    let mut decoder = Decoder::new();
    let mut found = 0;
    for &byte in bytes {
        let came = match decoder.push(byte) {
            None => continue,
            Some(Ok(payload)) => message(payload),
            Some(Err(error)) => outcome(&error.to_string()),
        };
        found ^= came;
    }
    found
}

/// The bytes as a payload, with a sound frame around it, too.
fn message(payload: &[u8]) -> u64 {
    let mut framed = [0; frame::MAX_FRAME];
    if let Ok(n) = frame::encode(payload, &mut framed) {
        let mut decoder = Decoder::new();
        let last = framed[..n]
            .iter()
            .filter_map(|&byte| decoder.push(byte).map(|frame| frame.map(<[u8]>::to_vec)))
            .last();
        // Nothing is a frame of its own.
        assert!(payload.is_empty() || last == Some(Ok(payload.to_vec())), "{payload:02x?}");
    }
    match Message::parse(payload, &LAYOUT) {
        Ok(Message::Readings(readings)) => {
            let values: usize = readings.entries().map(|entry| entry.values.count()).sum();
            outcome("readings") + values as u64
        }
        Ok(Message::Command(command)) => outcome("command") + command.values().count() as u64,
        Ok(Message::Poll { .. }) => outcome("poll"),
        Err(error) => outcome(&error.to_string()),
    }
}

fn bare(bytes: &[u8]) -> u64 {
    let Ok(mut decoder) = BareDecoder::new(LAYOUT.bare_readings_len(), 1_000) else { return 0 };
    let mut found = 0;
    for (i, &byte) in bytes.iter().enumerate() {
        // Some bytes come late.
        let at_ns = i as u64 * 300 + u64::from(byte & 3) * 500;
        if let Some(payload) = decoder.push(byte, at_ns) {
            let values = Values::new(LAYOUT.components, payload);
            found += values.filter(|value| value.is_finite()).count() as u64;
        }
    }
    found.min(40) + 100 * decoder.discarded().min(9)
}

fn lines(bytes: &[u8]) -> u64 {
    let (mut questions, mut answers) = (khepera::Lines::of_questions(), khepera::Lines::of_answers());
    let mut found = 0;
    for &byte in bytes {
        if let Some(line) = questions.push(byte) {
            let parsed = line.and_then(|line| {
                khepera::Question::parse(line, &LINES).map(|question| format!("{question:?}"))
            });
            found ^= parsed.map_or_else(|error| outcome(&error.to_string()), |text| outcome(&text));
        }
        if let Some(line) = answers.push(byte) {
            let parsed = line
                .and_then(|line| khepera::Answer::parse(line, &LINES).map(|answer| format!("{answer:?}")));
            found ^= parsed.map_or_else(|error| outcome(&error.to_string()), |text| outcome(&text));
        }
    }
    found
}

fn create_target() -> Target {
    target(
        "create",
        "commands and streams of an iRobot Create",
        vec![
            vec![128, 131, 145, 0, 200, 0, 200, 142, 100],
            vec![128, 148, 2, 29, 13, 140, 0, 1, 70, 32, 141, 0],
            vec![19, 5, 29, 2, 25, 13, 0, 163],
        ],
        &[b"\x80\x83", b"\x94\x02", b"\x95\x03", b"\x8c\x00\x10", b"\x13\x05\x1d"],
        open_interface,
    )
}

fn open_interface(bytes: &[u8]) -> u64 {
    let mut found = 0;
    for version in [create::Version::One, create::Version::Two] {
        let mut commands = create::Commands::new(version);
        let mut stream = create::Stream::new(version, &[29, 13]);
        for &byte in bytes {
            if let Some(command) = commands.push(byte) {
                found ^= create::Command::parse(version, command)
                    .map_or(1, |command| outcome(&format!("{command:?}")));
            }
            found ^= match stream.push(byte) {
                None => 0,
                Some(Ok(bytes)) => {
                    let payload = create::Payload { version, bytes };
                    outcome("stream") + u64::from(payload.packet(create::Packet::VirtualWall).is_some())
                }
                Some(Err(error)) => outcome(&error.to_string()),
            };
        }
    }
    found
}

fn asercom_target() -> Target {
    target(
        "asercom",
        "letters to an e-puck",
        vec![b"D,500,-500\rN\rQ\rP,1,2\r".to_vec(), b"\xbc\x01\x02\x03\x04\xb2\xaf\0".to_vec()],
        &[b"\r", b"\r\n", b"\0", b"J,", b"R\r", b"K\r", b"\xb2", b"\xbc", b"\x89"],
        letters,
    )
}

/// A robot that answers each command, and whose answers are as long as a message may be.
fn letters(bytes: &[u8]) -> u64 {
    let mut machine = asercom::Machine::new();
    let code = |name: &str, component| Some(name.len() as i16 * 100 + component as i16);
    let mut found = 0_u64;
    for &byte in bytes {
        let Some(deed) = machine.push(byte) else { continue };
        match deed {
            asercom::Deed::SetSteps(steps) => machine.set_steps(code, steps),
            asercom::Deed::Calibrate => machine.calibrate(code),
            asercom::Deed::Drive(_) | asercom::Deed::Reset => {}
            asercom::Deed::Answer | asercom::Deed::Unknown => {}
        }
        let mut out = [0; 512];
        let (len, content) = if machine.owes() { machine.answer(code, &mut out) } else { Default::default() };
        found ^= outcome(&format!("{len} {content:?}"));
    }
    found
}

fn scans(bytes: &[u8]) -> u64 {
    let mut rest = bytes;
    let mut found = 0;
    while let Some(end) = scip::message_end(rest) {
        let (message, behind) = rest.split_at(end.min(rest.len()));
        found ^= match scip::parse(message) {
            Ok(scan) => outcome("scan") + scan.ranges_mm().flatten().count().min(99) as u64,
            Err(error) => outcome(&error.to_string()),
        };
        if message.is_empty() {
            break;
        }
        rest = behind;
    }
    found ^ scip::parse(bytes).map_or_else(|error| outcome(&error.to_string()), |_| 1)
}

fn sentences(bytes: &[u8]) -> u64 {
    let whole = bytes.split_inclusive(|&byte| byte == b'\n');
    whole.fold(0, |found, line| {
        // The checksum is the one that it should have, too.
        let body: Vec<u8> =
            line.iter().copied().filter(|byte| !matches!(byte, b'$' | b'*' | b'\r' | b'\n')).collect();
        let sum = body.iter().fold(0, |sum, byte| sum ^ byte);
        let mended = [b"$", &body[..], format!("*{sum:02X}\r\n").as_bytes()].concat();
        let of = |line: &[u8]| match nmea::parse(line) {
            Ok(nmea::Sentence::Rmc(_)) => outcome("rmc"),
            Ok(_) => outcome("other"),
            Err(error) => outcome(&error.to_string()),
        };
        found ^ of(line) ^ of(&mended).rotate_left(1)
    })
}

fn images(bytes: &[u8]) -> u64 {
    let length = line_image::message_len(bytes);
    let found = length.map_or_else(|error| outcome(&error.to_string()), |length| u64::from(length.is_some()));
    found
        ^ match line_image::parse(bytes) {
            Ok(image) => outcome("image") + image.columns().count().min(9) as u64,
            Err(error) => outcome(&error.to_string()),
        }
}

fn scan() -> Vec<u8> {
    let format =
        scip::Format { characters: scip::Characters::Three, first_step: 0, last_step: 40, cluster: 2 };
    let mut bytes = vec![0; format.message_len()];
    let n = scip::encode(&format, 77, (0..format.points() as u32).map(|i| i * 50), &mut bytes).unwrap_or(0);
    bytes.truncate(n);
    bytes
}

fn sentence() -> Vec<u8> {
    let fix = nmea::Fix {
        time_utc_ms: 1_000,
        date: (1, 1, 16),
        valid: true,
        latitude_deg: 57.7,
        longitude_deg: 11.97,
        speed_m_s: 0.5,
        course_deg: 30.0,
        altitude_m: 2.0,
        satellites: 8,
        hdop: 1.0,
        pdop_vdop: Some((2.0, 1.7)),
    };
    let mut bytes = vec![0; 2 * nmea::MAX_SENTENCE];
    let n = nmea::write_gga(&fix, &mut bytes).unwrap_or(0);
    let m = nmea::write_rmc(&fix, &mut bytes[n..]).unwrap_or(0);
    bytes.truncate(n + m);
    bytes
}

fn image() -> Vec<u8> {
    let columns = (0..12).map(|i| line_image::Column { rgb: [i, 2 * i, 3 * i], depth_mm: 100 });
    let mut bytes = vec![0; line_image::encoded_len(12, 2)];
    let n = line_image::encode(5, columns, 2, &mut bytes).unwrap_or(0);
    bytes.truncate(n);
    bytes
}

/// The device's side of SCIP: what a program of others sends to a laser, which begins a scan every 100 ms meanwhile.
fn scip_device_target() -> Target {
    let seeds = vec![
        b"VV\nPP\nII\nBM\nMD0044072500000\nQT\n".to_vec(),
        b"BM;abc\r\nGD0000076801\rGS0044072501;x\nGE0000108000\nRB\nRB\n%ST\n".to_vec(),
        b"TM0\nTM1\nTM2\nSS115200\nSS019200\nRS\nRT\n%SL\nMS0000076801102\nME0000108000003\n".to_vec(),
    ];
    target("scip-device", "commands to a laser", seeds, DEVICE_WORDS, scip_device)
}

const DEVICE_WORDS: &[&[u8]] = &[
    b"\n", b"\r", b";", b"BM\n", b"QT\n", b"RS\n", b"MD", b"GD", b"ME", b"SS", b"TM", b"00", b"0044", b"0725",
];

/// Devices of both models. Whatever comes, the device stays one that there can be, and each byte has at most so many in
/// answer.
fn scip_device(bytes: &[u8]) -> u64 {
    let models = [scip::device::Model::Urg04lx, scip::device::Model::Ust10lx];
    models.into_iter().fold(0, |found, model| found.rotate_left(7) ^ scip_device_of(model, bytes))
}

fn scip_device_of(model: scip::device::Model, bytes: &[u8]) -> u64 {
    let facts = scip::device::Description {
        model,
        least_mm: 20,
        most_mm: 5600,
        steps_per_turn: 1024,
        first_step: 44,
        last_step: 725,
        front_step: 384,
        turns_per_minute: 600,
    };
    let ranges_m = [1.5; 682];
    let mut device = scip::device::Device::new();
    let (mut found, mut out) = (0_u64, Vec::new());
    for (i, &byte) in bytes.iter().enumerate() {
        let (now_ns, is_scan) = (10_000_000 * i as u64, i % 10 == 9);
        let newest = scip::device::Newest { begun_ns: now_ns, ranges_m: &ranges_m };
        out.clear();
        if device.push(byte) {
            let answer = device.answer(&facts, NonZeroU32::new(115_200), now_ns, Some(newest), &mut out);
            found = found.rotate_left(5) ^ outcome(&format!("{answer:?}"));
        }
        if is_scan && device.wants_scan(now_ns) {
            device.send_scan(&facts, newest, &mut out);
        }
        assert!(device.is_sound(now_ns), "after {} bytes", i + 1);
        assert!(out.len() < MOST_ANSWER, "{} bytes in answer to one", out.len());
    }
    found
}

/// Two scans of all steps in lines of 64 characters with a checksum each, and what stands before them.
const MOST_ANSWER: usize = 20_000;
