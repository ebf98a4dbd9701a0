//! The laptop's end of the link: what has arrived, decoded, with the state of readability.

use alloc::vec::Vec;

use baudbot_wire::{Message, Values, clock};
use serde::{Deserialize, Serialize};

use crate::firmware::{Decoder, Firmware, Found, Protocol};
use crate::link::LineCounters;
use crate::time::SimTime;

/// The last reading of one sensor that reached the laptop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// One value a component, in SI units, as the wire's quantisation left them; empty if none came yet.
    pub values: Vec<f64>,
    /// When it was sampled, by the microcontroller's clock and to its resolution on the wire (0.1 ms);
    /// `None` if the protocol does not say.
    pub sampled_at: Option<SimTime>,
    /// Sequence number of the frame that brought it.
    pub sequence: u8,
    /// New since the brain was last given it (§3.2.1).
    pub readable: bool,
}

/// State of the laptop's end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Laptop {
    decoder: Decoder,
    pub(crate) readings: Vec<Reading>,
    /// Bytes that arrived since the brain's last step.
    pub(crate) unread: Vec<u8>,
    /// A message has arrived whole since the brain's last step.
    pub(crate) has_message: bool,
    /// Until when the brain thinks.
    pub(crate) busy_until: SimTime,
    pub(crate) freshness: Vec<Freshness>,
}

/// How old one sensor's readings were when the brain got them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Freshness {
    /// Steps of the brain in which the sensor was readable.
    pub readable: u64,
    /// Readings among them that told their age.
    pub aged: u64,
    /// Sum of those ages, in nanoseconds.
    pub age_sum_ns: u64,
    /// The largest of those ages, in nanoseconds.
    pub age_max_ns: u64,
}

impl Laptop {
    pub(crate) fn new(firmware: &Firmware) -> Self {
        let sensors = firmware.layout().counts.len();
        Self {
            decoder: firmware.reading_decoder(),
            readings: alloc::vec![Reading::default(); sensors],
            unread: Vec::new(),
            has_message: false,
            busy_until: SimTime::ZERO,
            freshness: alloc::vec![Freshness::default(); sensors],
        }
    }

    /// A byte arrives. Those that a brain leaves unread beyond `buffer` are lost, as in any driver.
    pub(crate) fn receive(
        &mut self,
        firmware: &Firmware,
        buffer: usize,
        (at, byte): (SimTime, u8),
        counters: &mut LineCounters,
    ) {
        if self.unread.len() >= buffer {
            counters.overrun_bytes += 1;
            return;
        }
        self.unread.push(byte);
        let before = self.decoder.cut_short();
        match self.decoder.push(byte, at) {
            Found::Nothing => {}
            Found::BadFrame => counters.bad_frames += 1,
            Found::Payload(payload) => {
                if note(&mut self.readings, firmware, payload, at) {
                    counters.messages += 1;
                    self.has_message = true;
                } else {
                    counters.bad_messages += 1;
                }
            }
        }
        counters.bad_messages += self.decoder.cut_short() - before;
    }

    /// The brain steps at `at`: it has now been given all that arrived.
    pub(crate) fn hand_over(&mut self, at: SimTime) {
        self.unread.clear();
        self.has_message = false;
        self.busy_until = at;
        for (reading, freshness) in self.readings.iter_mut().zip(&mut self.freshness) {
            if !core::mem::take(&mut reading.readable) {
                continue;
            }
            freshness.readable += 1;
            if let Some(sampled_at) = reading.sampled_at {
                let age = at.since(sampled_at);
                freshness.aged += 1;
                freshness.age_sum_ns += age;
                freshness.age_max_ns = freshness.age_max_ns.max(age);
            }
        }
    }
}

/// Notes the readings of a message; `false` if it makes no sense.
fn note(readings: &mut [Reading], firmware: &Firmware, payload: &[u8], at: SimTime) -> bool {
    if let Protocol::Bare { .. } = firmware.protocol {
        return note_bare(readings, firmware, payload);
    }
    let layout = firmware.layout();
    let Ok(Message::Readings(message)) = Message::parse(payload, &layout) else { return false };
    let closed_ns = clock::unwrap_time(message.time_100us, at.as_ns());
    for entry in message.entries() {
        let reading = &mut readings[entry.sensor];
        reading.values.clear();
        reading.values.extend(entry.values);
        let age_ns = entry.age_100us.map(|age| u64::from(age) * clock::UNIT_NS);
        reading.sampled_at = age_ns.map(|age_ns| SimTime::from_ns(closed_ns.saturating_sub(age_ns)));
        reading.sequence = message.sequence;
        reading.readable = true;
    }
    true
}

/// The bare decoder gives a payload only when it is whole, so there is a value for every component.
fn note_bare(readings: &mut [Reading], firmware: &Firmware, payload: &[u8]) -> bool {
    let layout = firmware.layout();
    let mut values = Values::new(layout.components, payload);
    for (reading, components) in readings.iter_mut().zip(layout.sensors()) {
        reading.values.clear();
        reading.values.extend(values.by_ref().take(components.len()));
        reading.sequence = reading.sequence.wrapping_add(1);
        reading.readable = true;
    }
    true
}
