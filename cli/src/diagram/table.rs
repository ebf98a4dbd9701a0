//! The events of a window as text.

use std::collections::BTreeMap;

use baudbot_plot::quantity::count;
use baudbot_plot::text::columns;
use baudbot_plot::timing::{
    LaneId, Shot, has_lane, is_in, ms, printable, pulses_in_words, turns_in_words, what,
};
use baudbot_sim::chip::{Level, Line, Net, Pulses, Shown, Stretch};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;

use super::parts::{self, Deed};
use super::record::{Kept, Window};

/// An event, and the text that was sent in it.
pub(super) struct Row {
    deed: Deed,
    meaning: String,
}

/// The events of a window, by their beginnings: the lane, and the event. What is of the cycle that the window is about
/// has a `*`. The texts of `meanings` are with their events; of the pins, those that have lanes are there.
pub(super) fn rows(
    robot: &RobotSpec,
    (kept, chosen): (&Kept, Option<&[Net]>),
    window: &Window,
    meanings: &BTreeMap<usize, String>,
) -> Vec<Row> {
    let span = (window.from_ns, window.until_ns);
    let in_window = |(_, event): &(usize, &Event)| is_in(event, window.from_ns, window.until_ns);
    let events = kept.events.iter().enumerate().filter(in_window);
    let events = events.map(|(i, event)| row(robot, event, is_of_cycle(window, i), meanings.get(&i)));
    let shots = kept.pins.shots.iter().filter(|shot| has_lane(shot, &kept.pins.shots, span, chosen));
    let chip = robot.chip.as_ref();
    let of_shot = |shot| {
        let parts = chip.into_iter().flat_map(move |chip| parts::deeds(chip, shot, window.until_ns));
        of_pin(shot, window.until_ns).chain(parts).filter(|deed| window.has(deed.start_ns, deed.end_ns))
    };
    let on_pins = shots.flat_map(of_shot).map(|deed| Row { deed, meaning: String::new() });
    let mut rows: Vec<_> = events.chain(on_pins).collect();
    rows.sort_by_key(|row| (row.deed.start_ns, row.deed.end_ns));
    rows
}

/// A line for each: its beginning and its duration, in milliseconds, its lane, and what happened.
pub(super) fn text(rows: &[Row]) -> String {
    let head = ["start ms", "duration ms", "who", "what"].map(str::to_owned);
    let line = |Row { deed, meaning }: &Row| {
        let meaning = if meaning.is_empty() { String::new() } else { format!(": {}", shortened(meaning)) };
        let [start, long] = deed.times(DECIMALS);
        [start, long, deed.who.clone(), deed.what.clone() + &meaning]
    };
    let lines: Vec<_> = std::iter::once(head).chain(rows.iter().map(line)).collect();
    columns("", &lines, |i| i >= 2)
}

/// The same as comma-separated values, to the nanosecond.
pub(super) fn csv(rows: &[Row]) -> anyhow::Result<String> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(["start_ms", "duration_ms", "who", "what", "meaning"])?;
    for Row { deed, meaning } in rows {
        let [start, long] = deed.times(6);
        csv.write_record([&start, &long, &deed.who, &deed.what, meaning])?;
    }
    Ok(String::from_utf8(csv.into_inner()?)?)
}

impl Deed {
    /// The deed's beginning and duration, in milliseconds.
    fn times(&self, decimals: usize) -> [String; 2] {
        [self.start_ns, self.end_ns.saturating_sub(self.start_ns)].map(|ns| ms(ns, decimals))
    }
}

fn row(robot: &RobotSpec, event: &Event, is_of_cycle: bool, meaning: Option<&String>) -> Row {
    let mark = if is_of_cycle { " *" } else { "" };
    let deed = Deed {
        start_ns: event.start.as_ns(),
        end_ns: event.end.as_ns(),
        who: LaneId::of(event.what).name(robot),
        what: what(robot, event.what) + mark,
    };
    Row { deed, meaning: meaning.cloned().unwrap_or_default() }
}

/// The events on a signal.
fn of_pin(shot: &Shot, until_ns: u64) -> impl Iterator<Item = Deed> {
    let who = shot.signal.label();
    let deed = move |(i, shown): (usize, &Shown)| {
        let next_ns = shot.shown.get(i + 1).map_or(until_ns, Shown::at_ns);
        let (end_ns, what) = match *shown {
            Shown::Stretch(Stretch::Level { level, .. }) => (next_ns, level_in_words(level).to_owned()),
            Shown::Stretch(Stretch::Pulses(pulses)) => (pulses.until_ns, pulses_of(&pulses)),
            Shown::Turns(turns) => (turns.until_ns, turns_in_words(&turns)),
            Shown::Number { at_ns, number } if matches!(shot.signal.line, Line::Adc(_)) => {
                (at_ns, number.to_string())
            }
            Shown::Number { number, .. } => (next_ns, format!("'{}'", printable(number))),
            Shown::Over { .. } => return None,
        };
        Some(Deed { start_ns: shown.at_ns(), end_ns, who: who.clone(), what })
    };
    shot.shown.iter().enumerate().filter_map(deed)
}

fn pulses_of(pulses: &Pulses) -> String {
    match pulses.is_even {
        true => format!("{}, {}", count(pulses.count as usize, "pulse"), pulses_in_words(pulses)),
        false => format!("{} of different lengths", count(pulses.count as usize, "pulse")),
    }
}

fn level_in_words(level: Level) -> &'static str {
    match level {
        Level::Low => "low",
        Level::High => "high",
        Level::Open => "not driven",
        Level::Short => "driven against each other",
    }
}

/// The beginning of a text that is longer than a line.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(MOST_TEXT) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

fn is_of_cycle(window: &Window, place: usize) -> bool {
    window.cycle.as_ref().is_some_and(|cycle| cycle.events.contains(&place))
}

/// The decimals of a millisecond.
const DECIMALS: usize = 3;
/// The most characters of a message.
const MOST_TEXT: usize = 160;
