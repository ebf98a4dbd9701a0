//! A logic analyser on the pins: it makes [`Edges`] of what the chip and the parts do.
//!
//! Events are reported in any order, some of them ahead of time, and wait until the chip has come to their instants.
//! Signals of timers that are reported by their [shape](Pwm) are drawn from it: the first period begins, high, when the
//! timer takes the pin or changes its period; a new duty holds from the next period on. So the frequency and the duty
//! are the chip's, and the phase is not. The bits of characters are drawn, too, as the chip does not move TXD and RXD
//! for them.

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_avr::usart::{BitLength, Frame};
use baudbot_avr::{Drive, External, Pin, Port, Pwm, Round};

use super::pins::Sides;
use super::wave::Wave;
use crate::clock::ChipClock;
use crate::edges::{By, Edge, Edges, Level, RoundsOver, Seen};

/// An analyser, if there is one. It is no part of a board's state: it is not saved, and makes no difference between boards.
#[derive(Clone, Debug, Default)]
pub(super) struct Fitted(pub(super) Option<Box<Analyser>>);

impl PartialEq for Fitted {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[derive(Clone, Debug)]
pub(super) struct Analyser {
    /// The instant of the board's start, in nanoseconds of the reader's clock.
    pub(super) origin_ns: u64,
    edges: Edges,
    wires: Vec<Wire>,
    /// The reports whose instants are still to come.
    waiting: Vec<(u64, Told)>,
    waves: Vec<Wave>,
    /// The level that the cable gives RXD; the other end makes it high while nothing is sent.
    cable: bool,
    /// The last begin of a round that was drawn, and the short rounds since then.
    round: Option<(u64, Short)>,
}

/// Short rounds of a loop.
#[derive(Clone, Copy, Debug)]
struct Short {
    head: u32,
    count: u32,
    cycles: u64,
}

/// Cycles of a round of the main loop that is drawn by itself: shorter ones would leave no room for other edges.
const SHORTEST_ROUND: u64 = 1000;

/// A pin as it was when the analyser was fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wire {
    pub(super) pin: Pin,
    pub(super) sides: Sides,
    /// The levels of the parts that yield to the chip.
    pub(super) yields: Yields,
    pub(super) shape: Option<Pwm>,
    /// The level that was noted last.
    pub(super) level: Option<Level>,
}

/// Parts on a wire that the chip overrides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Yields {
    /// None.
    Never,
    /// The part gives the wire this level by a resistor only.
    At(External),
    /// The part has a resistor.
    Always,
}

/// A report of an event.
#[derive(Clone, Copy, Debug)]
enum Told {
    Chip(Pin, Drive),
    Shape(Pin, Pwm),
    Part(Pin, External),
    Converted(u8, u16),
    Out(Character),
    In(Character),
    Round(Short, u64),
}

/// The fate of a character.
#[derive(Clone, Copy, Debug)]
enum Character {
    Begins(Frame),
    Bit(bool),
    Ends,
}

const RXD: Option<Pin> = Pin::new(Port::D, 0);
const TXD: Option<Pin> = Pin::new(Port::D, 1);

impl Analyser {
    /// An analyser that is fitted at a cycle.
    pub(super) fn new(wires: Vec<Wire>, origin_ns: u64, now: u64, clock: &ChipClock) -> Self {
        let waves = wires.iter().filter_map(|wire| Some(Wave::new(wire.pin, wire.shape?, now))).collect();
        let (edges, waiting) = (Edges::default(), Vec::new());
        let mut analyser = Self { origin_ns, edges, wires, waiting, waves, cable: true, round: None };
        for place in 0..analyser.wires.len() {
            analyser.look(place, By::Chip, now, clock);
        }
        analyser
    }

    pub(super) const fn edges(&self) -> &Edges {
        &self.edges
    }

    pub(super) fn levels(&self) -> impl Iterator<Item = (Pin, Level)> {
        self.wires.iter().filter_map(|wire| Some((wire.pin, wire.level?)))
    }

    pub(super) fn chip(&mut self, pin: Pin, drive: Drive, at: u64) {
        if Some(pin) == TXD {
            self.break_off(at);
        }
        self.waiting.push((at, Told::Chip(pin, drive)));
    }

    /// The transmitter releases its pin: behind its last character, or within one by a reset.
    fn break_off(&mut self, at: u64) {
        let before = self.waiting.len();
        self.waiting.retain(|(later, told)| *later <= at || !matches!(told, Told::Out(_)));
        if self.waiting.len() < before {
            self.waiting.push((at, Told::Out(Character::Ends)));
        }
    }

    pub(super) fn shape(&mut self, pin: Pin, pwm: Pwm, at: u64) {
        self.waiting.push((at, Told::Shape(pin, pwm)));
    }

    pub(super) fn part(&mut self, pin: Pin, external: External, at: u64) {
        self.waiting.push((at, Told::Part(pin, external)));
    }

    pub(super) fn converted(&mut self, channel: u8, result: u16, at: u64) {
        self.waiting.push((at, Told::Converted(channel, result)));
    }

    pub(super) fn round(&mut self, at: u64, last: Round) {
        let none = Short { head: last.head, count: 0, cycles: 0 };
        self.round = match self.round {
            // Another loop was the main one: its duration is not reported.
            Some((before, short)) if short.head != last.head && at < before + SHORTEST_ROUND => {
                Some((before, none))
            }
            Some((before, short)) if at < before + SHORTEST_ROUND => {
                let (count, cycles) = (short.count.saturating_add(1), short.cycles + last.cycles);
                Some((before, Short { count, cycles, ..short }))
            }
            drawn => {
                let short = drawn.map(|(_, short)| short).filter(|short| short.head == last.head);
                self.waiting.push((at, Told::Round(short.unwrap_or(none), last.cycles)));
                Some((at, none))
            }
        };
    }

    pub(super) fn sends(&mut self, frame: Frame, start: u64, bit_cycles: u64) {
        self.character(frame, Told::Out, |bit| start + bit * bit_cycles);
    }

    pub(super) fn receives(&mut self, frame: Frame, start: u64, length: BitLength) {
        self.character(frame, Told::In, |bit| start + length.begin_of(bit));
    }

    fn character(&mut self, frame: Frame, told: fn(Character) -> Told, begin: impl Fn(u64) -> u64) {
        let bits = u64::from(frame.bits());
        self.waiting.push((begin(0), told(Character::Begins(frame))));
        self.waiting.extend((0..bits).map(|bit| (begin(bit), told(Character::Bit(frame.level(bit))))));
        self.waiting.push((begin(bits), told(Character::Ends)));
    }

    /// Notes all that has happened up to a cycle.
    pub(super) fn settle(&mut self, now: u64, clock: &ChipClock) {
        self.waiting.sort_by_key(|(at, _)| *at);
        let over = self.waiting.partition_point(|(at, _)| *at <= now);
        let waiting = self.waiting.split_off(over);
        for (at, told) in core::mem::replace(&mut self.waiting, waiting) {
            self.draw(at, clock);
            self.take(told, at, clock);
        }
        self.draw(now, clock);
    }

    /// Draws the signals of timers up to a cycle.
    fn draw(&mut self, until: u64, clock: &ChipClock) {
        while let Some(wave) =
            self.waves.iter_mut().min_by_key(|wave| wave.next()).filter(|wave| wave.next() <= until)
        {
            let (pin, at) = (wave.pin(), wave.next());
            let drive = if wave.step() { Drive::High } else { Drive::Low };
            self.change(pin, By::Shape, at, clock, |sides| sides.chip = drive);
        }
    }

    fn take(&mut self, told: Told, at: u64, clock: &ChipClock) {
        match told {
            Told::Chip(pin, drive) => {
                self.waves.retain(|wave| wave.pin() != pin);
                self.change(pin, By::Chip, at, clock, |sides| sides.chip = drive);
            }
            Told::Shape(pin, shape) => {
                self.note(Seen::Shape { pin, shape }, at, clock);
                match self.waves.iter_mut().find(|wave| wave.pin() == pin) {
                    Some(wave) => wave.change(shape, at),
                    None => self.waves.push(Wave::new(pin, shape, at)),
                }
            }
            Told::Part(pin, external) => self.change(pin, By::Part, at, clock, |sides| sides.part = external),
            Told::Converted(channel, result) => self.note(Seen::Converted { channel, result }, at, clock),
            Told::Round(short, cycles) => {
                self.note(Seen::Round(self.rounds(short, cycles, at, clock)), at, clock);
            }
            Told::Out(Character::Begins(frame)) => self.note(Seen::Sends(Some(frame)), at, clock),
            Told::Out(Character::Ends) => self.note(Seen::Sends(None), at, clock),
            Told::Out(Character::Bit(high)) => {
                let drive = if high { Drive::High } else { Drive::Low };
                let Some(pin) = TXD else { return };
                self.change(pin, By::Character, at, clock, |sides| sides.chip = drive);
            }
            Told::In(Character::Begins(frame)) => self.note(Seen::Receives(Some(frame)), at, clock),
            Told::In(Character::Ends) => self.note(Seen::Receives(None), at, clock),
            Told::In(Character::Bit(high)) => {
                self.cable = high;
                let Some(pin) = RXD else { return };
                self.change(pin, By::Character, at, clock, |_| {});
            }
        }
    }

    fn rounds(&self, short: Short, cycles: u64, at: u64, clock: &ChipClock) -> RoundsOver {
        let since_ns = self.origin_ns.saturating_add(clock.ns(at.saturating_sub(cycles)));
        let short_cycles = u32::try_from(short.cycles).unwrap_or(u32::MAX);
        RoundsOver { head: short.head, short: short.count, short_cycles, cycles, since_ns }
    }

    fn change(&mut self, pin: Pin, by: By, at: u64, clock: &ChipClock, change: impl FnOnce(&mut Sides)) {
        let Some(place) = self.wires.iter().position(|wire| wire.pin == pin) else { return };
        change(&mut self.wires[place].sides);
        self.look(place, by, at, clock);
    }

    /// Notes the level of a wire, if it is another one.
    fn look(&mut self, place: usize, by: By, at: u64, clock: &ChipClock) {
        let wire = self.wires[place];
        let level = Some(wire.level_now(self.cable));
        if level == wire.level {
            return;
        }
        self.wires[place].level = level;
        if let Some(level) = level {
            self.note(Seen::Level { pin: wire.pin, level, by }, at, clock);
        }
    }

    fn note(&mut self, seen: Seen, at: u64, clock: &ChipClock) {
        self.edges.push(Edge { at_ns: self.origin_ns.saturating_add(clock.ns(at)), seen });
    }
}

impl Wire {
    fn level_now(&self, cable: bool) -> Level {
        let Sides { chip, part } = self.sides;
        let is_driven = chip.is_output();
        let is_short = is_driven
            && self.sides.is_short()
            && match self.yields {
                Yields::Never => true,
                Yields::At(level) => part != level,
                Yields::Always => false,
            };
        if is_short {
            return Level::Short;
        }
        if Some(self.pin) == RXD && part == External::Open && !is_driven {
            return if cable { Level::High } else { Level::Low };
        }
        match self.sides.level() {
            Some(true) => Level::High,
            Some(false) => Level::Low,
            None => Level::Open,
        }
    }
}
