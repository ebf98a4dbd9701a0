//! The serial cable between microcontroller and laptop: two lines, one each way.
//!
//! A UART sends characters of so many bits, back to back: the n-th character of a burst that began at T has
//! arrived at T + ⌈n · bits · 10⁹ / baud⌉ nanoseconds. Counting from the start of the burst keeps the
//! instants exact where a character's time is no whole number of nanoseconds. The notes count 8 bits a
//! character (§3.2.1); a start and a stop bit make it 10 (8N1), parity or a second stop bit 11.
//!
//! The ideal link, for goldens and for telling the effect of the cable from that of the rest, carries any
//! number of bytes in no time and loses none.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};

/// What a link is.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// No time, no loss.
    Ideal,
    /// A serial cable.
    Uart(Uart),
    /// None: the brain is the microcontroller's program (Fig. 1.19), and its thinking takes that processor's time.
    Onboard,
}

/// A serial cable and the buffers at its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Uart {
    /// Bits a second.
    pub baud: u32,
    /// Bits a character, start and stop bits included: 8, 10 or 11.
    pub bits_per_character: u8,
    /// Characters that the microcontroller can hold unread; more are lost.
    pub receive_depth: usize,
    /// Characters that the microcontroller can hold unsent, the one being sent included; when all are taken
    /// it waits.
    pub transmit_depth: usize,
    /// Bytes that the laptop's driver holds each way: more to be sent are refused, and more that a brain
    /// leaves unread are lost.
    pub laptop_buffer_bytes: usize,
    /// Probability that a byte arrives with one bit wrong.
    pub byte_error_rate: f64,
}

impl Link {
    /// Nanoseconds from the start of a burst to the arrival of its `n`-th character (from 1).
    pub(crate) fn burst_ns(&self, n: u64) -> u64 {
        match self {
            Self::Ideal | Self::Onboard => 0,
            Self::Uart(uart) => {
                let bits = u128::from(n) * u128::from(uart.bits_per_character);
                let ns = (bits * u128::from(SECOND_NS)).div_ceil(u128::from(uart.baud));
                u64::try_from(ns).unwrap_or(u64::MAX)
            }
        }
    }

    /// See [`Uart::receive_depth`]; an ideal link loses nothing.
    pub(crate) fn receive_depth(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard => usize::MAX,
            Self::Uart(uart) => uart.receive_depth,
        }
    }

    /// See [`Uart::transmit_depth`].
    pub(crate) fn transmit_depth(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard => usize::MAX,
            Self::Uart(uart) => uart.transmit_depth,
        }
    }

    /// See [`Uart::laptop_buffer_bytes`].
    pub(crate) fn laptop_buffer(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard => IDEAL_BUFFER,
            Self::Uart(uart) => uart.laptop_buffer_bytes,
        }
    }

    fn byte_error_rate(&self) -> f64 {
        match self {
            Self::Ideal | Self::Onboard => 0.0,
            Self::Uart(uart) => uart.byte_error_rate,
        }
    }
}

/// Bytes that the driver of an ideal link holds: enough for any brain, and yet an end for one that never reads.
const IDEAL_BUFFER: usize = 1 << 20;

/// One direction of a link: the bytes on their way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Line {
    /// Each byte with the instant at which it has arrived whole.
    in_flight: VecDeque<(SimTime, u8)>,
    /// The messages on their way, so that it can be told how old a reading truly is when it arrives.
    messages: VecDeque<Sent>,
    /// Bytes put on the line so far; some are still on their way.
    sent: u64,
    burst_start: SimTime,
    burst_characters: u64,
    errors: Stream,
    pub(crate) counters: LineCounters,
}

/// A message of readings on its way.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sent {
    /// How many bytes will have arrived when it has.
    end: u64,
    /// When each of its fresh readings was sampled.
    sampled: Vec<(usize, SimTime)>,
}

/// What went over one direction of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineCounters {
    /// Bytes that went over the line, lost ones included.
    pub bytes: u64,
    /// Bytes that arrived with a wrong bit.
    pub corrupted_bytes: u64,
    /// Bytes lost because the receiver had no room.
    pub overrun_bytes: u64,
    /// Bytes not taken because the sender's buffer was full.
    pub refused_bytes: u64,
    /// Messages that arrived whole.
    pub messages: u64,
    /// Frames thrown away for their checksum, their coding or their length.
    pub bad_frames: u64,
    /// Sound frames whose content made no sense, and messages cut short by silence.
    pub bad_messages: u64,
}

impl Line {
    pub(crate) fn new(errors: Stream) -> Self {
        Self {
            in_flight: VecDeque::new(),
            messages: VecDeque::new(),
            sent: 0,
            burst_start: SimTime::ZERO,
            burst_characters: 0,
            errors,
            counters: LineCounters::default(),
        }
    }

    /// Puts bytes on the line at `now`, behind those that wait.
    pub(crate) fn send(&mut self, link: &Link, now: SimTime, bytes: &[u8]) {
        if now > self.free_at(link) {
            self.burst_start = now;
            self.burst_characters = 0;
        }
        for &byte in bytes {
            self.burst_characters += 1;
            let byte = self.disturb(link, byte);
            self.in_flight.push_back((self.free_at(link), byte));
        }
        self.sent += bytes.len() as u64;
    }

    /// Puts a message of readings on the line.
    pub(crate) fn send_message(
        &mut self,
        link: &Link,
        now: SimTime,
        bytes: &[u8],
        sampled: Vec<(usize, SimTime)>,
    ) {
        self.forget_lost_messages();
        self.send(link, now, bytes);
        self.messages.push_back(Sent { end: self.sent, sampled });
    }

    /// When the readings of the message whose last byte has just arrived were sampled: the truth, which is
    /// for statistics and not for the brain.
    pub(crate) fn sampled(&mut self) -> Vec<(usize, SimTime)> {
        self.forget_lost_messages();
        let whole = self.messages.pop_front_if(|sent| sent.end == self.counters.bytes);
        whole.map_or_else(Vec::new, |sent| sent.sampled)
    }

    /// A message of which the last byte is over, and that nobody asked about then, was not understood.
    fn forget_lost_messages(&mut self) {
        while self.messages.pop_front_if(|sent| sent.end < self.counters.bytes).is_some() {}
    }

    /// A receiver that holds `depth` bytes loses those that arrived by `now` beyond them.
    pub(crate) fn overrun(&mut self, now: SimTime, depth: usize) {
        let here = self.in_flight.partition_point(|(at, _)| *at <= now);
        if here > depth {
            self.in_flight.drain(depth..here);
            self.counters.overrun_bytes += (here - depth) as u64;
            self.counters.bytes += (here - depth) as u64;
        }
    }

    /// When the first byte on the way arrives.
    pub(crate) fn arrival(&self) -> SimTime {
        self.in_flight.front().map_or(SimTime::NEVER, |(at, _)| *at)
    }

    /// Takes the first byte, if it has arrived by `now`.
    pub(crate) fn take(&mut self, now: SimTime) -> Option<(SimTime, u8)> {
        if self.arrival() > now {
            return None;
        }
        self.counters.bytes += 1;
        self.in_flight.pop_front()
    }

    /// How many bytes are still on the way, or waiting for it, at `now`.
    pub(crate) fn waiting(&self, now: SimTime) -> usize {
        self.in_flight.len() - self.in_flight.partition_point(|(at, _)| *at <= now)
    }

    /// When at most `depth` bytes will still be on the way.
    pub(crate) fn drained_to(&self, depth: usize) -> SimTime {
        let finished = self.in_flight.len().checked_sub(depth.saturating_add(1));
        finished.map_or(SimTime::ZERO, |i| self.in_flight[i].0)
    }

    fn free_at(&self, link: &Link) -> SimTime {
        self.burst_start + link.burst_ns(self.burst_characters)
    }

    fn disturb(&mut self, link: &Link, byte: u8) -> u8 {
        let rate = link.byte_error_rate();
        if rate == 0.0 || self.errors.uniform() >= rate {
            return byte;
        }
        self.counters.corrupted_bytes += 1;
        byte ^ (1 << self.errors.below(8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uart(baud: u32, bits_per_character: u8) -> Link {
        Link::Uart(Uart {
            baud,
            bits_per_character,
            receive_depth: 64,
            transmit_depth: 64,
            laptop_buffer_bytes: 4096,
            byte_error_rate: 0.0,
        })
    }

    fn line() -> Line {
        Line::new(Stream::new(1, "test"))
    }

    #[test]
    fn six_bytes_at_9600_baud_take_the_notes_5_ms_with_8_bits() {
        let mut line = line();
        line.send(&uart(9600, 8), SimTime::ZERO, &[0; 6]);
        assert_eq!(line.in_flight.back().unwrap().0, SimTime::from_ns(5_000_000));
    }

    #[test]
    fn an_hour_of_characters_does_not_drift() {
        let (link, mut line) = (uart(115_200, 10), line());
        for _ in 0..3600 * 11_520 / 64 {
            line.send(&link, SimTime::ZERO, &[0; 64]);
            line.in_flight.clear();
        }
        assert_eq!(line.free_at(&link), SimTime::from_ns(3600 * SECOND_NS));
    }

    #[test]
    fn a_pause_starts_a_new_burst_and_a_queue_does_not() {
        let (link, mut line) = (uart(10_000, 10), line());
        line.send(&link, SimTime::ZERO, &[1, 2]);
        line.send(&link, SimTime::from_ns(1_500_000), &[3]);
        line.send(&link, SimTime::from_ns(9_000_000), &[4]);
        let arrivals: Vec<_> = line.in_flight.iter().map(|(at, _)| at.as_ns() / 1_000_000).collect();
        assert_eq!(arrivals, [1, 2, 3, 10]);
        assert_eq!(line.waiting(SimTime::from_ns(2_000_000)), 2);
        assert_eq!(line.drained_to(1), SimTime::from_ns(3_000_000));
        assert_eq!(line.drained_to(4), SimTime::ZERO);
    }

    #[test]
    fn messages_that_nobody_understood_are_forgotten() {
        let (link, mut line) = (uart(9600, 10), line());
        for i in 0..1000 {
            let now = SimTime::from_ns(i * 20_000_000);
            line.send_message(&link, now, &[0; 5], alloc::vec![(0, now)]);
            while line.take(now + 19_000_000).is_some() {}
        }
        // The last, and the one before it, which was over but not outdated when the last was sent.
        assert_eq!(line.messages.len(), 2);
        assert_eq!(line.sampled(), [(0, SimTime::from_ns(999 * 20_000_000))]);
    }

    #[test]
    fn byte_errors_come_at_their_rate_and_flip_one_bit() {
        let mut link = uart(9600, 10);
        let Link::Uart(uart) = &mut link else { unreachable!() };
        uart.byte_error_rate = 0.1;
        let mut line = line();
        line.send(&link, SimTime::ZERO, &[0; 10_000]);
        let wrong = line.in_flight.iter().filter(|(_, byte)| *byte != 0).count();
        assert!((800..1200).contains(&wrong), "{wrong}");
        assert_eq!(line.counters.corrupted_bytes, wrong as u64);
        assert!(line.in_flight.iter().all(|(_, byte)| byte.count_ones() <= 1));
    }
}
