//! Lines on which bytes pass more than a wire: an adapter, another direction that has the wire, outages.
//!
//! When a byte that goes through an adapter is delivered depends on those that come after it (a packet fills),
//! so that is recomputed whenever it is asked for, from what is under way at that moment. That is exact: a
//! byte is taken only once its instant has come, and then all that could have changed it has been sent.

use alloc::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::adapter::{Adapter, Ftdi, Packet};
use super::latencies::Latencies;
use super::{Line, Link};
use crate::random::Stream;
use crate::time::SimTime;

/// The direction of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Direction {
    /// The direction to the laptop: first the wire, then the adapter.
    Up,
    /// The direction to the microcontroller: first the adapter, then the wire.
    Down,
}

/// The memory of such a line.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct TransportPath {
    direction: Direction,
    /// The instant of the last packet. Up: when its chip was free for the next; down: when it was closed.
    since: SimTime,
    /// The instant at which the last packet is delivered.
    packet_at: SimTime,
    /// Up: its bytes that are still to be taken; down: those that it still has room for.
    packet_left: u32,
    pub(super) latencies: Option<Latencies>,
    /// Half duplex: the other direction has the wire until then.
    pub(super) blocked_until: SimTime,
    /// Half duplex, down: bytes that ask for the wire, each since when.
    pub(super) asking: VecDeque<(SimTime, u8)>,
}

impl TransportPath {
    pub(super) fn new(link: &Link, seed: u64, name: &[&str], direction: Direction) -> Self {
        let latencies = stream(link.adapter(), direction)
            .map(|stream| Latencies::new(link.adapter(), Stream::of(seed, &[&name.concat(), stream])));
        Self {
            direction,
            since: SimTime::ZERO,
            packet_at: SimTime::ZERO,
            packet_left: 0,
            latencies,
            blocked_until: SimTime::ZERO,
            asking: VecDeque::new(),
        }
    }

    /// Whether a line of this direction can be so on this cable at `now`, with so many bytes on the wire.
    pub(super) fn is_sound(
        &self,
        link: &Link,
        (direction, now): (Direction, SimTime),
        in_flight: usize,
    ) -> bool {
        let latencies = match (stream(link.adapter(), direction), &self.latencies) {
            (Some(_), Some(latencies)) => latencies.are_sound(link.adapter()),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        let soon = now + link.adapter().hold_ns().saturating_add(SOON_NS);
        let packet = match direction {
            Direction::Up => {
                let is_soon = self.since <= soon && self.packet_at <= soon && self.blocked_until <= soon;
                is_soon && self.packet_left as usize <= in_flight && self.asking.is_empty()
            }
            Direction::Down => {
                self.packet_left <= link.adapter().packet_bytes()
                    && (self.asking.is_empty() || link.turnaround_ns().is_some())
            }
        };
        latencies && packet && self.direction == direction
    }

    /// The instant from which on a byte that is handed over at `now` can be on the wire.
    fn ready(&mut self, link: &Link, now: SimTime) -> SimTime {
        match (self.direction, link.adapter()) {
            (Direction::Up, _) => now,
            (Direction::Down, radio @ Adapter::Bluetooth(_)) => self.by_radio(radio, now),
            (Direction::Down, adapter) => adapter.at_chip(now),
        }
    }

    fn by_radio(&mut self, radio: &Adapter, now: SimTime) -> SimTime {
        if now > self.since || self.packet_left == 0 {
            let latency_ns = self.latencies.as_mut().map_or(0, |latencies| latencies.take(radio));
            self.since = now.max(self.packet_at);
            self.packet_at = self.since + latency_ns;
            self.packet_left = radio.packet_bytes();
        }
        self.packet_left -= 1;
        self.packet_at
    }

    /// A module on the robot that holds so many bytes has no room for more.
    pub(super) fn is_full(&self, link: &Link, held: usize) -> bool {
        self.latencies.is_some()
            && self.direction == Direction::Up
            && held >= link.laptop_buffer()
            && matches!(link.adapter(), Adapter::Bluetooth(_))
    }

    /// The next packet to the laptop, if bytes come to the chip at these instants. None overtakes the last one.
    fn packet(&self, link: &Link, chip: impl Iterator<Item = SimTime>) -> Option<Packet> {
        let drawn_ns = self.latencies.as_ref().map_or(0, |latencies| latencies.next_ns);
        let Packet { closed, at } = link.adapter().packet(self.since, drawn_ns, chip)?;
        Some(Packet { closed, at: at.max(self.packet_at) })
    }
}

/// The end of the name of the stream by which an adapter adds chance to a direction, if it does.
fn stream(adapter: &Adapter, direction: Direction) -> Option<&'static str> {
    match (adapter, direction) {
        (Adapter::Bluetooth(_), _) => Some(":radio"),
        (Adapter::Cdc(frames) | Adapter::Ftdi(Ftdi { frames, .. }), Direction::Up) => {
            (frames.jitter_ns > 0).then_some(":jitter")
        }
        (Adapter::None, _) | (Adapter::Cdc(_) | Adapter::Ftdi(_), Direction::Down) => None,
    }
}

impl Line {
    pub(super) fn send_by_detour(&mut self, link: &Link, now: SimTime, bytes: &[u8]) {
        self.lose_first(link, now);
        for &byte in bytes {
            let byte = self.disturb(link.byte_error_rate(now), byte);
            let Some(transport_path) = &mut self.transport_path else { return };
            let ready = transport_path.ready(link, now);
            if transport_path.direction == Direction::Down && link.turnaround_ns().is_some() {
                transport_path.asking.push_back((ready, byte));
                self.sent += 1;
                continue;
            }
            let at = self.transmission.put(link, ready.max(transport_path.blocked_until));
            if transport_path.is_full(link, self.in_flight.len()) {
                self.counters.bytes += 1;
                self.counters.overrun_bytes += 1;
                continue;
            }
            self.in_flight.push_back((at, byte));
            self.sent += 1;
        }
    }

    /// The instants at which the bytes that ask for the wire will be at its end, if no others ask.
    pub(super) fn forecast(
        &self,
        link: &Link,
        transport_path: &TransportPath,
    ) -> impl Iterator<Item = SimTime> {
        let mut transmission = self.transmission;
        let asking = transport_path.asking.iter();
        asking.map(move |(ready, _)| transmission.put(link, (*ready).max(transport_path.blocked_until)))
    }

    /// The instants at which bytes that are not lost will be at the end of the wire.
    fn landings(&self, link: &Link, transport_path: &TransportPath) -> impl Iterator<Item = SimTime> {
        let on_the_wire = self.in_flight.iter().map(|(at, _)| *at);
        on_the_wire.chain(self.forecast(link, transport_path)).filter(|at| !link.is_out(*at))
    }

    pub(super) fn arrival_by_detour(&self, link: &Link, transport_path: &TransportPath) -> SimTime {
        let mut landings = self.landings(link, transport_path);
        if transport_path.direction == Direction::Down {
            return landings.next().unwrap_or(SimTime::NEVER);
        }
        if transport_path.packet_left > 0 {
            return transport_path.packet_at;
        }
        transport_path.packet(link, landings).map_or(SimTime::NEVER, |packet| packet.at)
    }

    pub(super) fn take_by_detour(&mut self, link: &Link, now: SimTime) -> Option<(SimTime, u8)> {
        self.settle(link, now);
        self.lose_first(link, now);
        let at = self.arrival(link);
        if at > now {
            return None;
        }
        self.open_packet(link);
        self.counters.bytes += 1;
        let taken = self.in_flight.pop_front().map(|(_, byte)| (at, byte));
        if self.is_taped() {
            self.note_taken(taken);
        }
        taken
    }

    /// The packet of the next byte is there, and the byte is taken from it.
    fn open_packet(&mut self, link: &Link) {
        let Some(transport_path) = &self.transport_path else { return };
        if transport_path.direction == Direction::Down {
            return;
        }
        let mut opened = None;
        if transport_path.packet_left == 0 {
            opened = transport_path.packet(link, self.landings(link, transport_path)).map(|packet| {
                let inside = self.landings(link, transport_path).take_while(|at| *at <= packet.closed);
                (packet, inside.take(link.adapter().packet_bytes() as usize).count() as u32)
            });
        }
        let Some(transport_path) = &mut self.transport_path else { return };
        if let Some((packet, bytes)) = opened {
            transport_path.since = packet.closed;
            transport_path.packet_at = packet.at;
            transport_path.packet_left = bytes;
            if let Some(latencies) = &mut transport_path.latencies {
                latencies.take(link.adapter());
            }
            if matches!(link.adapter(), Adapter::Bluetooth(_)) {
                transport_path.since = packet.at;
            }
        }
        transport_path.packet_left = transport_path.packet_left.saturating_sub(1);
    }

    /// Of the oldest bytes, those that were lost in an outage by `now` are gone.
    pub(super) fn lose_first(&mut self, link: &Link, now: SimTime) {
        while self.in_flight.pop_front_if(|(at, _)| *at <= now && link.is_out(*at)).is_some() {
            self.counters.bytes += 1;
            self.counters.lost_bytes += 1;
        }
    }

    /// All bytes that were lost in an outage by `now` are gone.
    pub(super) fn lose_all(&mut self, link: &Link, now: SimTime) {
        if !link.has_outages() {
            return;
        }
        for place in (0..self.in_flight.len()).rev() {
            let (at, _) = self.in_flight[place];
            if at <= now && link.is_out(at) {
                self.drop_in_flight(place);
                self.counters.bytes += 1;
                self.counters.lost_bytes += 1;
            }
        }
    }
}

/// The longest time for which bytes wait on a robot for its cable: a day.
pub(super) const SOON_NS: u64 = 86_400 * crate::time::SECOND_NS;
