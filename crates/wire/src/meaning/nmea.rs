//! Sentences of a satellite receiver.

use super::Meaning;
use super::text::{Ascii, Value};
use crate::nmea::{Position, Sentence, parse};

/// A sentence with its end, whose last byte came at `at_ns`.
pub(super) fn read(at_ns: u64, bytes: &[u8]) -> Meaning {
    match parse(bytes) {
        Ok(Sentence::Rmc(rmc)) => {
            let mut meaning = Meaning::of("RMC");
            add_time(&mut meaning, rmc.time_utc_ms);
            add_position(&mut meaning, rmc.position);
            if let Some(speed_m_s) = rmc.speed_m_s {
                meaning.add(format_args!(", {} m/s", Value(speed_m_s)));
            }
            if let Some(course_deg) = rmc.course_deg {
                meaning.add(format_args!(", course {}°", Value(course_deg)));
            }
            meaning.age_ns = rmc.time_utc_ms.map(|time_ms| age_ns(time_ms, at_ns));
            meaning
        }
        Ok(Sentence::Gga(gga)) => {
            let mut meaning = Meaning::of("GGA");
            add_time(&mut meaning, gga.time_utc_ms);
            add_position(&mut meaning, gga.position);
            meaning.add(format_args!(", quality {}", gga.quality));
            if let Some(satellites) = gga.satellites {
                meaning.add(format_args!(", satellites {satellites}"));
            }
            if let Some(altitude_m) = gga.altitude_m {
                meaning.add(format_args!(", altitude {} m", Value(altitude_m)));
            }
            meaning.age_ns = gga.time_utc_ms.map(|time_ms| age_ns(time_ms, at_ns));
            meaning
        }
        Ok(Sentence::Other) => other(bytes.trim_ascii_end()),
        Err(error) => {
            let mut meaning = Meaning::not_understood(bytes, "no sentence");
            meaning.add(format_args!("; {error}"));
            meaning
        }
    }
}

/// A sound sentence, described by its name and its fields.
fn other(line: &[u8]) -> Meaning {
    let fields = line.get(1..line.len().saturating_sub(3)).unwrap_or_default();
    let (name, fields) = fields.split_at_checked(5).unwrap_or((fields, &[]));
    let kind = name.get(2..).unwrap_or_default();
    let words = match kind {
        b"GLL" => "geographic position",
        b"GSA" => "satellites in use and dilution of precision",
        b"GSV" => "satellites in view",
        b"VTG" => "course and speed over ground",
        b"ZDA" => "time and date",
        b"HDT" => "heading",
        _ => "sentence",
    };
    Meaning::of(format_args!("{}: {words}{}", Ascii(kind), Ascii(fields)))
}

fn add_time(meaning: &mut Meaning, time_utc_ms: Option<u32>) {
    if let Some(time_ms) = time_utc_ms {
        let (seconds, ms) = (time_ms / 1000, time_ms % 1000);
        let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
        meaning.add(format_args!(" {hours:02}:{minutes:02}:{seconds:02}.{ms:03}"));
    }
}

fn add_position(meaning: &mut Meaning, position: Option<Position>) {
    let Some(Position { latitude_deg, longitude_deg }) = position else { return meaning.add(", no fix") };
    // The last digit of a sentence is 1/600,000 of a degree.
    let (north, east) = (latitude_deg.abs(), longitude_deg.abs());
    let (ns, ew) = (if latitude_deg < 0.0 { 'S' } else { 'N' }, if longitude_deg < 0.0 { 'W' } else { 'E' });
    meaning.add(format_args!(", {north:.6}° {ns} {east:.6}° {ew}"));
}

/// The age of a fix at `at_ns`, if it is no older than a day.
fn age_ns(time_utc_ms: u32, at_ns: u64) -> u64 {
    let now_ms = at_ns / 1_000_000 % DAY_MS;
    (now_ms + DAY_MS).saturating_sub(time_utc_ms.into()) % DAY_MS * 1_000_000 + at_ns % 1_000_000
}

const DAY_MS: u64 = 86_400_000;
