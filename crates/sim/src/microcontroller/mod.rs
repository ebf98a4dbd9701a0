//! The microcontroller: one processor with a timeline.
//!
//! It does one thing at a time, each to its end, in the order in which they fell due: read a sensor, frame
//! and send readings, take bytes from its receiver and obey them. What takes its time delays the rest; what
//! fell due more than once meanwhile was missed; bytes that found the receiver full are lost.
//!
//! **Reset.** Opening a serial port pulls DTR, which resets the chip of many boards; its bootloader then waits for a new
//! program before it starts the firmware (`Processor::bootloader_ns`). Until then the processor is busy, and what it
//! receives is lost. *Deviation:* the garbled bytes that some boards send right after that are not modelled.

mod acquire;
mod asercom;
mod at_once;
mod channel;
mod condition;
mod create;
mod devices;
mod khepera;
mod onboard;
mod request;
mod start;
mod tells;

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use acquire::first_due;
use baudbot_wire::{Layout, Sample, clock, frame, message, write_values};
pub(crate) use channel::Channel;
pub(crate) use condition::Condition;
use request::Request;
use serde::{Deserialize, Serialize};
use start::missed_start;
use tells::Tells;

use crate::drive::Wheels;
use crate::firmware::{Decoder, Firmware, Found, Mode, Owed, Protocol, Refusal, Registers};
use crate::link::{Line, LineCounters, Link};
use crate::model::RobotSpec;
use crate::schedule::Due;
use crate::sound;
use crate::time::SimTime;

/// State of the microcontroller.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Microcontroller {
    free_at: SimTime,
    channels: Vec<Channel>,
    /// The instant of the next frame of readings; never in poll mode, and of a Create, before a request.
    frame: Due,
    /// The instant at which the first sensor is due, and which that is, once one has been read.
    #[serde(skip)]
    first_due: Option<(SimTime, usize)>,
    sequence: u8,
    decoder: Decoder,
    orders: VecDeque<Order>,
    pub(crate) commands: u64,
}

/// A command that is obeyed at an instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Order {
    pub(crate) at: SimTime,
    pub(crate) signals: Wheels,
    /// The signals of the other actuators, in their order.
    pub(crate) others: Vec<f64>,
}

/// A message that was sent.
pub(crate) struct Sent {
    pub(crate) bytes: u32,
    /// The instant at which the control cycle began that it belongs to; `None` if there are no readings in it.
    pub(crate) cycle: Option<SimTime>,
    /// The instant at which it was framed.
    pub(crate) closed: SimTime,
    /// The beginning and the end of the message on the wire.
    pub(crate) on_wire: (SimTime, SimTime),
}

/// The message that a byte from the laptop completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Taken {
    /// No message is complete yet.
    Part,
    /// A message that made no sense.
    Nonsense,
    Poll,
    /// A command, which is obeyed at this instant.
    Command(SimTime),
}

/// The next task of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    Acquire(usize),
    SendReadings,
    Receive,
}

impl Microcontroller {
    pub(crate) fn new(spec: &RobotSpec, seed: u64, noise: bool) -> Self {
        let frame = match spec.firmware.mode {
            Mode::Stream(schedule) if !spec.firmware.is_silent_at_first() && spec.chip.is_none() => {
                schedule.start()
            }
            Mode::Stream(_) | Mode::Poll => Due { next: SimTime::NEVER, missed: 0 },
        };
        Self {
            free_at: SimTime::from_ns(spec.processor.bootloader_ns),
            channels: spec.sensors.iter().map(|sensor| Channel::new(spec, sensor, seed, noise)).collect(),
            frame,
            first_due: None,
            sequence: 0,
            decoder: spec.firmware.command_decoder(),
            orders: VecDeque::new(),
            commands: 0,
        }
    }

    /// Whether this processor may have become what `other` is at `now`, on a robot that is this.
    pub(crate) fn may_become(&self, spec: &RobotSpec, other: &Self, now: SimTime) -> bool {
        let channels = self.channels.iter().zip(&other.channels).zip(&*spec.sensors);
        // Orders are obeyed one behind the other, none later than the processor is done with it.
        let mut orders = other.orders.iter().map(|order| order.at);
        let signals = |order: &Order| {
            sound::wheels(&order.signals)
                && sound::numbers(order.others.iter().copied())
                && order.others.len() == spec.actuators.len()
        };
        other.channels.len() == spec.sensors.len()
            && channels.into_iter().all(|((own, other), sensor)| own.may_become(sensor, other, now))
            && other.frame.is_sound()
            && self.decoder.may_become(&other.decoder)
            && orders.clone().is_sorted()
            && orders.next_back().is_none_or(|last| last <= other.free_at)
            && other.orders.iter().all(signals)
            && sound::count(other.commands)
    }

    /// The task that comes next and when it starts: of those that fall due first, sensors in their order,
    /// then sending, then receiving.
    pub(crate) fn next(&self, link: &Link, downlink: &Line) -> (SimTime, Task) {
        let mut due = downlink.arrival(link);
        let mut task = Task::Receive;
        if self.frame.next <= due {
            (due, task) = (self.frame.next, Task::SendReadings);
        }
        let (first, i) = self.first_due.unwrap_or_else(|| first_due(&self.channels));
        if first <= due && i < self.channels.len() {
            (due, task) = (first, Task::Acquire(i));
        }
        (due.max(self.free_at), task)
    }

    /// Frames what is readable (§3.2.1) and puts it on the line; waits until the transmitter has taken it all.
    /// `sampled` is memory for what is to be known of the
    /// message, used before.
    pub(crate) fn send_readings(
        &mut self,
        spec: &RobotSpec,
        now: SimTime,
        uplink: &mut Line,
        robot: &Condition<'_>,
        sampled: Vec<(usize, SimTime)>,
    ) -> Sent {
        self.serve_frame(spec, now);
        let mut bytes = [0; frame::MAX_FRAME];
        let cost = if spec.is_onboard() { 0 } else { spec.processor.framing_ns_per_byte };
        let mut tells = Tells::Readings;
        let (n, closed) = match spec.firmware.protocol {
            Protocol::Bare { .. } => {
                let n = self.write_bare(&spec.firmware, &mut bytes);
                (n, now + n as u64 * cost)
            }
            Protocol::Khepera => {
                let n;
                (n, tells) = self.write_lines(spec, robot, &mut bytes);
                (n, now + n as u64 * cost)
            }
            Protocol::Asercom => {
                let n;
                (n, tells) = self.write_letters(spec, &mut bytes);
                (n, now + n as u64 * cost)
            }
            Protocol::Create(_) => {
                let n;
                let streams;
                (n, streams) = self.write_packets(spec, now, robot, &mut bytes);
                tells = if streams { Tells::Readings } else { Tells::Nothing };
                (n, now + n as u64 * cost)
            }
            Protocol::Framed { .. } => self.write_frame(&spec.firmware, now, cost, &mut bytes),
        };
        let tag = self.note_told(&spec.firmware, now, tells, sampled);
        let cycle = tag.cycle;
        let on_wire = uplink.send_message(&spec.link, closed, &bytes[..n], tag);
        self.free_at = closed.max(uplink.drained(&spec.link));
        if self.decoder.registers().is_some_and(Registers::owes) {
            self.frame.next = self.free_at;
        }
        self.speak_next();
        Sent { bytes: n as u32, cycle, closed, on_wire }
    }

    /// A frame is sent now: when is the next one due?
    fn serve_frame(&mut self, spec: &RobotSpec, now: SimTime) {
        match spec.firmware.mode {
            // The Open Interface has a schedule of its own.
            Mode::Stream(_) if self.decoder.open_interface().is_some() => {}
            Mode::Stream(schedule) => _ = self.frame.serve(&schedule, now),
            Mode::Poll => self.frame.next = SimTime::NEVER,
        }
    }

    /// The last sample of every sensor, zeros before the first.
    fn last_values(&self, layout: &Layout<'_>) -> impl Iterator<Item = f64> {
        self.channels.iter().zip(layout.sensors()).flat_map(|(channel, components)| {
            (0..components.len()).map(|i| channel.values.get(i).copied().unwrap_or(0.0))
        })
    }

    fn write_bare(&self, firmware: &Firmware, out: &mut [u8]) -> usize {
        let layout = firmware.layout();
        write_values(layout.components, self.last_values(&layout), out).expect(FITS)
    }

    /// A frame and the instant at which it is closed, which is the time that stands in it. That depends on
    /// the frame's length.
    fn write_frame(&self, firmware: &Firmware, now: SimTime, cost: u64, out: &mut [u8]) -> (usize, SimTime) {
        let len = firmware.layout().readings_len(|i| self.channels[i].fresh);
        let closed = now + frame::encoded_len_max(len) as u64 * cost;
        let mut payload = [0; frame::MAX_PAYLOAD];
        let n = self.write_payload(firmware, closed, &mut payload);
        (frame::encode(&payload[..n], out).expect(FITS), closed)
    }

    fn write_payload(&self, firmware: &Firmware, closed: SimTime, out: &mut [u8]) -> usize {
        let time_100us = clock::wrap_time(closed.as_ns());
        let sample = |i: usize| {
            let channel = &self.channels[i];
            let age_100us = clock::age_100us(closed.since(channel.sampled_at));
            channel.fresh.then_some(Sample { age_100us, values: &channel.values })
        };
        message::write_readings(&firmware.layout(), self.sequence, time_100us, sample, out).expect(FITS)
    }

    /// Takes the oldest byte that the receiver holds at `now`, or in no time as many as end a message. What arrived while the receiver was full is
    /// lost.
    pub(crate) fn receive(&mut self, spec: &RobotSpec, now: SimTime, downlink: &mut Line) -> Taken {
        if spec.processor.bootloader_ns > 0 && missed_start(spec, now, downlink) {
            return Taken::Nonsense;
        }
        if let Some(interface) = self.decoder.open_interface()
            && create::missed_boot(spec, (now, interface.deaf_until), downlink)
        {
            return Taken::Nonsense;
        }
        if let Some((_, command)) = downlink.take_command(now) {
            return self.receive_command(spec, now, &command, &mut downlink.counters);
        }
        downlink.overrun(&spec.link, now);
        self.free_at = now + if spec.is_onboard() { 0 } else { spec.processor.receiving_ns_per_byte };
        loop {
            let Some(arrival) = downlink.take(&spec.link, now) else { return Taken::Part };
            let taken = self.receive_byte(spec, arrival, &mut downlink.counters);
            // A processor that takes bytes in no time takes all of a message at once: nothing comes between them.
            if taken != Taken::Part || self.free_at > now {
                return taken;
            }
        }
    }

    fn receive_byte(
        &mut self,
        spec: &RobotSpec,
        (arrived, byte): (SimTime, u8),
        counters: &mut LineCounters,
    ) -> Taken {
        if let Some(machine) = self.decoder.asercom_mut() {
            let deed = machine.push(byte);
            return deed.map_or(Taken::Part, |deed| self.obey_letter(spec, deed, arrived, counters));
        }
        let before = self.decoder.cut_short();
        let found = match self.decoder.push(byte, arrived) {
            Found::Nothing => None,
            Found::BadFrame => {
                counters.bad_frames += 1;
                Some(Err(Refusal::Protocol))
            }
            Found::Payload(payload) => {
                let request = Request::parse(spec, payload);
                counters.bad_messages += u64::from(request.is_err());
                Some(request)
            }
        };
        counters.bad_messages += self.decoder.cut_short() - before;
        found.map_or(Taken::Part, |found| self.take_request(spec, found, counters))
    }

    fn take_request(
        &mut self,
        spec: &RobotSpec,
        found: Result<Request, Refusal>,
        counters: &mut LineCounters,
    ) -> Taken {
        match found {
            Ok(request) => {
                counters.messages += 1;
                self.obey(spec, request)
            }
            Err(refusal) => {
                self.refuse(spec, refusal);
                Taken::Nonsense
            }
        }
    }

    fn obey(&mut self, spec: &RobotSpec, request: Request) -> Taken {
        let taken = match request {
            Request::Poll => {
                self.decoder.owe(Owed::READINGS);
                Taken::Poll
            }
            Request::Drive(signals, others) => {
                self.decoder.owe(Owed::ACKNOWLEDGEMENT);
                self.drive(spec, signals, others)
            }
            Request::Access(access) => self.access(spec, &access),
            Request::OpenInterface(bytes) => self.command(spec, &bytes),
        };
        self.answer_soon(spec);
        taken
    }

    fn drive(&mut self, spec: &RobotSpec, signals: Wheels, others: Vec<f64>) -> Taken {
        self.free_at = self.free_at + spec.processor.obeying_ns;
        self.orders.push_back(Order { at: self.free_at, signals, others });
        self.stand();
        Taken::Command(self.free_at)
    }

    /// A polled firmware answers as soon as it can.
    fn answer_soon(&mut self, spec: &RobotSpec) {
        if spec.firmware.mode == Mode::Poll {
            self.frame.next = self.frame.next.min(self.free_at);
        }
    }

    /// The order in force at `now`, if one came since it was last asked for.
    pub(crate) fn order_at(&mut self, now: SimTime) -> Option<Order> {
        let mut last = None;
        while let Some(order) = self.orders.pop_front_if(|order| order.at <= now) {
            last = Some(order);
            self.commands += 1;
        }
        last
    }

    /// The brain thinks on this processor for so long, from `begun` on or as soon as it is free: nothing else runs
    /// meanwhile. Returns when it is done.
    pub(crate) fn think(&mut self, begun: SimTime, thinking_ns: u64) -> SimTime {
        self.free_at = self.free_at.max(begun) + thinking_ns;
        self.free_at
    }

    /// The instant until which the processor is busy.
    pub(crate) fn free_at(&self) -> SimTime {
        self.free_at
    }

    pub(crate) fn channels(&self) -> &[Channel] {
        &self.channels
    }

    pub(crate) fn channels_mut(&mut self) -> &mut [Channel] {
        &mut self.channels
    }

    /// Frames that fell due while the processor was busy and were left out.
    pub(crate) fn frames_missed(&self) -> u64 {
        self.frame.missed
    }
}

/// The reason why framing cannot fail.
const FITS: &str = "scenario files refuse robots whose messages are too long";
