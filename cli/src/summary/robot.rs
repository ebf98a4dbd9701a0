//! The summary of a robot.

use baudbot_proto::v1;
use baudbot_sim::link::Link;
use baudbot_sim::model::{RobotSpec, Writes};
use baudbot_sim::sensor::Sensor as SensorSpec;
use serde::Serialize;

use super::Chip;
use super::seconds;
use crate::assignment::Assigned;
use crate::link;

/// The results of a robot.
#[derive(Debug, Serialize)]
pub(crate) struct Robot {
    pub(crate) robot: String,
    /// Empty if it had none.
    pub(crate) brain: String,
    pub(crate) distance_m: f64,
    pub(crate) collisions: u64,
    /// The time for which something has kept it from moving.
    pub(crate) stood_in_contact_s: f64,
    pub(crate) turns: u64,
    pub(crate) commands: u64,
    pub(crate) lost_deliveries: u64,
    /// Steps of its brain that were discarded, since there were too many at a time.
    pub(crate) lost_steps: u64,
    /// The last state that its brain has published, in words.
    pub(crate) said: String,
    pub(crate) frames_missed: u64,
    /// `ideal`, `uart` or `usb`.
    pub(crate) link: &'static str,
    /// Absent if the link has no baud rate.
    pub(crate) baud: Option<u32>,
    pub(crate) bits_per_character: Option<u8>,
    /// The brain is the microcontroller's program; there is no link.
    #[serde(skip_serializing_if = "is_false")]
    pub(crate) onboard: bool,
    /// The chip that runs a program of the user's own; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) chip: Option<Chip>,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) cycles: Cycles,
    /// The answering time of its brain, by the wall clock; absent if that was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) thinking_wall: Option<Thinking>,
    /// The same by the processor time of the brain's process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) thinking_processor: Option<Thinking>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) battery: Option<Battery>,
    /// The zones that the robot has been in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) zones: Vec<Zone>,
    pub(crate) sensors: Vec<Sensor>,
}

/// A robot's control cycles: from the readings that its microcontroller frames to the command that answers them.
#[derive(Debug, Serialize)]
pub(crate) struct Cycles {
    pub(crate) deadline_ms: f64,
    pub(crate) kept: u64,
    pub(crate) late: u64,
    pub(crate) unanswered: u64,
    /// The assumption about the brain's writing in a budget of this robot.
    pub(crate) writes: Writes,
    /// Writes beyond that.
    pub(crate) unstated_writes: u64,
    /// Answered cycles that these disturbed; the bounds of the budget need not hold for them.
    pub(crate) disturbed: u64,
    /// The percentage of the cycles, kept or late, that were kept; absent if there were none.
    pub(crate) kept_percent: Option<f64>,
    /// Messages of readings a second that were answered by a command.
    pub(crate) exchanges_per_s: f64,
    /// Absent if none was answered.
    pub(crate) duration: Option<Durations>,
}

/// The distribution of durations.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Durations {
    pub(crate) mean_ms: f64,
    pub(crate) min_ms: f64,
    pub(crate) p50_ms: f64,
    pub(crate) p95_ms: f64,
    pub(crate) p99_ms: f64,
    pub(crate) max_ms: f64,
}

/// The answering time of a brain.
#[derive(Debug, Serialize)]
pub(crate) struct Thinking {
    /// Turns that were measured.
    pub(crate) turns: u64,
    #[serde(flatten)]
    pub(crate) durations: Durations,
}

/// The battery of a robot at the end.
#[derive(Debug, Serialize)]
pub(crate) struct Battery {
    pub(crate) charge_percent: f64,
    pub(crate) voltage_v: f64,
    pub(crate) used_j: f64,
    pub(crate) charged_j: f64,
}

/// A robot's time in a zone.
#[derive(Debug, Serialize)]
pub(crate) struct Zone {
    pub(crate) zone: String,
    pub(crate) time_s: f64,
}

/// One direction of a link.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    pub(crate) bytes: u64,
    pub(crate) messages: u64,
    /// The percentage of the characters that the line could have carried; absent if the link is ideal.
    pub(crate) used_percent: Option<f64>,
    pub(crate) overrun_bytes: u64,
    pub(crate) refused_bytes: u64,
    pub(crate) corrupted_bytes: u64,
    pub(crate) bad_frames: u64,
    pub(crate) bad_messages: u64,
    /// In outages of the cable.
    pub(crate) lost_bytes: u64,
}

/// A sensor and the freshness of its readings.
#[derive(Debug, Serialize)]
pub(crate) struct Sensor {
    pub(crate) sensor: String,
    pub(crate) samples: u64,
    pub(crate) missed: u64,
    /// Turns in which it was readable.
    pub(crate) readable: u64,
    /// The age then; absent if that is not known of any.
    pub(crate) age: Option<Durations>,
    /// The cable of its own, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) port: Option<Line>,
}

impl Robot {
    /// Whether the robot is driven only by the program of its chip, without a brain.
    pub(crate) fn has_program_only(&self) -> bool {
        self.chip.is_some() && self.brain.is_empty() && self.commands == 0
    }

    pub(super) fn new(
        spec: &RobotSpec,
        status: &v1::RobotStatus,
        world: &v1::WorldStatus,
        assigned: &Assigned,
    ) -> Self {
        let simulated_s = seconds(world.time_ns);
        let (baud, bits_per_character) = match &spec.link {
            Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
            Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character)),
        };
        let capacity = link::bytes_per_second(&spec.link).map(|rate| rate * simulated_s);
        let sensors = status.sensors.iter().zip(spec.sensors.iter());
        Self {
            robot: status.robot.clone(),
            brain: assigned.brain_of(&spec.name).unwrap_or_else(|| status.brain.clone()),
            distance_m: status.distance_m,
            collisions: status.collisions,
            stood_in_contact_s: seconds(status.stood_in_contact_ns),
            turns: status.turns,
            commands: status.commands,
            lost_deliveries: status.lost_deliveries,
            lost_steps: status.lost_steps,
            said: status.said.clone(),
            frames_missed: status.frames_missed,
            link: link::kind(&spec.link),
            baud,
            bits_per_character,
            onboard: matches!(spec.link, Link::Onboard),
            chip: status.chip.as_ref().map(|chip| Chip::new(chip, spec)),
            uplink: Line::new(&status.uplink.unwrap_or_default(), capacity),
            downlink: Line::new(&status.downlink.unwrap_or_default(), capacity),
            cycles: Cycles::new(status.cycles.as_ref(), spec.writes.unwrap_or_default(), simulated_s),
            thinking_wall: status.thinking_wall.as_ref().map(Thinking::new),
            thinking_processor: status.thinking_processor.as_ref().map(Thinking::new),
            battery: status.battery.as_ref().map(Battery::new),
            zones: zones(world, status),
            sensors: sensors.map(|(status, spec)| Sensor::new(status, spec, simulated_s)).collect(),
        }
    }
}

impl Line {
    fn new(status: &v1::LineStatus, capacity: Option<f64>) -> Self {
        Self {
            bytes: status.bytes,
            messages: status.messages,
            used_percent: capacity.map(|capacity| status.bytes as f64 / capacity * 100.0),
            overrun_bytes: status.overrun_bytes,
            refused_bytes: status.refused_bytes,
            corrupted_bytes: status.corrupted_bytes,
            bad_frames: status.bad_frames,
            bad_messages: status.bad_messages,
            lost_bytes: status.lost_bytes,
        }
    }
}

impl Cycles {
    fn new(status: Option<&v1::CycleStatus>, writes: Writes, simulated_s: f64) -> Self {
        let status = status.copied().unwrap_or_default();
        let all = status.kept + status.late;
        let answered = status.durations.map_or(0, |durations| durations.count);
        Self {
            deadline_ms: status.deadline_ns as f64 / 1e6,
            kept: status.kept,
            late: status.late,
            unanswered: status.unanswered,
            writes,
            unstated_writes: status.unstated_writes,
            disturbed: status.disturbed,
            kept_percent: (all > 0).then(|| status.kept as f64 / all as f64 * 100.0),
            exchanges_per_s: if simulated_s > 0.0 { answered as f64 / simulated_s } else { 0.0 },
            duration: status.durations.as_ref().map(Durations::new),
        }
    }
}

impl Thinking {
    fn new(status: &v1::Durations) -> Self {
        Self { turns: status.count, durations: Durations::new(status) }
    }
}

impl Durations {
    fn new(status: &v1::Durations) -> Self {
        let ms = |ns: u64| ns as f64 / 1e6;
        Self {
            mean_ms: ms(status.mean_ns),
            min_ms: ms(status.min_ns),
            p50_ms: ms(status.p50_ns),
            p95_ms: ms(status.p95_ns),
            p99_ms: ms(status.p99_ns),
            max_ms: ms(status.max_ns),
        }
    }
}

impl Battery {
    fn new(status: &v1::BatteryStatus) -> Self {
        let v1::BatteryStatus { charge, voltage_v, used_j, charged_j, current_a: _ } = *status;
        Self { charge_percent: charge * 100.0, voltage_v, used_j, charged_j }
    }
}

impl Sensor {
    fn new(status: &v1::SensorStatus, spec: &SensorSpec, simulated_s: f64) -> Self {
        let rate = spec.port.as_ref().and_then(|port| link::bytes_per_second(&port.link));
        let capacity = rate.map(|rate| rate * simulated_s);
        Self {
            sensor: status.sensor.clone(),
            samples: status.samples,
            missed: status.missed,
            readable: status.readable,
            age: status.ages.as_ref().map(Durations::new),
            port: status.port.as_ref().map(|line| Line::new(line, capacity)),
        }
    }
}

/// The zones that a robot has been in.
fn zones(world: &v1::WorldStatus, robot: &v1::RobotStatus) -> Vec<Zone> {
    let all = world.score.iter().flat_map(|score| &score.zones).zip(&robot.in_zone_ns);
    let been_in = all.filter(|(_, ns)| **ns > 0);
    been_in.map(|(zone, &ns)| Zone { zone: zone.zone.clone(), time_s: seconds(ns) }).collect()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_false(value: &bool) -> bool {
    !value
}
