//! One direction of a link: the bytes on their way.

use alloc::boxed::Box;
use alloc::collections::VecDeque;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::messages::{Message, Messages};
use super::tape::{Tape, Taped};
use super::transmission::Transmission;
use super::transport_path::{Direction, SOON_NS, TransportPath};
use super::{LineCounters, Link};
use crate::random::Stream;
use crate::time::SimTime;
use crate::wheels::Wheels;

/// One direction of a link.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Line {
    /// Each byte with the instant at which it is at the end of the wire.
    pub(super) in_flight: VecDeque<(SimTime, u8)>,
    messages: Messages,
    /// Bytes put on the line so far that stay in `in_flight` until they are over.
    pub(super) sent: u64,
    pub(super) transmission: Transmission,
    errors: Stream,
    /// The path of the bytes besides the wire; nothing on a plain cable.
    pub(super) transport_path: Option<TransportPath>,
    pub(crate) counters: LineCounters,
    /// Under way as it is: nothing else is then, and at the tick's end it becomes bytes.
    #[serde(skip)]
    command: Option<Whole>,
    /// The record of the line's bytes, if it is wanted.
    #[serde(skip)]
    tape: Option<Box<Tape>>,
}

/// A command to a microcontroller.
#[derive(Clone, Debug)]
pub(crate) struct Command {
    pub(crate) sequence: u8,
    pub(crate) wheels: Wheels,
    /// The signals for the other actuators.
    pub(crate) others: Vec<f64>,
}

/// A command that is on the line as it is, in place of so many bytes.
#[derive(Clone, Debug)]
struct Whole {
    arrival: SimTime,
    bytes: u64,
    command: Command,
}

impl Line {
    /// The line to the laptop, with random streams of the name that has these parts.
    pub fn up(link: &Link, seed: u64, name: &[&str]) -> Self {
        Self::new(link, seed, name, Direction::Up)
    }

    /// The line to the microcontroller, with random streams of the name that has these parts.
    pub fn down(link: &Link, seed: u64, name: &[&str]) -> Self {
        Self::new(link, seed, name, Direction::Down)
    }

    fn new(link: &Link, seed: u64, name: &[&str], direction: Direction) -> Self {
        Self {
            in_flight: VecDeque::new(),
            messages: Messages::default(),
            sent: 0,
            transmission: Transmission::default(),
            errors: Stream::of(seed, name),
            transport_path: link.has_detour().then(|| TransportPath::new(link, seed, name, direction)),
            counters: LineCounters::default(),
            command: None,
            tape: None,
        }
    }

    /// Visits its streams of random numbers.
    pub(crate) fn each_stream(&mut self, visit: &mut impl FnMut(&mut Stream)) {
        visit(&mut self.errors);
        let latencies = self.transport_path.iter_mut().filter_map(|path| path.latencies.as_mut());
        latencies.for_each(|latencies| visit(&mut latencies.chance));
    }

    /// Keeps the last so many bytes that are taken at its end, from now on.
    pub(crate) fn keep_tape(&mut self, bytes: usize) {
        self.tape = (bytes > 0).then(|| Box::new(Tape::with_room(bytes)));
    }

    /// The last bytes that were taken at its end, if they are kept.
    pub(crate) fn tape(&self) -> Option<&Tape> {
        self.tape.as_deref()
    }

    /// Whether its bytes are kept.
    pub(crate) fn is_taped(&self) -> bool {
        self.tape.is_some()
    }

    /// This byte has been taken, at this instant.
    #[cold]
    #[inline(never)]
    pub(super) fn note_taken(&mut self, taken: Option<(SimTime, u8)>) {
        let over = self.over();
        let message_until = self.messages.holding(over).map(|message| message.on_wire_until);
        if let (Some(tape), Some((at, byte))) = (&mut self.tape, taken) {
            tape.push(Taped { at, byte, message_until });
        }
    }

    /// Whether a line of this direction can be so on this cable at `now`, with readings of so many sensors on it: its
    /// bytes come one behind the other and are over some day, and their number is right.
    pub(crate) fn is_sound(&self, link: &Link, at: (Direction, SimTime), sensors: usize) -> bool {
        let (direction, now) = at;
        let transport_path = match &self.transport_path {
            Some(transport_path) => {
                link.has_detour() && transport_path.is_sound(link, at, self.in_flight.len())
            }
            None => !link.has_detour(),
        };
        let mut instants = self.in_flight.iter().map(|(at, _)| *at);
        let is_soon = direction == Direction::Down || self.transmission.end() <= now + SOON_NS;
        transport_path
            && is_soon
            && instants.clone().is_sorted()
            && instants.next_back().is_none_or(|last| last <= self.transmission.end())
            && crate::sound::count(self.sent)
            && self.under_way() <= self.sent
            && self.messages.are_sound(self.sent, sensors)
            && self.transmission.is_sound(link)
            && self.errors.is_sound()
            && self.counters.is_sound()
    }

    /// Allows outages of the cable, from now on.
    pub(crate) fn watch_outages(&mut self, link: &Link, seed: u64, name: &[&str], direction: Direction) {
        if link.has_detour() && self.transport_path.is_none() {
            self.transport_path = Some(TransportPath::new(link, seed, name, direction));
        }
    }

    /// The next byte begins a burst, behind those on the wire.
    pub(crate) fn begin_burst(&mut self) {
        self.transmission.begin();
    }

    /// Puts bytes on the line at `now`, behind those that wait.
    pub fn send(&mut self, link: &Link, now: SimTime, bytes: &[u8]) {
        if self.transport_path.is_some() {
            self.send_by_detour(link, now, bytes);
            return;
        }
        if matches!(link, Link::Ideal | Link::Onboard) && !bytes.is_empty() {
            let arrival = self.transmission.put_at_once(now, bytes.len() as u64);
            self.in_flight.extend(bytes.iter().map(|&byte| (arrival, byte)));
            self.sent += bytes.len() as u64;
            return;
        }
        let rate = link.byte_error_rate(now);
        self.in_flight.reserve(bytes.len());
        for &byte in bytes {
            let byte = self.disturb(rate, byte);
            self.in_flight.push_back((self.transmission.put(link, now), byte));
        }
        self.sent += bytes.len() as u64;
    }

    /// Puts a byte on the line to the laptop that a chip sends at its own pace: its character is over at this instant.
    pub(crate) fn send_at(&mut self, link: &Link, over: SimTime, byte: u8) {
        self.lose_first(link, over);
        let byte = self.disturb(link.byte_error_rate(over), byte);
        let at = self.transmission.put_until(link, over);
        let in_flight = self.in_flight.len();
        if self.transport_path.as_ref().is_some_and(|path| path.is_full(link, in_flight)) {
            self.counters.bytes += 1;
            self.counters.overrun_bytes += 1;
            return;
        }
        self.in_flight.push_back((at, byte));
        self.sent += 1;
    }

    /// Puts a message on the line, and returns when it is on the wire, as far as that is known now: its beginning and
    /// its end.
    pub(crate) fn send_message(
        &mut self,
        link: &Link,
        now: SimTime,
        bytes: &[u8],
        message: Message,
    ) -> (SimTime, SimTime) {
        self.messages.forget(self.over());
        let (from, begin) = (self.free_at(link).max(now), self.sent);
        self.send(link, now, bytes);
        let until = self.free_at(link).max(from);
        self.messages.push((begin, self.sent), Message { on_wire_until: until, ..message });
        (from, until)
    }

    /// Whether nothing that is sent later changes when its bytes are delivered.
    pub(crate) fn is_direct(&self) -> bool {
        self.transport_path.is_none()
    }

    /// Whether nothing is under way, and bytes would take no time and come as they are.
    pub(crate) fn is_idle_and_instant(&self, link: &Link) -> bool {
        let is_instant = matches!(link, Link::Ideal | Link::Onboard) && self.transport_path.is_none();
        is_instant && self.in_flight.is_empty() && self.command.is_none()
    }

    /// The same as [`send_message`](Self::send_message) on a line that is [idle and
    /// instant](Self::is_idle_and_instant), with a command in place of so many bytes.
    pub(crate) fn send_command(
        &mut self,
        (now, bytes): (SimTime, usize),
        command: Command,
        message: Message,
    ) -> (SimTime, SimTime) {
        self.messages.forget(self.over());
        let (from, begin, bytes) = (self.transmission.end().max(now), self.sent, bytes as u64);
        let arrival = self.transmission.put_at_once(now, bytes);
        self.sent += bytes;
        self.command = Some(Whole { arrival, bytes, command });
        let until = self.transmission.end().max(from);
        self.messages.push((begin, self.sent), Message { on_wire_until: until, ..message });
        (from, until)
    }

    /// Takes the command that is under way as it is, with the instant of its arrival, if that is not after `now`.
    pub(crate) fn take_command(&mut self, now: SimTime) -> Option<(SimTime, Command)> {
        let Whole { arrival, bytes, command } = self.command.take_if(|whole| whole.arrival <= now)?;
        self.counters.bytes += bytes;
        Some((arrival, command))
    }

    /// A command that was [taken](Self::take_command) is under way after all, as these bytes.
    pub(crate) fn lay_down(&mut self, arrival: SimTime, bytes: &[u8]) {
        self.counters.bytes -= bytes.len() as u64;
        self.in_flight.extend(bytes.iter().map(|&byte| (arrival, byte)));
    }

    /// Sends bytes of a message at `now` that are taken at once, on a line that is [idle and
    /// instant](Self::is_idle_and_instant).
    pub(crate) fn pass_message(&mut self, now: SimTime, bytes: &[u8]) {
        if let Some(tape) = &mut self.tape {
            let taped = |&byte| Taped { at: now, byte, message_until: Some(now) };
            bytes.iter().map(taped).for_each(|taped| tape.push(taped));
        }
        let bytes = bytes.len() as u64;
        self.transmission.put_at_once(now, bytes);
        self.sent += bytes;
        self.counters.bytes += bytes;
        self.counters.messages += 1;
        self.messages.forget(self.over());
    }

    /// The message whose last byte has just arrived. Its content is the truth, which is for statistics and not for the
    /// brain.
    pub(crate) fn message(&mut self) -> Option<Message> {
        self.messages.take(self.over())
    }

    /// The instant at which the control cycle began that the message with the byte that has just arrived belongs to.
    pub(crate) fn cycle_of_last_byte(&mut self) -> Option<SimTime> {
        self.messages.around(self.over())?.cycle
    }

    /// The byte in this place, which is under way, is lost: it is as if it had not been sent.
    pub(super) fn drop_in_flight(&mut self, place: usize) {
        self.messages.drop_byte(self.over() + place as u64 + 1);
        self.in_flight.remove(place);
        self.sent -= 1;
    }

    /// The number of sent bytes that are over.
    fn over(&self) -> u64 {
        self.sent - self.under_way()
    }

    /// Bytes that wait for the wire or are on it.
    pub(crate) fn under_way(&self) -> u64 {
        let asking = self.transport_path.as_ref().map_or(0, |transport_path| transport_path.asking.len());
        let whole = self.command.as_ref().map_or(0, |whole| whole.bytes);
        (self.in_flight.len() + asking) as u64 + whole
    }

    /// The instant from which on the wire is free for more, as far as it is known now.
    pub(crate) fn free_at(&self, link: &Link) -> SimTime {
        let Some(transport_path) = &self.transport_path else { return self.transmission.end() };
        let asking = self.forecast(link, transport_path).last();
        asking.unwrap_or_else(|| self.transmission.end().max(transport_path.blocked_until))
    }

    /// The microcontroller's receiver loses what arrived by `now` beyond what it can hold.
    pub fn overrun(&mut self, link: &Link, now: SimTime) {
        if self.transport_path.is_some() {
            self.settle(link, now);
            self.lose_all(link, now);
        }
        let depth = link.receive_depth();
        if self.in_flight.len() <= depth {
            return;
        }
        let here = self.in_flight.partition_point(|(at, _)| *at <= now);
        if here > depth {
            (depth..here).rev().for_each(|place| self.drop_in_flight(place));
            self.counters.overrun_bytes += (here - depth) as u64;
            self.counters.bytes += (here - depth) as u64;
        }
    }

    /// The line's end does not receive before an instant: what arrives earlier is lost.
    pub(crate) fn lose_before(&mut self, link: &Link, instant: SimTime) {
        if self.transport_path.is_some() {
            self.settle(link, instant);
        }
        let whole = self.command.take_if(|whole| whole.arrival < instant).map_or(0, |whole| whole.bytes);
        let mut lost = whole;
        while self.in_flight.pop_front_if(|(at, _)| *at < instant).is_some() {
            lost += 1;
        }
        self.counters.bytes += lost;
        self.counters.lost_bytes += lost;
    }

    /// The instant at which the next byte is delivered, as far as it is known now. Only what is sent before then can
    /// change it, and never to an instant that is over.
    #[inline]
    pub fn arrival(&self, link: &Link) -> SimTime {
        match &self.transport_path {
            None => match (&self.command, self.in_flight.front()) {
                (Some(whole), _) => whole.arrival,
                (None, Some((at, _))) => *at,
                (None, None) => SimTime::NEVER,
            },
            Some(transport_path) => self.arrival_by_detour(link, transport_path),
        }
    }

    /// Takes the next byte with the instant of its delivery, if that is not after `now`.
    #[inline]
    pub fn take(&mut self, link: &Link, now: SimTime) -> Option<(SimTime, u8)> {
        if self.transport_path.is_some() {
            return self.take_by_detour(link, now);
        }
        if self.arrival(link) > now {
            return None;
        }
        self.counters.bytes += 1;
        let taken = self.in_flight.pop_front();
        if self.tape.is_some() {
            self.note_taken(taken);
        }
        taken
    }

    /// The number of bytes that the laptop's driver still holds at `now`.
    pub fn waiting(&self, link: &Link, now: SimTime) -> usize {
        if let Link::Usb(_) = link {
            // A microcontroller that does not read keeps the bytes at the laptop.
            return self.in_flight.iter().filter(|(at, _)| *at > now || !link.is_out(*at)).count();
        }
        let asking = self
            .transport_path
            .as_ref()
            .map_or(0, |transport_path| self.forecast(link, transport_path).filter(|at| *at > now).count());
        asking + self.in_flight.len() - self.in_flight.partition_point(|(at, _)| *at <= now)
    }

    /// The instant at which the microcontroller's transmitter has taken all that was sent.
    pub fn drained(&self, link: &Link) -> SimTime {
        self.transmission.drained_to(link, link.transmit_depth())
    }

    /// The fate of a byte on a wire with this rate of errors.
    pub(super) fn disturb(&mut self, rate: f64, byte: u8) -> u8 {
        if rate == 0.0 || self.errors.uniform() >= rate {
            return byte;
        }
        self.counters.corrupted_bytes += 1;
        byte ^ (1 << self.errors.below(8))
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::link::properties::{line, uart};
    use crate::statistics::{SAMPLES, assert_rate, chi_squared};

    #[test]
    fn six_bytes_at_9600_baud_take_the_notes_5_ms_with_8_bits() {
        let link = uart(9600, 8);
        let mut line = line(&link);
        line.send(&link, SimTime::ZERO, &[0; 6]);
        assert_eq!(line.in_flight.back().unwrap().0, SimTime::from_ns(5_000_000));
    }

    #[test]
    fn a_pause_starts_a_new_burst_and_a_queue_does_not() {
        let link = uart(10_000, 10);
        let mut line = line(&link);
        line.send(&link, SimTime::ZERO, &[1, 2]);
        line.send(&link, SimTime::from_ns(1_500_000), &[3]);
        line.send(&link, SimTime::from_ns(9_000_000), &[4]);
        let arrivals: Vec<_> = line.in_flight.iter().map(|(at, _)| at.as_ns() / 1_000_000).collect();
        assert_eq!(arrivals, [1, 2, 3, 10]);
        assert_eq!(line.waiting(&link, SimTime::from_ns(2_000_000)), 2);
    }

    #[test]
    fn messages_that_nobody_understood_are_forgotten() {
        let link = uart(9600, 10);
        let mut line = line(&link);
        for i in 0..1000 {
            let now = SimTime::from_ns(i * 20_000_000);
            line.send_message(&link, now, &[0; 5], Message { sampled: vec![(0, now)], ..Message::default() });
            while line.take(&link, now + 19_000_000).is_some() {}
        }
        // The last, and the one before it, which was over but not outdated when the last was sent.
        assert_eq!(line.messages.len(), 2);
        assert_eq!(line.message().unwrap().sampled, [(0, SimTime::from_ns(999 * 20_000_000))]);
    }

    #[test]
    fn byte_errors_come_at_their_rate_and_flip_one_bit_whichever() {
        let mut link = uart(9600, 10);
        let Link::Uart(uart) = &mut link else { unreachable!() };
        uart.byte_error_rate = 0.1;
        let mut line = line(&link);
        let mut bits = [0; 8];
        for _ in 0..SAMPLES {
            match line.disturb(link.byte_error_rate(SimTime::ZERO), 0) {
                0 => {}
                byte => {
                    assert!(byte.is_power_of_two(), "{byte:#010b}");
                    bits[byte.trailing_zeros() as usize] += 1;
                }
            }
        }
        let wrong = bits.iter().sum();
        assert_eq!(line.counters.corrupted_bytes, wrong);
        assert_rate(wrong, SAMPLES as u64, 0.1);
        let outcome = chi_squared(&bits, &[1.0; 8]);
        assert!(outcome.fits(), "{bits:?}: {outcome:?}");
    }

    #[test]
    fn bytes_on_the_way_are_those_that_byte_errors_left() {
        let mut link = uart(9600, 10);
        let Link::Uart(uart) = &mut link else { unreachable!() };
        uart.byte_error_rate = 0.1;
        let mut line = line(&link);
        line.send(&link, SimTime::ZERO, &[0; 1000]);
        let wrong = line.in_flight.iter().filter(|(_, byte)| *byte != 0).count();
        assert!(wrong > 50, "{wrong}");
        assert_eq!(line.counters.corrupted_bytes, wrong as u64);
    }
}
