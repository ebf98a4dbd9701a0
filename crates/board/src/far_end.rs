//! The view of a UART on a line on which another one sends: bits sampled at the centres of its own characters.
//!
//! The sender's line is a level over time: high while it is idle, then for each character a low start bit, the data bits with
//! the least significant first, perhaps a parity bit, and one or two high stop bits. The receiver waits for the line to fall,
//! looks half of its own bit later whether it is still low (else that was no start bit), and then samples each bit one bit time
//! after the other. A stop bit that is low is a framing error: the byte is delivered nevertheless, as chips do, and the next
//! start bit is one that falls from high. All of it is arithmetic in picoseconds, so that the same line gives the same bytes.
//!
//! A break is a line that is low for longer than a character: a framing error with the byte 0.

use alloc::collections::VecDeque;

use baudbot_avr::usart::Frame;
use serde::{Deserialize, Serialize};

/// The settings of a UART.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Bits a second; not 0.
    pub baud: u32,
    /// Data bits of a character, 5 to 8.
    pub data_bits: u8,
    /// The parity bit.
    pub parity: Parity,
    /// Stop bits, 1 or 2.
    pub stop_bits: u8,
}

/// The parity bit of a character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parity {
    /// The character has no parity bit.
    None,
    /// The number of ones is odd.
    Odd,
    /// The number of ones is even.
    Even,
    /// The parity bit is always 1.
    Mark,
    /// The parity bit is always 0.
    Space,
}

/// A byte that a UART has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Read {
    /// The data bits.
    pub byte: u8,
    /// The instant at which its character was over, in nanoseconds.
    pub at_ns: u64,
    /// The error in it.
    pub error: Option<LineError>,
}

/// A UART's complaint about a character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError {
    /// The stop bit was low.
    Framing,
    /// The parity bit does not fit.
    Parity,
}

const PS_PER_S: u64 = 1_000_000_000_000;
const PS_PER_NS: u64 = 1000;
/// No receiver looks back at more changes of the level: those of a second at the greatest rates.
const MOST_CHANGES: usize = 1 << 20;

impl Settings {
    /// 8 data bits, no parity, 1 stop bit.
    pub const fn new_8n1(baud: u32) -> Self {
        Self { baud, data_bits: 8, parity: Parity::None, stop_bits: 1 }
    }

    /// The settings of a cable with so many bits a character: what 8 data bits and the start bit leave are stop bits. A
    /// character of fewer than 10 bits has fewer data bits and 1 stop bit.
    pub fn of_cable(baud: u32, bits_per_character: u32) -> Self {
        let bits = bits_per_character.clamp(7, 11) as u8;
        if bits < 10 {
            return Self { data_bits: bits - 2, ..Self::new_8n1(baud) };
        }
        Self { stop_bits: bits - 9, ..Self::new_8n1(baud) }
    }

    fn bit_ps(&self) -> u64 {
        PS_PER_S / u64::from(self.baud.max(1))
    }

    fn has_parity(&self) -> bool {
        self.parity != Parity::None
    }

    /// Bits of a character, start and stop bits included.
    pub fn bits(&self) -> u64 {
        1 + u64::from(self.data_bits) + u64::from(self.has_parity()) + u64::from(self.stop_bits)
    }

    /// The duration of a character, in nanoseconds.
    pub fn character_ns(&self) -> u64 {
        (self.bits() * self.bit_ps()).div_ceil(PS_PER_NS)
    }

    /// The parity bit of a byte; high where there is none.
    fn parity_bit(&self, byte: u8) -> bool {
        let ones = (byte & self.mask()).count_ones();
        match self.parity {
            Parity::None | Parity::Mark => true,
            Parity::Odd => ones.is_multiple_of(2),
            Parity::Even => !ones.is_multiple_of(2),
            Parity::Space => false,
        }
    }

    const fn mask(&self) -> u8 {
        0xff_u8 >> (8 - if self.data_bits > 8 { 8 } else { self.data_bits })
    }

    /// The levels of a character, bit by bit.
    fn levels(&self, byte: u8) -> impl Iterator<Item = bool> {
        let data = (0..self.data_bits).map(move |bit| byte >> bit & 1 == 1);
        let parity = self.has_parity().then(|| self.parity_bit(byte));
        let stop = core::iter::repeat_n(true, usize::from(self.stop_bits));
        core::iter::once(false).chain(data).chain(parity).chain(stop)
    }
}

/// A receiver, and what it knows of the line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Receiver {
    settings: Settings,
    /// Changes of the level that are still to be looked at: from when, in picoseconds, it is so.
    changes: VecDeque<(u64, bool)>,
    /// The level before these.
    level: bool,
    /// The instant until which the line is known.
    known_ps: u64,
    /// Up to where the receiver has looked.
    seen_ps: u64,
    /// A framing error: it waits until the line is high.
    waits_for_high: bool,
}

impl Receiver {
    /// A receiver at a line that is idle.
    pub fn new(settings: Settings) -> Self {
        let changes = VecDeque::new();
        Self { settings, changes, level: true, known_ps: 0, seen_ps: 0, waits_for_high: false }
    }

    /// Whether a receiver with these settings can be in this state before an instant, in nanoseconds.
    pub fn is_possible(&self, settings: &Settings, before_ns: u64) -> bool {
        let before = before_ns.saturating_mul(PS_PER_NS);
        let mut instants = self.changes.iter().map(|(from, _)| *from);
        self.settings == *settings
            && self.changes.len() <= MOST_CHANGES
            && instants.clone().is_sorted()
            && instants.next_back().is_none_or(|last| last <= before)
            && self.known_ps <= before
            && self.seen_ps <= before
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The line has a character of a sender that is set so, which begins at `from_ns`, or when the line is free.
    pub fn hear(&mut self, sender: &Settings, from_ns: u64, byte: u8) {
        let from = from_ns.saturating_mul(PS_PER_NS).max(self.known_ps);
        self.hear_levels(from, sender.bit_ps(), sender.levels(byte));
    }

    /// The line has a character of a chip, which is there from an instant until another, in nanoseconds.
    pub fn hear_frame(&mut self, frame: &Frame, (from_ns, until_ns): (u64, u64)) {
        let from = from_ns.saturating_mul(PS_PER_NS).max(self.known_ps);
        let until = until_ns.saturating_mul(PS_PER_NS);
        let bits = u64::from(frame.bits());
        self.hear_levels(from, until.saturating_sub(from) / bits, (0..bits).map(|bit| frame.level(bit)));
    }

    fn hear_levels(&mut self, from: u64, bit_ps: u64, levels: impl Iterator<Item = bool>) {
        self.known_ps = levels.fold(from, |at, level| {
            self.change(at, level);
            at + bit_ps
        });
    }

    /// The line is low for so long from `from_ns` on: a break.
    pub fn hear_break(&mut self, from_ns: u64, length_ns: u64) {
        let from = from_ns.saturating_mul(PS_PER_NS).max(self.known_ps);
        self.change(from, false);
        self.known_ps = from + length_ns.saturating_mul(PS_PER_NS);
        self.change(self.known_ps, true);
    }

    /// The line is idle until `until_ns`.
    pub fn idle(&mut self, until_ns: u64) {
        self.known_ps = self.known_ps.max(until_ns.saturating_mul(PS_PER_NS));
    }

    /// The instant at which the line is free for another character, in nanoseconds.
    pub fn free_ns(&self) -> u64 {
        self.known_ps.div_ceil(PS_PER_NS)
    }

    fn change(&mut self, from: u64, level: bool) {
        if self.changes.back().map_or(self.level, |(_, last)| *last) != level {
            self.changes.push_back((from, level));
        }
    }

    fn level_at(&self, instant: u64) -> bool {
        let before = self.changes.iter().take_while(|(from, _)| *from <= instant);
        before.last().map_or(self.level, |(_, level)| *level)
    }

    /// The next byte that it reads, as far as the line is known.
    pub fn read(&mut self) -> Option<Read> {
        loop {
            let start = self.next_start()?;
            let (bit, settings) = (self.settings.bit_ps(), self.settings);
            let sample = |place: u64| start + place * bit + bit / 2;
            let stop = 1 + u64::from(settings.data_bits) + u64::from(settings.has_parity());
            if sample(stop) > self.known_ps {
                return None;
            }
            if self.level_at(sample(0)) {
                self.pass(sample(0));
                continue;
            }
            let bits =
                (0..settings.data_bits).map(|i| u8::from(self.level_at(sample(1 + u64::from(i)))) << i);
            let byte = bits.fold(0, |byte, bit| byte | bit);
            let parity = !settings.has_parity()
                || self.level_at(sample(1 + u64::from(settings.data_bits))) == settings.parity_bit(byte);
            let framed = self.level_at(sample(stop));
            let error = match (framed, parity) {
                (false, _) => Some(LineError::Framing),
                (true, false) => Some(LineError::Parity),
                (true, true) => None,
            };
            self.waits_for_high = !framed;
            self.pass(sample(stop));
            return Some(Read { byte, at_ns: (start + settings.bits() * bit).div_ceil(PS_PER_NS), error });
        }
    }

    /// The instant at which the line falls next.
    fn next_start(&mut self) -> Option<u64> {
        if self.waits_for_high && !self.level {
            let (high, _) = *self.changes.front()?;
            self.pass(high);
        }
        self.waits_for_high = false;
        if !self.level {
            return Some(self.seen_ps);
        }
        self.changes.front().map(|(low, _)| *low)
    }

    /// All up to this instant has been looked at.
    fn pass(&mut self, instant: u64) {
        self.seen_ps = instant;
        while let Some((_, level)) = self.changes.pop_front_if(|(from, _)| *from <= instant) {
            self.level = level;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn heard(sender: Settings, receiver: Settings, bytes: &[u8]) -> Vec<(u8, Option<LineError>)> {
        let mut at = Receiver::new(receiver);
        for &byte in bytes {
            at.hear(&sender, 1000, byte);
        }
        at.idle(1_000_000_000);
        core::iter::from_fn(|| at.read()).map(|read| (read.byte, read.error)).collect()
    }

    fn all() -> Vec<u8> {
        (0..=255).collect()
    }

    #[test]
    fn the_same_settings_read_what_was_sent() {
        let parities = [Parity::None, Parity::Odd, Parity::Even, Parity::Mark, Parity::Space];
        for (parity, stop_bits) in parities.into_iter().flat_map(|parity| [(parity, 1), (parity, 2)]) {
            for baud in [300, 9600, 57_600, 250_000, 1_000_000] {
                let settings = Settings { baud, data_bits: 8, parity, stop_bits };
                let expected: Vec<_> = all().into_iter().map(|byte| (byte, None)).collect();
                assert_eq!(heard(settings, settings, &all()), expected, "{settings:?}");
            }
        }
        let seven = Settings { data_bits: 7, ..Settings::new_8n1(9600) };
        assert_eq!(heard(seven, seven, &[0x7f, 0x00]), [(0x7f, None), (0x00, None)]);
    }

    #[test]
    fn a_rate_that_is_off_by_4_percent_is_read_and_one_by_6_percent_is_not() {
        let expected: Vec<_> = all().into_iter().map(|byte| (byte, None)).collect();
        // Sampled at 9.5 bits, the stop bit is missed from a difference of half a bit on.
        for baud in [9216, 9984] {
            assert_eq!(heard(Settings::new_8n1(baud), Settings::new_8n1(9600), &all()), expected, "{baud}");
        }
        let off = heard(Settings::new_8n1(8900), Settings::new_8n1(9600), &all());
        assert!(off.iter().any(|(_, error)| *error == Some(LineError::Framing)));
    }

    #[test]
    fn half_the_rate_reads_each_bit_twice() {
        // 'U' is 0x55: start, 1 0 1 0 1 0 1 0, stop. At half the rate each second bit is sampled at its edge.
        // A sender at 4800 whose 0xff is a start bit of two of the receiver's: start and a first data bit of 0.
        let found = heard(Settings::new_8n1(4800), Settings::new_8n1(9600), &[0xff]);
        assert_eq!(found, [(0xfe, None)]);
        let found = heard(Settings::new_8n1(4800), Settings::new_8n1(9600), &[0x00]);
        assert_eq!(found, [(0x00, Some(LineError::Framing))], "18 bits of low are a break");
        let found = heard(Settings::new_8n1(9600), Settings::new_8n1(4800), &[0xff]);
        assert_eq!(found, [], "a start bit that is over before its centre is none");
    }

    #[test]
    fn parity_and_stop_bits_that_differ_are_told_as_chips_do() {
        let (none, even) =
            (Settings::new_8n1(9600), Settings { parity: Parity::Even, ..Settings::new_8n1(9600) });
        // The parity bit is read as the stop bit.
        assert_eq!(heard(even, none, &[0x01]), [(0x01, None)]);
        assert_eq!(heard(even, none, &[0x03]), [(0x03, Some(LineError::Framing))]);
        // The stop bit is read as the parity bit, and the idle line as the stop bit.
        assert_eq!(heard(none, even, &[0x03]), [(0x03, Some(LineError::Parity))]);
        assert_eq!(heard(none, even, &[0x01]), [(0x01, None)]);
        let two = Settings { stop_bits: 2, ..none };
        assert_eq!(heard(none, two, &[0x00, 0xff, 0x55]), [(0x00, None), (0xff, None), (0x55, None)]);
    }

    #[test]
    fn a_break_is_a_framing_error_with_0() {
        let mut at = Receiver::new(Settings::new_8n1(9600));
        at.hear_break(0, 250_000_000);
        at.hear(&Settings::new_8n1(9600), 0, 7);
        at.idle(1_000_000_000);
        let read: Vec<_> = core::iter::from_fn(|| at.read()).map(|read| (read.byte, read.error)).collect();
        assert_eq!(read, [(0, Some(LineError::Framing)), (7, None)]);
    }

    #[test]
    fn a_byte_is_read_when_its_character_is_over_and_not_before_the_line_is_known() {
        let settings = Settings::new_8n1(10_000);
        let mut at = Receiver::new(settings);
        at.hear(&settings, 500_000, b'a');
        assert_eq!(at.read(), Some(Read { byte: b'a', at_ns: 1_500_000, error: None }));
        let mut slow = Receiver::new(Settings::new_8n1(1000));
        slow.hear(&settings, 0, 0);
        assert_eq!(slow.read(), None, "what follows is not known");
        slow.idle(20_000_000);
        assert_eq!(slow.read().map(|read| read.byte), Some(0xff), "the start bit of the slow one covers all");
    }

    #[test]
    fn nothing_is_kept_of_what_has_been_read() {
        let (fast, slow) = (Settings::new_8n1(115_200), Settings::new_8n1(2400));
        let mut at = Receiver::new(slow);
        let mut random = 1_u32;
        for _ in 0..100_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            at.hear(&fast, 0, (random >> 24) as u8);
            while at.read().is_some() {}
            assert!(at.changes.len() < 1000);
        }
    }

    #[test]
    fn a_cable_of_n_bits_a_character_has_settings() {
        let of = |bits| Settings::of_cable(9600, bits);
        assert_eq!(of(10), Settings::new_8n1(9600));
        assert_eq!((of(11).stop_bits, of(11).bits()), (2, 11));
        assert_eq!((of(9).data_bits, of(9).bits()), (7, 9));
    }
}
