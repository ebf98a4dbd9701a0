//! The codec of a brain that reads and writes the wire's bytes itself. With it such a brain sees the turns
//! that a brain of messages sees.

use std::sync::Arc;

use baudbot_wire::khepera::{self, Answer, Lines};
use baudbot_wire::{
    BareDecoder, Decoder, Encoding, Layout, LayoutError, Message, Values, clock, frame, poll, write_command,
    write_values,
};

use crate::body::{Body, Protocol, Sensor};
use crate::listener::Listener;
use crate::raw::RawTurn;
use crate::turn::{Reading, Signals, Turn};

/// Owns what a [`Layout`] borrows.
#[derive(Clone, Debug, PartialEq)]
pub struct WireLayout {
    components: Vec<Encoding>,
    counts: Vec<u8>,
    /// The places of the sensors on the wire in the body.
    places: Vec<usize>,
    motors: Vec<Encoding>,
    ages: bool,
}

impl WireLayout {
    pub(crate) fn new(body: &Body) -> Self {
        // A brain on board gets its readings without a message, unless they are lines.
        let has_messages = !body.onboard || body.firmware.protocol == Protocol::Khepera;
        let sensors = || body.sensors.iter().enumerate();
        let on_wire = || sensors().filter(|(_, sensor)| has_messages && sensor.is_on_wire());
        let counts = on_wire().map(|(_, sensor)| u8::try_from(sensor.values()).unwrap_or(u8::MAX));
        Self {
            components: on_wire().flat_map(|(_, sensor)| encodings(sensor)).collect(),
            counts: counts.collect(),
            places: on_wire().map(|(place, _)| place).collect(),
            motors: vec![body.motor_encoding; 2 + body.actuators.len()],
            ages: matches!(body.firmware.protocol, Protocol::Framed { ages: true }),
        }
    }

    /// The layout.
    pub fn borrow(&self) -> Layout<'_> {
        Layout { components: &self.components, counts: &self.counts, motors: &self.motors, ages: self.ages }
    }

    /// Whether messages of this protocol can be made of it.
    pub(crate) fn check(&self, protocol: Protocol) -> Result<(), LayoutError> {
        self.borrow().check()?;
        match protocol {
            Protocol::Framed { .. } | Protocol::Bare { .. } => Ok(()),
            Protocol::Khepera => khepera::check(&self.borrow()),
        }
    }

    /// The most bytes that a command takes on the wire.
    pub(crate) fn command_wire_len(&self, protocol: Protocol) -> usize {
        match protocol {
            Protocol::Framed { .. } => frame::encoded_len_max(self.borrow().command_len()),
            Protocol::Bare { .. } => self.borrow().bare_command_len(),
            Protocol::Khepera => khepera::command_len_max(&self.borrow()) + khepera::POLL.len(),
        }
    }
}

/// Those of all values of a sensor. No cable has sensors of more than 255 values; one more is enough for the
/// layout's check to find that.
fn encodings(sensor: &Sensor) -> impl Iterator<Item = Encoding> {
    let values = sensor.components.iter().flat_map(|part| std::iter::repeat_n(part.encoding, part.count));
    values.take(usize::from(u8::MAX) + 1)
}

/// Turns the bytes of [`RawTurn`]s into [`Turn`]s, by the rules by which the server does it for a brain of
/// messages.
///
/// Both give the same turns, with one exception. The bare protocol marks a message that was cut short by
/// silence, and a raw turn does not say when within the step each byte arrived. Only a silence that is
/// certain counts here: longer than the protocol's gap even if the bytes on both sides of it arrived as
/// near to each other as their turns permit. So if bytes were lost, this decoder may take longer to
/// recover than the server's.
///
/// What comes over the cables of sensors' own is decoded, too, if its format is known here.
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
    Bare { decoder: BareDecoder, silence: Silence },
    Khepera(Lines),
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
            Protocol::Khepera => Port::Khepera(Lines::of_answers()),
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
        let Self { body, layout, port, listeners, readings, messages } = self;
        for (place, listener) in listeners {
            if let Some(reading) = listener.hear(raw.port(*place), raw.at_ns) {
                readings[*place] = Some(reading);
            }
        }
        let (layout, places) = (layout.borrow(), &layout.places);
        match port {
            Port::Framed(decoder) => {
                for &byte in &raw.bytes {
                    // A damaged frame is lost, and its readings stay what they were.
                    if let Some(Ok(payload)) = decoder.push(byte) {
                        note_frame(readings, (&layout, places), payload, raw.at_ns);
                    }
                }
            }
            Port::Bare { decoder, silence } => {
                let at_ns = silence.clock_ns(raw);
                for &byte in &raw.bytes {
                    if let Some(payload) = decoder.push(byte, at_ns) {
                        *messages = messages.wrapping_add(1);
                        let values = Values::new(layout.components, payload);
                        note_all(readings, (&layout, places), values, *messages);
                    }
                }
            }
            Port::Khepera(lines) => {
                for &byte in &raw.bytes {
                    let Some(Ok(line)) = lines.push(byte) else { continue };
                    if let Ok(Answer::Readings(values)) = Answer::parse(line, &layout) {
                        *messages = messages.wrapping_add(1);
                        note_all(readings, (&layout, places), values, *messages);
                    }
                }
            }
        }
        Turn { tick: raw.tick, at_ns: raw.at_ns, readings: readings.clone(), body: Arc::clone(body) }
    }
}

/// Notes the readings of a frame; a message that makes no sense is lost.
fn note_frame(
    readings: &mut [Option<Reading>],
    (layout, places): (&Layout<'_>, &[usize]),
    payload: &[u8],
    at_ns: u64,
) {
    let Ok(Message::Readings(message)) = Message::parse(payload, layout) else { return };
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

/// Turns signals into the bytes of commands.
#[derive(Clone, Debug)]
pub struct RawCommands {
    layout: WireLayout,
    protocol: Protocol,
    sequence: u8,
    /// What was last sent to the actuators besides the wheels.
    others: Vec<f64>,
}

impl RawCommands {
    /// An encoder for the robot with this body.
    ///
    /// # Errors
    /// As [`RawReadings::new`].
    pub fn new(body: &Body) -> Result<Self, LayoutError> {
        let layout = body.layout();
        layout.check(body.firmware.protocol)?;
        let others = vec![0.0; body.actuators.len()];
        Ok(Self { layout, protocol: body.firmware.protocol, sequence: 0, others })
    }

    /// The bytes of a command, with a poll behind it where a command does not ask for readings; the actuators besides
    /// the wheels get what was last sent to them, at first 0.
    pub fn command(&mut self, signals: Signals) -> Vec<u8> {
        self.command_with(signals, &[])
    }

    /// The bytes of a command with signals for the actuators besides the wheels, in the order of
    /// [`Body::actuators`]. Those beyond the end of `others` get what was last sent to them, at first 0.
    pub fn command_with(&mut self, signals: Signals, others: &[f64]) -> Vec<u8> {
        for (last, &new) in self.others.iter_mut().zip(others) {
            *last = new;
        }
        let sequence = self.sequence;
        let signals = [signals.left, signals.right].into_iter().chain(self.others.iter().copied());
        let (layout, mut bytes) = (self.layout.borrow(), [0; frame::MAX_PAYLOAD]);
        // None can fail: the layout was checked and gets a value for each of its motors.
        match self.protocol {
            Protocol::Bare { .. } => {
                let len = write_values(layout.motors, signals, &mut bytes).unwrap_or(0);
                bytes[..len].to_vec()
            }
            Protocol::Khepera => {
                let len = khepera::write_exchange(&layout, signals, &mut bytes).unwrap_or(0);
                bytes[..len].to_vec()
            }
            Protocol::Framed { .. } => {
                let len = write_command(&layout, sequence, signals, &mut bytes).unwrap_or(0);
                self.next_sequence();
                framed(&bytes[..len])
            }
        }
    }

    /// The bytes of a request for readings; `None` in the bare protocol, which has none.
    pub fn poll(&mut self) -> Option<Vec<u8>> {
        match self.protocol {
            Protocol::Bare { .. } => None,
            Protocol::Framed { .. } => Some(framed(&poll(self.next_sequence()))),
            Protocol::Khepera => Some(khepera::POLL.to_vec()),
        }
    }

    fn next_sequence(&mut self) -> u8 {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        sequence
    }
}

fn framed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = [0; frame::MAX_FRAME];
    // Cannot fail: no payload is longer than the layout's check permits.
    let len = frame::encode(payload, &mut bytes).unwrap_or(0);
    bytes[..len].to_vec()
}
