//! The commands of a Create, in the words of iRobot's Open Interface.

use super::Meaning;
use super::create::add_list;
use super::packets::PacketName;
use super::text::{Ascii, Count, Hex};
use crate::create::Version;

/// A command, as [`Commands`](crate::create::Commands) finds it.
pub(super) fn read(version: Version, bytes: &[u8]) -> Meaning {
    driving(bytes)
        .or_else(|| sensing(version, bytes))
        .or_else(|| state(version, bytes))
        .or_else(|| showing(version, bytes))
        .unwrap_or_else(|| Meaning::not_understood(bytes, "no command of this robot"))
}

fn driving(bytes: &[u8]) -> Option<Meaning> {
    let word = |high, low| i16::from_be_bytes([high, low]);
    Some(match *bytes {
        [137, a, b, c, d] => {
            let mut meaning = Meaning::of(format_args!("drive {} mm/s", word(a, b)));
            match word(c, d) {
                i16::MIN | i16::MAX => meaning.add(" straight"),
                -1 => meaning.add(", turn in place clockwise"),
                1 => meaning.add(", turn in place counter-clockwise"),
                radius_mm => meaning.add(format_args!(", radius {radius_mm} mm")),
            }
            meaning
        }
        [145, a, b, c, d] => {
            let (right, left) = (word(a, b), word(c, d));
            Meaning::of(format_args!("drive direct: right {right} mm/s, left {left} mm/s"))
        }
        [146, a, b, c, d] => {
            let (right, left) = (word(a, b), word(c, d));
            Meaning::of(format_args!("drive PWM: right {right}, left {left}"))
        }
        _ => return None,
    })
}

fn sensing(version: Version, bytes: &[u8]) -> Option<Meaning> {
    Some(match *bytes {
        [142, id] => Meaning::of(format_args!("sensors: {}", PacketName { version, id })),
        [148, 0] => Meaning::of("stream: none"),
        [148, _, ref ids @ ..] => {
            let mut meaning = Meaning::of("stream:");
            add_list(&mut meaning, version, ids);
            meaning
        }
        [149, _, ref ids @ ..] => {
            let mut meaning = Meaning::of("query list:");
            add_list(&mut meaning, version, ids);
            meaning
        }
        [150, 0] => Meaning::of("pause stream"),
        [150, _] => Meaning::of("resume stream"),
        _ => return None,
    })
}

fn state(version: Version, bytes: &[u8]) -> Option<Meaning> {
    let text = match (version, bytes) {
        (_, [128]) => "start",
        (_, [130]) => "control (safe mode)",
        (_, [131]) => "safe mode",
        (_, [132]) => "full mode",
        (Version::Two, [7]) => "reset",
        (Version::Two, [173]) => "stop the interface",
        (Version::Two, [133]) => "power down",
        (_, [134]) => "spot (cleans a spot)",
        (_, [135]) => "cover (cleans)",
        (Version::Two, [136]) => "max (cleans)",
        (_, [143]) => "cover and dock (seeks its dock)",
        (Version::One, [153]) => "play script",
        (Version::One, [154]) => "show script",
        (Version::One, &[136, demo]) => {
            return Some(Meaning::of(format_args!("demo {}", demo.cast_signed())));
        }
        (Version::One, &[155, tenths]) => {
            return Some(Meaning::of(format_args!("wait {}.{} s", tenths / 10, tenths % 10)));
        }
        (Version::One, &[156, a, b]) => {
            return Some(Meaning::of(format_args!("wait distance {} mm", i16::from_be_bytes([a, b]))));
        }
        (Version::One, &[157, a, b]) => {
            return Some(Meaning::of(format_args!("wait angle {}°", i16::from_be_bytes([a, b]))));
        }
        (Version::One, &[158, event]) => {
            return Some(Meaning::of(format_args!("wait event {}", event.cast_signed())));
        }
        (Version::One, [152, _, script @ ..]) => {
            let len = Count(script.len(), "byte");
            return Some(Meaning::of(format_args!("script, {len}: {}", Hex(script))));
        }
        (_, &[129, code]) => return Some(baud(code)),
        _ => return None,
    };
    Some(Meaning::of(text))
}

fn baud(code: u8) -> Meaning {
    const RATES: [u32; 12] =
        [300, 600, 1200, 2400, 4800, 9600, 14_400, 19_200, 28_800, 38_400, 57_600, 115_200];
    match RATES.get(usize::from(code)) {
        Some(rate) => Meaning::of(format_args!("baud {rate}")),
        None => {
            let mut meaning = Meaning::of(format_args!("baud code {code}, which does not exist"));
            meaning.is_understood = false;
            meaning
        }
    }
}

fn showing(version: Version, bytes: &[u8]) -> Option<Meaning> {
    Some(match (version, bytes) {
        (Version::One, [138, bits]) => Meaning::of(format_args!("low side drivers {bits:#05b}")),
        (Version::Two, [138, bits]) => Meaning::of(format_args!("motors {bits:#07b}")),
        (Version::One, [144, a, b, c]) => Meaning::of(format_args!("PWM of low side drivers {a} {b} {c}")),
        (Version::Two, &[144, a, b, c]) => {
            let [main, side, vacuum] = [a, b, c].map(u8::cast_signed);
            Meaning::of(format_args!("PWM motors: main brush {main}, side brush {side}, vacuum {vacuum}"))
        }
        (_, [139, bits, color, intensity]) => {
            Meaning::of(format_args!("LEDs {bits:#010b}, color {color}, intensity {intensity}"))
        }
        (_, [140, number, _, notes @ ..]) => song(*number, notes),
        (_, [141, number]) => Meaning::of(format_args!("play song {number}")),
        (Version::One, [147, bits]) => Meaning::of(format_args!("digital outputs {bits:#05b}")),
        (Version::One, [151, byte]) => Meaning::of(format_args!("send IR {byte}")),
        (Version::Two, [162, days, clock]) => {
            Meaning::of(format_args!("scheduling LEDs: weekdays {days:#09b}, clock {clock:#07b}"))
        }
        (Version::Two, [163, digits @ ..]) => Meaning::of(format_args!("digit LEDs, raw: {}", Hex(digits))),
        (Version::Two, [164, text @ ..]) => Meaning::of(format_args!("digit LEDs: {}", Ascii(text))),
        (Version::Two, [165, bits]) => Meaning::of(format_args!("buttons {bits:#010b}")),
        (Version::Two, [167, days, times @ ..]) => {
            Meaning::of(format_args!("schedule: weekdays {days:#09b}, times {}", Hex(times)))
        }
        (Version::Two, [168, day, hour, minute]) => {
            Meaning::of(format_args!("set day {day}, time {hour:02}:{minute:02}"))
        }
        _ => return None,
    })
}

/// Notes are pairs of a number and a duration in 1/64 s.
fn song(number: u8, notes: &[u8]) -> Meaning {
    let mut meaning = Meaning::of(format_args!("song {number}, {}:", Count(notes.len() / 2, "note")));
    for note in notes.as_chunks::<2>().0 {
        let [note, duration] = note;
        meaning.add(format_args!(" {note} for {duration}/64 s"));
    }
    meaning
}
