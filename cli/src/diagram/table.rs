//! The events of a window as text.

use std::collections::BTreeMap;

use baudbot_plot::text::columns;
use baudbot_plot::timing::{is_in, ms, what};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;
use baudbot_trace::Lane;

use super::record::Window;

/// A line for each event of a window: its beginning and its duration, in milliseconds, its lane, and what happened.
/// Those of the cycle that the window is about have a `*`. Behind those of `meanings` is what was said in them.
pub(super) fn table(
    robot: &RobotSpec,
    events: &[Event],
    window: &Window,
    meanings: &BTreeMap<usize, String>,
) -> String {
    let in_window = |(_, event): &(usize, &Event)| is_in(event, window.from_ns, window.until_ns);
    let mut shown: Vec<_> = events.iter().enumerate().filter(in_window).collect();
    shown.sort_by_key(|(_, event)| (event.start, event.end));
    let head = ["start ms", "duration ms", "who", "what"].map(str::to_owned);
    let rows: Vec<_> = shown
        .into_iter()
        .map(|(i, event)| row(robot, event, is_of_cycle(window, i), meanings.get(&i)))
        .collect();
    let rows: Vec<_> = std::iter::once(head).chain(rows).collect();
    columns("", &rows, |i| i >= 2)
}

fn row(robot: &RobotSpec, event: &Event, is_of_cycle: bool, meaning: Option<&String>) -> [String; 4] {
    let start = ms(event.start.as_ns(), DECIMALS);
    let long = ms(event.end.since(event.start), DECIMALS);
    let who = Lane::of(event.what, robot).next().map(|lane| lane.name(robot)).unwrap_or_default();
    let mark = if is_of_cycle { " *" } else { "" };
    let meaning = meaning.map_or_else(String::new, |meaning| format!(": {}", shortened(meaning)));
    [start, long, who, what(robot, event.what) + mark + &meaning]
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
