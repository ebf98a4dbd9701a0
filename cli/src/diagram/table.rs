//! What is in a window as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use baudbot_plot::quantity::count;
use baudbot_plot::text::columns;
use baudbot_plot::timing::{Shot, has_lane, is_in, ms, printable, pulses_in_words, turns_in_words, what};
use baudbot_plot::trace::Lane;
use baudbot_sim::chip::{Level, Line, Net, Pulses, Shown, Stretch};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;

use super::parts::{self, Deed};
use super::record::{Kept, Window};

/// Something that happened.
pub(super) struct Row {
    start_ns: u64,
    end_ns: u64,
    who: String,
    what: String,
    /// What was said in it.
    meaning: String,
}

/// What happened in a window, by its beginning: the lane, and what it was. What is of the cycle that the window is about has a `*`.
/// With those of `meanings` is what was said in them; of the pins, those that have lanes are there.
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
    let of_shot = |shot| of_pin(shot, window).chain(of_parts(robot, shot, window));
    let mut rows: Vec<_> = events.chain(shots.flat_map(of_shot)).collect();
    rows.sort_by_key(|row| (row.start_ns, row.end_ns));
    rows
}

/// A line for each: its beginning and its duration, in milliseconds, its lane, and what happened.
pub(super) fn text(rows: &[Row]) -> String {
    let head = ["start ms", "duration ms", "who", "what"].map(str::to_owned);
    let line = |row: &Row| {
        let meaning =
            if row.meaning.is_empty() { String::new() } else { format!(": {}", shortened(&row.meaning)) };
        let what = row.what.clone() + &meaning;
        [
            ms(row.start_ns, DECIMALS),
            ms(row.end_ns.saturating_sub(row.start_ns), DECIMALS),
            row.who.clone(),
            what,
        ]
    };
    let lines: Vec<_> = std::iter::once(head).chain(rows.iter().map(line)).collect();
    columns("", &lines, |i| i >= 2)
}

/// The same as comma-separated values, to the nanosecond.
pub(super) fn csv(rows: &[Row]) -> String {
    let mut csv = "start_ms,duration_ms,who,what,meaning\n".to_owned();
    for row in rows {
        let (start, long) = (ms(row.start_ns, 6), ms(row.end_ns.saturating_sub(row.start_ns), 6));
        let [who, what, meaning] = [&row.who, &row.what, &row.meaning].map(|text| quoted(text));
        let _ = writeln!(csv, "{start},{long},{who},{what},{meaning}");
    }
    csv
}

/// A cell of a table, in quotes if it needs them.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

fn row(robot: &RobotSpec, event: &Event, is_of_cycle: bool, meaning: Option<&String>) -> Row {
    let who = Lane::of(event.what, robot).next().map(|lane| lane.name(robot)).unwrap_or_default();
    let mark = if is_of_cycle { " *" } else { "" };
    Row {
        start_ns: event.start.as_ns(),
        end_ns: event.end.as_ns(),
        who,
        what: what(robot, event.what) + mark,
        meaning: meaning.cloned().unwrap_or_default(),
    }
}

/// What is on a signal.
fn of_pin(shot: &Shot, window: &Window) -> impl Iterator<Item = Row> {
    let who = shot.signal.label();
    let until_ns = window.until_ns;
    let row = move |(i, shown): (usize, &Shown)| {
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
        let start_ns = shown.at_ns();
        window.has(start_ns, end_ns).then(|| Row {
            start_ns,
            end_ns,
            who: who.clone(),
            what,
            meaning: String::new(),
        })
    };
    shot.shown.iter().enumerate().filter_map(row)
}

/// What lamps, buzzers and servos on a signal do.
fn of_parts(robot: &RobotSpec, shot: &Shot, window: &Window) -> impl Iterator<Item = Row> {
    let chip = robot.chip.iter();
    let deeds = chip.flat_map(|chip| parts::deeds(chip, shot, window.until_ns));
    let seen = deeds.filter(|deed| window.has(deed.start_ns, deed.end_ns));
    seen.map(|Deed { start_ns, end_ns, who, what }| Row {
        start_ns,
        end_ns,
        who,
        what,
        meaning: String::new(),
    })
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

/// Of a millisecond.
const DECIMALS: usize = 3;
/// Characters of what was said.
const MOST_TEXT: usize = 160;
