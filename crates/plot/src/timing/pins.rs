//! The way from the record of a logic analyser on the pins of a chip to lanes of a timing diagram.

use baudbot_sim::chip::{Level, Line, Net, Pulses, Shown, Signal, Stretch, Turns};

use super::axis::ms;
use super::bars::SIZE;
use super::class::Class;
use super::diagram::{Bar, Group, Lane, PLOT};
use super::lanes::handy_ms;
use crate::quantity::{duration, handy};
use crate::text::{shortened, width};

/// A signal with what is on it, in the order of time.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The signal.
    pub signal: Signal,
    /// The stretches of the signal, from before the window on if it is known.
    pub shown: Vec<Shown>,
}

/// Pulses with a period below this, in nanoseconds, are too near each other to be drawn one by one in a window of this length.
pub fn finest_ns(span_ns: u64) -> u64 {
    (span_ns as f64 * LEAST_PERIOD / PLOT) as u64
}

/// The lanes of signals in a window, which ends before `until_ns`: of the main loop, if rounds of it are known, and of wires. Without a choice of wires these are all that have something on
/// them or that the program moves, but for those of the UART; with it they are those, with their channels of the ADC. A wire with
/// a voltage that never is a level has no lane of its own.
pub fn pin_lanes(shots: &[Shot], span: (u64, u64), chosen: Option<&[Net]>) -> Vec<Lane> {
    let window = Window { from_ns: span.0, until_ns: span.1 };
    shots.iter().filter(|shot| window.has_lane(shot, shots, chosen)).map(|shot| window.lane(shot)).collect()
}

/// Whether a signal among others has a [lane](pin_lanes).
pub fn has_lane(
    shot: &Shot,
    shots: &[Shot],
    (from_ns, until_ns): (u64, u64),
    chosen: Option<&[Net]>,
) -> bool {
    Window { from_ns, until_ns }.has_lane(shot, shots, chosen)
}

/// The duty and the frequency of pulses that are alike, else how many there are.
pub fn pulses_in_words(pulses: &Pulses) -> String {
    if !pulses.is_even {
        return format!("{} × high", pulses.count);
    }
    format!("{}, {}", percent(pulses.duty()), hz_in_words(pulses.frequency_hz()))
}

/// A part of 1 in percent, to a tenth.
pub fn percent(part: f64) -> String {
    format!("{} %", handy((1000.0 * part).round() / 10.0))
}

/// A frequency in three digits.
pub fn hz_in_words(hz: f64) -> String {
    let three = |value: f64| handy(format!("{value:.2e}").parse().unwrap_or(value));
    if hz < 1000.0 { format!("{} Hz", three(hz)) } else { format!("{} kHz", three(hz / 1000.0)) }
}

/// A character as text, with an escape if it cannot be printed.
pub fn printable(number: u16) -> String {
    match u8::try_from(number) {
        Ok(byte) => byte.escape_ascii().to_string().replace("\\\"", "\"").replace("\\'", "'"),
        Err(_) => format!("\\x{number:03x}"),
    }
}

#[derive(Clone, Copy)]
struct Window {
    from_ns: u64,
    until_ns: u64,
}

impl Window {
    fn has_lane(self, shot: &Shot, shots: &[Shot], chosen: Option<&[Net]>) -> bool {
        let net_of = |number| Net::arduino(number);
        match (shot.signal.line, chosen) {
            (Line::Wire(net), Some(chosen)) => {
                let has_channel = |other: &Shot| other.signal.line == channel(net);
                chosen.contains(&net) && (self.is_driven(shot) || !shots.iter().any(has_channel))
            }
            (Line::Wire(net), None) => {
                let is_uart = [net_of(0), net_of(1)].contains(&Some(net));
                let is_wired = !shot.signal.on.is_empty();
                let is_voltage = shots.iter().any(|other| other.signal.line == channel(net));
                (is_wired && !is_voltage && !is_uart) || (!is_uart && self.moves(shot))
            }
            (Line::Adc(own), Some(chosen)) => chosen.iter().any(|net| net.adc_channel() == Some(own)),
            (Line::Adc(_), None) => true,
            (Line::MainLoop, _) => self.turns(shot).next().is_some(),
            (Line::Sent | Line::Received, _) => self.numbers(shot).next().is_some(),
        }
    }

    /// Whether a wire is high or low in the window.
    fn is_driven(self, shot: &Shot) -> bool {
        self.stretches(shot).any(|stretch| !matches!(stretch, Stretch::Level { level: Level::Open, .. }))
    }

    /// Whether a wire changes in the window, other than by being released.
    fn moves(self, shot: &Shot) -> bool {
        let stretches = self.stretches(shot);
        let begins = stretches
            .filter(|stretch| stretch.at_ns() > self.from_ns || matches!(stretch, Stretch::Pulses(_)));
        begins.into_iter().any(|stretch| !matches!(stretch, Stretch::Level { level: Level::Open, .. }))
    }

    /// The stretches of a wire that are seen.
    fn stretches(self, shot: &Shot) -> impl Iterator<Item = Stretch> {
        let all: Vec<Stretch> = stretches(&shot.shown);
        let ends: Vec<u64> = all.iter().skip(1).map(Stretch::at_ns).chain([u64::MAX]).collect();
        let is_seen = move |(one, end): &(Stretch, u64)| one.at_ns() < self.until_ns && *end > self.from_ns;
        all.into_iter().zip(ends).filter(is_seen).map(|(one, _)| one)
    }

    /// Numbers of a signal that are seen, each with its end.
    fn numbers(self, shot: &Shot) -> impl Iterator<Item = (u64, u64, u16)> {
        let next_ns = move |i: usize| shot.shown.get(i + 1).map_or(self.until_ns, Shown::at_ns);
        let number = move |(i, shown): (usize, &Shown)| match *shown {
            Shown::Number { at_ns, number } => Some((at_ns, next_ns(i), number)),
            Shown::Over { .. } | Shown::Stretch(_) | Shown::Turns(_) => None,
        };
        let is_seen =
            move |(from, until, _): &(u64, u64, u16)| *from < self.until_ns && *until > self.from_ns;
        shot.shown.iter().enumerate().filter_map(number).filter(is_seen)
    }

    /// Rounds of the main loop that are seen.
    fn turns(self, shot: &Shot) -> impl Iterator<Item = Turns> {
        let turns = |shown: &Shown| if let Shown::Turns(turns) = shown { Some(*turns) } else { None };
        let is_seen = move |turns: &Turns| turns.from_ns < self.until_ns && turns.until_ns > self.from_ns;
        shot.shown.iter().filter_map(turns).filter(is_seen)
    }

    fn lane(self, shot: &Shot) -> Lane {
        let label = shot.signal.label();
        let (group, bars, wave) = match shot.signal.line {
            Line::MainLoop => (Group::Microcontroller, self.turns(shot).map(rounds).collect(), Vec::new()),
            Line::Wire(_) => (Group::Pins, Vec::new(), self.stretches(shot).collect()),
            Line::Adc(_) => (Group::Chip, self.results(shot), Vec::new()),
            Line::Sent => (Group::Chip, self.text(shot, Class::Sent), Vec::new()),
            Line::Received => (Group::Chip, self.text(shot, Class::Received), Vec::new()),
        };
        Lane { label, group, bars, wave }
    }

    fn results(self, shot: &Shot) -> Vec<Bar> {
        let seen = self.numbers(shot).filter(|(at_ns, ..)| *at_ns >= self.from_ns);
        let bar = |(at_ns, _, number): (u64, u64, u16)| Bar {
            start_ns: at_ns,
            end_ns: at_ns,
            label: number.to_string(),
            title: format!("{number}: at {} ms", handy_ms(at_ns)),
            class: Class::Convert,
            is_aside: false,
        };
        seen.map(bar).collect()
    }

    /// Characters; those that follow on each other and have no room for their own text are one bar.
    fn text(self, shot: &Shot, class: Class) -> Vec<Bar> {
        let ns_per_px = self.until_ns.saturating_sub(self.from_ns).max(1) as f64 / PLOT;
        let mut words: Vec<(u64, u64, String)> = Vec::new();
        for (from, until, number) in self.numbers(shot) {
            let character = printable(number);
            let room = (until - from) as f64 / ns_per_px;
            let gap_ns = (until - from) / 2;
            match words.last_mut() {
                Some((_, end, text)) if room < ROOMY && from.saturating_sub(*end) <= gap_ns => {
                    *end = until;
                    text.push_str(&character);
                }
                _ => words.push((from, until, character)),
            }
        }
        let bar = |(start_ns, end_ns, text): (u64, u64, String)| {
            let room = (end_ns - start_ns) as f64 / ns_per_px - 7.0;
            let short = shortened(&text, SIZE, room);
            let label = if width(&short, SIZE) <= room { short } else { String::new() };
            let (from, until) = (ms(start_ns, 3), ms(end_ns, 3));
            let title = format!("{}: {from} to {until} ms, {}", text, duration((end_ns - start_ns) as f64));
            Bar { start_ns, end_ns, label, title, class, is_aside: false }
        };
        words.into_iter().map(bar).collect()
    }
}

/// The number of rounds of the main loop and the cycles that they take, in words.
pub fn turns_in_words(turns: &Turns) -> String {
    let cycles = handy((10.0 * turns.mean_cycles()).round() / 10.0);
    match turns.count {
        0 | 1 => format!("a round of {cycles} cycles"),
        count => format!("{count} short rounds, {cycles} cycles on average"),
    }
}

/// The bar of rounds of the main loop.
fn rounds(turns: Turns) -> Bar {
    let Turns { from_ns, until_ns, count, are_short, .. } = turns;
    let long = duration(until_ns.saturating_sub(from_ns) as f64);
    let (from, until) = (handy_ms(from_ns), handy_ms(until_ns));
    Bar {
        start_ns: from_ns,
        end_ns: until_ns,
        label: if count > 1 { format!("{count} rounds") } else { long.clone() },
        title: format!("{}: {from} to {until} ms, {long}", turns_in_words(&turns)),
        class: if are_short { Class::Rounds } else { Class::Round },
        is_aside: false,
    }
}

/// The stretches among what is shown.
fn stretches(shown: &[Shown]) -> Vec<Stretch> {
    let mut all = Vec::new();
    for one in shown {
        if let Shown::Stretch(stretch) = one {
            baudbot_sim::chip::add(&mut all, *stretch);
        }
    }
    all
}

/// The line of the ADC's channel on a wire; of a wire without one, one that no signal has.
fn channel(net: Net) -> Line {
    net.adc_channel().map_or(Line::Wire(Net::Ground), Line::Adc)
}

/// Periods of pulses that are drawn one by one are at least so wide, in pixels.
const LEAST_PERIOD: f64 = 4.0;
/// A character that is so wide, in pixels, is a bar of its own.
const ROOMY: f64 = 14.0;
