//! Frames, and the readings and commands in them.

use super::Meaning;
use super::text::{Count, Value, ms};
use crate::clock::{UNIT_NS, unwrap_time};
use crate::frame::Decoder;
use crate::layout::Layout;
use crate::message::{Command, Message, Readings};

/// A frame, its delimiter included, whose last byte came at `at_ns`.
pub(super) fn read(layout: Option<&Layout<'_>>, names: &[&str], at_ns: u64, bytes: &[u8]) -> Meaning {
    let mut decoder = Decoder::new();
    let (last, before) = bytes.split_last().unwrap_or((&0, &[]));
    for &byte in before {
        // No delimiter is among them, so nothing ends here.
        let _ = decoder.push(byte);
    }
    let payload = match decoder.push(*last) {
        None => return Meaning::of("delimiter without a frame"),
        Some(Err(error)) => {
            let mut meaning = Meaning::not_understood(bytes, "damaged frame");
            meaning.add(format_args!("; {error}"));
            return meaning;
        }
        Some(Ok(payload)) => payload,
    };
    let Some(layout) = layout else { return without_layout(payload, at_ns) };
    match Message::parse(payload, layout) {
        Ok(Message::Readings(readings)) => readings_of(&readings, names, at_ns),
        Ok(Message::Command(command)) => command_of(&command),
        Ok(Message::Poll { sequence }) => Meaning::of(format_args!("poll #{sequence}")),
        Err(error) => {
            let mut meaning = Meaning::not_understood(bytes, "no message of this layout");
            meaning.add(format_args!("; {error}"));
            meaning
        }
    }
}

fn readings_of(readings: &Readings<'_>, names: &[&str], at_ns: u64) -> Meaning {
    let closed_ns = unwrap_time(readings.time_100us, at_ns);
    let mut meaning =
        Meaning::of(format_args!("readings #{}, closed at {} ms", readings.sequence, ms(closed_ns)));
    let mut oldest = Some(0);
    let mut is_first = true;
    for entry in readings.entries() {
        let mark = if core::mem::take(&mut is_first) { ':' } else { ',' };
        meaning.add(format_args!("{mark} {}", Name(names, entry.sensor)));
        entry.values.for_each(|value| meaning.add(format_args!(" {}", Value(value))));
        // The largest age stands for any from there on.
        let age_ns = entry.age_100us.filter(|&age| age < u8::MAX).map(|age| u64::from(age) * UNIT_NS);
        if let Some(age_ns) = age_ns {
            meaning.add(format_args!(" ({} ms old)", ms(age_ns)));
        }
        oldest = oldest.zip(age_ns).map(|(oldest, age)| age.max(oldest));
    }
    let since_ns = at_ns.saturating_sub(closed_ns);
    meaning.age_ns = oldest.filter(|_| !is_first).map(|age_ns| age_ns.saturating_add(since_ns));
    meaning
}

fn command_of(command: &Command<'_>) -> Meaning {
    let mut meaning = Meaning::of(format_args!("command #{}", command.sequence));
    add_signals(&mut meaning, command.values());
    meaning
}

/// The signals of a command: the wheels, then the other actuators.
pub(super) fn add_signals(meaning: &mut Meaning, signals: impl Iterator<Item = f64>) {
    for (i, signal) in signals.enumerate() {
        let mark = if i == 0 { ':' } else { ',' };
        let signal = Value(signal);
        match i {
            0 => meaning.add(format_args!("{mark} left {signal}")),
            1 => meaning.add(format_args!("{mark} right {signal}")),
            _ => meaning.add(format_args!("{mark} actuator {} {signal}", i - 2)),
        }
    }
}

/// The part of a message's meaning that needs no layout.
fn without_layout(payload: &[u8], at_ns: u64) -> Meaning {
    let len = Count(payload.len(), "byte");
    match *payload {
        [0x11, sequence, low, high, ..] => {
            let closed_ns = unwrap_time(u16::from_le_bytes([low, high]), at_ns);
            Meaning::of(format_args!("readings #{sequence}, closed at {} ms, {len}", ms(closed_ns)))
        }
        [0x12, sequence, ..] => Meaning::of(format_args!("command #{sequence}, {len}")),
        [0x13, sequence] => Meaning::of(format_args!("poll #{sequence}")),
        _ => Meaning::not_understood(payload, "a whole frame"),
    }
}

/// The name of a sensor.
pub(super) struct Name<'a>(pub(super) &'a [&'a str], pub(super) usize);

impl core::fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0.get(self.1) {
            Some(name) => f.write_str(name),
            None => write!(f, "sensor {}", self.1),
        }
    }
}
