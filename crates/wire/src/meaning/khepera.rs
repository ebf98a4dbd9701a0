//! Lines of a Khepera, in the words of appendix A of K-Team's manual (version 5).
//!
//! Lines are read by their letters and numbers alone, whatever a robot's firmware has in its answers.

use super::Meaning;
use super::text::Ascii;

/// The meaning of a command's letter.
struct Word {
    letter: u8,
    asks: &'static str,
    /// The meaning of each number of the question.
    numbers: &'static [&'static str],
    answers: &'static str,
}

const fn word(
    letter: u8,
    asks: &'static str,
    numbers: &'static [&'static str],
    answers: &'static str,
) -> Word {
    Word { letter, asks, numbers, answers }
}

const WORDS: [Word; 18] = [
    word(b'A', "set speed PID", &["Kp", "Ki", "Kd"], "speed PID set"),
    word(b'B', "ask software version", &[], "software version"),
    word(b'C', "go to position", &["", ""], "goes to position"),
    word(b'D', "set speed", &["", ""], "speed set"),
    word(b'E', "ask speed", &[], "speed"),
    word(b'F', "set position PID", &["Kp", "Ki", "Kd"], "position PID set"),
    word(b'G', "set position counters", &["", ""], "position counters set"),
    word(b'H', "ask position", &[], "position"),
    word(b'I', "ask analog input", &[""], "analog input"),
    word(
        b'J',
        "set speed profile",
        &["left speed", "acceleration", "right speed", "acceleration"],
        "speed profile set",
    ),
    word(b'K', "ask status of motion", &[], "status of motion (target, mode, error; left, right)"),
    word(b'L', "set LED", &["", "action"], "LED set"),
    word(b'N', "ask proximity", &[], "proximity"),
    word(b'O', "ask ambient light", &[], "ambient light"),
    word(b'P', "set pulse width", &["", ""], "pulse width set"),
    word(b'R', "read extension bus", &["address"], "extension bus"),
    word(b'T', "to turret", &[""], "turret"),
    word(b'W', "write extension bus", &["byte", "address"], "extension bus written"),
];

/// A line to the robot, with its end.
pub(super) fn read_question(bytes: &[u8]) -> Meaning {
    let line = bytes.trim_ascii_end();
    let Some((letter, rest)) = line.split_first() else { return Meaning::of("end of line") };
    let Some(word) = WORDS.iter().find(|word| word.letter == *letter) else {
        let mut meaning = Meaning::not_understood(bytes, "no command");
        meaning.add(format_args!("; {}", Ascii(line)));
        return meaning;
    };
    let Word { asks, numbers, .. } = word;
    let mut meaning = Meaning::of(format_args!("{}: {asks}", Ascii(line)));
    let mut found = 0;
    for field in fields(rest) {
        match numbers.get(found) {
            Some(&"") | None => meaning.add(format_args!(" {}", Ascii(field))),
            Some(name) => meaning.add(format_args!(" {name} {}", Ascii(field))),
        }
        found += 1;
    }
    // Behind the number of a turret stands its own command.
    let fits = found == numbers.len() || (*letter == b'T' && found > 1);
    let is_sound = fields(rest).all(is_number) || *letter == b'T';
    if !fits || !is_sound || !begins_with_comma(rest) {
        meaning.is_understood = false;
        meaning.add(format_args!(" (not understood: {} whole numbers belong there)", numbers.len()));
    }
    meaning
}

/// A line of the robot's, with its end.
pub(super) fn read_answer(bytes: &[u8]) -> Meaning {
    let line = bytes.trim_ascii_end();
    let Some((letter, rest)) = line.split_first() else { return Meaning::of("end of line") };
    if line == b"z,Protocol error" {
        return Meaning::of("z: refused, protocol error");
    }
    if line == b"Command not found" {
        return Meaning::of("refused, command not found");
    }
    let word = WORDS.iter().find(|word| word.letter.to_ascii_lowercase() == *letter);
    let Some(word) = word.filter(|_| begins_with_comma(rest)) else {
        let mut meaning = Meaning::not_understood(bytes, "no answer");
        meaning.add(format_args!("; {}", Ascii(line)));
        return meaning;
    };
    let mut meaning = Meaning::of(format_args!("{}: {}", Ascii(&[*letter]), word.answers));
    let is_text = matches!(letter, b'b' | b't');
    meaning.is_understood = is_text || fields(rest).all(is_number);
    fields(rest).for_each(|field| meaning.add(format_args!(" {}", Ascii(field))));
    if !meaning.is_understood {
        meaning.add(" (not understood: no whole numbers)");
    }
    meaning
}

/// The texts behind the commas.
fn fields(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    rest.split(|&byte| byte == b',').skip(1)
}

fn begins_with_comma(rest: &[u8]) -> bool {
    rest.first().is_none_or(|&byte| byte == b',')
}

fn is_number(field: &[u8]) -> bool {
    let digits = field.strip_prefix(b"-").unwrap_or(field);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}
