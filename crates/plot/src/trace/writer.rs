//! A trace that grows with the run: nothing of it is kept but a few events of each lane.
//!
//! A trace is a file of packets: descriptions of tracks, begins and ends of slices, instants. Perfetto sorts them by
//! their times, and leaves those of one time in the order of the file. As a track's slices are written one after the
//! other, an end is always before the begin that may have the same time.

use std::collections::BTreeMap;
use std::io::{self, Write};

use baudbot_sim::SimTime;
use baudbot_sim::chip::Line;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::{Event, What};

use super::packet::{
    CounterDescriptor, DebugAnnotation, EXPLICIT, INCREMENTAL_STATE_CLEARED, INSTANT, NO_MERGE,
    ProcessDescriptor, SLICE_BEGIN, SLICE_END, TracePacket, TrackDescriptor, TrackEvent,
};
use super::track::{MOST, Place, Tracks};
use crate::timing::{Group, LaneId, signal, words};

/// Writes a trace for Perfetto: each robot is a process there, each of its lanes a track. Times are simulated ones, in
/// nanoseconds since the start of the run.
#[derive(Debug)]
pub struct TraceWriter<W: Write> {
    pub(crate) out: W,
    pub(crate) robots: Vec<Robot>,
}

#[derive(Debug)]
pub(crate) struct Robot {
    pub(crate) spec: RobotSpec,
    lanes: BTreeMap<LaneId, Tracks>,
    /// The number of tracks of each lane.
    pub(crate) described: BTreeMap<LaneId, usize>,
    /// The end of the latest event.
    now: SimTime,
}

impl<W: Write> TraceWriter<W> {
    /// Begins a trace of these robots of a world. It writes packet by packet: `out` had better be buffered.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(out: W, world_name: &str, robots: &[RobotSpec]) -> io::Result<Self> {
        let robot = |spec: &RobotSpec| Robot {
            spec: spec.clone(),
            lanes: BTreeMap::new(),
            described: BTreeMap::new(),
            now: SimTime::ZERO,
        };
        let mut writer = Self { out, robots: robots.iter().map(robot).collect() };
        TracePacket {
            sequence_flags: Some(INCREMENTAL_STATE_CLEARED),
            first_packet_on_sequence: Some(true),
            ..packet()
        }
        .write(&mut writer.out)?;
        for (i, spec) in robots.iter().enumerate() {
            writer.describe_robot(i, &format!("{} ({world_name})", spec.name))?;
            for lane in LaneId::always(spec) {
                writer.describe(i, lane, 0)?;
            }
        }
        Ok(writer)
    }

    /// Takes an event of a robot, which goes by its place. Events should come in about the order of their ends.
    ///
    /// # Errors
    /// If it cannot be written, or there is no such robot.
    pub fn event(&mut self, robot: usize, event: &Event) -> io::Result<()> {
        let Some(this) = self.robots.get_mut(robot) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("there is no robot {robot}")));
        };
        this.now = this.now.max(event.end);
        let lanes: Vec<_> = LaneId::all_of(event.what, &this.spec).collect();
        for lane in lanes {
            let next = self.robots[robot].lanes.entry(lane).or_default().push(*event);
            if let Some((event, place)) = next {
                self.put(robot, lane, &event, place)?;
            }
        }
        Ok(())
    }

    /// Marks that so many events of a robot were not recorded, at the latest one.
    ///
    /// # Errors
    /// If it cannot be written, or there is no such robot.
    pub fn lost(&mut self, robot: usize, count: u64) -> io::Result<()> {
        let Some(this) = self.robots.get(robot) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("there is no robot {robot}")));
        };
        let at = this.now;
        let uuid = self.track(robot, LaneId::Trouble, 0)?;
        let annotations = vec![DebugAnnotation { uint_value: Some(count), ..annotation("events") }];
        let named = named("events not recorded".to_owned(), "trouble", annotations);
        self.put_packet(at, INSTANT, named, uuid)
    }

    /// The output.
    pub fn written(&self) -> &W {
        &self.out
    }

    /// Writes what still waits and gives back what was written to, flushed.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        for robot in 0..self.robots.len() {
            for (lane, mut tracks) in std::mem::take(&mut self.robots[robot].lanes) {
                while let Some((event, place)) = tracks.pop() {
                    self.put(robot, lane, &event, place)?;
                }
            }
        }
        self.out.flush()?;
        Ok(self.out)
    }

    fn put(&mut self, robot: usize, lane: LaneId, event: &Event, place: Place) -> io::Result<()> {
        let spec = &self.robots[robot].spec;
        let mut annotations = annotations(event.what, spec);
        let (name, category) = (words::what(event.what, spec), category(LaneId::of(event.what)));
        match place {
            Place::Slice(track) => {
                let uuid = self.track(robot, lane, track)?;
                self.put_slice((event.start, event.end), named(name, category, annotations), uuid)
            }
            Place::Instant => {
                let uuid = self.track(robot, lane, 0)?;
                let ns = event.end.since(event.start);
                if ns > 0 {
                    annotations.push(DebugAnnotation { uint_value: Some(ns), ..annotation("duration_ns") });
                }
                self.put_packet(event.start, INSTANT, named(name, category, annotations), uuid)
            }
        }
    }

    pub(crate) fn put_slice(
        &mut self,
        (start, end): (SimTime, SimTime),
        event: TrackEvent,
        uuid: u64,
    ) -> io::Result<()> {
        self.put_packet(start, SLICE_BEGIN, event, uuid)?;
        self.put_packet(end, SLICE_END, TrackEvent::default(), uuid)
    }

    pub(crate) fn put_packet(
        &mut self,
        at: SimTime,
        kind: i32,
        event: TrackEvent,
        uuid: u64,
    ) -> io::Result<()> {
        let track_event = Some(TrackEvent { r#type: Some(kind), track_uuid: Some(uuid), ..event });
        // Perfetto reads times as signed numbers.
        let timestamp = at.as_ns().min(i64::MAX as u64);
        TracePacket { timestamp: Some(timestamp), track_event, ..packet() }.write(&mut self.out)
    }

    /// The track of a lane, which is described before it is used.
    pub(crate) fn track(&mut self, robot: usize, lane: LaneId, track: usize) -> io::Result<u64> {
        while self.robots[robot].described.get(&lane).is_none_or(|tracks| *tracks <= track) {
            let next = self.robots[robot].described.get(&lane).copied().unwrap_or(0);
            self.describe(robot, lane, next)?;
        }
        Ok(uuid(robot, lane, track))
    }

    fn describe(&mut self, robot: usize, lane: LaneId, track: usize) -> io::Result<()> {
        let this = &mut self.robots[robot];
        this.described.insert(lane, track + 1);
        let name = lane.name(&this.spec);
        let counts = matches!(lane, LaneId::Signal(place)
            if signal(&this.spec, place).is_some_and(|signal| matches!(signal.line, Line::Adc(_))));
        let name = if track == 0 { name } else { format!("{name} ({})", track + 1) };
        let rank = lane.code() * MOST as u64 + track as u64;
        let descriptor = TrackDescriptor {
            uuid: Some(uuid(robot, lane, track)),
            name: Some(name),
            parent_uuid: Some(process(robot)),
            counter: counts.then_some(CounterDescriptor {}),
            sibling_order_rank: i32::try_from(rank).ok(),
            sibling_merge_behavior: Some(NO_MERGE),
            ..TrackDescriptor::default()
        };
        TracePacket { track_descriptor: Some(descriptor), ..packet() }.write(&mut self.out)
    }

    fn describe_robot(&mut self, robot: usize, name: &str) -> io::Result<()> {
        let pid = i32::try_from(robot + 1).ok();
        let descriptor = TrackDescriptor {
            uuid: Some(process(robot)),
            process: Some(ProcessDescriptor { pid, process_name: Some(name.to_owned()) }),
            child_ordering: Some(EXPLICIT),
            ..TrackDescriptor::default()
        };
        TracePacket { track_descriptor: Some(descriptor), ..packet() }.write(&mut self.out)
    }
}

/// A packet of the only sequence that there is. It names no clock: the default is one in nanoseconds.
fn packet() -> TracePacket {
    TracePacket { trusted_packet_sequence_id: Some(1), ..TracePacket::default() }
}

pub(crate) fn named(name: String, category: &str, debug_annotations: Vec<DebugAnnotation>) -> TrackEvent {
    let categories = vec![category.to_owned()];
    TrackEvent { name: Some(name), categories, debug_annotations, ..TrackEvent::default() }
}

fn annotations(what: What, robot: &RobotSpec) -> Vec<DebugAnnotation> {
    let (sensor, bytes) = words::sensor_and_bytes(what);
    let bytes = bytes.map(|bytes| DebugAnnotation { uint_value: Some(bytes.into()), ..annotation("bytes") });
    let sensor = sensor.map(|place| DebugAnnotation {
        string_value: Some(words::sensor(robot, place)),
        ..annotation("sensor")
    });
    let informed = if let What::Think { informed } = what { Some(informed) } else { None };
    let informed = informed.map(|is| DebugAnnotation { bool_value: Some(is), ..annotation("informed") });
    bytes.into_iter().chain(sensor).chain(informed).collect()
}

fn annotation(name: &str) -> DebugAnnotation {
    DebugAnnotation { name: Some(name.to_owned()), ..DebugAnnotation::default() }
}

fn category(lane: LaneId) -> &'static str {
    match lane.group() {
        Group::Sensors => "sensor",
        Group::Pins | Group::Chip => "pin",
        Group::Microcontroller => "microcontroller",
        Group::Up | Group::Down => "cable",
        Group::Brain => "brain",
        Group::Motors => "motors",
        Group::Trouble => "trouble",
    }
}

/// The number of a robot's process among all tracks.
fn process(robot: usize) -> u64 {
    (robot as u64 + 1) << 32
}

/// The number of a lane's track among all tracks: a lane's code has 20 bits.
fn uuid(robot: usize, lane: LaneId, track: usize) -> u64 {
    process(robot) | lane.code() << 8 | track as u64
}
