//! The way from the bytes of a cable to readings.

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_wire::codec::{Notice, Sink, Stamp};
use baudbot_wire::{LayoutError, Uplink, WireLayout};

use super::RawTurn;
use super::listener::Listener;
use crate::body::Body;
use crate::turn::{Reading, Turn};

/// Turns the bytes of [`RawTurn`]s into [`Turn`]s, by the rules by which the server does it for a brain of
/// messages.
///
/// Both give the same turns, with one exception. The bare protocol marks a message that was cut short by silence, and a
/// raw turn does not have the instant of each byte. Only a silence that is certain counts here: longer than the
/// protocol's gap even if the bytes on both sides of it arrived as near to each other as their turns permit. So if
/// bytes were lost, this decoder may take longer to recover than the server's.
///
/// Readings that come as bytes. Those on the cables of sensors' own are decoded, too, if their format is known here.
#[derive(Clone, Debug)]
pub struct RawReadings {
    body: Arc<Body>,
    layout: WireLayout,
    /// The places of the layout's sensors in the body.
    places: Vec<usize>,
    uplink: Uplink,
    silence: Silence,
    /// The positions since the last readings, of a robot that sends them separately.
    positions: Option<[i32; 2]>,
    /// The listeners of the sensors with a port of their own, with their places.
    listeners: Vec<(usize, Listener)>,
    readings: Vec<Option<Reading>>,
    /// Whole messages of readings so far: their number, where they have none of their own.
    messages: u8,
}

impl RawReadings {
    /// A decoder for the robot with this body, to be given each of its turns in order. A run that is reset needs a
    /// new one, as the wire is cut and the clock starts again.
    ///
    /// # Errors
    /// If the body's encodings are such as no cable can have; those of an attached robot never are.
    pub fn new(body: Arc<Body>) -> Result<Self, LayoutError> {
        let layout = body.layout();
        layout.agreement().check()?;
        let uplink = layout.agreement().uplink()?;
        let places = body.told_sensors().map(|(place, _)| place).collect();
        let readings = vec![None; body.sensors.len()];
        let listeners = body.sensors.iter().enumerate();
        let listeners = listeners.filter_map(|(i, sensor)| Some((i, Listener::new(sensor)?))).collect();
        let (silence, positions) = (Silence::default(), None);
        Ok(Self { body, layout, places, uplink, silence, positions, listeners, readings, messages: 0 })
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
        let agreement = self.layout.agreement();
        let silent_ns = self.silence.clock_ns(raw);
        let mut has_message = false;
        for &byte in &raw.bytes {
            let Some(payload) = self.uplink.push(byte, silent_ns) else { continue };
            let sequence = self.messages.wrapping_add(1);
            let mut sink = Places { places: &self.places, readings: &mut self.readings, sequence };
            match agreement.read(payload, raw.at_ns, &mut sink) {
                Notice::Readings => {
                    if let Some(positions) = self.positions.take() {
                        agreement.read_positions(positions, &mut sink);
                    }
                    self.messages = sequence;
                    has_message = true;
                }
                Notice::Positions(positions) => self.positions = Some(positions),
                // A damaged message is lost, and its readings stay what they were.
                Notice::Nonsense | Notice::Acknowledgement | Notice::Answer => {}
            }
        }
        has_message
    }
}

/// The readings that messages bring, by the places of their sensors in the body.
struct Places<'a> {
    places: &'a [usize],
    readings: &'a mut [Option<Reading>],
    /// The number of a message that has none of its own.
    sequence: u8,
}

impl Sink for Places<'_> {
    fn take(&mut self, sensor: usize, stamp: Option<Stamp>, values: impl Iterator<Item = f64>) {
        let Stamp { sequence, sampled_at_ns } =
            stamp.unwrap_or(Stamp { sequence: self.sequence, sampled_at_ns: None });
        let values = values.collect();
        self.readings[self.places[sensor]] =
            Some(Reading { values, sampled_at_ns, sequence: sequence.into(), readable: true });
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
