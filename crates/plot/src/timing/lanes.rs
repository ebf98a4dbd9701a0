//! The way from a robot's events to the lanes of its timing diagram.

use std::collections::{BTreeMap, BTreeSet};

use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::{Event, What};

use super::axis::ms;
use super::class::Class;
use super::diagram::{Bar, Lane};
use super::lane_id::LaneId;
use super::words;
use crate::quantity::{count, duration};

/// The lanes of a robot with its events in a window, which ends before `until_ns`. If `of_cycle` has the places of events,
/// all others are aside, but for trouble. `meanings` has what was said in events on cables, by their places.
pub fn lanes(
    robot: &RobotSpec,
    events: &[Event],
    (from_ns, until_ns): (u64, u64),
    of_cycle: Option<&BTreeSet<usize>>,
    meanings: &BTreeMap<usize, String>,
) -> Vec<Lane> {
    let mut lanes: BTreeMap<LaneId, Vec<Bar>> = BTreeMap::new();
    for (i, event) in events.iter().enumerate().filter(|(_, event)| is_in(event, from_ns, until_ns)) {
        let is_aside =
            of_cycle.is_some_and(|cycle| !cycle.contains(&i) && !Class::of(event.what).style().is_trouble);
        for who in LaneId::all_of(event.what, robot) {
            lanes.entry(who).or_default().push(bar(robot, (event, meanings.get(&i)), who, is_aside));
        }
    }
    for who in LaneId::always(robot) {
        let is_one_of_many = matches!(who, LaneId::Sensor(_)) && robot.sensors.len() > MOST_SENSORS;
        if !is_one_of_many {
            lanes.entry(who).or_default();
        }
    }
    let lane = |(who, bars): (LaneId, Vec<Bar>)| Lane {
        label: who.name(robot),
        group: who.group(),
        bars,
        wave: Vec::new(),
    };
    lanes.into_iter().map(lane).collect()
}

/// Whether a part of an event is in a window.
pub fn is_in(event: &Event, from_ns: u64, until_ns: u64) -> bool {
    let (start, end) = (event.start.as_ns(), event.end.as_ns());
    start < until_ns && (end > from_ns || start >= from_ns)
}

/// An event with its bytes and times, in one line.
fn title(robot: &RobotSpec, event: &Event) -> String {
    let (start, ns) = (event.start.as_ns(), event.end.since(event.start));
    let mut title = what(robot, event.what);
    match ns {
        0 => title += &format!(": at {} ms", handy_ms(start)),
        _ => {
            let end = handy_ms(event.end.as_ns());
            title += &format!(": {} to {end} ms, {}", handy_ms(start), duration(ns as f64));
        }
    }
    title
}

/// The event, with the number of bytes.
pub fn what(robot: &RobotSpec, what: What) -> String {
    let text = words::what(what, robot);
    match words::sensor_and_bytes(what).1 {
        Some(bytes) => format!("{text}, {}", count(bytes as usize, "byte")),
        None => text,
    }
}

fn bar(robot: &RobotSpec, (event, meaning): (&Event, Option<&String>), who: LaneId, is_aside: bool) -> Bar {
    let mut title = title(robot, event);
    if let Some(meaning) = meaning {
        title += &format!("; {meaning}");
    }
    Bar {
        start_ns: event.start.as_ns(),
        end_ns: event.end.as_ns(),
        label: label(robot, event, who),
        title,
        class: Class::of(event.what),
        is_aside,
    }
}

/// The text on a bar: all that is not in the name of its lane.
fn label(robot: &RobotSpec, event: &Event, who: LaneId) -> String {
    let bytes = |bytes: u32| count(bytes as usize, "byte");
    match event.what {
        // A chip's program reads sensors in no time of their own.
        What::Acquire { .. } if event.end == event.start => String::new(),
        What::Acquire { .. } if matches!(who, LaneId::Sensor(_)) => {
            duration(event.end.since(event.start) as f64)
        }
        What::Acquire { sensor } => words::sensor(robot, sensor),
        What::Measure { .. } => "measure".to_owned(),
        What::Frame { .. } => "frame".to_owned(),
        What::Block => "wait".to_owned(),
        What::Up { bytes: n } | What::Down { bytes: n } => bytes(n),
        What::Port { bytes: n, .. } | What::PortDown { bytes: n, .. } => bytes(n),
        What::Lost { bytes: n } => format!("{} lost", bytes(n)),
        What::Think { informed: true } => "think".to_owned(),
        What::Think { informed: false } => "no news".to_owned(),
        What::Adapter | What::Missed { .. } | What::Obey | What::Act | What::Late | What::Fault { .. } => {
            words::what(event.what, robot)
        }
    }
}

/// Milliseconds to the nanosecond, and no zeros at their end.
pub(super) fn handy_ms(ns: u64) -> String {
    let text = ms(ns, 6);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A robot with more sensors than this has lanes only for those that did something.
const MOST_SENSORS: usize = 16;
