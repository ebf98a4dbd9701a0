//! The conformance vectors of `vectors.txt`, read and written. They are there for other languages too.

use std::fmt::Write;

use baudbot_wire::{
    Decoder, Encoding, FrameError, Layout, Message, MessageError, Sample, Values, frame, poll, write_command,
    write_readings, write_values,
};

const BYTE: Encoding = Encoding::Level { bits: 8, min: 0.0, max: 255.0 };
const WHEEL: Encoding = Encoding::Counter { bits: 16 };
const MOTOR: Encoding = Encoding::Signed { bits: 8, limit: 127.0 };

const ROBOT: Layout<'_> = Layout {
    components: &[BYTE, Encoding::Level { bits: 10, min: 0.0, max: 1023.0 }, WHEEL, WHEEL, Encoding::Float64],
    counts: &[1, 1, 2, 1],
    motors: &[MOTOR; 2],
    ages: true,
};
const NINE: Layout<'_> = Layout { components: &[BYTE; 9], counts: &[1; 9], motors: &[], ages: false };
const EXACT: Layout<'_> =
    Layout { components: &[], counts: &[], motors: &[Encoding::Float64; 2], ages: false };
const WIDE: Layout<'_> = Layout { components: &[], counts: &[], motors: &[MOTOR; 300], ages: false };

#[test]
fn every_vector_means_what_it_says() {
    for vector in vectors() {
        let found = match vector.bare() {
            Some(encodings) => format!("[{}]", listed(Values::new(encodings, &vector.wire))),
            None => read(&vector),
        };
        let expected =
            vector.meaning.trim_start_matches("bare_readings ").trim_start_matches("bare_command ");
        assert_eq!(found, expected, "{}", vector.name);
    }
}

#[test]
fn every_message_is_written_as_the_vector_has_it() {
    let mut written = 0;
    for vector in vectors() {
        let mut out = [0; frame::MAX_FRAME];
        let len = if let Some(encodings) = vector.bare() {
            write_values(encodings, Values::new(encodings, &vector.wire), &mut out).unwrap()
        } else if !vector.meaning.contains("error") && vector.wire[0] != frame::DELIMITER {
            rewrite(&vector, &mut out)
        } else {
            continue;
        };
        assert_eq!(out[..len], vector.wire, "{}", vector.name);
        written += 1;
    }
    assert_eq!(written, 10);
}

struct Vector {
    name: &'static str,
    wire: Vec<u8>,
    layout: Layout<'static>,
    meaning: &'static str,
}

impl Vector {
    /// The encodings of its values, if it is not framed.
    fn bare(&self) -> Option<&'static [Encoding]> {
        match self.meaning.split_once(' ')?.0 {
            "bare_readings" => Some(self.layout.components),
            "bare_command" => Some(self.layout.motors),
            _ => None,
        }
    }
}

fn vectors() -> impl Iterator<Item = Vector> {
    let lines = include_str!("../vectors.txt").lines();
    lines.filter(|line| !line.is_empty() && !line.starts_with('#')).map(|line| {
        let [name, hex, meaning] = line.split(" | ").collect::<Vec<_>>()[..] else { panic!("{line}") };
        let wire = hex.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
        let (layout, meaning) = meaning.split_once(' ').unwrap();
        let layout = match layout {
            "robot" => ROBOT,
            "nine" => NINE,
            "exact" => EXACT,
            "wide" => WIDE,
            other => panic!("no layout {other}"),
        };
        assert_eq!(layout.check(), Ok(()));
        Vector { name, wire, layout, meaning }
    })
}

/// The vector's bytes as a reader understands them, in the words of the file.
fn read(vector: &Vector) -> String {
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for &byte in &vector.wire {
        match decoder.push(byte) {
            None => {}
            Some(Err(error)) => found.push(format!("error={}", frame_error(error))),
            Some(Ok(payload)) => found.push(match Message::parse(payload, &vector.layout) {
                Err(error) => format!("error={}", message_error(error)),
                Ok(message) => described(&message),
            }),
        }
    }
    found.join(" ")
}

fn described(message: &Message<'_>) -> String {
    match message {
        Message::Poll { sequence } => format!("poll sequence={sequence}"),
        Message::Command(command) => {
            format!("command sequence={} [{}]", command.sequence, listed(command.values()))
        }
        Message::Readings(readings) => {
            let mut text = format!("readings sequence={} time={}", readings.sequence, readings.time_100us);
            for entry in readings.entries() {
                let age = entry.age_100us.map_or_else(String::new, |age| format!("@{age}"));
                write!(text, " {}{age}=[{}]", entry.sensor, listed(entry.values)).unwrap();
            }
            text
        }
    }
}

fn listed(values: Values<'_>) -> String {
    values.map(|value| value.to_string()).collect::<Vec<_>>().join(",")
}

fn frame_error(error: FrameError) -> &'static str {
    match error {
        FrameError::TooLong { .. } => "too_long",
        FrameError::Cobs { .. } => "cobs",
        FrameError::TooShort { .. } => "too_short",
        FrameError::Crc { .. } => "crc",
    }
}

fn message_error(error: MessageError) -> &'static str {
    match error {
        MessageError::Version { .. } => "version",
        MessageError::Kind { .. } => "kind",
        MessageError::Length { .. } => "length",
        MessageError::Mask { .. } => "mask",
        MessageError::NotFinite { .. } => "not_finite",
    }
}

/// Reads the vector's one message and writes it again.
fn rewrite(vector: &Vector, out: &mut [u8]) -> usize {
    let mut decoder = Decoder::new();
    let (&delimiter, bytes) = vector.wire.split_last().unwrap();
    assert!(bytes.iter().all(|&byte| decoder.push(byte).is_none()), "{}", vector.name);
    let payload = decoder.push(delimiter).unwrap().unwrap();
    let mut again = [0; frame::MAX_PAYLOAD];
    let len = match Message::parse(payload, &vector.layout).unwrap() {
        Message::Poll { sequence } => {
            again[..2].copy_from_slice(&poll(sequence));
            2
        }
        Message::Command(command) => {
            write_command(&vector.layout, command.sequence, command.values(), &mut again).unwrap()
        }
        Message::Readings(readings) => {
            let entries: Vec<(_, _, Vec<f64>)> = readings
                .entries()
                .map(|entry| (entry.sensor, entry.age_100us.unwrap_or(0), entry.values.collect()))
                .collect();
            let fresh = |sensor| {
                let (_, age_100us, values) = entries.iter().find(|entry| entry.0 == sensor)?;
                Some(Sample { age_100us: *age_100us, values })
            };
            write_readings(&vector.layout, readings.sequence, readings.time_100us, fresh, &mut again).unwrap()
        }
    };
    frame::encode(&again[..len], out).unwrap()
}
