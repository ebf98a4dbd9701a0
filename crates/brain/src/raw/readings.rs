//! From the bytes of a cable to readings.

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::create::{Payload, Signal, Stream, Version};
use baudbot_wire::khepera::{Answer, Lines, Numbers, counted};
use baudbot_wire::{BareDecoder, Decoder, Layout, LayoutError, Message, Values, clock};

use super::RawTurn;
use super::listener::Listener;
use crate::body::{Body, Protocol};
use crate::layout::WireLayout;
use crate::turn::{Reading, Turn};

/// Turns the bytes of [`RawTurn`]s into [`Turn`]s, by the rules by which the server does it for a brain of
/// messages.
///
/// Both give the same turns, with one exception. The bare protocol marks a message that was cut short by
/// silence, and a raw turn does not say when within the step each byte arrived. Only a silence that is
/// certain counts here: longer than the protocol's gap even if the bytes on both sides of it arrived as
/// near to each other as their turns permit. So if bytes were lost, this decoder may take longer to
/// recover than the server's.
///
/// Readings that come as bytes. Those on the cables of sensors' own are decoded, too, if their format is known here.
#[derive(Clone, Debug)]
pub struct RawReadings {
    body: Arc<Body>,
    layout: WireLayout,
    port: Port,
    /// Of the sensors with a port of their own, with their places.
    listeners: Vec<(usize, Listener)>,
    readings: Vec<Option<Reading>>,
    /// Whole messages of readings so far; only the framed protocol has another sequence number.
    messages: u8,
}

#[derive(Clone, Debug)]
enum Port {
    Framed(Decoder),
    Bare {
        decoder: BareDecoder,
        silence: Silence,
    },
    /// With the positions that were told since the last readings.
    Khepera(Lines, Option<[i32; 2]>),
    Create(Version, Stream),
}

impl RawReadings {
    /// A decoder for the robot with this body, to be given each of its turns in order. A run that is reset needs a
    /// new one, as the wire is cut and the clock starts again.
    ///
    /// # Errors
    /// If the body's encodings are such as no cable can have; those of an attached robot never are.
    pub fn new(body: Arc<Body>) -> Result<Self, LayoutError> {
        let layout = body.layout();
        layout.check(body.firmware.protocol)?;
        let port = match body.firmware.protocol {
            Protocol::Framed { .. } => Port::Framed(Decoder::new()),
            Protocol::Bare { gap_ns } => {
                let decoder = BareDecoder::new(layout.borrow().bare_readings_len(), gap_ns)?;
                Port::Bare { decoder, silence: Silence::default() }
            }
            Protocol::Khepera => Port::Khepera(Lines::of_answers(), None),
            Protocol::Create(version) => Port::Create(version, Stream::new(version, &layout.packets)),
        };
        let readings = vec![None; body.sensors.len()];
        let listeners = body.sensors.iter().enumerate();
        let listeners = listeners.filter_map(|(i, sensor)| Some((i, Listener::new(sensor)?))).collect();
        Ok(Self { body, layout, port, listeners, readings, messages: 0 })
    }

    /// The turn in messages.
    pub fn turn(&mut self, raw: &RawTurn) -> Turn {
        for reading in self.readings.iter_mut().flatten() {
            reading.readable = false;
        }
        for (place, listener) in &mut self.listeners {
            if let Some(reading) = listener.hear(raw.port(*place), raw.at_ns) {
                self.readings[*place] = Some(reading);
            }
        }
        let has_message = self.hear(raw);
        let (readings, body) = (self.readings.clone(), Arc::clone(&self.body));
        Turn { tick: raw.tick, at_ns: raw.at_ns, readings, body, has_message }
    }

    /// Takes the bytes of the microcontroller; the answer is whether they were a whole message of readings.
    fn hear(&mut self, raw: &RawTurn) -> bool {
        let Self { layout, port, readings, messages, .. } = self;
        let mut has_message = false;
        let (signals, places) = (&layout.signals, &layout.places);
        let layout = layout.borrow();
        match port {
            Port::Framed(decoder) => hear_frames(decoder, &raw.bytes, |payload| {
                has_message |= note_frame(readings, (&layout, places), payload, raw.at_ns);
            }),
            Port::Bare { decoder, silence } => {
                let at_ns = silence.clock_ns(raw);
                for &byte in &raw.bytes {
                    if let Some(payload) = decoder.push(byte, at_ns) {
                        *messages = messages.wrapping_add(1);
                        let values = Values::new(layout.components, payload);
                        has_message = true;
                        note_all(readings, (&layout, places), values, *messages);
                    }
                }
            }
            Port::Khepera(lines, positions) => {
                hear_lines((lines, positions), &raw.bytes, &layout, |told| {
                    *messages = messages.wrapping_add(1);
                    has_message = true;
                    note_lines(readings, (&layout, places), told, *messages);
                });
            }
            Port::Create(version, stream) => {
                hear_stream((*version, stream), &raw.bytes, |payload| {
                    *messages = messages.wrapping_add(1);
                    has_message = true;
                    note_packets(readings, (&layout, places, signals), payload, *messages);
                });
            }
        }
        has_message
    }
}

/// The answers of a Khepera: the positions of its wheels, if they came, and the values of all else.
type Told<'a> = (Option<[i32; 2]>, Numbers<'a>);

/// Notes the frames that these bytes complete. A damaged one is lost, and its readings stay what they were.
fn hear_frames(decoder: &mut Decoder, bytes: &[u8], mut note: impl FnMut(&[u8])) {
    for &byte in bytes {
        if let Some(Ok(payload)) = decoder.push(byte) {
            note(payload);
        }
    }
}

/// Notes the readings of a Khepera that these bytes complete.
fn hear_lines<'a>(
    (lines, positions): (&mut Lines, &mut Option<[i32; 2]>),
    bytes: &[u8],
    layout: &Layout<'a>,
    mut note: impl FnMut(Told<'_>),
) {
    for &byte in bytes {
        let Some(Ok(line)) = lines.push(byte) else { continue };
        match Answer::parse(line, layout) {
            Ok(Answer::Positions(told)) => *positions = Some(told),
            Ok(Answer::Readings(levels)) => note((positions.take(), levels)),
            Ok(Answer::Acknowledgement | Answer::Registers(_) | Answer::Refusal) | Err(_) => {}
        }
    }
}

/// Notes the messages of a Create's stream that these bytes complete.
fn hear_stream((version, stream): (Version, &mut Stream), bytes: &[u8], mut note: impl FnMut(Payload<'_>)) {
    for &byte in bytes {
        if let Some(Ok(bytes)) = stream.push(byte) {
            note(Payload { version, bytes });
        }
    }
}

/// Notes a message of a Create's stream. A sensor that is not told has no reading.
fn note_packets(
    readings: &mut [Option<Reading>],
    (layout, places, mut rest): (&Layout<'_>, &[usize], &[Option<Signal>]),
    payload: Payload<'_>,
    sequence: u8,
) {
    for (&place, components) in places.iter().zip(layout.sensors()) {
        let (signals, behind) = rest.split_at(components.len().min(rest.len()));
        rest = behind;
        let values: Option<Vec<_>> =
            components.iter().zip(signals).map(|(to, signal)| payload.value((*signal)?, *to)).collect();
        if let Some(values) = values.filter(|values| !values.is_empty()) {
            readings[place] =
                Some(Reading { values, sampled_at_ns: None, sequence: sequence.into(), readable: true });
        }
    }
}

/// Notes the readings of a frame; a message that makes no sense is lost.
fn note_frame(
    readings: &mut [Option<Reading>],
    (layout, places): (&Layout<'_>, &[usize]),
    payload: &[u8],
    at_ns: u64,
) -> bool {
    let Ok(Message::Readings(message)) = Message::parse(payload, layout) else { return false };
    let closed_ns = clock::unwrap_time(message.time_100us, at_ns);
    for entry in message.entries() {
        // The largest age on the wire stands for any from there on, so it tells nothing.
        let age = entry.age_100us.filter(|&age| age < u8::MAX);
        let age_ns = age.map(|age| u64::from(age) * clock::UNIT_NS);
        let reading = Reading {
            values: entry.values.collect(),
            sampled_at_ns: age_ns.map(|age_ns| closed_ns.saturating_sub(age_ns)),
            sequence: message.sequence.into(),
            readable: true,
        };
        readings[places[entry.sensor]] = Some(reading);
    }
    true
}

/// Notes a message that knows no readability, so that every value that arrives is readable.
fn note_all(
    readings: &mut [Option<Reading>],
    (layout, places): (&Layout<'_>, &[usize]),
    mut values: impl Iterator<Item = f64>,
    sequence: u8,
) {
    for (&place, components) in places.iter().zip(layout.sensors()) {
        let values = values.by_ref().take(components.len()).collect();
        readings[place] =
            Some(Reading { values, sampled_at_ns: None, sequence: sequence.into(), readable: true });
    }
}

/// Notes a Khepera's answer to `N`, and the positions that came before it, if any did.
fn note_lines(
    readings: &mut [Option<Reading>],
    (layout, places): (&Layout<'_>, &[usize]),
    (positions, mut levels): Told<'_>,
    sequence: u8,
) {
    for (&place, components) in places.iter().zip(layout.sensors()) {
        let values = match (counted(components, positions.unwrap_or_default()), positions) {
            (Some(_), None) => continue,
            (Some(values), Some(_)) => values.to_vec(),
            (None, _) => levels.by_ref().take(components.len()).collect(),
        };
        readings[place] =
            Some(Reading { values, sampled_at_ns: None, sequence: sequence.into(), readable: true });
    }
}

/// A clock that goes on only while the wire is certainly silent.
#[derive(Clone, Debug, Default)]
struct Silence {
    clock_ns: u64,
    last_turn_ns: u64,
    last_bytes_ns: u64,
}

impl Silence {
    /// The reading of the clock for all bytes of this turn. They arrived after the turn before it, those
    /// before them by their own turn at the latest: what lies between is silence.
    fn clock_ns(&mut self, raw: &RawTurn) -> u64 {
        if !raw.bytes.is_empty() {
            let silence_ns = self.last_turn_ns.saturating_sub(self.last_bytes_ns);
            self.clock_ns = self.clock_ns.saturating_add(silence_ns);
            self.last_bytes_ns = raw.at_ns;
        }
        self.last_turn_ns = raw.at_ns;
        self.clock_ns
    }
}
