//! Commands to a laser range finder and its messages, in SCIP 2.0.

use super::Meaning;
use super::scip_words::{KINDS, Kind, Parameters, status_word};
use super::text::{Ascii, Count};
use crate::scip::{BLOCK_LEN, FIRST_CHARACTER, LINE_FEED, TIME_LEN, value};

/// A line to the device, with its end.
pub(super) fn read_command(bytes: &[u8]) -> Meaning {
    let line = bytes.trim_ascii_end();
    if line.is_empty() {
        return Meaning::of("end of line");
    }
    let Some((kind, parameters)) = kind_of(line) else {
        let mut meaning = Meaning::not_understood(bytes, "no command");
        meaning.add(format_args!("; {}", Ascii(line)));
        return meaning;
    };
    let mut meaning = Meaning::of(format_args!("{}: {}", Ascii(line), kind.asks));
    meaning.is_understood = add_parameters(&mut meaning, kind, parameters);
    if !meaning.is_understood {
        meaning.add(" (not understood: other parameters belong there)");
    }
    meaning
}

/// The command that a line begins with, and what follows it, without a text of the host's.
fn kind_of(line: &[u8]) -> Option<(&'static Kind, &[u8])> {
    let command = line.split(|&byte| byte == b';').next()?;
    KINDS.iter().find_map(|kind| Some((kind, command.strip_prefix(kind.letters)?)))
}

/// Adds the meaning of the parameters; whether they are those of the command.
fn add_parameters(meaning: &mut Meaning, kind: &Kind, parameters: &[u8]) -> bool {
    let number = |from: usize, len: usize| digits(parameters.get(from..from + len)?);
    match (kind.parameters, parameters.len()) {
        (Parameters::None, 0) => true,
        (Parameters::TimeMode, 1) => {
            let word = match parameters {
                b"0" => "on",
                b"1" => "ask time",
                b"2" => "off",
                _ => return false,
            };
            meaning.add(format_args!(" {word}"));
            true
        }
        (Parameters::Rate, 6) => number(0, 6).is_some_and(|rate| {
            meaning.add(format_args!(" {rate}"));
            true
        }),
        (Parameters::Other, _) => true,
        (Parameters::Steps, 10) | (Parameters::Scans, 13) => {
            let (Some(first), Some(last), Some(cluster)) = (number(0, 4), number(4, 4), number(8, 2)) else {
                return false;
            };
            meaning.add(format_args!(" of steps {first} to {last}"));
            if cluster > 1 {
                meaning.add(format_args!(", cluster {cluster}"));
            }
            kind.parameters == Parameters::Steps || add_scans(meaning, number(10, 1), number(11, 2))
        }
        (Parameters::None | Parameters::TimeMode | Parameters::Rate, _) => false,
        (Parameters::Steps | Parameters::Scans, _) => false,
    }
}

fn add_scans(meaning: &mut Meaning, interval: Option<u32>, scans: Option<u32>) -> bool {
    let (Some(interval), Some(scans)) = (interval, scans) else { return false };
    if interval > 0 {
        meaning.add(format_args!(", {} left out between two", Count(interval as usize, "scan")));
    }
    match scans {
        0 => meaning.add(", without an end"),
        scans => meaning.add(format_args!(", {}", Count(scans as usize, "scan"))),
    }
    true
}

/// A message of the device's, with the two line feeds at its end, whose last byte came at `at_ns`.
pub(super) fn read_answer(at_ns: u64, bytes: &[u8]) -> Meaning {
    let message = bytes.strip_suffix(b"\n\n").unwrap_or(bytes);
    let mut lines = message.split(|&byte| byte == LINE_FEED);
    let echo = lines.next().unwrap_or_default();
    let (Some((kind, parameters)), Some(status)) = (kind_of(echo), lines.next()) else {
        let mut meaning = Meaning::not_understood(bytes, "no answer");
        meaning.add(format_args!("; {}", Ascii(echo)));
        return meaning;
    };
    let mut meaning = Meaning::of(format_args!("{}:", Ascii(echo)));
    meaning.is_understood = add_status(&mut meaning, kind, status);
    match kind.parameters {
        Parameters::Steps | Parameters::Scans => {
            let is_echo = add_parameters(&mut meaning, kind, parameters);
            let is_sound = add_scan(&mut meaning, kind, at_ns, lines);
            meaning.is_understood &= is_echo && is_sound;
        }
        Parameters::TimeMode if parameters == b"1" => {
            let is_sound = add_scan(&mut meaning, kind, at_ns, lines);
            meaning.is_understood &= is_sound;
            meaning.age_ns = None;
        }
        Parameters::None | Parameters::TimeMode | Parameters::Rate | Parameters::Other => {
            let is_sound = add_texts(&mut meaning, lines);
            meaning.is_understood &= is_sound;
        }
    }
    meaning
}

/// Adds the status; whether its checksum is right.
fn add_status(meaning: &mut Meaning, kind: &Kind, line: &[u8]) -> bool {
    let (&[a, b, sum], true) = (line.first_chunk().unwrap_or(&[0; 3]), line.len() == 3) else {
        meaning.add(format_args!(" no status ({})", Ascii(line)));
        return false;
    };
    meaning.add(format_args!(" status {}", Ascii(&[a, b])));
    if let Some(word) = status_word(kind, [a, b]) {
        meaning.add(format_args!(" ({word})"));
    }
    let is_right = sum == checksum(&[a, b]);
    if !is_right {
        meaning.add(", its checksum wrong");
    }
    is_right
}

/// Adds the time stamp and the number of values in the blocks behind it; whether all checksums are right.
fn add_scan<'a>(
    meaning: &mut Meaning,
    kind: &Kind,
    at_ns: u64,
    mut lines: impl Iterator<Item = &'a [u8]>,
) -> bool {
    let Some(time) = lines.next().filter(|line| !line.is_empty()) else { return true };
    let Some((&sum, stamp)) = time.split_last().filter(|(_, stamp)| stamp.len() == TIME_LEN) else {
        meaning.add(format_args!(", no time stamp ({})", Ascii(time)));
        return false;
    };
    let time_ms = value(stamp) & 0xff_ffff;
    meaning.add(format_args!(", time {time_ms} ms"));
    let now_ms = at_ns / 1_000_000;
    let age_ms = now_ms.wrapping_sub(time_ms.into()) & 0xff_ffff;
    let (mut characters, mut wrong, mut is_block_short) = (0, usize::from(sum != checksum(stamp)), false);
    for line in lines {
        let Some((&sum, block)) = line.split_last() else { continue };
        wrong += usize::from(sum != checksum(block) || block.len() > BLOCK_LEN || is_block_short);
        is_block_short = block.len() < BLOCK_LEN;
        characters += block.len();
    }
    if let Some((what, count)) = kind.values
        && characters > 0
    {
        meaning.add(format_args!(", {}", Count(characters / count, what)));
        meaning.age_ns = Some(age_ms * 1_000_000 + at_ns % 1_000_000);
    }
    match wrong {
        0 => meaning.add(", checksums right"),
        wrong => meaning.add(format_args!(", checksum wrong of {}", Count(wrong, "line"))),
    }
    wrong == 0
}

/// Adds lines of text; whether their checksums are right. That of a line which ends in a semicolon does not count it.
fn add_texts<'a>(meaning: &mut Meaning, lines: impl Iterator<Item = &'a [u8]>) -> bool {
    let mut is_sound = true;
    for line in lines {
        let Some((&sum, characters)) = line.split_last() else { continue };
        let said = characters.strip_suffix(b";").unwrap_or(characters);
        let is_right = sum == checksum(said) || sum == checksum(characters);
        is_sound &= is_right;
        let wrong = if is_right { "" } else { " (checksum wrong)" };
        meaning.add(format_args!("; {}{wrong}", Ascii(said)));
    }
    is_sound
}

fn checksum(characters: &[u8]) -> u8 {
    let sum = characters.iter().fold(0_u8, |sum, &character| sum.wrapping_add(character));
    FIRST_CHARACTER + (sum & 0x3f)
}

fn digits(text: &[u8]) -> Option<u32> {
    text.iter()
        .try_fold(0, |number, byte| byte.is_ascii_digit().then(|| number * 10 + u32::from(byte - b'0')))
}
