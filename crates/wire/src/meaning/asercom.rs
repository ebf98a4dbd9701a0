//! Letters of an e-puck, in lines of text and in bytes.

use super::text::Ascii;
use super::{Cut, Meaning, ends_with};
use crate::asercom::{MOST_ASKED, NOT_FOUND, answer_len, commands, is_whole};
use crate::buffer::Buffer;

/// The letters of the last binary commands that are answered in bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct Letters(Buffer<MOST_ASKED>);

impl Letters {
    pub(super) fn cut_command(&mut self, bytes: &[u8]) -> Cut {
        if !is_whole(bytes) {
            return Cut::Wait;
        }
        self.0.clear();
        let letters = binary(bytes).map(|(letter, _)| letter).filter(|letter| answer_len(*letter) > 0);
        letters.for_each(|letter| _ = self.0.push(letter));
        Cut::After
    }

    pub(super) fn cut_answer(&self, bytes: &[u8]) -> Cut {
        let len: usize = self.0.used().iter().map(|letter| answer_len(*letter)).sum();
        match len {
            0 => ends_with(bytes, b"\n"),
            _ if bytes.len() >= len => Cut::After,
            _ => Cut::Wait,
        }
    }

    /// The robot's answer: a line, or the bytes of all letters.
    pub(super) fn read_answer(&mut self, bytes: &[u8]) -> Meaning {
        let asked = core::mem::take(&mut self.0);
        if asked.len() == 0 {
            return read_line(bytes);
        }
        let (mut meaning, mut rest) = (Meaning::of("answer"), bytes);
        for &letter in asked.used() {
            let Some((own, behind)) = rest.split_at_checked(answer_len(letter)) else { break };
            rest = behind;
            meaning.add(format_args!("; {}", word(letter)));
            match letter {
                b'A' => {
                    let numbers = own.as_chunks().0.iter().copied().map(f32::from_le_bytes);
                    numbers.for_each(|number| meaning.add(format_args!(" {number}")));
                }
                b't' => own.iter().for_each(|byte| meaning.add(format_args!(" {byte}"))),
                _ => add_numbers(&mut meaning, own),
            }
        }
        meaning
    }
}

/// A line to the robot with its end, or binary letters with theirs.
pub(super) fn read_command(bytes: &[u8]) -> Meaning {
    let line = bytes.trim_ascii_end();
    match bytes.first() {
        Some(0) => Meaning::of("end of letters"),
        Some(128..) => read_binary(bytes),
        Some(_) | None if line.is_empty() => Meaning::of("end of line"),
        Some(first) if has(LINES, *first) => Meaning::of(format_args!("{}: {}", Ascii(line), word(*first))),
        Some(_) | None => {
            let mut meaning = Meaning::not_understood(bytes, "no command");
            meaning.add(format_args!("; {}", Ascii(line)));
            meaning
        }
    }
}

fn read_binary(bytes: &[u8]) -> Meaning {
    let mut meaning = Meaning::of("in bytes");
    for (letter, data) in binary(bytes) {
        if !has(BINARY, letter) {
            meaning.is_understood = false;
            meaning.add(format_args!("; not understood: {:02x}", letter.wrapping_neg()));
            continue;
        }
        meaning.add(format_args!("; {}: {}", char::from(letter), word(letter)));
        match letter {
            b'D' | b'P' => add_numbers(&mut meaning, data),
            _ => data.iter().for_each(|byte| meaning.add(format_args!(" {byte}"))),
        }
    }
    meaning
}

/// A line of the robot's, with its end.
fn read_line(bytes: &[u8]) -> Meaning {
    let line = bytes.trim_ascii();
    match line {
        [] => Meaning::of("end of line"),
        _ if line == NOT_FOUND.trim_ascii() => Meaning::of("z: refused, command not found"),
        [letter] => Meaning::of(format_args!("{}: {}", Ascii(line), word(letter.to_ascii_uppercase()))),
        [letter, b',', ..] if has(LINES, *letter) => {
            let mut meaning = Meaning::of(format_args!("{}: {}", Ascii(&[*letter]), word(*letter)));
            let fields = line.split(|byte| *byte == b',').skip(1);
            fields.for_each(|field| meaning.add(format_args!(" {}", Ascii(field))));
            meaning
        }
        _ => Meaning::of(Ascii(line)),
    }
}

/// The binary commands but for their end; none in a line.
fn binary(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let is_binary = bytes.first().is_some_and(|byte| *byte >= 128);
    commands(bytes).filter(move |(letter, _)| is_binary && *letter != 0)
}

fn add_numbers(meaning: &mut Meaning, bytes: &[u8]) {
    let numbers = bytes.as_chunks().0.iter().copied().map(i16::from_le_bytes);
    numbers.for_each(|number| meaning.add(format_args!(" {number}")));
}

/// Whether the letter is one of these, of text in either case.
fn has(letters: &[u8], letter: u8) -> bool {
    letters.contains(&letter) || (letters == LINES && letters.contains(&letter.to_ascii_uppercase()))
}

/// The letters of lines, and those of bytes.
const LINES: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWbg";
const BINARY: &[u8] = b"ADEILMNOPQUWabgtuw";

/// The subject of a letter.
const fn word(letter: u8) -> &'static str {
    match letter {
        b'b' => "battery",
        b'g' => "gyro",
        b't' => "temperature",
        b'w' => "RGB panel",
        _ => match letter.to_ascii_uppercase() {
            b'A' => "acceleration",
            b'B' => "body LED",
            b'C' => "selector",
            b'D' => "set speeds",
            b'E' => "speeds",
            b'F' => "front LED",
            b'G' => "IR receiver",
            b'H' => "help",
            b'I' => "camera",
            b'J' => "set camera",
            b'K' => "calibrate proximity",
            b'L' => "LED",
            b'M' => "floor",
            b'N' => "proximity",
            b'O' => "light",
            b'P' => "set steps",
            b'Q' => "steps",
            b'R' => "reset",
            b'S' => "stop",
            b'T' => "sound",
            b'U' => "microphones",
            b'V' => "version",
            b'W' => "write I2C",
            _ => "nothing",
        },
    }
}
