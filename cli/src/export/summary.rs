//! The description of a recording, if no output is requested.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::Context;
use baudbot_plot::quantity::{count, duration, handy};
use baudbot_recording::RecordedRun;
use prost_types::Timestamp;
use serde::Serialize;

use super::events::kind_of;
use crate::text;

/// A recording in short.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    file: String,
    bytes: u64,
    format: u32,
    program_version: &'a str,
    world: &'a str,
    scenario: &'a str,
    seed: u64,
    /// The start of the run, in UTC.
    started: String,
    step_ns: u64,
    first_tick: u64,
    last_tick: u64,
    from_s: f64,
    to_s: f64,
    simulated_s: f64,
    robots: &'a [String],
    ticks_with_inputs: usize,
    events: BTreeMap<&'static str, usize>,
    last_state_hash: String,
    cut_off: Option<&'a str>,
}

pub(super) fn show(path: &Path, recorded: &RecordedRun, as_json: bool) -> anyhow::Result<()> {
    let bytes = fs::metadata(path).with_context(|| format!("cannot read {}", path.display()))?.len();
    let summary = Summary::new(path.display().to_string(), bytes, recorded);
    if as_json {
        return text::print_json(&summary);
    }
    text::print(&summary.text())
}

impl<'a> Summary<'a> {
    fn new(file: String, bytes: u64, recorded: &'a RecordedRun) -> Self {
        let header = recorded.header();
        let (first_tick, last_tick, step_ns) = (recorded.first_tick(), recorded.last_tick(), header.step_ns);
        let seconds = |ticks: u64| ticks as f64 * step_ns as f64 / 1e9;
        let mut events = BTreeMap::new();
        for event in recorded.events() {
            *events.entry(kind_of(event)).or_default() += 1;
        }
        let started = Timestamp {
            seconds: i64::try_from(header.started_unix_ns / 1_000_000_000).unwrap_or(0),
            nanos: 0,
        };
        Self {
            file,
            bytes,
            format: header.format,
            program_version: &header.program_version,
            world: &header.world,
            scenario: &recorded.scenario().name,
            seed: header.seed,
            started: started.to_string(),
            step_ns,
            first_tick,
            last_tick,
            from_s: seconds(first_tick),
            to_s: seconds(last_tick),
            simulated_s: seconds(last_tick - first_tick),
            robots: &header.robots,
            ticks_with_inputs: recorded.inputs(),
            events,
            last_state_hash: format!("{:016x}", recorded.last_hash()),
            cut_off: recorded.problem(),
        }
    }

    fn text(&self) -> String {
        let ticks = self.last_tick - self.first_tick;
        let (from_s, to_s) = (handy(self.from_s), handy(self.to_s));
        let step = duration(self.step_ns as f64);
        let events = self.events.iter().map(|(kind, number)| format!("{number} {kind}"));
        let events = events.collect::<Vec<_>>().join(", ");
        let mut pairs = vec![
            ("recording", format!("{}, {}", self.file, size(self.bytes))),
            ("world", format!("{}, scenario {}, seed {}", self.world, self.scenario, self.seed)),
            ("recorded", format!("{} by baudbot {}", self.started, self.program_version)),
            ("ticks", format!("{ticks} of {step}, from {from_s} to {to_s} s")),
            ("robots", self.robots()),
            ("inputs", format!("in {}", count(self.ticks_with_inputs, "tick"))),
            ("events", if events.is_empty() { "none".to_owned() } else { events }),
            ("state hash", format!("{} at the end", self.last_state_hash)),
        ];
        if let Some(problem) = self.cut_off {
            pairs.push(("cut off", problem.to_owned()));
        }
        text::pairs("", &pairs)
    }

    fn robots(&self) -> String {
        match self.robots {
            [] => "none".to_owned(),
            few if few.len() <= 8 => few.join(", "),
            many => format!("{}: {} … {}", many.len(), many[0], many[many.len() - 1]),
        }
    }
}

fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{} kB", handy(bytes as f64 / 1e3)),
        _ => format!("{} MB", handy(bytes as f64 / 1e6)),
    }
}
