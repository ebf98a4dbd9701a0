//! The laptop's end of the link: what has arrived, decoded, with the state of readability.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use baudbot_wire::codec::{Notice, Sink, Stamp};
use serde::{Deserialize, Serialize};

use crate::firmware::{Decoder, Firmware, Found};
use crate::freshness::Freshness;
use crate::heard::AllHeard;
use crate::link::{Line, Message as Arrived};
use crate::model::{PortUse, RobotSpec};
use crate::sensor::Sensor;
use crate::sensor::port::{PortState, Received};
use crate::time::SimTime;
use crate::values::ReadingValues;

/// The last reading of one sensor that reached the laptop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// One value a component, in SI units, as the wire's quantisation left them; empty if none came yet.
    pub values: ReadingValues,
    /// The instant at which it was sampled, by the microcontroller's clock and to its resolution on the wire (0.1 ms);
    /// `None` if the protocol does not give it, or the sample was 25.5 ms old or more when its frame was closed. A
    /// sample within a tick is of the scene at the tick's start.
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
    /// The instants at which each of them arrived, for a program that has opened the port.
    #[serde(skip)]
    pub(crate) instants: Vec<SimTime>,
    /// Bytes that have arrived in this tick for a program in simulated time, which has not heard of them yet. A replay has no
    /// program: they are no part of the state.
    #[serde(skip)]
    pub(crate) arrived: Vec<u8>,
    /// A message has arrived whole since the brain's last step.
    pub(crate) has_message: bool,
    /// The instant until which the brain thinks.
    pub(crate) busy_until: SimTime,
    pub(crate) freshness: Vec<Freshness>,
    /// The instants at which the readings that are readable were truly sampled.
    sampled: Vec<Option<SimTime>>,
    /// The truth for observers.
    #[serde(skip)]
    pub(crate) truth: AllHeard,
    /// Began the control cycle of the newest message of the microcontroller's since the brain's last step.
    heard: Option<SimTime>,
    /// The ticks of the brain's last steps, and when the control cycles began that it had to answer in them.
    asked: VecDeque<(u64, Option<SimTime>)>,
    /// In which tick the step was that is answered now; `None` if it is the last one.
    pub(crate) answers_tick: Option<u64>,
    /// Whether it has been answered.
    has_answered: bool,
    /// Whether a message had come before the brain's last step.
    pub(crate) informed: bool,
    /// Whether there is a brain, and it has taken the step.
    pub(crate) has_stepped: bool,
}

impl Laptop {
    pub(crate) fn new(sensors: usize, firmware: &Firmware) -> Self {
        Self {
            decoder: firmware.reading_decoder(),
            readings: alloc::vec![Reading::default(); sensors],
            unread: Vec::new(),
            instants: Vec::new(),
            arrived: Vec::new(),
            has_message: false,
            busy_until: SimTime::ZERO,
            freshness: alloc::vec![Freshness::default(); sensors],
            sampled: alloc::vec![None; sensors],
            truth: AllHeard::default(),
            heard: None,
            asked: VecDeque::new(),
            answers_tick: None,
            has_answered: false,
            informed: false,
            has_stepped: false,
        }
    }

    /// Whether this laptop may have become what `other` is, on a robot that is this: there is of everything as much as it
    /// has sensors, and a reading has all of its values or none.
    pub(crate) fn may_become(&self, spec: &RobotSpec, other: &Self) -> bool {
        let sensors = spec.sensors.len();
        let fits = |(reading, sensor): (&Reading, &Sensor)| {
            reading.values.is_empty() || reading.values.len() == sensor.encodings.len()
        };
        [other.readings.len(), other.freshness.len(), other.sampled.len()] == [sensors; 3]
            && other.readings.iter().zip(&*spec.sensors).all(fits)
            && other
                .freshness
                .iter()
                .all(|fresh| fresh.ages.is_sound() && crate::sound::count(fresh.readable))
            && other.asked.len() <= MAX_ASKED
            && self.decoder.may_become(&other.decoder)
    }

    /// A byte arrives, and with it perhaps the end of a message. Those that a brain leaves unread beyond the driver's
    /// buffer are lost.
    pub(crate) fn receive(
        &mut self,
        spec: &RobotSpec,
        (at, byte): (SimTime, u8),
        uplink: &mut Line,
    ) -> Option<Arrived> {
        if self.unread.len() >= spec.link.laptop_buffer() {
            uplink.counters.overrun_bytes += 1;
            return None;
        }
        match spec.port_use {
            PortUse::Closed => self.unread.push(byte),
            PortUse::Open | PortUse::Simulated => self.keep_for_program(spec.port_use, (at, byte)),
        }
        if spec.chip.as_ref().is_some_and(|chip| chip.is_opaque()) {
            return None;
        }
        let before = self.decoder.cut_short();
        let found = match self.decoder.push(byte, at) {
            Found::Nothing => {
                uplink.counters.bad_messages += self.decoder.cut_short() - before;
                return None;
            }
            Found::BadFrame => {
                uplink.counters.bad_frames += 1;
                None
            }
            Found::Payload(payload) => {
                let sink = &mut Arrivals(&mut self.readings);
                Some(spec.firmware.agreement().read(payload, at.as_ns(), sink))
            }
        };
        uplink.counters.bad_messages += self.decoder.cut_short() - before;
        self.take_noted(spec, found, (at, uplink))
    }

    /// Out of line, as brains, which most robots have, get messages.
    #[cold]
    #[inline(never)]
    fn keep_for_program(&mut self, port_use: PortUse, (at, byte): (SimTime, u8)) {
        if port_use == PortUse::Simulated {
            self.arrived.push(byte);
        } else {
            self.unread.push(byte);
            self.instants.push(at);
        }
    }

    /// Takes a byte. The message that it ended counts, if it ended one; of readings the answer is their meaning.
    fn take_noted(
        &mut self,
        spec: &RobotSpec,
        found: Option<Notice>,
        (at, uplink): (SimTime, &mut Line),
    ) -> Option<Arrived> {
        match found {
            None => {}
            Some(Notice::Nonsense) => uplink.counters.bad_messages += 1,
            Some(Notice::Acknowledgement) => uplink.counters.messages += 1,
            Some(Notice::Answer) => {
                uplink.counters.messages += 1;
                self.has_message = true;
            }
            Some(Notice::Positions(positions)) => {
                uplink.counters.messages += 1;
                self.has_message = true;
                self.decoder.keep_positions(positions);
                if let Some(message) = uplink.message() {
                    self.note_ages(&message);
                    self.truth.keep_positions(&message.sampled);
                }
            }
            Some(Notice::Readings) => {
                if let Some(positions) = self.decoder.take_positions() {
                    let sink = &mut Arrivals(&mut self.readings);
                    spec.firmware.agreement().read_positions(positions, sink);
                    self.truth.take_positions(at);
                }
                uplink.counters.messages += 1;
                self.has_message = true;
                let message = uplink.message();
                match &message {
                    Some(message) => {
                        self.note_ages(message);
                        self.hear(message, at);
                        self.heard = message.cycle;
                    }
                    None => self.hear_unknown(at),
                }
                return message;
            }
        }
        None
    }

    /// Takes the bytes of a message that is [noted](Self::note_message) besides; false, and nothing is done, if it
    /// matters which they are.
    pub(crate) fn take_at_once(&mut self, spec: &RobotSpec, bytes: &[u8]) -> bool {
        let has_room = self.unread.len() + bytes.len() <= spec.link.laptop_buffer();
        let is_taken = has_room && self.decoder.is_between_frames();
        if is_taken {
            self.unread.extend_from_slice(bytes);
        }
        is_taken
    }

    /// A message has come without a cable, of a control cycle that began at `begun`.
    pub(crate) fn note_message(&mut self, begun: SimTime) {
        self.has_message = true;
        self.heard = Some(begun);
    }

    /// Whether a message of the microcontroller's readings has come since the brain's last step: with new readings, or without.
    pub(crate) fn has_heard(&self, spec: &RobotSpec) -> bool {
        let mut on_wire =
            self.readings.iter().zip(&*spec.sensors).filter(|(_, sensor)| sensor.port.is_none());
        self.heard.is_some() || on_wire.any(|(reading, _)| reading.readable)
    }

    /// Each sensor's reading with the true instant of its sample, and the truth for observers.
    pub(crate) fn readings_with_truth(
        &mut self,
    ) -> (impl Iterator<Item = (&mut Reading, &mut Option<SimTime>)>, &mut AllHeard) {
        (self.readings.iter_mut().zip(&mut self.sampled), &mut self.truth)
    }

    fn note_ages(&mut self, message: &Arrived) {
        for &(i, sampled_at) in &message.sampled {
            self.sampled[i] = Some(sampled_at);
        }
    }

    fn hear(&mut self, message: &Arrived, now: SimTime) {
        message.sampled.iter().for_each(|&(i, sampled_at)| self.truth.take(i, now, Some(sampled_at)));
    }

    /// Readings have come of which it is not known when they were sampled, nor which of the new ones they are.
    fn hear_unknown(&mut self, now: SimTime) {
        let new = self.readings.iter().enumerate().filter(|(_, reading)| reading.readable);
        new.for_each(|(i, _)| self.truth.take(i, now, None));
    }

    /// A byte arrives on the cable of sensor `i`'s own. If it ends a message that is no reading, the answer is whether
    /// readings follow it.
    pub(crate) fn receive_from_port(
        &mut self,
        spec: &RobotSpec,
        i: usize,
        arrival: (SimTime, u8),
        state: &mut PortState,
    ) -> Option<bool> {
        let sensor = &spec.sensors[i];
        let port = sensor.port.as_ref()?;
        let received = state.receive(port, &sensor.device, arrival, spec.port_use);
        let (values, sampled_at) = match received {
            Received::Reading(values, sampled_at) => (values, sampled_at),
            Received::Answer(is_start) => return Some(is_start),
            Received::Bad => return Some(false),
            Received::Nothing => return None,
        };
        self.has_message = true;
        let reading = &mut self.readings[i];
        let sequence = reading.sequence.wrapping_add(1);
        *reading = Reading { values: values.into(), sampled_at, sequence, readable: true };
        let message = state.line.message();
        self.truth.take(i, arrival.0, None);
        if let Some(message) = &message {
            self.note_ages(message);
            self.hear(message, arrival.0);
        }
        None
    }

    /// The instant at which the control cycle began that what is written now answers.
    pub(crate) fn answer(&mut self) -> Option<SimTime> {
        match self.answers_tick {
            None => {
                self.has_answered = true;
                self.asked.back()?.1
            }
            Some(tick) => self.asked.iter().find(|(other, _)| *other == tick)?.1,
        }
    }

    /// The instant at which the control cycle began that the brain's step has not answered, now that it is over.
    pub(crate) fn left_unanswered(&mut self) -> Option<SimTime> {
        self.answers_tick = None;
        if self.has_answered { None } else { self.asked.back()?.1 }
    }

    /// The brain steps at `at`, in this tick: it has now been given all that arrived, which is no longer readable (§3.2.1).
    pub(crate) fn hand_over(&mut self, tick: u64, at: SimTime) {
        if self.asked.len() == MAX_ASKED {
            self.asked.pop_front();
        }
        self.asked.push_back((tick, self.heard.take()));
        self.has_answered = false;
        self.unread.clear();
        self.instants.clear();
        self.informed = core::mem::take(&mut self.has_message);
        self.busy_until = at;
        for ((reading, sampled_at), freshness) in
            self.readings.iter_mut().zip(&mut self.sampled).zip(&mut self.freshness)
        {
            if core::mem::take(&mut reading.readable) {
                freshness.note(at, sampled_at.take());
            }
        }
    }
}

/// The readings that messages bring. Those without a number of their own are counted.
struct Arrivals<'a>(&'a mut [Reading]);

impl Sink for Arrivals<'_> {
    #[inline]
    fn take(&mut self, sensor: usize, stamp: Option<Stamp>, values: impl Iterator<Item = f64>) {
        let reading = &mut self.0[sensor];
        reading.values.clear();
        reading.values.extend(values);
        reading.readable = true;
        match stamp {
            Some(Stamp { sequence, sampled_at_ns }) => {
                (reading.sequence, reading.sampled_at) = (sequence, sampled_at_ns.map(SimTime::from_ns));
            }
            None => reading.sequence = reading.sequence.wrapping_add(1),
        }
    }
}

/// Most steps of the brain that it may answer later than in their ticks, and be known to.
const MAX_ASKED: usize = 64;
