//! The content of messages, as readings.

use baudbot_wire::create::Payload;
use baudbot_wire::khepera::{self, Answer};
use baudbot_wire::{Layout, Message, Values, clock};

use super::Reading;
use crate::firmware::{Firmware, Protocol};
use crate::time::SimTime;

/// The content of a message.
pub(super) enum Noted {
    Nonsense,
    /// Of a command: nothing that a brain waits for.
    Acknowledgement,
    /// No readings, but what a brain that asks waits for.
    Answer,
    /// The position counters of a Khepera, which become readings with the next that it tells.
    Positions([i32; 2]),
    Readings,
}

/// Notes the readings of a message.
pub(super) fn note(readings: &mut [Reading], firmware: &Firmware, payload: &[u8], at: SimTime) -> Noted {
    let layout = firmware.layout();
    match firmware.protocol {
        Protocol::Framed { .. } => note_frame(readings, &layout, payload, at),
        // The bare decoder gives a payload only when it is whole, so there is a value for every component.
        Protocol::Bare { .. } => note_all(readings, &layout, Values::new(layout.components, payload)),
        Protocol::Khepera => match Answer::parse(payload, &layout) {
            Ok(Answer::Readings(values)) => note_levels(readings, &layout, values),
            Ok(Answer::Positions(positions)) => Noted::Positions(positions),
            Ok(Answer::Acknowledgement) => Noted::Acknowledgement,
            Ok(Answer::Registers(_) | Answer::Refusal) => Noted::Answer,
            Err(_) => Noted::Nonsense,
        },
        Protocol::Create(version) => note_packets(readings, firmware, Payload { version, bytes: payload }),
    }
}

/// Notes a message of a Create's stream. A sensor that is not told has no reading; another stream than that of the layout has
/// none at all.
fn note_packets(readings: &mut [Reading], firmware: &Firmware, payload: Payload<'_>) -> Noted {
    let layout = firmware.layout();
    let mut rest = firmware.signals();
    for (reading, components) in readings.iter_mut().zip(layout.sensors()) {
        let (signals, behind) = rest.split_at(components.len().min(rest.len()));
        rest = behind;
        let told = || components.iter().zip(signals).map(|(to, signal)| payload.value((*signal)?, *to));
        if components.is_empty() || !told().all(|value| value.is_some()) {
            continue;
        }
        note_one(reading, told().flatten());
    }
    Noted::Readings
}

fn note_frame(readings: &mut [Reading], layout: &Layout<'_>, payload: &[u8], at: SimTime) -> Noted {
    let Ok(Message::Readings(message)) = Message::parse(payload, layout) else { return Noted::Nonsense };
    let closed_ns = clock::unwrap_time(message.time_100us, at.as_ns());
    for entry in message.entries() {
        let reading = &mut readings[entry.sensor];
        reading.values.clear();
        reading.values.extend(entry.values);
        // The largest age on the wire stands for any from there on, so it tells nothing.
        let age = entry.age_100us.filter(|&age| age < u8::MAX);
        let age_ns = age.map(|age| u64::from(age) * clock::UNIT_NS);
        reading.sampled_at = age_ns.map(|age_ns| SimTime::from_ns(closed_ns.saturating_sub(age_ns)));
        reading.sequence = message.sequence;
        reading.readable = true;
    }
    Noted::Readings
}

/// Notes a message that knows no readability: a value for every component.
fn note_all(readings: &mut [Reading], layout: &Layout<'_>, mut values: impl Iterator<Item = f64>) -> Noted {
    for (reading, components) in readings.iter_mut().zip(layout.sensors()) {
        note_one(reading, values.by_ref().take(components.len()));
    }
    Noted::Readings
}

/// Notes an answer to `N`: a value for every component that is no counter.
fn note_levels(
    readings: &mut [Reading],
    layout: &Layout<'_>,
    mut values: impl Iterator<Item = f64>,
) -> Noted {
    for (reading, components) in readings.iter_mut().zip(layout.sensors()) {
        if !components.is_empty() && khepera::counted(components, [0; 2]).is_none() {
            note_one(reading, values.by_ref().take(components.len()));
        }
    }
    Noted::Readings
}

/// Notes the position counters that came before an answer to `N`.
pub(super) fn note_positions(readings: &mut [Reading], layout: &Layout<'_>, positions: [i32; 2]) {
    for (reading, components) in readings.iter_mut().zip(layout.sensors()) {
        if let Some(values) = khepera::counted(components, positions) {
            note_one(reading, values.into_iter());
        }
    }
}

/// Notes values that have no number of their own on the wire.
fn note_one(reading: &mut Reading, values: impl Iterator<Item = f64>) {
    reading.values.clear();
    reading.values.extend(values);
    reading.sequence = reading.sequence.wrapping_add(1);
    reading.readable = true;
}
