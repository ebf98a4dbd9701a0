//! Events as a table: those of the timelines, and those of the recording.

use std::io;
use std::sync::Arc;

use baudbot_plot::timing::{Class, LaneId, words};
use baudbot_proto::v1::{RecordedEvent, ReplayEventKind};
use baudbot_recording::RecordedRun;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;
use baudbot_sim::{SimTime, World};

use super::Out;
use super::pass::Sink;
use crate::trace::unseen;

/// A table that is being written.
pub(super) struct Events {
    out: csv::Writer<Out>,
    /// The events of the recording, in the order of ticks.
    recorded: Vec<RecordedEvent>,
    /// The next of these.
    next: usize,
    /// Events that were over before are left out.
    from: SimTime,
    /// The number of events of each robot that have been reported or left out.
    seen: Vec<u64>,
    is_begun: bool,
}

impl Events {
    pub(super) fn new(out: Out, run: &Arc<RecordedRun>, from: SimTime) -> Self {
        let mut recorded = run.events().to_vec();
        recorded.sort_by_key(|event| event.tick);
        let seen = vec![0; run.scenario().robots.len()];
        Self { out: csv::Writer::from_writer(out), recorded, next: 0, from, seen, is_begun: false }
    }

    /// The recording's events of this tick.
    fn recorded(&mut self, world: &World) -> io::Result<()> {
        while let Some(event) = self.recorded.get(self.next).filter(|event| event.tick <= world.tick()) {
            self.next += 1;
            let at_ns = event.tick.saturating_mul(world.scenario().step_ns);
            if at_ns < self.from.as_ns() {
                continue;
            }
            let at_ns = at_ns.to_string();
            let robot = robot_of(event, &world.scenario().robots);
            self.out.write_record([&at_ns, &at_ns, robot, kind_of(event), "", "", &event.text])?;
        }
        Ok(())
    }
}

impl Sink for Events {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        if !std::mem::replace(&mut self.is_begun, true) {
            self.out.write_record(["start_ns", "end_ns", "robot", "kind", "part", "bytes", "text"])?;
        }
        self.recorded(world)?;
        for (robot, seen) in world.robots().zip(&mut self.seen) {
            let (spec, timeline) = (robot.spec(), robot.timeline());
            let (gone, events) = timeline.since(unseen(*seen, timeline.total()));
            if gone > 0 {
                let (at_ns, text) = (world.time().as_ns().to_string(), format!("{gone} events not kept"));
                self.out.write_record([&at_ns, &at_ns, &spec.name, "gap", "", "", &text])?;
            }
            for event in events.filter(|event| event.end >= self.from) {
                write(&mut self.out, spec, event)?;
            }
            *seen = timeline.total();
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}

fn write(out: &mut csv::Writer<Out>, robot: &RobotSpec, event: &Event) -> io::Result<()> {
    let (start_ns, end_ns) = (event.start.as_ns().to_string(), event.end.as_ns().to_string());
    let (kind, part) = (Class::of(event.what).style().name, LaneId::of(event.what).name(robot));
    let (_, bytes) = words::sensor_and_bytes(event.what);
    let bytes = bytes.map_or_else(String::new, |bytes| bytes.to_string());
    let text = words::what(event.what, robot);
    Ok(out.write_record([&start_ns, &end_ns, &robot.name, kind, &part, &bytes, &text])?)
}

/// The kind of the event, in a word.
pub(super) fn kind_of(event: &RecordedEvent) -> &'static str {
    match event.kind() {
        ReplayEventKind::Unspecified => "other",
        ReplayEventKind::Collision => "collision",
        ReplayEventKind::Brain => "brain",
        ReplayEventKind::Change => "change",
        ReplayEventKind::Ending => "ending",
        ReplayEventKind::Order => "order",
    }
}

/// The robot that it names: the one that ran into something, or the only one.
fn robot_of<'a>(event: &RecordedEvent, robots: &'a [RobotSpec]) -> &'a str {
    let quoted = event.text.split('`').skip(1).step_by(2);
    let named = quoted.filter_map(|name| robots.iter().find(|robot| robot.name == name));
    let named: Vec<_> = named.collect();
    match named.as_slice() {
        [robot] => &robot.name,
        [robot, ..] if event.kind() == ReplayEventKind::Collision => &robot.name,
        _ => "",
    }
}
